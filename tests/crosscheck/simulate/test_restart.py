"""Runs that go on from a restart file: the same bits as without a break, for every kind of scene, or one line."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosscheck.engines.protocol import Restartable, Run
from crosscheck.engines.registry import load_class
from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Contact,
    Face,
    File,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    LatticeGas,
    LennardJones,
    Method,
    Obstacle,
    Occupations,
    Oscillation,
    Output,
    Scene,
    Spring,
    explicit,
)
from crosscheck.simulate.run import simulate

ENERGIES = ("kinetic_energy", "potential_energy")


def oscillators(scheme: str) -> tuple[Scene, Method]:
    return Scene(
        name="oscillators",
        dimension=2,
        duration=2.0,
        spring=Spring(k=1.0, gamma=0.1),
        initial=explicit(np.array([[1.0, 0.0], [0.3, 0.2]]), np.array([[0.0, 1.0], [0.1, 0.1]])),
        output=Output(interval=0.25, observables=ENERGIES, trajectory=True),
    ), Method(scheme=scheme, dt=1 / 64)


def fluid(**changes: Any) -> tuple[Scene, Method]:
    entries: dict[str, Any] = {
        "name": "fluid",
        "dimension": 3,
        "duration": 0.5,
        "lennard_jones": LennardJones(cutoff=1.7, truncation="shifted"),
        "box": Box(lengths=(4.0,) * 3),
        "initial": Lattice(kind="lattice", structure="fcc", number=32, temperature=1.0, seed=7),
        "output": Output(interval=0.0625, observables=(*ENERGIES, "virial"), trajectory=True, forces=True),
    }
    return Scene(**(entries | changes)), Method(scheme="velocity_verlet", dt=1 / 256)


def disks(scheme: str = "event_driven", **changes: Any) -> tuple[Scene, Method]:
    entries: dict[str, Any] = {
        "name": "disks",
        "dimension": 2,
        "duration": 8.0,
        "hard_spheres": HardSpheres(),
        "box": Box(lengths=(8.0, 8.0)),
        "initial": Lattice(kind="lattice", structure="square", number=36, temperature=1.0, seed=7),
        "output": Output(interval=0.5, observables=("kinetic_energy", "collisions"), trajectory=True),
    }
    return Scene(**(entries | changes)), Method(scheme=scheme)


ROUGH = GrainFriction(tangential_restitution=0.2, static=0.5, sliding=0.5)
FLOOR = Face(oscillation=Oscillation(amplitude=0.2, frequency=5.0, phase=0.3))


def soft(**changes: Any) -> tuple[Scene, Method]:
    floor = FLOOR.model_copy(update={"friction": Friction(tangential_restitution=0.0, static=0.4, sliding=0.4)})
    scene, _ = disks(
        hard_spheres=HardSpheres(restitution=0.9, friction=ROUGH),
        acceleration=(0.0, -1.0),
        box=Box(lengths=(8.0, 8.0), boundaries=("periodic", "hard"), faces={"y-": floor}),
        output=Output(
            interval=0.5, observables=("kinetic_energy", "rotational_energy", "contact_time", "wall_impulse"),
            trajectory=True,
        ),
    )  # fmt: skip
    return scene.changed(duration=4.0), Method(scheme="velocity_verlet", dt=1 / 1024, contact=Contact(stiffness=1e3))


def gas(scheme: str, **more: Any) -> tuple[Scene, Method]:
    boltzmann = scheme == "lattice_boltzmann"
    return Scene(
        name="gas",
        dimension=2,
        duration=40.0,
        lattice_gas=LatticeGas(
            model="fhp1", rows=16, columns=70, obstacles=(Obstacle(rows=(0, 0), rule="diffusive_y"),), force=0.01
        ),
        initial=Occupations(kind="occupations", density=0.3, seed=3),
        output=Output(
            interval=10.0,
            observables=("populations", "h_function") if boltzmann else ("populations", "sites", "force_impulse"),
            fields=(7, 4),
        ),
    ), Method(scheme=scheme)


#: Events of every kind, and each scheduler, are in tests/refimpl/events; here is one scene for each way to run.
SCENES = {
    **{scheme: oscillators(scheme) for scheme in ("verlet", "beeman", "gear5")},
    "fluid": fluid(),
    "fluid without a trajectory": fluid(output=Output(interval=0.0625, observables=(*ENERGIES, "virial"), forces=True)),
    "disks": disks(),
    "disks counted": disks(duration=1e3, output=Output(collisions=(20, 40, 60, 80), observables=("kinetic_energy",))),
    "soft": soft(),
    **{scheme: gas(scheme) for scheme in ("lattice_planes", "lattice_lookup", "lattice_numpy", "lattice_boltzmann")},
}


def halved(scene: Scene) -> Scene:
    counts = scene.output.collisions
    if counts is None:
        return scene.changed(duration=scene.duration / 2)
    return scene.changed(output=scene.output.model_copy(update={"collisions": counts[: len(counts) // 2]}))


def compiled(scene: Scene, half: Scene, method: Method) -> tuple[Run, Run, Run]:
    """The whole run, its first half, and the second one from the state between them, in this process."""
    engine = load_class("refimpl")()
    assert isinstance(engine, Restartable)
    whole, _ = engine.run_from(scene, method, None)
    first, state = engine.run_from(half, method, None)
    assert state is not None
    second, _ = engine.run_from(half, method, {name: values.copy() for name, values in state.items()})
    return whole, first, second


def as_plain_python(worker: Worker, directory: Path, scene: Scene, half: Scene, method: Method) -> tuple[Run, Run, Run]:
    """The same in a worker, for scenes so small that compiling takes longer; the state goes through a file."""
    middle, end = directory / "middle.npz", directory / "end.npz"
    first = worker.run(half, method, keep=middle)
    return worker.run(scene, method), first, worker.run(half, method, restart=middle, keep=end)


@pytest.mark.parametrize("name", SCENES)
def test_a_run_goes_on_with_the_same_bits(name: str, interpreted: Worker, tmp_path: Path) -> None:
    scene, method = SCENES[name]
    method, half = resolved(scene, method), halved(scene)
    if name.startswith(("fluid", "disks", "soft")):
        whole, first, second = as_plain_python(interpreted, tmp_path, scene, half, method)
    else:
        whole, first, second = compiled(scene, half, method)
    assert not whole.stopped
    middle = len(first["time"]) - 1
    if scene.output.collisions is None:
        np.testing.assert_array_equal(second["time"], first["time"])
    for observable, row in scene.asked().items():
        found, expected = second[observable], whole[observable]
        if observable == "time" or observable.startswith("field_initial"):
            continue
        if row.cumulative:  # counts from where the run goes on
            expected = expected[middle:] - expected[middle] if row.axes[0] == "sample" else expected - first[observable]
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(whole[observable]).max())
            continue
        np.testing.assert_array_equal(found, expected[middle:] if row.axes[0] == "sample" else expected)


def test_reversals_count_from_where_the_run_goes_on() -> None:
    scene, method = gas("lattice_numpy")
    assert scene.lattice_gas is not None
    still = scene.lattice_gas.model_copy(update={"obstacles": (), "force": None, "model": "hpp"})
    output = scene.output.model_copy(update={"observables": ("sites",)})
    engine = load_class("refimpl")()
    assert isinstance(engine, Restartable)
    plain = scene.changed(lattice_gas=still, output=output, duration=20.0)
    back = plain.changed(lattice_gas=still.model_copy(update={"reversals": (5,)}))
    _, state = engine.run_from(plain, method, None)
    returned, _ = engine.run_from(back, method, state)
    twice = plain.changed(lattice_gas=still.model_copy(update={"reversals": (25,)}), duration=40.0)
    np.testing.assert_array_equal(returned["sites"], engine.run(twice, method)["sites"])


# -- through files ---------------------------------------------------------------------------------------------


def without_compiling_and_drawing(patch: pytest.MonkeyPatch) -> None:
    """Workers of `simulate` run plain Python, which is enough for short runs; pictures are no part of a restart."""
    patch.setenv("NUMBA_DISABLE_JIT", "1")
    patch.setattr("crosscheck.simulate.run.draw_picture", lambda *_: [])


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    without_compiling_and_drawing(monkeypatch)


def written(tmp_path: Path, name: str, scene: Scene, method: Method | None) -> Path:
    path = tmp_path / f"{name}.toml"
    path.write_text(scene.model_copy(update={"method": method}).to_toml())
    return path


def columns(path: Path) -> list[list[str]]:
    lines = path.read_text().splitlines()
    return [line.split(",")[1:] for line in lines if line[0] in "0123456789"]


def frames(path: Path) -> list[bytes]:
    import ase.io

    return [b"".join(frame.arrays[name].tobytes() for name in ("positions", "velocities")) for frame in
            ase.io.read(path, ":")]  # fmt: skip


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("engine", ["refimpl", "ase"])
def test_from_a_restart_file_and_from_a_trajectory(tmp_path: Path, engine: str) -> None:
    entries: dict[str, Any] = {"output": Output(interval=0.0625, observables=ENERGIES, trajectory=True)}
    scene, method = fluid(duration=0.25, **entries)
    whole, half = (written(tmp_path, name, scene.changed(duration=span), method)
                   for name, span in (("whole", 0.25), ("half", 0.125)))  # fmt: skip
    trajectory = File(kind="file", path=f"first/trajectory-{engine}.extxyz")
    again = written(tmp_path, "again", scene.model_copy(update={"initial": trajectory, "duration": 0.125}), method)
    simulate(whole, [engine], tmp_path / "whole")
    simulate(half, [engine], tmp_path / "first")
    restart = tmp_path / "first" / f"restart-{engine}.npz"
    simulate(half, [engine], tmp_path / "second", restart=restart)
    starts = ["second"]
    if engine == "refimpl":  # velocity Verlet, and lists made anew for each recorded state: positions, velocities do
        simulate(again, [engine], tmp_path / "third")
        starts.append("third")
    for start in starts:
        for file, read in ((f"trajectory-{engine}.extxyz", frames), (f"observables-{engine}.csv", columns)):
            assert read(tmp_path / start / file) == read(tmp_path / "whole" / file)[2:]  # type: ignore[operator]
    with zipfile.ZipFile(tmp_path / "second" / f"restart-{engine}.npz") as file:
        header = json.loads(file.read("header.json"))
    assert header["time"] == 0.25
    assert header["initial"]["kind"] == "lattice"


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Scene file and restart file of a run of oscillators."""
    tmp_path = tmp_path_factory.mktemp("restart")
    scene = written(tmp_path, "scene", *oscillators("verlet"))
    with pytest.MonkeyPatch.context() as patch:
        without_compiling_and_drawing(patch)
        simulate(scene, ["refimpl"], tmp_path / "out")
    return scene, tmp_path / "out" / "restart-refimpl.npz"


