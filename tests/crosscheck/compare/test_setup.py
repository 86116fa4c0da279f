"""What is different in a set-up, and what only has another name."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from crosscheck.compare.differences import converted, roundings_of
from crosscheck.compare.pairing import pair
from crosscheck.compare.setup import different_setup
from crosscheck.trajectories.frames import DOUBLE, QUANTITIES, SINGLE, Box, Frame, Rounding, Units
from crosscheck.trajectories.memory import in_memory

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
        (
            {"box": Box(5 * np.eye(3), np.zeros(3), np.array([True, False, True]))},
            "the box is periodic along x, y, z against x, z",
        ),
        (
            {"box": Box(5 * np.eye(3), np.zeros(3), np.zeros(3, dtype=bool))},
            "the box is periodic along x, y, z against no axis",
        ),
        (  # as AMBER's NetCDF states what is not periodic
            {"box": Box(np.diag([5.0, 5.0, 0.0]), np.zeros(3), np.ones(3, dtype=bool))},
            "the box is periodic along x, y, z against x, y",
        ),
    ],
)
def test_what_is_different_is_told(changes: dict[str, Any], told: str) -> None:
    (found,) = different_setup(frame(), frame(**changes), ROUNDING)
    assert told in found
    assert "and 0 more" not in found


def test_particles_that_are_missing_are_told() -> None:
    fewer = Frame(0.0, None, np.arange(1, 4), np.zeros((3, 3)))
    assert different_setup(frame(), fewer, ROUNDING)[0] == "4 particles against 3"


@pytest.mark.parametrize(
    "changes",
    [
        {"types": np.array([0, 0, 1, 1])},
        {"types": np.array(["He", "He", "Ar", "Ar"])},
        {"types": None, "masses": None, "diameters": None, "box": None},
        {"box": Box(np.diag([5.0, 5.0, 5.0 + 2e-7]), np.ones(3), np.ones(3, dtype=bool))},
        {"box": Box(np.diag([5.0, 5.0, 5.0]), np.zeros(3), np.zeros(3, dtype=bool), stated=False)},
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
    thick = thin._replace(vectors=np.diag([5.0, 5.0, 0.2]))
    assert different_setup(frame(positions=plane, box=thin), frame(positions=plane, box=thick), ROUNDING) == []
    alone = [
        Frame(0.0, None, np.array([1]), np.array([[1.0, 2.0, 0.0]]), box=box._replace(vectors=5 * np.eye(3)))
        for box in (thin, none)
    ]
    assert different_setup(alone[0], alone[1], ROUNDING) == []
    longer = alone[0]._replace(box=none._replace(vectors=np.diag([5.0, 5.5, 5.0])))
    assert different_setup(alone[0], longer, ROUNDING) == ["the edges of the box are 5 x 5 x 5 against 5 x 5.5 x 5"]


def test_what_rounding_lets_sizes_and_edges_differ_by_is_converted_with_them() -> None:
    """A file in nm with three decimals: a number in Angstrom may differ by 0.005."""
    here, there = (in_memory(name, np.zeros(1), np.zeros((1, 4, 3))) for name in ("a", "b"))
    here = replace(here, units=Units("Angstrom", "fs", "Angstrom/fs"))
    digits = dict.fromkeys(QUANTITIES, Rounding(0.0005, 0.0, "3 decimals"))
    there = replace(there, units=Units("nm", "ps", "nm/ps"), rounding=digits)
    pairing = pair(here, there)
    roundings = roundings_of(here, there, pairing)
    yours = converted(frame(), pairing)
    same = {"positions": yours.positions, "diameters": yours.diameters, "box": yours.box}
    assert different_setup(frame(**same), yours, roundings) == []
    for more, found in ((0.0049, 0), (0.0051, 1)):
        assert yours.diameters is not None
        assert len(different_setup(frame(**same | {"diameters": yours.diameters + more}), yours, roundings)) == found
        longer = Box(np.diag([50.0, 50.0, 50.0 + more]), np.zeros(3), np.ones(3, dtype=bool))
        assert len(different_setup(frame(**same | {"box": longer}), yours, roundings)) == found
    masses = np.array([1.0, 1.0, 3.0, 3.00051])  # they have no unit of length
    assert len(different_setup(frame(**same | {"masses": masses}), yours, roundings)) == 1
