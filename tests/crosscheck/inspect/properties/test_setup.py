"""Masses, sizes, types and box of a file against those of the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hard_disks import disks
from inspected import flying, judged, said

from crosscheck.scene import Box, HardSpheres
from crosscheck.trajectories.frames import Box as FileBox

SCENE = disks(
    box=Box(lengths=(6.0, 5.0)),
    masses=(1.0, 2.0, 4.0),
    species=(0, 0, 1),
    hard_spheres=HardSpheres(diameter=(1.0, 0.5)),
)
FILE: dict[str, Any] = {
    "masses": np.array([1.0, 2.0, 4.0]),
    "types": np.array(["A", "A", "B"]),
    "diameters": np.array([1.0, 1.0, 0.5]),
    "box": FileBox(np.diag([6.0, 5.0, 1.0]), np.zeros(3), np.array([True, True, False])),
}


def plane(**changes: Any) -> Any:
    return flying(number=3, **(FILE | changes))


def test_a_file_of_the_scene() -> None:
    (one,) = judged(plane(), "set-up", SCENE)
    assert one.outcome == "pass"
    (one,) = judged(plane(masses=None, types=None, diameters=None, box=None), "set-up", SCENE)
    assert one.outcome == "pass"


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"masses": np.array([1.0, 2.0, 4.0 + 1e-12])}, "the mass of particle 3"),
        ({"diameters": np.array([1.0, 1.1, 0.5])}, "the diameter of particle 2 is 1.1 against 1"),
        ({"types": np.array(["A", "B", "B"])}, "the type of particle"),
        ({"box": FILE["box"]._replace(vectors=np.diag([6.0, 5.1, 1.0]))}, "the edges of the box"),
        ({"box": FILE["box"]._replace(periodic=np.array([True, False, False]))}, "periodic along x against x, y"),
    ],
)
def test_what_differs_is_named(changes: dict[str, Any], text: str) -> None:
    (one,) = judged(plane(**changes), "set-up", SCENE)
    assert one.outcome == "fail"
    assert text in one.note


def test_without_a_scene_there_is_nothing_to_compare_with() -> None:
    assert "no scene is given" in said(flying(), "set-up")
