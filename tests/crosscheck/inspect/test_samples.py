"""Whether a file holds more than one sample of its velocities."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying

from crosscheck.inspect.samples import Samples, apart
from crosscheck.inspect.setting import Ensemble, Options, setting_of
from crosscheck.inspect.view import View


def samples(source: object, ensemble: Ensemble | None = None) -> Samples:
    setting, before = setting_of(source, None, Options(ensemble=ensemble)), None
    found = Samples(setting)
    for index in range(len(source)):
        before = View(setting, index, source.read(index), before)
        found.add(before)
    return found


@pytest.mark.parametrize(
    ("dt", "frames", "one"), [(0.001, 100, True), (0.01, 40, True), (0.05, 200, False), (1.0, 30, False)]
)
def test_velocities_that_last_are_one_sample(dt: float, frames: int, one: bool) -> None:
    """The velocities of these particles forget themselves as exp(-t)."""
    source = PLANTED.source_of(PLANTED.ornstein_uhlenbeck(1, frames=frames, dt=dt))
    assert samples(source).one is one


def test_speeds_that_last_are_one_sample_although_directions_change() -> None:
    rng = np.random.default_rng(1)
    v = rng.normal(size=(60, 20, 3))
    v *= (rng.uniform(0.1, 3, 20) / np.linalg.norm(v, axis=2))[..., None]
    assert samples(flying(velocities=v)).one


def test_the_error_of_one_sample_is_that_of_its_law() -> None:
    found = samples(flying())
    values = np.full(60, 1.5)
    mean = found.mean(values, 0.04)
    assert (mean.value, mean.error, mean.independent) == (1.5, 0.2, 1.0)
    assert found.independent(values) == 1.0
    many = samples(PLANTED.source_of(PLANTED.normals(1, 60)))
    noise = np.random.default_rng(1).normal(size=60)
    assert many.mean(noise, 0.04).error == pytest.approx(1 / 60**0.5, rel=0.5)
    assert many.independent(noise) > 30


def test_waves_of_a_crystal_may_keep_their_energies() -> None:
    """But for those of a bath; and particles that leave their places have none."""
    crystal = PLANTED.source_of(PLANTED.harmonic_crystal(1, frames=60, edge=3))
    gas = PLANTED.source_of(PLANTED.ornstein_uhlenbeck(1, frames=60))
    assert [samples(crystal).waves, samples(crystal, "nvt").waves, samples(gas).waves] == [True, False, False]
    wrapped = PLANTED.source_of(PLANTED.wrapped(PLANTED.harmonic_crystal(1, frames=60, edge=3)))
    assert samples(wrapped).waves  # particles that move about a face of the box
    found = samples(crystal)
    assert found.doubt(0.04, 1e-3)[0] == pytest.approx(3.29 * 0.2, rel=1e-3)
    assert found.independent(np.random.default_rng(1).normal(size=60)) == 1.0
    assert samples(gas).doubt(0.04, 1e-3) == (0.0, "")
    assert samples(flying()).doubt(0.04, 1e-3)[0] == 0.0  # one sample of all, which has that error


@pytest.mark.parametrize(
    ("number", "independent", "every"),
    [(100, 100.0, 1), (100, 50.0, 3), (100, 10.0, 19), (100, 1.0, 100), (100, 200.0, 1)],
)
def test_independent_frames_are_twice_as_far_apart(number: int, independent: float, every: int) -> None:
    assert apart(number, independent) == every
