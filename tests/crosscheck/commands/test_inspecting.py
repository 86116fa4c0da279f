"""`crosscheck inspect` as its user meets it: files of several formats, what is printed, exit status, JSON and page."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from inspected import PLANTED, flying

from crosscheck import cli
from crosscheck.scene import Box, Lattice, LennardJones, Output, Scene
from crosscheck.status import Status
from crosscheck.trajectories.frames import Box as Box3
from crosscheck.trajectories.trajectory import Trajectory
from crosscheck.trajectories.writers.extxyz import write


class Outcome:
    def __init__(self, status: Any, out: str, err: str) -> None:
        self.status, self.out, self.err = status, out, err


@pytest.fixture
def inspect(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Any:
    """Runs `crosscheck inspect <words>` in this process."""

    def call(*words: str | Path) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["crosscheck", "inspect", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        out, err = capfd.readouterr()
        return Outcome(end.value.code or 0, out, err)

    return call


def extxyz(path: Path, source: Any) -> Path:
    """The source as a file."""
    box = source.box or Box3(np.zeros((3, 3)), np.zeros(3), np.zeros(3, dtype=bool))
    more = {} if source.velocities is None else {"velocities": np.asarray(source.velocities)}
    species = None if source.types is None else np.unique(source.types, return_inverse=True)[1]
    cell, walled = np.diag(box.vectors), np.zeros((3, 2), dtype=bool)
    steps = np.arange(len(source.times))
    write(
        path,
        Trajectory(source.times, steps, source.positions, 3, cell, box.periodic, walled, source.masses, species, more),
    )
    return path


def dump(path: Path, source: Any, masses: bool = False) -> Path:
    """The source as a LAMMPS dump of wrapped positions with six digits."""
    lines = []
    for step, (x, v) in enumerate(zip(source.positions, source.velocities, strict=True)):
        lines += [f"ITEM: TIMESTEP\n{100 * step}\nITEM: NUMBER OF ATOMS\n{len(x)}\nITEM: BOX BOUNDS pp pp pp"]
        lines += [f"0 {edge:g}" for edge in np.diag(source.box.vectors)]
        lines += [f"ITEM: ATOMS id type x y z vx vy vz{' mass' if masses else ''}"]
        for row, (place, speed) in enumerate(zip(x % np.diag(source.box.vectors), v, strict=True)):
            kind = 1 if source.types is None or source.types[row] == "A" else 2
            numbers = " ".join(f"{one:g}" for one in (*place, *speed, *([source.masses[row]] if masses else [])))
            lines.append(f"{row + 1} {kind} {numbers}")
    path.write_text("\n".join(lines) + "\n")
    return path


def gas(seed: int = 1, **changes: Any) -> Any:
    return PLANTED.source_of(PLANTED.ornstein_uhlenbeck(seed, **{"frames": 120, "dt": 0.3, "number": 40} | changes))


def test_a_right_file_is_status_0_and_its_table_has_every_property(inspect: Any, tmp_path: Path) -> None:
    done = inspect(extxyz(tmp_path / "gas.xyz", gas()), "--temperature", "1.3", "--ensemble", "nvt")
    assert done.status == Status.PASSED, done.out + done.err
    first, *rest = done.out.splitlines()
    assert "extended XYZ, 120 frames of 40 particles; taken to be in equilibrium, canonical." in first
    for name in ("frames", "time axis", "jumps", "images of the box", "equipartition", "Maxwell's distribution"):
        assert any(line.startswith(name) for line in rest), name
    assert "angular momentum: cannot be said: it is conserved in open space" in done.out
    assert "a right trajectory is red with the probability 0.001" in done.out


def test_a_wrong_file_is_status_1_with_what_and_where(inspect: Any, tmp_path: Path) -> None:
    run = PLANTED.ornstein_uhlenbeck(1, frames=120, dt=0.3)
    wrong = PLANTED.source_of(PLANTED._exchange(run, np.random.default_rng(1)))
    done = inspect(extxyz(tmp_path / "gas.xyz", wrong), "--json", tmp_path / "o.json", "--page", tmp_path / "o.html")
    assert done.status == Status.FAILED
    assert "time axis: fail: frames earlier than the one before; frame 61 (counted from 0) is at time" in done.out
    found = json.loads((tmp_path / "o.json").read_text())
    assert found["status"] == 1
    assert found["frames"] == 120
    by_name = {one["name"]: one for one in found["properties"]}
    (red,) = [
        one for one in by_name["time axis"]["judgements"] if one["outcome"] == "fail" and "earlier" in one["quantity"]
    ]
    assert red["measured"] == 1.0
    assert by_name["angular momentum"]["unsaid"]
    assert "<h2>Red or open</h2>" in (tmp_path / "o.html").read_text()


def test_a_dump_whose_masses_the_user_knows(inspect: Any, tmp_path: Path) -> None:
    path = dump(tmp_path / "gas.lammpstrj", gas())
    without = inspect(path)
    assert "equipartition: cannot be said: the file states no masses for its types (--mass TYPE=MASS" in without.out
    done = inspect(path, "--mass", "1=1", "--mass", "2=3", "--ensemble", "nvt", "--temperature", "1.3")
    assert done.status == Status.PASSED, done.out
    assert "temperature of 2 over that of all" in done.out
    # the wrong way round, the species are not of one temperature
    assert inspect(path, "--mass", "1=3", "--mass", "2=1").status == Status.FAILED


def test_a_file_that_was_cut_is_status_1(inspect: Any, tmp_path: Path) -> None:
    path = dump(tmp_path / "gas.lammpstrj", gas(), masses=True)
    text = path.read_text()
    path.write_text(text[: int(0.9 * len(text))])
    done = inspect(path)
    assert done.status == Status.FAILED
    assert "frames: fail: places where the file ends, or frames cannot be used; what follows step" in done.out


def test_few_frames_are_inconclusive_unless_that_is_allowed(inspect: Any, tmp_path: Path) -> None:
    path = extxyz(tmp_path / "gas.xyz", gas(frames=12))
    assert inspect(path).status == Status.INCONCLUSIVE
    assert inspect(path, "--allow-inconclusive").status == Status.PASSED


def test_nothing_but_the_file_is_no_success(inspect: Any, tmp_path: Path) -> None:
    source = flying(frames=1, number=1, velocities=None, box=None)
    done = inspect(extxyz(tmp_path / "one.xyz", source))
    assert done.status == Status.UNJUDGED
    assert "crosscheck: nothing but the file itself was judged" in done.err


def test_a_scene_says_what_is_conserved(inspect: Any, tmp_path: Path) -> None:
    scene = Scene(
        name="gas",
        dimension=3,
        duration=0.59,
        lennard_jones=LennardJones(cutoff=1.0),
        box=Box(lengths=(5.0, 5.0, 5.0)),
        initial=Lattice(kind="lattice", structure="fcc", number=20, temperature=1.0, seed=1),
        output=Output(interval=0.01, trajectory=True),
    )
    (tmp_path / "gas.toml").write_text(scene.to_toml())
    done = inspect(extxyz(tmp_path / "gas.xyz", flying()), "--scene", tmp_path / "gas.toml")
    assert "taken to be closed and in equilibrium, at constant energy" in done.out
    assert "change of the momentum along x" in done.out
    done = inspect(extxyz(tmp_path / "few.xyz", flying(number=8)), "--scene", tmp_path / "gas.toml")
    assert done.status == Status.USAGE
    assert "it has 8 particles, and scene gas has 20" in done.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere.xyz"], "nowhere.xyz: cannot be read"),
        (["gas.xyz", "--ensemble", "npt"], "--ensemble npt: unknown; take one of equilibrium, nvt, nve, none"),
        (["gas.xyz", "--arithmetic", "half"], "--arithmetic half: unknown; take one of double, single"),
        (["gas.xyz", "--skip", "1"], "--skip 1: give a share of the frames"),
        (["gas.xyz", "--temperature", "warm"], "--temperature warm: give a number above 0"),
        (["gas.xyz", "--temperature", "300K"], "gas.xyz states no units of mass and velocity"),
        (["gas.xyz", "--mass", "A"], "--mass A: give TYPE=MASS"),
        (["gas.xyz", "--mass", "Q=1"], "has the types H, He: give one for each of them"),
        (["gas.xyz", "--hard"], "--hard: gas.xyz states no diameters"),
        (["gas.xyz", "--json", "."], ".: is a directory, and a file is to be written"),
        (["gas.xyz", "--page", "no/such/place.html/x"], "place.html"),
        (["gas.xyz", "--scene", "nowhere.toml"], "nowhere.toml: there is no such file"),
        (["table.csv"], "table.csv: it holds no positions (CSV with a column time): give a trajectory"),
        (["damaged.xyz"], "damaged.xyz: cannot be read as extended XYZ"),
    ],
)
def test_a_mistake_is_one_line_and_status_2(
    inspect: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    extxyz(tmp_path / "gas.xyz", gas(frames=5))
    (tmp_path / "table.csv").write_text("time,energy\n0,1\n1,1\n")
    (tmp_path / "damaged.xyz").write_text("three\n")
    (tmp_path / "no").write_text("a file")
    done = inspect(*words)
    assert done.status == Status.USAGE
    assert done.out == ""
    (line,) = done.err.splitlines()
    assert line.startswith("crosscheck: ")
    assert message in line
