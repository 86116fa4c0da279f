"""The stated rounding bounds the real one, whatever the format of the numbers, and is not much larger."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from crosscheck.columns import SAMPLE
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Rounding
from crosscheck.trajectories.rounding import coarsest, of_decimals, scaled, unwrapped

#: Numbers of a run: positions in a box, velocities, in any unit.
SEEDS = st.integers(0, 2**32 - 1)
#: A relative rounding is ten times too large for 9.99..., and 24 bits are added where it hardly matters.
_SLACK = 11.5
SIZES = st.sampled_from([1e-9, 1e-3, 1.0, 50.0, 1e7])


def numbers(seed: int, size: float, count: int = 600) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=count) * size if seed % 2 else rng.uniform(0, size, count)


def check(values: NDArray[np.float64], words: list[str], slack: float = _SLACK) -> None:
    """The words of the first numbers tell a rounding that all of them have, and that some of them nearly need."""
    found = of_decimals(words[: 3 * SAMPLE])
    read = np.array([float(word) for word in words])
    error = np.abs(read - values)
    assert (error <= found.of(read)).all(), found
    assert found.of(read).max() <= slack * max(error.max(), 2.0**-53 * np.abs(read).max()), found


@given(SEEDS, SIZES, st.integers(1, 17))
def test_a_fixed_number_of_decimals(seed: int, size: float, places: int) -> None:
    values = numbers(seed, size)
    words = [f"{value:.{places}f}" for value in values]
    assume(places > 1 or len(set(words)) > 20)  # "0.0" is also what zero looks like
    check(values, words, slack=1e300 if size < 10.0**-places else _SLACK)  # of "0.00" nobody knows how much it was


@given(SEEDS, SIZES, st.integers(3, 17))
def test_a_number_of_significant_digits(seed: int, size: float, digits: int) -> None:
    values = numbers(seed, size)
    check(values, [f"{value:.{digits}g}" for value in values])
    check(values, [f"{value:.{digits - 1}e}" for value in values])


@given(SEEDS, SIZES)
def test_the_shortest_decimals_that_read_back(seed: int, size: float) -> None:
    values = numbers(seed, size)
    words = list(map(repr, values.tolist()))
    check(values, words)
    assert of_decimals(words) == DOUBLE


@given(SEEDS, SIZES, st.sampled_from(["{}", "{:.8g}", "{:.9g}", "{:.12g}", "{:.17g}", "{:.6g}", "{:.10e}"]))
def test_numbers_that_had_32_bits_before_they_were_printed(seed: int, size: float, form: str) -> None:
    values = numbers(seed, size)
    single = values.astype(np.float32)
    words = [str(value) if form == "{}" else form.format(float(value)) for value in single]
    check(values, words)
    assert of_decimals(words).relative >= SINGLE.relative


@given(SEEDS, st.integers(6, 12))
def test_numbers_of_32_bits_with_a_fixed_number_of_decimals(seed: int, places: int) -> None:
    values = numbers(seed, 50.0)
    check(values, [f"{value:.{places}f}" for value in values.astype(np.float32)])


@given(SEEDS, st.integers(8, 15))
def test_numbers_of_64_bits_are_not_taken_for_those_of_32(seed: int, digits: int) -> None:
    found = of_decimals([f"{value:.{digits}g}" for value in numbers(seed, 50.0, SAMPLE)])
    assert found.relative < SINGLE.relative
    assert found.name == f"{digits} significant digits"


@pytest.mark.parametrize(
    ("words", "relative", "absolute"),
    [
        (["39.948"] * 50, 5e-6, 0),  # one mass: six digits, as by %g
        (["1", "2.5"], 5e-6, 0),
        ([repr(k / 2) for k in range(64)], 5e-6, 0),  # sites of a lattice
        ([f"{k / 8:g}" for k in range(64)], 5e-6, 0),
        ([f"{k / 2:.8f}" for k in range(64)], 0, 5e-9),
        (["0.00000000"] * 8, 0, 5e-9),
        (["0", "-0.0", "nan", "inf"], 0, 0),
        ([], 0, 0),
    ],
)
def test_numbers_that_are_few_or_nice(words: list[str], relative: float, absolute: float) -> None:
    found = of_decimals(words)
    assert found.relative == pytest.approx(relative, rel=0.02, abs=1e-15)
    assert found.absolute == absolute


@given(SEEDS, st.sampled_from([4, 6, 10, 16]), st.booleans())
def test_fractions_of_a_box(seed: int, digits: int, tilted: bool) -> None:
    rng = np.random.default_rng(seed)
    vectors = np.diag(rng.uniform(5, 50, 3)) + (np.tril(rng.uniform(-5, 5, (3, 3)), -1) if tilted else 0)
    lower = rng.uniform(-50, 50, 3)
    fractions = rng.uniform(-2, 3, (300, 3))
    words = [f"{value:.{digits}g}" for value in fractions.ravel()]
    read = np.array(list(map(float, words))).reshape(-1, 3)
    found = scaled(of_decimals(words), vectors, lower, float(np.abs(read).max()))
    error = np.abs((read @ vectors + lower) - (fractions @ vectors + lower))
    assert (error <= found.of(read @ vectors + lower)).all()
    assert found.of(read @ vectors + lower).max() < 40 * error.max()


@given(SEEDS, st.sampled_from(["{:.6g}", "{!r}", "{:.5f}"]))
def test_positions_with_images(seed: int, form: str) -> None:
    rng = np.random.default_rng(seed)
    vectors = np.diag(rng.uniform(5, 50, 3))
    inside, images = rng.uniform(0, 1, (300, 3)) @ vectors, rng.integers(-9, 10, (300, 3))
    words = [form.format(value) for value in inside.ravel().tolist()]
    read = np.array(list(map(float, words))).reshape(-1, 3) + images @ vectors
    exact = inside.astype(np.longdouble) + images.astype(np.longdouble) @ vectors.astype(np.longdouble)
    found = unwrapped(of_decimals(words), vectors)
    assert (np.abs(read - exact) <= found.of(read)).all()


def test_numbers_of_one_decade_may_have_either_format() -> None:
    """None of these ends in 0, so both formats print the same; other numbers of the file may be larger or smaller."""
    words = [f"{k / 7:.6g}" for k in range(8, 70) if k % 7 and f"{k / 7:.5f}"[-1] != "0"]
    assert words == [f"{float(word):.5f}" for word in words]
    found = of_decimals(words)
    assert found.of(np.array([53.123456])) >= 5e-5
    assert found.of(np.array([0.0123456])) >= 5e-6


def test_the_coarsest_of_several_bounds_all() -> None:
    fixed, general = of_decimals([f"{k / 7:.3f}" for k in range(64)]), of_decimals([f"{k / 7:.7g}" for k in range(64)])
    both = coarsest([fixed, general])
    assert both.absolute == fixed.absolute
    assert both.relative == general.relative


FORMATS: list[Callable[[float], str]] = [lambda x: f"{x:20.15g}", lambda x: f"{x:+.8e}", lambda x: f"{x:.3E}"]


@pytest.mark.parametrize("form", FORMATS)
def test_signs_and_capitals(form: Callable[[float], str]) -> None:
    values = numbers(3, 50.0)
    check(values, [form(float(value)).strip() for value in values])


def test_images_round_by_the_largest_component_of_the_edges() -> None:
    tilted = np.array([[10.0, 0, 0], [9, 8, 0], [-7, 6, 5]])  # along x, three edges sum up to 26
    assert unwrapped(SINGLE, tilted).absolute == pytest.approx((SINGLE.relative + 4 * DOUBLE.relative) * 26, rel=1e-12)
    absolute = scaled(Rounding(1e-6, 0.0, "6 decimals"), tilted, np.zeros(3), 1.0).absolute
    assert absolute == pytest.approx(26e-6, rel=1e-6)


def test_twenty_different_numbers_tell_their_digits_and_fewer_count_as_six() -> None:
    words = [f"{k / 7 + k:.4g}" for k in range(101, 200, 5) if f"{k / 7 + k:.4g}"[-1] != "0"][:19]
    assert len(set(words)) == 19
    assert of_decimals(words).relative == pytest.approx(5e-6, rel=0.02)
    assert of_decimals([*words, "0.1234"]).relative == pytest.approx(5e-4, rel=0.02)
