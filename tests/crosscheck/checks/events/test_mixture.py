"""The mixtures' scenes: packing fraction, momentum, temperature."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events import mixture
from crosscheck.references.hard_spheres import degrees_of_freedom


@pytest.mark.parametrize("name", sorted(mixture.MIXTURES))
def test_mixture_starts_as_said(name: str) -> None:
    d, eta = mixture.MIXTURES[name]
    scene, known = mixture.mixture_scene(mixture.MIXTURES[name], 5)
    state = scene.initial_state()  # refuses overlaps
    assert state.diameters is not None
    assert state.lengths is not None
    assert known.packing_fraction[d - 2] == pytest.approx(eta)
    assert np.pi / (2 * d) * (state.diameters**d).sum() / state.lengths.prod() == pytest.approx(eta)
    assert (state.masses[:, None] * state.velocities).sum(axis=0) == pytest.approx(np.zeros(d), abs=1e-11)
    kinetic = 0.5 * (state.masses[:, None] * state.velocities**2).sum()
    assert 2 * kinetic / degrees_of_freedom(scene.number, d, True) == pytest.approx(1.0)
    assert not state.velocities[np.array(scene.species) == 1].any()
