"""Overlaps of hard particles, and smallest distances of others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hard_disks import disks
from inspected import cube, flying, judged, said

from crosscheck.scene import Box, Explicit, HardSpheres, Method
from crosscheck.scene.parts import Contact
from crosscheck.trajectories.frames import Rounding

NAME = "overlaps"


def lattice(gap: float = 0.0, **more: Any) -> Any:
    """27 spheres of diameter 1 on a lattice, of which two, across a face of the box, are `gap` apart in frame 3."""
    x = np.stack(np.meshgrid(*[np.arange(3) * 5 / 3] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    positions = np.broadcast_to(x, (5, 27, 3)).copy()
    positions[3, 18] = positions[3, 0] - np.array([1 + gap, 0, 0])
    entries = {"positions": positions, "velocities": None, "diameters": np.ones(27), "masses": None, "box": cube()}
    return flying(frames=5, number=27, **(entries | more))


@pytest.mark.parametrize(("gap", "outcome"), [(1e-6, "pass"), (0.0, "pass"), (-1e-12, "fail"), (-1e-6, "fail")])
def test_an_overlap_beyond_the_last_bits(gap: float, outcome: str) -> None:
    (one,) = judged(lattice(gap), NAME, hard=True)
    assert one.outcome == outcome
    assert one.measured == pytest.approx(max(-gap, 0), abs=1e-15)
    assert one.sensitivity < 1e-13
    if outcome == "fail":
        assert one.note == "particles 1 and 19 in frame 3 (counted from 0)"


@pytest.mark.parametrize(("gap", "outcome"), [(-1e-5, "pass"), (-1e-3, "fail")])
def test_digits_of_the_file_are_let_through(gap: float, outcome: str) -> None:
    rounding = Rounding(0.5e-4, 0.0, "4 decimals")
    assert judged(lattice(gap, rounding=rounding), NAME, hard=True)[0].outcome == outcome


def test_digits_of_the_diameters_are_let_through_and_a_scene_has_all_of_its_own() -> None:
    source = lattice(-1e-5)
    source.rounding["diameters"] = Rounding(0.5e-4, 0.0, "4 decimals")
    assert judged(source, NAME, hard=True)[0].outcome == "pass"
    x = np.array([[1.0, 1.0, 0.0], [1.0 + 1 - 1e-5, 1.0, 0.0], [4.0, 4.0, 0.0]])
    plane = flying(frames=4, number=3, positions=np.broadcast_to(x, (4, 3, 3)), velocities=None, box=None)
    plane.rounding["diameters"] = Rounding(0.5e-4, 0.0, "4 decimals")
    assert judged(plane, NAME, disks(box=Box(lengths=(6.0, 5.0))))[0].outcome == "fail"


def test_images_in_an_unwrapped_file() -> None:
    x = np.array(lattice(-1e-6).positions)
    x[:, 5:] += np.array([10.0, -5.0, 25.0])
    assert judged(lattice(positions=x), NAME, hard=True)[0].measured == pytest.approx(1e-6, rel=1e-6)


def test_sizes_that_differ() -> None:
    sizes = np.ones(27)
    sizes[18] = 0.5
    assert judged(lattice(-0.2, diameters=sizes), NAME, hard=True)[0].outcome == "pass"
    assert judged(lattice(-0.26, diameters=sizes), NAME, hard=True)[0].outcome == "fail"
    sizes[[0, 18]] = 0.0
    assert judged(lattice(-0.9, diameters=sizes), NAME, hard=True) == (), "points do not touch"
    assert "all diameters are 0" in said(lattice(diameters=np.zeros(27)), NAME, hard=True)


def test_without_diameters_the_smallest_distance_is_told() -> None:
    (one,) = judged(lattice(-0.3), NAME)
    assert one.outcome == "pass"
    assert "the smallest distance is 0.7, of particles 1 and 19 in frame 3" in said(lattice(-0.3), NAME)
    (one,) = judged(lattice(-1.0), NAME)
    assert (one.outcome, one.measured) == ("fail", 1.0)
    coarse = lattice(-1.0, rounding=Rounding(0.05, 0.0, "1 decimal"))
    assert judged(coarse, NAME) == ()
    assert "the file's digits are few" in said(coarse, NAME)


def test_a_scene_says_whether_particles_are_hard() -> None:
    scene = disks(
        box=Box(lengths=(6.0, 6.0)),
        hard_spheres=HardSpheres(diameter=1.0, fixed=(1,)),
        species=(0, 1, 1),
        initial=Explicit(positions=((1.0, 1.0), (3.0, 3.0), (5.0, 1.5))),
    )
    x = np.zeros((4, 3, 3))
    x[..., :2] = (1.0, 1.0), (3.0, 3.0), (3.4, 3.0)
    source = flying(frames=4, number=3, positions=x, velocities=None, masses=None, box=None)
    assert judged(source, NAME, scene) == (), "two fixed particles may overlap"
    x[2, 0, :2] = 3.0, 2.1
    source = flying(frames=4, number=3, positions=x, velocities=None, masses=None, box=None)
    assert judged(source, NAME, scene)[0].measured == pytest.approx(0.1)
    soft = scene.changed(
        species=None,
        hard_spheres=HardSpheres(),
        method=Method(scheme="velocity_verlet", dt=0.01, contact=Contact(stiffness=1e3)),
    )
    assert [one.quantity for one in judged(source, NAME, soft)] == ["pairs at distance 0"]


def test_what_keeps_it_from_being_said() -> None:
    assert "there is one particle" in said(flying(number=1, velocities=None), NAME)
    assert "smaller than two diameters" in said(lattice(diameters=np.full(27, 3.0)), NAME, hard=True)
    far = flying(number=2, box=None, positions=np.array([[[0.0, 0, 0], [100.0, 0, 0]]] * 4), frames=4, velocities=None)
    assert "no two particles come nearer" in said(far, NAME)
