"""What is different in a set-up, and what only has another name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crosscheck.compare.setup import different_setup
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Box, Frame, Rounding

ROUNDING = dict.fromkeys(("masses", "diameters", "box"), (DOUBLE, DOUBLE))


def frame(**known: Any) -> Frame:
    box = Box(np.diag([5.0, 5.0, 5.0]), np.zeros(3), np.ones(3, dtype=bool))
    made = Frame(0.0, None, np.arange(1, 5), np.arange(12.0).reshape(4, 3), box=box)
    return made._replace(
        types=np.array([1, 1, 2, 2]), masses=np.array([1.0, 1.0, 3.0, 3.0]), diameters=np.full(4, 0.5)
    )._replace(**known)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"masses": np.array([1.0, 1.0, 3.0, 3.003])}, "the mass of particle 4 is 3 against 3.003"),
        (
            {"diameters": np.array([0.5, 0.50001, 0.5, 0.6])},
            "the diameter of particle 2 is 0.5 against 0.50001, and 1 more",
        ),
        ({"types": np.array([1, 2, 2, 2])}, "the type of particle"),
        ({"ids": np.array([1, 2, 3, 9])}, "2 ids occur in one of them alone, such as 4"),
        (
            {"box": Box(np.diag([5.0, 5.001, 5.0]), np.zeros(3), np.ones(3, dtype=bool))},
            "the edges of the box are 5 x 5 x 5 against 5 x 5.001 x 5",
        ),
    ],
)
def test_what_is_different_is_told(changes: dict[str, Any], told: str) -> None:
    (found,) = different_setup(frame(), frame(**changes), ROUNDING)
    assert told in found


def test_particles_that_are_missing_are_told() -> None:
    fewer = Frame(0.0, None, np.arange(1, 4), np.zeros((3, 3)))
    assert different_setup(frame(), fewer, ROUNDING)[0] == "4 particles against 3"


@pytest.mark.parametrize(
    "changes",
    [
        {"types": np.array([0, 0, 1, 1])},
        {"types": np.array(["He", "He", "Ar", "Ar"])},
        {"types": None, "masses": None, "diameters": None, "box": None},
        {"box": Box(np.diag([5.0, 5.0, 5.0 + 2e-7]), np.ones(3), np.zeros(3, dtype=bool))},
    ],
)
def test_other_names_and_what_is_not_stated_are_no_difference(changes: dict[str, Any]) -> None:
    assert different_setup(frame(), frame(**changes), ROUNDING) == []
    assert different_setup(frame(**changes), frame(), ROUNDING) == []


def test_masses_of_32_bits() -> None:
    masses = np.array([39.948, 39.948, 83.798, 83.798])
    rounded = masses.astype(np.float32).astype(np.float64)
    assert different_setup(frame(masses=masses), frame(masses=rounded), ROUNDING)
    single = dict.fromkeys(("masses", "diameters", "box"), (DOUBLE, SINGLE))
    assert different_setup(frame(masses=masses), frame(masses=rounded), single) == []


def test_edges_that_a_file_has_rounded_or_left_out_are_no_difference() -> None:
    rough = Box(np.diag([5.0, 5.0, 5.00002]), np.zeros(3), np.ones(3, dtype=bool))
    assert different_setup(frame(), frame(box=rough), ROUNDING)
    digits = ROUNDING | {"box": (DOUBLE, Rounding(0.0, 5e-6, "6 significant digits"))}
    assert different_setup(frame(), frame(box=rough), digits) == []
    plane = np.arange(12.0).reshape(4, 3) * np.array([1.0, 1.0, 0.0])
    thin = Box(np.diag([5.0, 5.0, 0.1]), np.zeros(3), np.ones(3, dtype=bool))
    none = Box(np.diag([5.0, 5.0, 0.0]), np.zeros(3), np.array([True, True, False]))
    assert different_setup(frame(positions=plane, box=thin), frame(positions=plane, box=none), ROUNDING) == []