def rewritten(kept: Path, path: Path, header: dict[str, Any] | None = None, **arrays: Any) -> Path:
    """A copy with other entries of the header and other arrays; None: without it."""
    with np.load(kept) as old:
        found = {name: old[name] for name in old if name != "header.json"}
        table = json.loads(old["header.json"]) | (header or {})
    found |= arrays
    np.savez(path, **{name: value for name, value in found.items() if value is not None})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("header.json", json.dumps({name: one for name, one in table.items() if one is not None}))
    return path


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(
    ("header", "arrays", "message"),
    [
        ({"version": 2}, {}, "its layout has the version 2, this program reads 1"),
        ({"format": "another"}, {}, "its header.json does not say that it is one"),
        ({"engine": 3}, {}, "header.json: 'engine' is missing or of another type"),
        ({"time": None}, {}, "header.json: 'time' is missing or of another type"),
        ({"engine_version": "0.0"}, {}, "was written by refimpl 0.0, this is .*: another version need not give"),
        ({"engine": "lammps"}, {}, "was written by engine lammps, and is of no use to refimpl"),
        ({"method": {"scheme": "euler", "dt": 1 / 64}}, {}, 'another method: scheme is "euler" there, "verlet" here'),
        ({"scene": {}}, {}, "was written with another scene: dimension is absent there, 2 here"),
        ({"initial": {"kind": "nothing"}}, {}, "initial.kind: Input should be one of"),
        ({}, {"r": np.zeros(6)}, r"does not fit: array r has the shape \(6,\), not \(4,\)"),
        ({}, {"r": np.zeros(4, np.float32)}, "does not fit: array r has the type float32, not float64"),
        ({}, {"v": None}, "does not fit: array v is missing"),
        ({}, {"more": np.zeros(4)}, "does not fit: array more has no place"),
        ({}, {"r": np.array([{}], dtype=object)}, "its arrays cannot be read .Object arrays cannot be loaded"),
    ],
)
def test_hostile_restart_files_are_one_line(
    tmp_path: Path, kept: tuple[Path, Path], header: dict[str, Any], arrays: dict[str, Any], message: str
) -> None:
    scene, restart = kept
    with pytest.raises(UsageError, match=message) as caught:
        simulate(scene, ["refimpl"], tmp_path, restart=rewritten(restart, tmp_path / "bad.npz", header, **arrays))
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("plain")
def test_damaged_restart_files_are_one_line(tmp_path: Path, kept: tuple[Path, Path]) -> None:
    scene, restart = kept
    whole, empty = restart.read_bytes(), io.BytesIO()
    np.savez(empty, r=np.zeros(4))
    flipped = bytearray(whole)
    flipped[whole.index(b"r.npy") + 140] ^= 1
    for number, data in enumerate((whole[:-30], whole[: len(whole) // 2], b"", b"text", empty.getvalue(), flipped)):
        bad = tmp_path / f"{number}.npz"
        bad.write_bytes(data)
        with pytest.raises(UsageError, match="not a whole restart file") as caught:
            simulate(scene, ["refimpl"], tmp_path, restart=bad)
        assert "\n" not in str(caught.value)
    for missing in (tmp_path / "nowhere.npz", tmp_path):
        with pytest.raises(UsageError, match="not a whole restart file"):
            simulate(scene, ["refimpl"], tmp_path, restart=missing)


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"spring": Spring(k=2.0, gamma=0.1)}, "was written with another scene: spring.k is 1.0 there, 2.0 here"),
        ({"masses": 2.0}, "was written with another scene: masses is 1.0 there, 2.0 here"),
        ({"method": Method(scheme="verlet", dt=1 / 32)}, "another method: dt is 0.015625 there, 0.03125 here"),
    ],
)
def test_a_restart_file_of_another_scene_is_refused(
    tmp_path: Path, kept: tuple[Path, Path], changes: dict[str, Any], message: str
) -> None:
    scene, method = oscillators("verlet")
    given = changes.get("method", method)
    other = scene.changed(**{name: value for name, value in changes.items() if name != "method"})
    with pytest.raises(UsageError, match=message):
        simulate(written(tmp_path, "other", other, given), ["refimpl"], tmp_path, restart=kept[1])


