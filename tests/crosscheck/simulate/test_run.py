"""`simulate`: files of a scene on one and two engines, checked against closed forms, and the shipped scenes."""

import csv
import math

import numpy as np
import pytest

from crosscheck.engines.protocol import OPERATIONS, Run
from crosscheck.engines.refimpl.engine import RefimplEngine
from crosscheck.engines.registry import engine_class
from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Cylinder,
    Explicit,
    Face,
    GrainFriction,
    HardSpheres,
    Lattice,
    LennardJones,
    Method,
    Output,
    Scene,
    Spring,
)
from crosscheck.simulate.run import (
    _draw,
    _Result,
    _write_observables,
    _write_trajectory,
    load,
    observables,
    shipped_scenes,
    simulate,
)


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
    if not claims.stepping:
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
    spring=Spring(k=1.0, gamma=0.1),
    initial=Explicit(positions=((1.0, 0.0), (0.0, 1.0))),
)


def test_a_scene_that_records_nothing_gives_a_picture(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.to_toml() + '\n[method]\nscheme = "velocity_verlet"\ndt = 0.1\n')
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
    """omega dt = 6: the oscillator's amplitude grows 34 times a step."""
    scene = load("damped-oscillator").changed(
        duration=200.0,
        method=Method(scheme="velocity_verlet", dt=0.5),
        output=Output(interval=5.0, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    )
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    paths = simulate(path, ["refimpl"], tmp_path / "out")
    assert "diverged" in paths[0].read_text()
    assert paths[1].read_text().startswith("1\n")
    assert "(diverged)" in paths[-1].read_text()


# -- hard spheres ----------------------------------------------------------------------------------------

EVENTS = Method(scheme="event_driven")


def disks(**changes):
    entries = {
        "name": "disks",
        "dimension": 2,
        "duration": 2.0,
        "hard_spheres": HardSpheres(),
        "box": Box(lengths=(6.0, 5.0)),
        "initial": Explicit(
            positions=((1.0, 1.0), (3.0, 3.0), (5.9, 1.5)), velocities=((1.0, 0.0), (0.0, 0.0), (0.0, 1.9))
        ),
        "output": Output(interval=1.0, observables=("kinetic_energy",), trajectory=True),
    }
    return Scene(**(entries | changes))


def fall(scene, **more):
    """A run of straight paths through the box, with everything else that is given."""
    state, time = scene.initial_state(), scene.samples()
    positions = state.positions + state.velocities * time[:, None, None]
    velocities = np.broadcast_to(state.velocities, positions.shape)
    return Run(time, positions[-1], state.velocities, positions, velocities, **more)


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
    paths = simulate(path, ["refimpl"], tmp_path / "out")
    assert [written.suffix for written in paths] == [".csv", ".extxyz", ".png", ".svg"]
    table = read_table(paths[0])
    assert list(table) == ["time", "kinetic_energy", "temperature", "collisions"]
    assert table["collisions"].tolist()[::4] == [0, 1]
    assert table["temperature"] == pytest.approx(table["kinetic_energy"] / 2)  # two that move, and no box around them
    assert ", event_driven\n" in paths[0].read_text()
    assert "to t = 4" in paths[-1].read_text()


def test_observables_of_hard_spheres():
    scene = disks(initial=Lattice(kind="lattice", structure="square", number=12, temperature=1.0, seed=1))
    ones = np.ones(3)
    tallies = {"collisional_virial": 6 * ones, "kinetic_energy_integral": np.array([0.0, 5.0, 10.0])}
    asked = Output(interval=1.0, observables=("kinetic_energy", *tallies))
    table = observables(scene.changed(output=asked), fall(scene, kinetic_energy=5 * ones, tallies=tallies))
    assert list(table) == ["time", "kinetic_energy", "temperature", "pressure", *tallies]
    assert table["temperature"] == pytest.approx(2 * 5 / (2 * 11))
    assert table["pressure"][1:] == pytest.approx([(2 * 5 + 6) / (2 * 30), (2 * 10 + 6) / (2 * 30 * 2)])
    assert np.isnan(table["pressure"][0])
    fallen = scene.changed(acceleration=(0.0, -1.0))
    assert observables(fallen, fall(fallen, kinetic_energy=5 * ones))["temperature"] == pytest.approx(2 * 5 / (2 * 12))


def test_the_temperature_of_grains_is_that_of_their_translation():
    scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)))
    ones = np.ones(3)
    assert "temperature" not in observables(scene, fall(scene, kinetic_energy=ones))
    run = fall(scene, kinetic_energy=ones, tallies={"rotational_energy": 0.25 * ones})
    assert observables(scene, run)["temperature"] == pytest.approx(2 * 0.75 / (2 * 2))


