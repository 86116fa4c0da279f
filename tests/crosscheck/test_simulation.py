"""`simulate`: files of a scene on one and two engines, checked against closed forms, and the shipped scenes."""

import csv
import math

import numpy as np
import pytest

from crosscheck.engines.base import Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import UsageError
from crosscheck.scene import Box, Explicit, Lattice, LennardJones, Method, Output, Scene, Spring
from crosscheck.simulation import load, observables, shipped_scenes, simulate


def read_table(path):
    with path.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def lammps_available():
    try:
        import importlib.util

        engine_class("lammps")
        return importlib.util.find_spec("lammps") is not None
    except (UsageError, ImportError):
        return False


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_is_whole(name):
    scene = load(name)
    assert scene.name == name
    scene.initial_state()
    assert scene.steps(scene.method.dt) > 0
    assert scene.every(scene.method.dt) > 0
    assert scene.method.scheme in engine_class("refimpl").schemes


def test_shipped_figure_eight_has_the_published_invariants():
    state = load("figure-eight").initial_state()
    r, v = state.positions, state.velocities
    distances = [np.linalg.norm(r[i] - r[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    assert 0.5 * (v**2).sum() - sum(1 / d for d in distances) == pytest.approx(-1.2871419918, abs=2e-9)
    assert (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]).sum() == pytest.approx(0, abs=1e-15)


def test_damped_oscillator(tmp_path):
    paths = simulate("damped-oscillator", ["refimpl"], tmp_path)
    assert [path.name for path in paths] == [
        "observables-refimpl.csv", "trajectory-refimpl.extxyz", "picture.png", "picture.svg",
    ]  # fmt: skip
    table = read_table(paths[0])
    assert list(table) == ["time", "kinetic_energy", "potential_energy", "total_energy", "temperature"]
    assert table["time"][-1] == pytest.approx(5)
    # r(5 s) = -0.028097802999337 m, v(5 s) = 0.0081163495371 m/s; velocity Verlet at dt = 1 ms is right to 1e-4 or so
    assert table["potential_energy"][-1] == pytest.approx(0.5e4 * 0.028097802999337**2, rel=1e-2)
    assert table["temperature"] == pytest.approx(2 * table["kinetic_energy"])
    import ase.io

    frames = ase.io.read(paths[1], ":")
    assert len(frames) == len(table["time"])
    assert frames[-1].positions[0, 0] == pytest.approx(-0.0280978, abs=1e-4)
    assert frames[0].get_velocities()[0, 0] == pytest.approx(-100 / 140, abs=1e-8)
    assert paths[2].read_bytes()[:4] == b"\x89PNG"


@pytest.mark.skipif(not lammps_available(), reason="needs the engine lammps")
def test_two_engines_side_by_side(tmp_path):
    paths = simulate("damped-oscillator", ["refimpl", "lammps"], tmp_path)
    assert len(paths) == 6
    ours, theirs = (read_table(tmp_path / f"observables-{engine}.csv") for engine in ("refimpl", "lammps"))
    assert ours["total_energy"] == pytest.approx(theirs["total_energy"], rel=1e-9)
    assert "|refimpl - lammps|" in paths[-1].read_text()


def small_fluid(**lennard_jones):
    return Scene(
        name="fluid",
        dimension=3,
        duration=0.05,
        box=Box(lengths=(6.0, 6.0, 6.0)),
        lennard_jones=LennardJones(cutoff=2.5, **lennard_jones),
        initial=Lattice(kind="lattice", structure="fcc", number=108, temperature=1.0, seed=3),
        output=Output(interval=0.05, observables=("kinetic_energy", "potential_energy", "virial")),
    )


def run_of(scene, **arrays):
    zeros = np.zeros((scene.number, scene.dimension))
    return Run(np.zeros(1), zeros, zeros, **{name: np.array([value]) for name, value in arrays.items()})


def test_observables_follow_their_definitions():
    scene = small_fluid()
    table = observables(scene, run_of(scene, kinetic_energy=160.5, potential_energy=-500.0, virial=-30.0))
    assert table["temperature"] == pytest.approx(2 * 160.5 / (3 * 107))
    assert table["pressure"] == pytest.approx((2 * 160.5 - 30) / (3 * 216))
    assert table["total_energy"] == pytest.approx(-339.5)


def test_tail_corrections_are_added():
    scene, plain = small_fluid(tail_corrections=True), small_fluid()
    values = {"kinetic_energy": 160.5, "potential_energy": -500.0, "virial": -30.0}
    with_tails, without = observables(scene, run_of(scene, **values)), observables(plain, run_of(plain, **values))
    rho, x = 108 / 216, 2.5**-3
    energy = 8 / 3 * math.pi * 108 * rho * (x**3 / 3 - x)
    pressure = 16 / 3 * math.pi * rho**2 * (2 * x**3 / 3 - x)
    assert with_tails["potential_energy"] - without["potential_energy"] == pytest.approx(energy)
    assert with_tails["pressure"] - without["pressure"] == pytest.approx(pressure)


def test_only_what_the_scene_records_is_there():
    scene = small_fluid().changed(output=Output(interval=0.05, observables=("kinetic_energy",)))
    assert list(observables(scene, run_of(scene, kinetic_energy=1.0))) == ["time", "kinetic_energy", "temperature"]


SCENE = Scene(
    name="two springs",
    dimension=2,
    duration=1.0,
    spring=Spring(k=1.0),
    initial=Explicit(positions=((1.0, 0.0), (0.0, 1.0))),
)


def test_a_scene_that_records_nothing_gives_a_picture(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.to_toml() + '\n[method]\nscheme = "verlet"\ndt = 0.1\n')
    paths = simulate(path, ["refimpl"], tmp_path / "out")
    assert [written.name for written in paths] == ["picture.png", "picture.svg"]


def test_without_method_it_says_what_to_add(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.to_toml())
    with pytest.raises(UsageError, match=r"add \[method\]"):
        simulate(path, ["refimpl"], tmp_path)


def test_unknown_scheme_names_those_there_are(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.to_toml() + '\n[method]\nscheme = "magic"\ndt = 0.1\n')
    with pytest.raises(UsageError, match=r"'magic'.*velocity_verlet"):
        simulate(path, ["refimpl"], tmp_path)


def test_unknown_scene_names_the_shipped_ones(tmp_path):
    with pytest.raises(UsageError, match="figure-eight"):
        simulate("figure-nine", ["refimpl"], tmp_path)


def test_an_engine_is_named_once(tmp_path):
    with pytest.raises(UsageError, match="once"):
        simulate("kepler", ["refimpl", "refimpl"], tmp_path)


def test_a_diverged_run_is_written_up_to_there(tmp_path):
    scene = small_fluid().changed(
        duration=50.0,
        method=Method(scheme="euler", dt=0.5),
        output=Output(interval=5.0, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    )
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    paths = simulate(path, ["refimpl"], tmp_path / "out")
    assert "diverged" in paths[0].read_text()
    assert paths[1].read_text().startswith("108\n")
    assert "(diverged)" in paths[-1].read_text()
