"""Models and velocity sets that tests of lattice gases go through, with the conserved sums of occupations."""

from __future__ import annotations

import numpy as np
import pytest

from refimpl.lattice.models import MODELS, Model, build
from refimpl.lattice.velocities import SQUARE, TRIANGULAR, TRIANGULAR_REST, VelocitySet

SETS = {"square": SQUARE, "triangular": TRIANGULAR, "triangular with rest": TRIANGULAR_REST}
SAT7 = {
    name: build(name, TRIANGULAR_REST, lambda velocities, state: None, identity=identity)
    for name, identity in (("sat7", False), ("sat7_identity", True))
}
ALL = MODELS | SAT7
every_model = pytest.mark.parametrize("model", ALL.values(), ids=ALL.keys())
every_set = pytest.mark.parametrize("velocities", SETS.values(), ids=SETS.keys())
DENSITIES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def mass_and_momentum(velocities: VelocitySet, f: np.ndarray) -> np.ndarray:
    """(..., 3) of f (..., b)."""
    return np.concatenate([f.sum(axis=-1, keepdims=True), f @ velocities.cartesian], axis=-1)


def mean_state(velocities: VelocitySet, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """d and u."""
    found = mass_and_momentum(velocities, f)
    return found[..., 0] / velocities.channels, found[..., 1:] / found[..., :1]


def table_of(model: Model) -> np.ndarray:
    """A(s -> t) of a model's outcomes, (2^b, 2^b)."""
    found = np.zeros((len(model.outcomes),) * 2)
    for state, outcomes in enumerate(model.outcomes):
        found[state, list(outcomes)] = 1 / len(outcomes)
    return found
