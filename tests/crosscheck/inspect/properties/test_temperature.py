"""The kinetic temperature: stationary, and that of a bath."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said

NAME = "temperature"


def bath(seed: int = 1, **more: object) -> object:
    return PLANTED.source_of(PLANTED.ornstein_uhlenbeck(seed, **more))


@pytest.mark.parametrize(("temperature", "outcome"), [("1.3", "pass"), ("1.1", "fail"), ("1.5", "fail")])
def test_the_temperature_of_the_bath(temperature: str, outcome: str) -> None:
    (one,) = judged(bath(), NAME, ensemble="nvt", temperature=temperature)
    assert one.outcome == outcome
    assert one.measured == pytest.approx(1.3, abs=4 * one.uncertainty)


def test_a_drift_is_red() -> None:
    assert judged(bath(), NAME)[0].outcome == "pass"
    run = PLANTED.ornstein_uhlenbeck(1)
    hotter = run.velocities * np.linspace(1, 1.2, len(run.times))[:, None, None]
    (one,) = judged(PLANTED.source_of(run._replace(velocities=hotter)), NAME)
    assert one.outcome == "fail"
    assert one.measured == pytest.approx(0.35, abs=0.1)
    assert judged(PLANTED.source_of(run._replace(velocities=hotter)), NAME, ensemble="none") == ()


def test_the_start_is_left_out() -> None:
    run = PLANTED.ornstein_uhlenbeck(1)
    melting = run.velocities * np.where(np.arange(len(run.times)) < 50, 1.5, 1.0)[:, None, None]
    source = PLANTED.source_of(run._replace(velocities=melting))
    assert judged(source, NAME)[0].outcome == "pass"
    assert "the first 60 frames are left out" in said(source, NAME)
    assert judged(source, NAME, skip=0.0)[0].outcome != "pass"


def test_a_file_shorter_than_its_correlations_is_one_sample() -> None:
    """Of 20 files of 0.4 of the correlation time none is red, whatever their means."""
    for seed in range(20):
        for options in ({}, {"ensemble": "nvt", "temperature": "1.3"}):
            found = judged(bath(seed, frames=40, dt=0.01), NAME, **options)
            assert all(one.outcome != "fail" for one in found)


def test_a_constant_temperature_has_no_drift() -> None:
    assert judged(flying(), NAME) == ()
    assert "and constant" in said(flying(), NAME)
    t = float((np.array(flying().velocities)[0] ** 2).sum() / 57)
    (one,) = judged(flying(), NAME, temperature=repr(t * 1.1))
    assert one.outcome == "pass", "one sample of the canonical ensemble may be off by 10 %"
    (one,) = judged(flying(), NAME, temperature=repr(t / 3))
    assert one.outcome == "fail"


def test_degrees_of_freedom() -> None:
    free, constrained = (said(flying(), NAME, constraints=n) for n in (0, 19))
    assert "of 57 degrees of freedom" in free
    assert "of 38 degrees of freedom" in constrained
    assert "nothing moves about the centre of mass" in said(flying(number=1), NAME)