def test_columns_of_tallies():
    names = ("wall_impulse", "wall_energy", "operation_counts")
    scene = disks(
        box=Box(lengths=(6.0, 5.0), boundaries=("periodic", "hard"), faces={"y+": Face(open=True)}),
        initial=Explicit(positions=((1.0, 1.0),)),
        output=Output(interval=1.0, observables=names),
    )
    numbers = np.arange(8.0).reshape(4, 2)
    tallies = {
        "wall_impulse": np.stack([numbers] * 3),
        "wall_energy": np.stack([numbers[:, 0]] * 3),
        "operation_counts": np.ones((3, 6)),
    }
    table = observables(scene, fall(scene, tallies=tallies))
    assert list(table) == ["time", "wall_impulse[y-].x", "wall_impulse[y-].y", "wall_energy[y-]", *OPERATIONS]
    assert (table["wall_impulse[y-].y"] == 5).all()
    assert (table["wall_energy[y-]"] == 4).all()


def test_a_trajectory_has_radii_and_spins(tmp_path):
    import ase.io

    scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)))
    run = fall(scene, angular_velocities=np.full((3, 3, 1), 2.5))
    run["positions"][2] = np.nan  # stopped
    frames = ase.io.read(_write_trajectory(tmp_path / "t.extxyz", scene, run), ":")
    assert len(frames) == 2
    assert frames[1].arrays["radius"].tolist() == [0.5] * 3
    assert frames[1].arrays["angular_velocities"].tolist() == [[0, 0, 2.5]] * 3


def test_why_a_run_stopped_is_in_the_table(tmp_path):
    scene = disks()
    run = fall(scene, kinetic_energy=np.ones(3), stopped="inelastic collapse of particles 0 and 1 at t = 0.5")
    result = _Result("refimpl", "1", run, observables(scene, run))
    text = _write_observables(tmp_path / "o.csv", scene, EVENTS, result).read_text()
    assert "# the run stopped: inelastic collapse of particles 0 and 1 at t = 0.5\n" in text


def circles(scene, run):
    """Diameters (in the units of the axes) and centres of what is drawn as disks, and the axes."""
    from matplotlib.figure import Figure

    from crosscheck.simulate.run import _draw_configuration

    axes = Figure().add_subplot()
    _draw_configuration(axes, scene, run)
    found = [(c.get_widths(), c.get_offsets()) for c in axes.collections]
    return np.concatenate([w for w, _ in found]), np.concatenate([o for _, o in found]), axes


def test_disks_are_drawn_in_their_size():
    scene = disks(hard_spheres=HardSpheres(diameter=(1.0, 0.5)), species=(0, 1, 0))
    widths, centres, axes = circles(scene, fall(scene))
    # the third one has gone up to y = 5.3, that is 0.3, and reaches over both periodic edges: it is seen four times
    assert sorted(widths) == [0.5] + [1.0] * 5
    for x in (5.9, -0.1):
        for y in (0.3, 5.3):
            assert np.isclose(centres, [x, y]).all(axis=1).sum() == 1
    assert axes.get_xlim() == (0, 6)
    assert axes.get_ylim() == (0, 5)


@pytest.mark.parametrize("boundaries", [("hard", "hard"), ("open", "open"), ("periodic", "hard"), None])
def test_walls_are_drawn(tmp_path, boundaries):
    drum = Cylinder(radius=2.5) if boundaries == ("open", "open") else None
    box = None if boundaries is None else Box(lengths=(6.0, 5.0), boundaries=boundaries, cylinder=drum)
    scene = disks(
        box=box,
        hard_spheres=HardSpheres(diameter=(1.0, 0.0), fixed=(0,)),
        species=(0, 1, 1),
        initial=Explicit(
            positions=((3.0, 2.5), (2.0, 2.0), (4.0, 3.0)), velocities=((0.0, 0.0), (0.5, 0.0), (0.0, 0.1))
        ),
    )
    run = fall(scene)
    widths, _, axes = circles(scene, run)
    assert len(widths) == 3
    walls = [line for line in axes.lines if line.get_linewidth() == 2]
    assert len(walls) == (0 if boundaries is None else 2 * boundaries.count("hard"))
    assert [patch.radius for patch in axes.patches] == [2.5] * (drum is not None)
    assert len(axes.lines) - len(walls) == 2  # the paths of those that move
    result = _Result("refimpl", "1", run, observables(scene, run))
    assert [path.suffix for path in _draw(tmp_path, scene, EVENTS, [result])] == [".png", ".svg"]


def test_hard_spheres_without_method(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(disks().to_toml())
    with pytest.raises(UsageError, match=r'add \[method\] with scheme = "event_driven"'):
        simulate(path, ["refimpl"], tmp_path)
