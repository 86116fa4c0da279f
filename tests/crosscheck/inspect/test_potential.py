"""The potential energy of scenes at other positions, against sums by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hard_disks import disks
from pair_sums import evaluate

from crosscheck.inspect.potential import potential_of
from crosscheck.scene import Box, Gravity, HardSpheres, Lattice, LennardJones, Scene, Spring, explicit
from crosscheck.scene.parts import Well
from crosscheck.trajectories.frames import Box as FileBox
from crosscheck.trajectories.frames import Frame


def frame_of(positions: np.ndarray, box: FileBox | None = None) -> Frame:
    space = np.pad(positions, ((0, 0), (0, 3 - positions.shape[1])))
    return Frame(0.0, 0, np.arange(1, len(space) + 1), space, box=box)


def moved(scene: Scene, seed: int = 1) -> np.ndarray:
    positions = scene.own_start().positions
    return positions + np.random.default_rng(seed).uniform(-0.05, 0.05, positions.shape)


@pytest.mark.parametrize("truncation", ["truncated", "shifted", "force_shifted"])
def test_lennard_jones(truncation: str) -> None:
    """Of a plain cut, the shifted potential: the one that the forces conserve."""
    lj = LennardJones(cutoff=2.0, truncation=truncation)
    lattice = Lattice(kind="lattice", structure="fcc", number=32, temperature=1.0, seed=1)
    scene = Scene(name="s", dimension=3, duration=1.0, lennard_jones=lj, box=Box(density=0.5), initial=lattice)
    x = moved(scene)
    same = scene.changed(
        initial=explicit(x, np.zeros_like(x)),
        box=Box(lengths=tuple(scene.lengths().tolist())),
        lennard_jones=lj.model_copy(update={"truncation": truncation.replace("truncated", "shifted")}),
    )
    assert potential_of(scene)(frame_of(x)) == pytest.approx(evaluate(same).energy, rel=1e-12)


def test_positions_count_from_the_corner_of_the_box() -> None:
    scene = Scene(
        name="s", dimension=2, duration=1.0, spring=Spring(k=3.0), initial=explicit(np.eye(2), np.zeros((2, 2)))
    )
    assert potential_of(scene)(frame_of(np.array([[1.0, 2.0], [0.0, 3.0]]))) == pytest.approx(1.5 * 14)
    fallen = disks(acceleration=(0.0, -2.0), box=Box(lengths=(6.0, 5.0), boundaries=("periodic", "hard")))
    lower = FileBox(np.diag([6.0, 5.0, 0.0]), np.array([0.0, -1.0, 0.0]), np.array([True, False, False]))
    frame = frame_of(np.array([[1.0, 0.0], [3.0, 1.0], [5.0, 2.0]]), lower)
    assert potential_of(fallen)(frame) == pytest.approx(2.0 * (1 + 2 + 3))


def test_gravity_of_a_few_bodies_and_none_of_many() -> None:
    x = np.array([[0.0, 0.0], [3.0, 4.0]])
    scene = Scene(
        name="s", dimension=2, duration=1.0, masses=(2.0, 3.0), gravity=Gravity(G=2.0), initial=explicit(x, 0 * x)
    )
    assert potential_of(scene)(frame_of(x)) == pytest.approx(-2.0 * 6 / 5)
    many = np.random.default_rng(1).uniform(0, 9, (1001, 2))
    scene = Scene(name="s", dimension=2, duration=1.0, gravity=Gravity(), initial=explicit(many, 0 * many))
    assert "1000 bodies" in potential_of(scene)


def test_wells_count_pairs_inside() -> None:
    scene = disks(
        hard_spheres=HardSpheres(well=Well(depth=0.7, range=1.5)),
        box=Box(lengths=(9.0, 9.0)),
        initial=explicit(np.array([[1.0, 1.0], [2.2, 1.0], [5.0, 5.0]]), np.zeros((3, 2))),
    )
    box = FileBox(np.diag([9.0, 9.0, 0.0]), np.zeros(3), np.array([True, True, False]))
    for second, pairs in (((2.49, 1.0), 1), ((2.51, 1.0), 0), ((8.51, 1.0), 1)):
        frame = frame_of(np.array([[1.0, 1.0], second, [5.0, 5.0]]), box)
        assert potential_of(scene)(frame) == pytest.approx(-0.7 * pairs)


def test_particles_in_one_place_have_no_finite_energy() -> None:
    lattice = Lattice(kind="lattice", structure="fcc", number=32, temperature=1.0, seed=1)
    scene = Scene(
        name="s",
        dimension=3,
        duration=1.0,
        lennard_jones=LennardJones(cutoff=2.0),
        box=Box(density=0.5),
        initial=lattice,
    )
    x = moved(scene)
    x[3] = x[4]
    assert not np.isfinite(potential_of(scene)(frame_of(x)))
