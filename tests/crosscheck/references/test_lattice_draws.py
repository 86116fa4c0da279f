"""Tests of random outcomes: on draws that are fair, and on draws that are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import kstest, norm

from crosscheck.references.lattice_audit import Motion, draws_of
from crosscheck.references.lattice_draws import as_normal, frequencies, largest_correlation, serial
from crosscheck.references.lattice_models import transitions

#: By chance beyond once in 4e7 tests.
LIMIT = 5.5
GENERATOR = np.random.default_rng(1)


def drawn(probabilities: np.ndarray, arrived: np.ndarray, uniform: np.ndarray) -> np.ndarray:
    """Outcomes by inversion of the distribution function."""
    return (probabilities.cumsum(axis=1)[arrived] < uniform[..., None]).sum(axis=-1)


def gas(model: str, steps: int = 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Arrived states of steps x 32 x 32 sites, uniform numbers, and the probabilities of the model."""
    table = transitions(model)
    shape = (steps, 32, 32)
    return GENERATOR.integers(0, len(table), shape), GENERATOR.random(shape), table


def test_the_normal_variable_of_a_probability() -> None:
    assert as_normal(2 * norm.sf(3.0)) == pytest.approx(3)
    assert as_normal(1.0) == 0
    assert as_normal(0.5, 3) == pytest.approx(norm.isf((1 - 0.5**3) / 2))
    assert np.isfinite(as_normal(0.0))


@pytest.mark.parametrize("model", ["fhp3", "fhp_saturated_identity"])
def test_fair_draws(model: str) -> None:
    arrived, uniform, table = gas(model)
    after = drawn(table, arrived, uniform)
    counts = np.zeros_like(table)
    np.add.at(counts, (arrived.ravel(), after.ravel()), 1)
    found = frequencies(counts, table)
    assert max(found.total, found.worst) < LIMIT
    one = Motion(arrived, after)
    assert serial(one, table).largest < LIMIT
    assert serial(one, table, Motion(arrived, drawn(table, arrived, GENERATOR.random(arrived.shape)))).largest < LIMIT


def test_frequencies_of_fair_draws_are_those_of_a_normal_variable() -> None:
    """Their sizes, over many gases, of the few outcomes of one state."""
    table = np.array([[0.25, 0.25, 0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    sizes = []
    for _ in range(400):
        counts = np.zeros((3, 3))
        counts[0] = GENERATOR.multinomial(2000, table[0])
        sizes.append(frequencies(counts, table).total)
    assert kstest(sizes, lambda z: 2 * norm.cdf(z) - 1).pvalue > 1e-6


def test_an_outcome_too_many() -> None:
    table = transitions("fhp1")
    counts = np.zeros_like(table)
    counts[9, 18], counts[9, 36], counts[18, 36], counts[18, 9] = 5300, 4700, 5000, 5000
    found = frequencies(counts, table)
    assert found.worst > LIMIT
    assert found.state == 9
    assert found.draws == 20_000


def test_states_that_were_not_seen_are_not_judged() -> None:
    with pytest.raises(ValueError, match="no state has two outcomes"):
        frequencies(np.zeros((64, 64)), transitions("fhp1"))


def in_turn(uniform: np.ndarray) -> np.ndarray:
    """At each step those of the step before, moved by 3 rows and 4 columns."""
    return np.array([np.roll(uniform[0], (3 * step, 4 * step), axis=(0, 1)) for step in range(len(uniform))])


REPEATS = {
    "two rows": lambda uniform: uniform[:, np.arange(32) // 2],
    "every eighth column": lambda uniform: uniform[:, :, np.arange(32) % 8],
    "two steps": lambda uniform: uniform[np.arange(len(uniform)) // 2],
    "moved along": in_turn,
}


@pytest.mark.parametrize("repeat", REPEATS.values(), ids=REPEATS.keys())
@pytest.mark.parametrize("model", ["fhp3", "fhp_saturated_identity"])
def test_a_number_that_is_used_twice(model: str, repeat: Callable[[np.ndarray], np.ndarray]) -> None:
    arrived, uniform, table = gas(model, 6)
    found = serial(Motion(arrived, drawn(table, arrived, repeat(uniform))), table)
    assert found.largest > LIMIT


def test_the_distance_is_found() -> None:
    z = GENERATOR.choice([-1.0, 1.0], (2, 64, 64))
    z[1] = np.roll(z[0], (3, 5), axis=(0, 1))
    found = largest_correlation(z, np.ones_like(z))
    assert found.distance == (1, 3, 5)
    assert found.largest > LIMIT
    other = np.roll(z, (0, 7, 0), axis=(0, 1, 2))
    assert largest_correlation(z, np.ones_like(z), other, np.ones_like(z)).largest > LIMIT


def test_rare_outcomes() -> None:
    """Of a force with the probability 0.01; and too few of them."""
    arrived = np.ones((4, 32, 32), dtype=np.int64)
    after = (GENERATOR.random(arrived.shape) < 0.01).astype(np.int64)
    assert serial(Motion(arrived, after), draws_of(0.01)).largest < 2 * LIMIT
    with pytest.raises(ValueError, match="too few pairs"):
        serial(Motion(arrived[:, :2, :2], after[:, :2, :2]), draws_of(0.01))
