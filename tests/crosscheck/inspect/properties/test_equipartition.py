"""Shares of the kinetic energy: their means and scatter where all is right, and what is red."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said

NAME = "equipartition"


def drawn(seed: int, frames: int = 300, constant_energy: bool = False) -> object:
    """Velocities of three masses that are drawn anew in each frame, canonical or on a sphere of constant energy."""
    rng = np.random.default_rng(seed)
    masses = np.repeat([1.0, 2.0, 8.0], [10, 14, 6])
    v = rng.normal(size=(frames, 30, 3)) / masses[:, None] ** 0.5
    if constant_energy:
        v -= (masses[:, None] * v).sum(axis=1, keepdims=True) / masses.sum()
        v /= np.sqrt((masses[:, None] * v**2).sum(axis=(1, 2), keepdims=True))
    types = np.repeat(["A", "B", "C"], [10, 14, 6])
    return flying(frames=frames, number=30, velocities=v, masses=masses, types=types)


@pytest.mark.parametrize("constant_energy", [False, True])
def test_shares_of_axes_and_species_have_the_mean_1_in_both_ensembles(constant_energy: bool) -> None:
    """The motion of the centre of mass takes m/M of a particle, which 6 heavy ones of 30 would show."""
    found = judged(drawn(1, 4000, constant_energy), NAME)
    assert len(found) == 6
    for one in found:
        assert one.outcome == "pass"
        assert one.measured == pytest.approx(1, abs=4 * one.uncertainty)
        assert one.uncertainty < 0.01


def test_the_stated_sensitivity_is_seen() -> None:
    """A share that is off by the sensitivity is red in 9 of 10 files: of 20, 13 or more with the probability 0.998."""
    seen = 0
    for seed in range(20):
        source = drawn(seed, 200)
        sensitivity = next(one for one in judged(source, NAME) if "along x" in one.quantity).sensitivity
        # T_x/T = g/((g + 2)/3) = 1 + s
        g = 2 * (1 + sensitivity) / (2 - sensitivity)
        v = np.array(source.velocities) * np.array([g**0.5, 1.0, 1.0])
        changed = flying(frames=200, number=30, velocities=v, masses=source.masses, types=source.types)
        (one,) = [one for one in judged(changed, NAME) if "along x" in one.quantity]
        seen += one.outcome == "fail"
    assert seen >= 13


def test_a_hot_species_is_red_and_its_neighbours_are_told_apart() -> None:
    run = PLANTED._hot(PLANTED.ornstein_uhlenbeck(1), np.random.default_rng(1))
    found = {one.quantity: one for one in judged(PLANTED.source_of(run), NAME)}
    assert found["temperature of A over that of all"].outcome == "fail"
    assert found["temperature of A over that of all"].measured == pytest.approx(1.44 / 1.22, abs=0.04)


def test_one_sample_of_velocities_says_little_and_is_not_red() -> None:
    found = judged(flying(frames=100), NAME)
    assert [one.outcome for one in found] == ["inconclusive"] * 3
    # of one sample, the share of an axis is beta with 19 of 57 degrees of freedom
    rng = np.random.default_rng(1)
    one, others = rng.chisquare(19, 20000), rng.chisquare(38, 20000)
    shares = 3 * one / (one + others)
    assert found[0].uncertainty == pytest.approx(shares.std(), rel=0.1)


def test_what_keeps_it_from_being_said() -> None:
    assert "10 or more" in said(flying(number=9), NAME)
    assert "not taken to be in equilibrium" in said(flying(), NAME, ensemble="none")
    source = drawn(1)
    assert "species are not compared" in said(source, NAME, constraints=5)
    assert len(judged(source, NAME, constraints=5)) == 3
    few = flying(frames=5, velocities=None)
    assert "no velocities" in said(few, NAME)
