"""The table of observables: whole, consistent with the scenes that ask for it, and read by all who need it."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.engines.protocol import shapes
from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Explicit,
    GrainFriction,
    HardSpheres,
    LatticeGas,
    Occupations,
    Output,
    Scene,
    Spring,
)
from crosscheck.scene.observables import AXIS_NAMES, NAMED, TABLE, Observable, asked_for, lengths, named

PAIR = Explicit(positions=((1.0, 1.0), (3.0, 3.0)))
SPRING = Scene(name="a", dimension=2, duration=1.0, spring=Spring(k=1.0), initial=PAIR)
DISKS = Scene(
    name="a",
    dimension=2,
    duration=1.0,
    hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)),
    box=Box(lengths=(5.0, 6.0), boundaries=("hard", "open")),
    initial=PAIR,
)
GAS = Scene(
    name="a",
    dimension=2,
    duration=1.0,
    lattice_gas=LatticeGas(model="fhp1", columns=8, rows=4),
    initial=Occupations(kind="occupations", density=0.2, seed=0),
)


@pytest.mark.parametrize("row", TABLE.values(), ids=TABLE)
def test_a_row_is_whole(row: Observable) -> None:
    assert set(row.axes) <= set(AXIS_NAMES)
    assert row.meaning
    assert row.unit
    assert not row.cumulative or row.matter == "hard_spheres" or row.name == "force_impulse"
    assert (row.derive is None) == (row.needs == ())
    assert all(need in TABLE for need in row.needs)
    assert row.refusable or row.asked == "always"


def test_names_of_output_are_those_of_the_table() -> None:
    for name in NAMED:
        assert TABLE[name].asked == "observables"
    groups = [named(matter) for matter in ("particles", "smooth_particles", "hard_spheres", "lattice_gas")]
    assert sorted(name for group in groups for name in group) == sorted(NAMED)
    with pytest.raises(UsageError, match="'kinetic_energy', 'potential_energy', 'virial'"):
        SPRING.changed(output=Output.model_construct(interval=1.0, observables=("kinetic_energi",)))


def test_a_scene_asks_for_its_matter_alone() -> None:
    assert list(SPRING.asked()) == ["time", "final_positions", "final_velocities"]
    assert list(DISKS.asked()) == ["time", "final_positions", "final_velocities", "final_angular_velocities"]
    assert list(GAS.asked()) == ["time"]
    smooth = DISKS.changed(hard_spheres=HardSpheres(), output=Output(interval=1.0, trajectory=True))
    assert "angular_velocities" not in smooth.asked()
    for scene in (SPRING, DISKS, GAS):
        everything = asked_for(scene.matters, NAMED, trajectory=True, forces=True, fields=True, trace=True)
        assert all(row.matter in scene.matters for row in everything.values())


def test_shapes_follow_the_axes() -> None:
    spring = SPRING.changed(
        output=Output(interval=0.5, observables=("virial", "momentum"), trajectory=True, forces=True)
    )
    assert shapes(spring, 3) == {
        "time": (3,),
        "final_positions": (2, 2),
        "final_velocities": (2, 2),
        "positions": (3, 2, 2),
        "velocities": (3, 2, 2),
        "forces": (2, 2),
        "virial": (3,),
        "momentum": (3, 2),
    }
    names = ("wall_impulse", "wall_energy", "operation_counts", "rotational_energy")
    disks = shapes(DISKS.changed(output=Output(interval=0.5, observables=names, fields=(3, 7), trajectory=True)), 3)
    assert disks["angular_velocities"] == (3, 2, 1)
    assert [disks[name] for name in names] == [(3, 4, 2), (3, 4), (3, 9), (3,)]
    assert [disks[f"field_{name}"] for name in ("mass", "momentum", "flux_mass", "flux_momentum")] == [
        (3, 7),
        (3, 7, 2),
        (2, 3, 7),
        (2, 3, 7, 2),
    ]
    gas = GAS.changed(output=Output(interval=1.0, observables=("populations", "sites"), fields=(4, 2)))
    assert shapes(gas, 2) == {"time": (2,), "populations": (2, 4, 2, 6), "sites": (4, 8)}
    assert lengths(("sample", "grid"), {"sample": (5,), "grid": (1, 2, 3)}) == (5, 1, 2, 3)


def test_the_momentum_is_the_sum_of_m_v() -> None:
    derive = TABLE["momentum"].derive
    assert derive is not None
    velocities = np.array([[[1.0, 2.0], [3.0, -4.0]], [[0.0, 1.0], [1.0, 0.0]]])
    found = derive(np.array([2.0, 0.5]), {"velocities": velocities})
    np.testing.assert_array_equal(found, [[3.5, 2.0], [0.5, 2.0]])


@pytest.mark.parametrize(
    ("name", "table"), [("rotational_energy", "hard_spheres.friction"), ("wall_torque", "box.cylinder")]
)
def test_what_an_observable_requires(name: str, table: str) -> None:
    with pytest.raises(UsageError, match=rf"'{name}' needs \[{table}\]"):
        DISKS.changed(hard_spheres=HardSpheres(), output=Output(interval=1.0, observables=(name,)))
