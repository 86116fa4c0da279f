"""g(r) of particles at random, of a lattice, of hard rods in a plane, and of a box that does not fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from inspected import cube, flying, judged, of_property, said

from crosscheck.inspect.properties.radial_distribution import _RadialDistribution
from crosscheck.inspect.setting import Options, setting_of
from crosscheck.trajectories.frames import Box, Frame
from crosscheck.trajectories.memory import InMemory

NAME = "radial distribution"


def scattered(seed: int, frames: int = 60, number: int = 60, **more: Any) -> Any:
    x = np.random.default_rng(seed).uniform(0, 5, (frames, number, 3))
    return flying(frames=frames, number=number, positions=x, velocities=None, **more)


@pytest.mark.parametrize("seed", range(4))
def test_particles_at_random_have_g_of_1(seed: int) -> None:
    source = scattered(seed)
    (one,) = judged(source, NAME, homogeneous=True)
    assert one.outcome == "pass"
    assert one.expected < 0.1
    (figure,) = of_property(source, NAME).figures
    g = np.array(figure.series[0].y)
    r = np.array(figure.series[0].x)
    assert np.average(g, weights=r**2) == pytest.approx(1, abs=0.01)


def test_in_a_plane_of_any_thickness() -> None:
    x = np.random.default_rng(1).uniform(0, 5, (60, 50, 3))
    x[..., 2] = 0.25
    for thickness in (0.0, 0.5):
        box = Box(np.diag([5.0, 5.0, thickness]), np.zeros(3), np.array([True, True, True]))
        (one,) = judged(flying(frames=60, number=50, positions=x, velocities=None, box=box), NAME, homogeneous=True)
        assert (one.outcome, one.measured < 0.05) == ("pass", True)


def test_a_box_that_does_not_fit() -> None:
    """The density is that of the box: with one that is too large g(r) does not go to 1."""
    source = scattered(1, frames=20, number=1500)
    assert judged(source, NAME, homogeneous=True, skip=0.0)[0].outcome != "fail"
    wide = scattered(1, frames=20, number=1500, box=cube(6.5))
    assert judged(wide, NAME, homogeneous=True, skip=0.0)[0].outcome == "fail"
    assert judged(wide, NAME) == ()
    assert "--homogeneous asks for 1" in said(wide, NAME)


def test_the_waves_of_a_crystal_are_a_doubt_and_no_fault() -> None:
    sites = np.stack(np.meshgrid(*[np.arange(4) * 1.25] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x = sites + 0.05 * np.random.default_rng(1).normal(size=(100, 64, 3))
    (one,) = judged(flying(frames=100, number=64, positions=x, velocities=None), NAME, homogeneous=True)
    assert one.outcome == "pass"
    assert one.expected > 0.2, "what it could see is little, and that is stated"


@dataclass(frozen=True)
class _Breathing(InMemory):
    """Boxes whose edges change from frame to frame, as at constant pressure."""

    change: float = 0.0

    def _frame(self, index: int) -> Frame:
        return super()._frame(index)._replace(box=cube(5 * (1 + self.change * (-1) ** (index // 2))))


@pytest.mark.parametrize(("change", "left_out"), [(0.02, ""), (0.2, "20 frames are left out")])
def test_boxes_that_change(change: float, left_out: str) -> None:
    text = said(_Breathing(**vars(scattered(1, frames=40)), change=change), NAME, skip=0.0)
    assert ("left out" in text) == bool(left_out)
    assert left_out in text


def test_the_line_through_the_tail_is_told_at_its_ends() -> None:
    """Weights of a line: of any straight g(r) they give its values where the tail begins and ends."""
    setting = setting_of(scattered(1, number=1500), None, Options(homogeneous=True))
    tail = _RadialDistribution(setting, 2.4)
    begin, end = tail._line()
    middle = (tail._edges[1:] + tail._edges[:-1]) / 2
    straight = 0.8 + 0.3 * middle
    assert (begin @ straight, end @ straight) == pytest.approx((0.8 + 0.3 * 0.7 * 2.4, 0.8 + 0.3 * 2.4))


def test_the_first_peak_is_told() -> None:
    sites = np.stack(np.meshgrid(*[np.arange(4) * 1.25] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x = sites + 0.02 * np.random.default_rng(1).normal(size=(40, 64, 3))
    text = said(flying(frames=40, number=64, positions=x, velocities=None), NAME)
    assert float(text.split(" at r = ")[1].split(",")[0]) == pytest.approx(1.25, abs=0.05)


def test_what_keeps_it_from_being_said() -> None:
    assert "no box" in said(scattered(1, box=None), NAME)
    walls = Box(np.diag([5.0] * 3), np.zeros(3), np.array([True, True, False]))
    assert "not periodic along all axes" in said(scattered(1, box=walls), NAME)
    assert "fewer than 4 frames" in said(scattered(1, frames=3), NAME)
    assert "in a plane or in space" in said(scattered(1, number=1), NAME)
