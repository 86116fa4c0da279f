"""Hard spheres: entries that contradict each other, and initial states that are impossible."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scene_files import DISKS, DRUM, FLUID, MIXTURE, ROUGH, SPRING, TURNING, assert_one_message, changed, load

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Contact,
    HardSpheres,
    Lattice,
    Scene,
)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (DISKS, "hard_spheres.diameter", [1.0, 2.0],
         "hard_spheres.diameter has 2 values, one per species: add species"),
        (MIXTURE, "species", [0, 2], "species 2 has no hard_spheres.diameter: there are 2 values"),
        (DISKS, "hard_spheres.fixed", [1], "hard_spheres.fixed: there is no particle of species 1"),
        (MIXTURE, "hard_spheres.fixed", [0, 1], "hard_spheres.fixed: all particles are fixed, nothing moves"),
        (TURNING, "hard_spheres.friction", ROUGH | {"inertia": 1.5},
         "inertia = 1.5 is more than that of a hollow grain, 1:"),
        (DISKS, "acceleration", [1.0], "acceleration needs 2 components, found 1"),
        (changed(MIXTURE, "hard_spheres.fixed", [0]), "acceleration", [0.0, -1.0], "fixed particles do not fall"),
        (DISKS, "initial", {"kind": "kepler", "eccentricity": 0.0}, "initial.kind = 'kepler' needs [gravity]"),
        (DISKS, "initial.angular_velocities", [[1.0], [1.0]],
         "smooth grains do not rotate: add [hard_spheres.friction]"),
        (DISKS, "box", {"lengths": [5.0, 5.0], "boundaries": ["wall", "wall"], "wall": {"cutoff": 1.0}},
         'box.boundaries: a "wall" is for [lennard_jones]; that of hard spheres is called "hard"'),
        (DISKS, "box.faces", {"w-": {}}, 'box.faces."w-": there is no such face; the faces are x-, x+, y-, y+'),
        (DISKS, "box.faces", {"z-": {}}, 'box.faces."z-": there is no such face'),
        (DISKS, "box.faces", {"x-": {}}, 'box.faces."x-": box.boundaries says "periodic" along x: make it "hard"'),
        (DISKS, "box.faces", {"y-": {"friction": ROUGH}},
         'box.faces."y-".friction: smooth grains have no friction at walls'),
        (DISKS, "box.faces", {"y-": {"temperature": 1.0}},
         "seed is missing: walls with temperature or random_phase draw"),
        (DRUM, "box.cylinder.axis", "x", "box.cylinder.axis = 'x': in the plane it is a circle: remove axis"),
        (DRUM, "box.cylinder.friction", ROUGH, "box.cylinder.friction: smooth grains have no friction at walls"),
        (DRUM, "box.boundaries", ["open", "hard"],
         'box.boundaries: along y, across the cylinder, it must be "open", found "hard"'),
        (DISKS, "output", {"interval": 1.0, "observables": ["virial"]}, "hard spheres have no 'virial'"),
        (DISKS, "output", {"forces": True}, "output.forces: hard spheres exert impulses, not forces"),
        (DISKS, "output", {"interval": 1.0, "observables": ["rotational_energy"]},
         "'rotational_energy' needs [hard_spheres.friction]"),
        (DISKS, "output", {"interval": 1.0, "observables": ["wall_torque"]}, "'wall_torque' needs [box.cylinder]"),
        (DISKS, "output", {"fields": [4]}, "output.fields needs 2 entries, found 1"),
        (changed(DISKS, "box", ...), "output", {"fields": [4, 4]}, "output.fields divides a box into cells: add [box]"),
        (SPRING, "acceleration", [1.0], "acceleration goes with [hard_spheres] only"),
        (SPRING, "output", {"interval": 1.0, "observables": ["collisions"]},
         "'collisions' goes with [hard_spheres] only"),
        (FLUID, "box", {"packing_fraction": 0.4}, "box.packing_fraction goes with [hard_spheres] only"),
        (FLUID, "box.boundaries", ["hard"] * 3, 'a boundary "hard" goes with [hard_spheres] only'),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_with_its_path(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    assert_one_message(tmp_path, changed(table, path, value), message)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (DISKS, "box.lengths", [2.0, 5.0],
         "its length 2 along x, which is periodic, must exceed two contact ranges, 2:"),
        (changed(DISKS, "hard_spheres.well", {"depth": 1.0, "range": 2.5}), "box.lengths", [5.0, 9.0],
         "must exceed two contact ranges, 5"),
        (DISKS, "initial.positions", [[1.0, 1.0], [1.5, 1.0]],
         r"particles 0 and 1 overlap: their centres are 0.5 apart, and their contact distance is 1 \(gap -0.5\): move"),
        (DISKS, "initial.positions", [[0.2, 2.0], [4.8, 2.0]],
         "particles 0 and 1 overlap: their centres are 0.4 apart"),
        (DISKS, "initial.positions", [[1.0, 0.4], [3.0, 3.0]],
         "particle 0 is beyond the wall y- by 0.1: its centre must be at least 0.5 from y = 0; it is at 0.4"),
        (DISKS, "initial.positions", [[1.0, 1.0], [3.0, 7.0]], r"particle 1 is beyond the wall y\+ by 2.5"),
        (changed(DISKS, "box.faces", {"y-": {"oscillation": {"amplitude": 0.7, "frequency": 1.0}}}), "duration", 1.0,
         "particle 0 is beyond the wall y- by 0.2"),
        (DISKS, "box.faces", {"y-": {"oscillation": {"amplitude": 4.1, "frequency": 1.0}}},
         "box.faces: the walls that oscillate along y leave no room for the largest particle"),
        (DRUM, "initial.positions", [[2.5, 2.5], [2.5, 4.6]],
         "particle 1 is beyond the cylinder by 0.1: its centre must be within 2 of the axis; it is 2.1 away"),
        (DRUM, "box.cylinder.radius", 3.0, "box.cylinder.radius = 3 does not fit into the box: make box.lengths"),
        (changed(MIXTURE, "initial.positions", [[1.0, 1.0], [4.0, 3.0]]), "hard_spheres.fixed", [0],
         r"initial.velocities\[0\] is not zero: the particle is of a fixed species"),
        (MIXTURE, "species", [0], "species: 1 values for 2 particles"),
        (DISKS, "initial", {"kind": "lattice", "structure": "square", "number": 36, "speed": 1.0, "seed": 0},
         "overlap.*take fewer particles, smaller ones or a larger box"),
        (changed(DISKS, "box.lengths", [5.0, 0.9]), "initial",
         {"kind": "lattice", "structure": "square", "number": 4, "speed": 1.0, "seed": 0},
         "box: 0.9 along y is too narrow for a particle of diameter 1 between its walls"),
        (changed(DRUM, "box.cylinder.radius", 0.4), "initial",
         {"kind": "lattice", "structure": "square", "number": 1, "speed": 1.0, "seed": 0},
         "box.cylinder.radius = 0.4 must exceed that of the particles, 0.5"),
    ],
)  # fmt: skip
def test_hard_states_that_cannot_be(tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str) -> None:
    if path == "box.lengths" and "well" in table["hard_spheres"]:
        table = changed(table, "initial.positions", [[1.0, 1.0], [3.0, 5.0]])
    with pytest.raises(UsageError, match=message) as error:
        load(tmp_path, changed(table, path, value)).initial_state()
    assert len(str(error.value).splitlines()) == 1


def test_touching_is_no_overlap(tmp_path: Path) -> None:
    load(tmp_path, changed(DISKS, "initial.positions", [[1.0, 0.5], [2.0 - 1e-12, 0.5]])).initial_state()


#: (table, changes, what a start with soft contacts is refused for; None: it is not).
SOFT_STARTS: list[tuple[dict[str, Any], dict[str, Any], str | None]] = [
    (DISKS, {"initial.positions": [[1.0, 1.0], [1.51, 1.0]]}, None),
    (DISKS, {"initial.positions": [[1.0, 1.0], [1.49, 1.0]]},
     r"particles 0 and 1 overlap by more than the smaller of their radii, 0.5: their centres are 0.49 apart"),
    (DISKS, {"initial.positions": [[0.2, 2.0], [4.7, 2.0]]}, None),
    (DISKS, {"initial.positions": [[0.2, 2.0], [4.8, 2.0]]},
     "particles 0 and 1 overlap by more than the smaller of their radii, 0.5"),
    (DISKS, {"initial.positions": [[1.0, 0.01], [3.0, 3.0]]}, None),
    (DISKS, {"initial.positions": [[1.0, -0.01], [3.0, 3.0]]},
     r"particle 0 is beyond the wall y- by 0.51, more than its radius: its centre "
     r"must be at least 0 from y = 0; it is at -0.01"),
    (DISKS, {"initial.positions": [[1.0, 1.0], [3.0, 7.0]]},
     r"particle 1 is beyond the wall y\+ by 2.5, more than its radius"),
    (DRUM, {"initial.positions": [[2.5, 2.5], [2.5, 4.6]]}, None),
    (DRUM, {"initial.positions": [[2.5, 2.5], [2.5, 5.01]]},
     "particle 1 is beyond the cylinder by 0.51, more than its radius: its centre must be within 2.5 of the axis"),
    (DISKS, {"box.faces": {"y-": {"oscillation": {"amplitude": 5.1, "frequency": 1.0}}}},
     "walls that oscillate along y leave no room"),
    (DISKS, {"hard_spheres.diameter": [1.0, 0.2], "species": [0, 1], "initial.positions": [[1.0, 1.0], [1.51, 1.0]]},
     None),
    (DISKS, {"hard_spheres.diameter": [1.0, 0.2], "species": [0, 1], "initial.positions": [[1.0, 1.0], [1.49, 1.0]]},
     "smaller of their radii, 0.1"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "changes", "message"), SOFT_STARTS)
def test_soft_spheres_may_start_in_contact_and_hard_ones_may_not(
    tmp_path: Path, table: dict[str, Any], changes: dict[str, Any], message: str | None
) -> None:
    for path, value in changes.items():
        table = changed(table, path, value)
    scene, contact = load(tmp_path, table), Contact(stiffness=1.0)
    with pytest.raises(UsageError, match=r"overlap|beyond the|leave no room"):
        scene.initial_state()
    if message is None:
        np.testing.assert_array_equal(scene.initial_state(contact).positions, table["initial"]["positions"])
        return
    with pytest.raises(UsageError, match=message) as error:
        scene.initial_state(contact)
    assert len(str(error.value).splitlines()) == 1


def test_fixed_particles(tmp_path: Path) -> None:
    still = changed(changed(MIXTURE, "hard_spheres.fixed", [1]), "initial.positions", [[1.0, 1.0], [2.0, 2.8]])
    scene = load(tmp_path, still)
    np.testing.assert_array_equal(scene.fixed(), [False, True])
    scene.initial_state()
    assert not load(tmp_path, MIXTURE).fixed().any()
    # fixed ones may overlap each other
    still = changed(still, "initial.velocities", [[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    three = changed(changed(still, "species", [0, 1, 1]), "initial.positions", [[1.0, 0.6], [1.0, 3.0], [1.5, 3.5]])
    load(tmp_path, three).initial_state()


def test_many_disks_are_checked_at_once() -> None:
    scene = Scene(
        name="many",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=0.5),
        initial=Lattice(kind="lattice", structure="square", number=200_000, temperature=1.0, seed=1),
    )
    assert len(scene.initial_state().positions) == 200_000  # all pairs would take hours
