"""Differences of frames: images, rounding, the first component, momentum."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.compare.differences import (
    Gap,
    common_rows,
    converted,
    frames_of,
    gap,
    gaps,
    informed,
    nearest_image,
    spacing,
)
from crosscheck.compare.pairing import Pairing, pair
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Box, Frame, Rounding
from crosscheck.trajectories.memory import in_memory

CUBE = Box(np.diag([5.0, 6.0, 7.0]), np.zeros(3), np.ones(3, dtype=bool))
TILTED = Box(np.array([[5.0, 0, 0], [1.5, 6.0, 0], [-1.0, 2.0, 7.0]]), np.zeros(3), np.ones(3, dtype=bool))
SLAB = Box(np.diag([5.0, 6.0, 0.0]), np.zeros(3), np.array([True, False, False]))


def frame(positions: Any, velocities: Any = None, **known: Any) -> Frame:
    positions = np.asarray(positions, dtype=np.float64)
    return Frame(0.0, None, np.arange(1, len(positions) + 1), positions, velocities, **known)


def between(one: Frame, other: Frame, nearest: bool = False, rounding: Rounding = DOUBLE) -> Gap:
    return gap(0, 0.0, one, other, nearest, dict.fromkeys(("positions", "velocities", "spins"), (rounding, DOUBLE)))


@given(
    st.sampled_from([CUBE, TILTED]),
    st.lists(st.tuples(*[st.integers(-3, 3)] * 3), min_size=1, max_size=5),
    st.integers(0, 1000),
)
def test_images_of_a_particle_are_no_distance(box: Box, images: list[tuple[int, int, int]], seed: int) -> None:
    inside = np.random.default_rng(seed).random((len(images), 3)) @ box.vectors
    apart = nearest_image(inside + np.array(images) @ box.vectors - inside, box)
    assert np.abs(apart).max() < 1e-13


def test_walls_have_no_images() -> None:
    apart = nearest_image(np.array([[4.0, 5.0, 0.5]]), SLAB)
    assert apart.tolist() == [[-1.0, 5.0, 0.5]]


NOT_STATED = CUBE._replace(stated=False)


@pytest.mark.parametrize("walls_first", [True, False])
def test_a_wall_that_one_file_states_is_one_for_both(walls_first: bool) -> None:
    """What crosses half the box between walls has moved, whatever the other file, as of XTC, may be taken for."""
    walls = CUBE._replace(periodic=np.array([True, False, True]))
    moved = np.array([[4.0, 5.0, 6.0]])
    sources = [
        in_memory("dump", np.zeros(1), np.zeros((1, 1, 3)), box=walls),
        in_memory("xtc", np.zeros(1), moved[None], box=NOT_STATED, wrapping="wrapped"),
    ]
    one, other = sources if walls_first else sources[::-1]
    (found,) = gaps(one, other, pair(one, other))
    assert found.largest["positions"] == pytest.approx(np.linalg.norm([-1, 5, -1]))
    for box in (frame.box for frame in frames_of(one, other, pair(one, other), 0)):
        assert box is not None
        assert box.periodic.tolist() == [True, False, True]


def test_where_no_file_states_walls_every_axis_may_be_periodic() -> None:
    none = NOT_STATED._replace(periodic=np.zeros(3, dtype=bool))
    for mine, yours in ((NOT_STATED, none), (none, NOT_STATED)):
        box = informed(frame(np.zeros((1, 3)), box=mine), yours).box
        assert box is not None
        assert box.periodic.all()
        assert not box.stated
    stated = informed(frame(np.zeros((1, 3)), box=CUBE), none).box
    assert stated is CUBE
    assert informed(frame(np.zeros((1, 3)), box=none), None).box is none
    assert informed(frame(np.zeros((1, 3))), CUBE).box is None


def test_spins_and_boxes_are_converted() -> None:
    pairing = Pairing(*[np.zeros(1, dtype=np.int64)] * 2, "time", np.zeros(1), None, 10.0, 0.01, 0.001, 1000.0, ())
    box = CUBE._replace(lower=np.ones(3), stated=False)
    ones = np.ones((2, 3))
    found = converted(frame(ones, ones, spins=ones, diameters=np.ones(2), masses=np.ones(2), box=box), pairing)
    held = (found.positions, found.velocities, found.spins, found.diameters, found.masses)
    assert [float(np.ravel(one)[0]) for one in held] == [10.0, 0.01, 0.001, 10.0, 1.0]
    assert found.box is not None
    assert np.diag(found.box.vectors).tolist() == [50.0, 60.0, 70.0]
    assert found.box.lower.tolist() == [10.0] * 3
    assert not found.box.stated


def test_particles_that_one_frame_lacks_are_counted() -> None:
    one, other = frame(np.zeros((4, 3))), frame(np.zeros((3, 3)))
    other = other._replace(ids=np.array([1, 3, 7]))
    found = between(one, other)
    assert found.missing == (2, 1)
    assert found.number == 2
    assert not found.same
    assert [list(rows) for rows in common_rows(one.ids, other.ids)] == [[0, 2], [0, 1]]
    moved = between(one, other._replace(positions=np.array([[0.0, 0, 0], [0, 1, 0], [0, 0, 0]])))
    assert moved.beyond is not None
    assert (moved.beyond.particle, moved.farthest["positions"]) == (3, 3)
    assert moved.largest["positions"] == 1.0


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("name", ["positions", "velocities", "spins"])
def test_every_component_of_every_quantity_counts(axis: int, name: str) -> None:
    base = np.random.default_rng(1).random((5, 3)) + 1
    one = frame(base, base.copy(), spins=base.copy())
    moved = getattr(one, name).copy()
    moved[3, axis] += 1e-9
    found = between(one, one._replace(**{name: moved}))
    assert found.beyond is not None
    assert (found.beyond.quantity, found.beyond.particle, found.beyond.axis) == (name, 4, axis)
    assert found.beyond == found.differing
    assert found.farthest[name] == 4
    assert found.largest[name] == pytest.approx(1e-9, rel=1e-6)
    assert found.rms[name] == pytest.approx(1e-9 / 5**0.5, rel=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_rounding_of_a_file_is_no_difference(scale: float) -> None:
    base = np.random.default_rng(2).standard_normal((200, 3)) * scale
    rounded = base.astype(np.float32).astype(np.float64)
    found = between(frame(rounded), frame(base), rounding=SINGLE)
    assert found.beyond is None
    assert found.differing is not None
    assert 0.2 * found.floor["positions"] < found.rms["positions"] < found.floor["positions"]
    assert found.largest["positions"] <= found.most["positions"]
    beyond = between(frame(rounded + 3e-7 * scale), frame(base), rounding=SINGLE)
    assert beyond.beyond is not None


def test_numbers_that_are_not_finite_are_seen() -> None:
    one, other = frame(np.ones((3, 3))), np.ones((3, 3))
    other[1, 2] = np.nan
    found = between(one, frame(other))
    assert not found.finite
    assert found.beyond is not None
    assert (found.beyond.particle, found.beyond.axis) == (2, 2)


def test_momentum_and_energy_count_masses() -> None:
    masses, velocities = np.array([1.0, 3.0]), np.array([[1.0, 0, 0], [0, -2.0, 0]])
    found = between(frame(np.zeros((2, 3)), velocities, masses=masses), frame(np.zeros((2, 3)), velocities))
    assert found.momentum == ((1.0, -6.0, 0.0), (1.0, -2.0, 0.0))
    assert found.kinetic == (pytest.approx(13 / 4), pytest.approx(5 / 4))
    assert found.momentum_scale == pytest.approx(np.hypot(1, 6))


def test_distance_of_neighbours() -> None:
    cube = np.stack(np.meshgrid(*[np.arange(5.0)] * 3), axis=-1).reshape(-1, 3)
    box = Box(5 * np.eye(3), np.zeros(3), np.ones(3, dtype=bool))
    assert spacing(frame(cube, box=box)) == pytest.approx(1.0)
    flat = cube[cube[:, 2] == 0]
    assert spacing(frame(flat, box=box)) == pytest.approx(1.0)
    assert spacing(frame(np.zeros((1, 3)))) == 1.0


def test_taking_off_edges_of_a_box_rounds_once_more() -> None:
    x = 1.5
    one, other = frame([[x, x, x]], box=CUBE), frame([[x, x, x + 2 * np.spacing(x)]], box=CUBE)
    assert between(one, other).beyond is not None
    assert between(one, other, nearest=True).beyond is None
    assert between(one._replace(box=None), other._replace(box=None), nearest=True).beyond is not None
