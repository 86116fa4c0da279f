"""Maxwell's distribution by its fourth moment and by counts, in both ensembles and for few particles."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said
from scipy.stats import chi2, kstest

from crosscheck.inspect.inspection import inspect_trajectory

NAME = "Maxwell's distribution"


def drawn(seed: int, frames: int, number: int, constant_energy: bool = False) -> object:
    rng = np.random.default_rng(seed)
    masses = np.linspace(1, 5, number)
    v = rng.normal(size=(frames, number, 3)) / masses[:, None] ** 0.5
    if constant_energy:
        v -= (masses[:, None] * v).sum(axis=1, keepdims=True) / masses.sum()
        v /= np.sqrt((masses[:, None] * v**2).sum(axis=(1, 2), keepdims=True))
    return flying(frames=frames, number=number, velocities=v, masses=masses)


@pytest.mark.parametrize("number", [10, 50])
@pytest.mark.parametrize("constant_energy", [False, True])
def test_the_fourth_moment_is_exact_in_both_ensembles(number: int, constant_energy: bool) -> None:
    """3 f/(f + 2), f = n - 1: of ten particles 2.45, far from 3."""
    found = judged(drawn(1, 3000, number, constant_energy), NAME)
    moments = [one for one in found if "^4" in one.quantity]
    assert len(moments) == 3
    for one in moments:
        assert one.expected == pytest.approx(3 * (number - 1) / (number + 1))
        assert one.measured == pytest.approx(one.expected, abs=4 * one.uncertainty)
        assert one.uncertainty < 0.03


def test_counts_of_independent_frames_are_no_further_off_than_chance() -> None:
    """chi^2 is smaller than its law, since energy and momentum of a frame are given: no p-value is too small."""
    found = [judged(drawn(seed, 40, 20), NAME, ensemble="nvt") for seed in range(30)]
    values = [one.measured for each in found for one in each if "chi^2" in one.quantity]
    assert len(values) == 90
    assert kstest(values, chi2(11).cdf, alternative="less").pvalue > 1e-4
    assert max(values) < chi2(11).isf(1e-5)


@pytest.mark.parametrize("frames", [1, 3, 60])
def test_one_sample_counts_once_however_often_it_was_written(frames: int) -> None:
    """Particles that never meet keep their velocities: the frames are copies of each other."""
    source = flying(frames=max(frames, 6), number=200)
    found = [one for one in judged(source, NAME, skip=0.0) if "chi^2" in one.quantity]
    assert [one.outcome for one in found] == ["pass"] * 3
    assert "of 1 decorrelated frames" in found[0].criterion.why
    rng = np.random.default_rng(1)
    wrong = np.broadcast_to(rng.choice([-1.0, 1.0], (200, 3)) * (1 + 0.01 * rng.normal(size=(200, 3))), (6, 200, 3))
    found = [one for one in judged(flying(frames=6, number=200, velocities=wrong), NAME) if "chi^2" in one.quantity]
    assert [one.outcome for one in found] == ["fail"] * 3


@pytest.mark.parametrize("shape", ["uniform", "laplace", "two speeds"])
def test_other_shapes_are_red(shape: str) -> None:
    rng = np.random.default_rng(3)
    size = (300, 40, 3)
    v = {
        "uniform": rng.uniform(-1, 1, size),
        "laplace": rng.laplace(size=size),
        # the fourth moment of a normal, 3, from two speeds: only the counts tell
        "two speeds": rng.choice([-1.0, 1.0], size) * np.where(rng.random(size) < 1 / 3, 3**0.5, 1e-3),
    }[shape]
    found = {one.quantity: one.outcome for one in judged(flying(frames=300, number=40, velocities=v), NAME)}
    assert found["chi^2 of the histogram of v_x against Maxwell's"] == "fail"
    assert shape == "two speeds" or found["<v_x^4>/<v_x^2>^2"] == "fail"


def test_species_are_told_apart() -> None:
    run = PLANTED.ornstein_uhlenbeck(1, frames=100)
    v = run.velocities.copy()
    rng = np.random.default_rng(1)
    v[:, :32] = rng.uniform(-1, 1, v[:, :32].shape) * 3**0.5 * 1.3**0.5
    found = judged(PLANTED.source_of(run._replace(velocities=v)), NAME)
    red = {one.quantity for one in found if one.outcome == "fail"}
    assert any("of A" in quantity for quantity in red)
    assert not any("of B^4" in quantity for quantity in red)


def test_speeds_are_drawn_beside_maxwells() -> None:
    inspection = inspect_trajectory(drawn(1, 50, 30))
    (figure,) = [figure for figure in inspection.figures if figure.title == "Speeds"]
    bars, curve = figure.series
    assert np.sum(np.array(bars.y) * np.diff(bars.x)) == pytest.approx(1, abs=1e-3)
    middle = (np.array(bars.x)[1:] + np.array(bars.x)[:-1]) / 2
    np.testing.assert_allclose(bars.y, np.interp(middle, curve.x, curve.y), atol=0.08)


def test_constraints_are_a_doubt_of_the_moments() -> None:
    free, bound = (judged(drawn(1, 300, 50), NAME, ensemble="nvt", constraints=number) for number in (0, 5))
    assert [one.doubt for one in free if "^4" in one.quantity] == [0.0] * 3
    assert [one.doubt for one in bound] == pytest.approx([3 * 5 / 49] * 3)


def test_few_counts_are_not_judged() -> None:
    text = said(drawn(1, 6, 10), NAME)
    assert "the histogram of v_x is not judged: 5 independent frames" in text or "independent frames" in text
    assert not any("chi^2" in one.quantity for one in judged(drawn(1, 60, 40), NAME, constraints=10))