@pytest.mark.usefixtures("plain")
def test_name_duration_output_and_initial_state_may_differ(tmp_path: Path, kept: tuple[Path, Path]) -> None:
    scene, method = oscillators("verlet")
    other = scene.changed(
        name="other",
        duration=0.5,
        initial=explicit(np.ones((3, 2)), np.zeros((3, 2))),
        output=Output(interval=0.5, trajectory=True),
    )
    simulate(written(tmp_path, "other", other, method), ["refimpl"], tmp_path / "out", restart=kept[1])
    assert len(frames(tmp_path / "out" / "trajectory-refimpl.extxyz")[0]) == 2 * 2 * 3 * 8


@pytest.mark.usefixtures("plain")
def test_an_engine_that_cannot_restart_says_so(tmp_path: Path, kept: tuple[Path, Path]) -> None:
    scene, restart = kept
    engine = f"{tmp_path / 'plain.py'}:Plain"
    (tmp_path / "plain.py").write_text(
        "from crosscheck.engines.refimpl.engine import RefimplEngine\n"
        "class Plain(RefimplEngine):\n    name = 'plain'\n    run_from = None\n"
    )
    files = simulate(scene, [engine], tmp_path / "out").paths
    assert not [path for path in files if path.name.startswith("restart")]
    bad = rewritten(restart, tmp_path / "bad.npz", {"engine": engine})
    with pytest.raises(UsageError, match="--restart: plain does not promise the same bits after a restart: start from"):
        simulate(scene, [engine], tmp_path / "out", restart=bad)
