"""Laws of the largest value: their rates on simulated values, and that one wrong value does not change them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.inspect.outliers import Largest, of_deviations, of_maxima

DRAWN = {
    "gumbel": lambda rng, size: rng.gumbel(2.0, 0.3, size),
    "of normal speeds": lambda rng, size: np.abs(rng.normal(size=(*size, 50))).max(axis=-1),
    "of Maxwell's speeds": lambda rng, size: np.linalg.norm(rng.normal(size=(*size, 30, 3)), axis=-1).max(axis=-1),
    "uniform": lambda rng, size: rng.uniform(0, 1, size),
}


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("frames", [30, 200])
def test_the_largest_of_right_maxima_is_beyond_the_limit_no_more_often_than_stated(name: str, frames: int) -> None:
    """Of 400 series at the level 1e-2, 4 are expected, and 13 or more with the probability 2e-4."""
    rng = np.random.default_rng(1)
    beyond = 0
    for values in DRAWN[name](rng, (400, frames)):
        law = of_maxima(values)
        beyond += law is not None and values.max() > law.isf(1e-2)
    assert beyond <= 12


@pytest.mark.parametrize(("tail", "drawn"), [("normal", "normal"), ("laplace", "laplace"), ("laplace", "normal")])
def test_the_largest_of_right_deviations(tail: str, drawn: str) -> None:
    rng = np.random.default_rng(2)
    beyond = 0
    for values in getattr(rng, drawn)(size=(400, 100)):
        law = of_deviations(values, tail)
        beyond += law is not None and np.abs(values).max() > law.isf(1e-2)
    assert beyond <= 12


def test_limits_are_exact_where_the_scale_is_known() -> None:
    law = Largest(2.0, 0.3, 100, 0.0, "gumbel")
    largest = np.random.default_rng(3).gumbel(2.0, 0.3, (4000, 100)).max(axis=1)
    assert np.mean(largest > law.isf(0.05)) == pytest.approx(0.05, abs=0.015)
    law = Largest(0.0, 1.0, 100, 0.0, "normal")
    largest = np.abs(np.random.default_rng(4).normal(size=(4000, 100))).max(axis=1)
    assert np.mean(largest > law.isf(0.05)) == pytest.approx(0.05, abs=0.015)


def test_one_wrong_value_is_seen_and_hardly_changes_the_law() -> None:
    values = np.random.default_rng(5).gumbel(2.0, 0.3, 200)
    limit = of_maxima(values).isf(1e-5)
    values[70] = 30.0
    law = of_maxima(values)
    assert law.isf(1e-5) == pytest.approx(limit, rel=0.1)
    assert law.sf(30.0) < 1e-5


@given(probability=st.floats(1e-12, 0.4), tail=st.sampled_from(["gumbel", "normal", "laplace"]))
def test_the_probability_is_that_of_the_limit(probability: float, tail: str) -> None:
    law = Largest(1.0, 0.2, 50, 0.1, tail)
    assert law.sf(law.isf(probability)) == pytest.approx(probability, rel=1e-6)


def test_below_the_floor_nothing_is_improbable() -> None:
    law = Largest(1.0, 1e-3, 50, 0.1, "gumbel", floor=2.0)
    assert law.isf(1e-6) == 2.0
    assert law.sf(1.9) == 0.5
    assert law.sf(2.1) < 1e-6


def test_few_or_correlated_values_have_no_law() -> None:
    assert of_maxima(np.random.default_rng(6).normal(size=19)) is None
    assert of_maxima(np.sin(0.01 * np.arange(200.0))) is None
    assert of_deviations(np.linspace(-1, 1, 100), "normal") is None
