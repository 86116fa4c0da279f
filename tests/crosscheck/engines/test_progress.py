"""Progress of a run: what is reported and read, and that a run in pieces is the same run, bit for bit."""

import in_pieces as in_pieces_file
import pytest

from crosscheck.engines import progress
from crosscheck.engines.workers.pool import Worker
from crosscheck.scene import (
    Box,
    Explicit,
    Gravity,
    HardSpheres,
    Lattice,
    LatticeGas,
    Method,
    Occupations,
    Output,
    Scene,
)


@pytest.fixture
def file(tmp_path):
    """The file to which this process reports."""
    progress.listen(tmp_path / "progress")
    yield tmp_path / "progress"
    progress.listen(None)


def test_what_is_reported_is_read(file):
    assert progress.read(file) == ("", None)
    progress.stage("compiling kernels")
    assert progress.read(file) == ("compiling kernels", None)
    progress.report(0.25)
    assert progress.read(file) == ("running", 0.25)
    progress.report(0.5)  # too soon to be written again
    assert progress.read(file) == ("running", 0.25)


def test_without_a_listener_a_run_is_one_piece(tmp_path):
    progress.stage("compiling kernels")
    assert progress.Pace(10).more(0) > 1e18
    assert list(tmp_path.iterdir()) == []


def test_pieces_grow_until_they_take_long_enough(file, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    pace, sizes = progress.Pace(1e6), []
    for took in (0.0, 0.01, 0.02, 0.3, 0.2, 2.0, 0.2):
        now[0] += took
        sizes.append(pace.more(5e5))
    assert sizes == [2, 4, 8, 8, 8, 4, 4]
    assert progress.read(file) == ("running", 0.5)


@pytest.fixture(scope="module")
def in_pieces():
    """`refimpl` in pieces of one step or one collision."""
    worker = Worker(f"{in_pieces_file.__file__}:InPieces", interpreted=True)
    yield worker
    worker.close()


GAS = Scene(
    name="gas",
    dimension=2,
    duration=8.0,
    hard_spheres=HardSpheres(restitution=0.95),
    box=Box(lengths=(8.0, 8.0)),
    initial=Lattice(kind="lattice", structure="square", number=16, temperature=1.0, seed=1),
    output=Output(
        interval=3.0,
        observables=("kinetic_energy", "collisions", "collisional_virial", "kinetic_energy_integral"),
        trajectory=True,
        fields=(2, 2),
    ),
    method=Method(scheme="event_driven"),
)
PLANETS = Scene(
    name="planets",
    dimension=2,
    duration=1.0,
    gravity=Gravity(),
    initial=Explicit(positions=((0.0, 0.0), (1.0, 0.0), (0.0, 2.0)), velocities=((0.0, 0.0), (0.0, 1.0), (-0.7, 0.0))),
    output=Output(interval=0.25, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    method=Method(scheme="verlet", dt=0.05),  # of two steps: it has a memory
)
SITES = Scene(
    name="sites",
    dimension=2,
    duration=11,
    lattice_gas=LatticeGas(model="fhp2", columns=64, rows=8, force=0.1),
    initial=Occupations(kind="occupations", density=0.3, seed=2),
    output=Output(interval=4, observables=("populations", "force_impulse", "sites"), fields=(2, 2)),
    method=Method(scheme="lattice_planes"),
)


@pytest.mark.parametrize("scene", [GAS, PLANETS, SITES], ids=lambda scene: scene.name)
def test_a_run_in_pieces_is_the_same_run(scene, interpreted, in_pieces, tmp_path):
    whole, pieces = interpreted.run(scene, scene.method), in_pieces.run(scene, scene.method, tmp_path / "progress")
    assert progress.read(tmp_path / "progress")[0] == "running"
    assert set(whole) == set(pieces)
    for name, values in whole.items():
        assert values.tobytes() == pieces[name].tobytes(), name
    assert (whole.cost.steps, whole.cost.events) == (pieces.cost.steps, pieces.cost.events)
