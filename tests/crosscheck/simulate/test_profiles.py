"""Density, velocity, temperature and fluxes on cells, by their definitions and by what must add up."""

import numpy as np
import pytest
from hard_disks import EVENTS, disks

from crosscheck.scene import Box, Explicit, LatticeGas, Method, Occupations, Output, Scene
from crosscheck.simulate.profiles import cell_edges, on_blocks, on_cells


@pytest.fixture
def ran(interpreted):
    """Runs a scene of hard disks."""
    return lambda scene: interpreted.run(scene, EVENTS)


def test_two_free_particles_in_two_cells(ran):
    """Each stays in its half of the box: n = 1/(cell), its velocity, and T = 0, since it is alone."""
    scene = disks(
        duration=2.0,
        box=Box(lengths=(10.0, 5.0)),
        initial=Explicit(positions=((2.0, 1.0), (8.0, 1.0)), velocities=((0.25, 0.5), (0.0, -1.0))),
        output=Output(interval=1.0, fields=(2, 1)),
    )
    found = {name: one.values.ravel() for name, one in on_cells(scene, ran(scene)).items()}
    assert [edges.tolist() for edges in cell_edges(scene)] == [[0, 5, 10], [0, 5]]
    assert found["density"] == pytest.approx([1 / 25, 1 / 25])
    assert found["velocity.x"] == pytest.approx([0.25, 0.0])
    assert found["velocity.y"] == pytest.approx([0.5, -1.0])
    assert found["temperature"] == pytest.approx([0.0, 0.0], abs=1e-15)
    assert found["energy_flux.x"] == pytest.approx([0.0, 0.0])


def test_flux_through_a_face(ran):
    """A particle of energy 2 crosses the face at x = 5 once in 4 units of time: 2/(4 * 5)."""
    scene = disks(
        duration=4.0,
        box=Box(lengths=(10.0, 5.0)),
        initial=Explicit(positions=((1.0, 1.0), (8.5, 4.0)), velocities=((2.0, 0.0), (0.0, 0.0))),
        output=Output(interval=4.0, fields=(2, 1)),
    )
    found = on_cells(scene, ran(scene))
    assert found["energy_flux.x"].values.ravel() == pytest.approx([0.0, 2 / 20])
    # over all cells the density is that of the box
    assert found["density"].values.mean() == pytest.approx(2 / 50)


def test_temperature_of_two_that_pass(ran):
    """Two particles with velocities +1 and -1 along y in one cell: <v> = 0, T = <v^2>/2 = 1/2."""
    scene = disks(
        duration=1.0,
        box=Box(lengths=(10.0, 5.0)),
        initial=Explicit(positions=((2.0, 1.0), (4.0, 1.0)), velocities=((0.0, 1.0), (0.0, -1.0))),
        output=Output(interval=1.0, fields=(1, 1)),
    )
    assert on_cells(scene, ran(scene))["temperature"].values.item() == pytest.approx(0.5)
    heavy = scene.changed(masses=(1.0, 3.0))
    found = on_cells(heavy, ran(heavy))
    assert "temperature" not in found  # cells count mass, not particles
    # <v> = -1/2 by mass, <v^2> = 1: (1 - 1/4)/2
    assert found["thermal_energy"].values.item() == pytest.approx(0.375)


def test_a_run_that_stops_has_the_density_of_its_own_time(ran):
    scene = disks(
        duration=1e9,
        box=Box(lengths=(10.0, 5.0)),
        output=Output(collisions=(1000000,), fields=(2, 1)),
        initial=Explicit(positions=((2.0, 1.0), (8.0, 4.0)), velocities=((0.25, 0.0), (0.0, 0.0))),
    )
    run = ran(scene.changed(duration=50.0))
    assert run.stopped
    assert on_cells(scene, run)["density"].values.mean() == pytest.approx(2 / 50)


def test_flow_of_a_lattice_gas(interpreted):
    scene = Scene(
        name="flow",
        dimension=2,
        duration=2,
        lattice_gas=LatticeGas(model="hpp", columns=64, rows=4),
        initial=Occupations(kind="occupations", channels=(1.0, 0.0, 0.0, 0.0), seed=1),
        output=Output(interval=1, observables=("populations",), fields=(2, 1)),
    )
    found = on_blocks(scene, interpreted.run(scene, Method(scheme="lattice_numpy")))
    assert {name: one.values.shape for name, one in found.items()} == dict.fromkeys(found, (3, 2, 1))
    assert np.unique(found["density"].values) == [1.0]
    speed = np.hypot(found["velocity.x"].values, found["velocity.y"].values)
    assert np.unique(speed) == [1.0]
