"""`crosscheck compare` and `repeat`: what they print, write, and return."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import thermostat
from pairs_of_runs import from_state, liquid, run

from crosscheck import commands
from crosscheck.commands.comparing import DOCUMENT, PAGE
from crosscheck.compare.written import schema
from crosscheck.engines.protocol import Run
from crosscheck.errors import UsageError
from crosscheck.scene import Output, Scene
from crosscheck.simulate.arrays import write_arrays
from crosscheck.simulate.observables import Result, observables
from crosscheck.trajectories.formats import formats
from crosscheck.trajectories.trajectory import trajectory_of


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Runs of one liquid in files of several formats: the run itself, one off by a last bit, one with half the step."""
    directory = tmp_path_factory.mktemp("results")
    scene = liquid().changed(duration=10.0, output=Output(interval=0.2, trajectory=True))
    start = scene.own_start()
    positions = start.positions.copy()
    positions[17, 0] = np.nextafter(positions[17, 0], 9)
    runs = {
        "base": (scene, run(scene)),
        "bit": (scene, run(from_state(scene, positions, start.velocities))),
        "half": (scene, run(scene, 0.0025)),
    }
    paths = {}
    for name, (one, arrays) in runs.items():
        write(paths, directory, name, one, arrays)
    return paths


def write(paths: dict[str, Path], directory: Path, name: str, scene: Scene, arrays: dict[str, Any]) -> None:
    assert scene.method is not None
    result = Result("refimpl", "0", Run(arrays), observables(scene, Run(arrays)))
    paths[f"{name}.npz"] = write_arrays(directory / f"{name}.npz", scene, scene.method, result)
    trajectory = trajectory_of(scene, Run(arrays), scene.method)
    assert trajectory is not None
    for form in ("dump", "extxyz", "gsd"):
        writer = formats()[form]
        assert writer.write is not None
        path = directory / f"{name}.{writer.suffix}"
        writer.write(path, trajectory)
        paths[f"{name}.{form}"] = path
    import ase.io

    frames = ase.io.read(paths[f"{name}.extxyz"], index=":")
    for frame, time in zip(frames, arrays["time"], strict=True):
        frame.info["time"] = float(time)
    ase.io.write(directory / f"{name}.traj", frames)
    paths[f"{name}.traj"] = directory / f"{name}.traj"


def standard(mode: str | None = None, **known: Any) -> commands.Standard:
    entries: dict[str, Any] = {"tolerance": None, "arithmetic": "double", "topology": None, "scene": None}
    entries |= {"engine": "refimpl", "time_limit": 60.0}
    return commands.Standard(mode=mode, **(entries | known))


@pytest.mark.parametrize("one", ["npz", "dump", "extxyz", "gsd", "traj"])
@pytest.mark.parametrize("other", ["npz", "dump", "extxyz", "gsd", "traj"])
def test_one_run_in_any_two_formats_is_the_same(files: dict[str, Path], tmp_path: Path, one: str, other: str) -> None:
    status = commands.compare([files[f"base.{one}"], files[f"base.{other}"]], standard("tolerance"), tmp_path)
    assert status == 0
    found = json.loads((tmp_path / DOCUMENT).read_text())
    assert found["verdict"] == ("same_bits" if found["first_bits"] is None else "same_within_rounding")
    assert len(found["frames"]) == 51


@pytest.mark.parametrize("form", ["npz", "dump", "extxyz", "gsd", "traj"])
def test_chaos_and_a_bug_are_told_from_files_of_every_format(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str], form: str
) -> None:
    assert commands.compare([files["base.npz"], files[f"bit.{form}"]], standard(), tmp_path) == 0
    assert "chaos only: the separation grows as exp(lambda t)" in capsys.readouterr().out
    assert commands.compare([files["base.npz"], files[f"half.{form}"]], standard(), tmp_path) == 1
    assert "different dynamics, too early: at t = 0.2" in capsys.readouterr().out


def test_the_document_has_the_form_of_its_schema_and_the_page_says_the_same(
    files: dict[str, Path], tmp_path: Path
) -> None:
    for other in ("base", "bit", "half"):
        commands.compare([files["base.npz"], files[f"{other}.npz"]], standard(), tmp_path)
        found = json.loads((tmp_path / DOCUMENT).read_text())
        jsonschema.validate(found, schema(), cls=jsonschema.Draft202012Validator)
        page = (tmp_path / PAGE).read_text()
        assert found["sentence"].split(":")[0] in page
        assert page.count("<svg") >= (4 if other == "half" else 2)


@pytest.mark.parametrize(
    ("mode", "statuses"),
    [("exact", (0, 1, 1)), ("tolerance", (0, 1, 1)), ("chaos", (0, 0, 1)), ("statistics", (0, 0, 0))],
)
def test_the_exit_status_is_that_of_the_standard(
    files: dict[str, Path], tmp_path: Path, mode: str, statuses: tuple[int, ...]
) -> None:
    for other, status in zip(("base", "bit", "half"), statuses, strict=True):
        assert commands.compare([files["base.npz"], files[f"{other}.npz"]], standard(mode), tmp_path) == status


def test_of_many_runs_the_odd_one_is_named(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = []
    for number in range(4):
        runs.append(tmp_path / f"run{number}")
        runs[-1].mkdir()
        (runs[-1] / "arrays-refimpl.npz").symlink_to(files["bit.npz" if number == 2 else "base.npz"])
    status = commands.compare(runs, standard("exact"), tmp_path / "out")
    out = capsys.readouterr().out
    assert status == 1
    assert "4 runs, 51 common frames; 3 are the same to the last bit" in out
    assert "run2/arrays-refimpl.npz left the others at t = 0 (step 0):" in out
    assert "particle 18" in out
    assert commands.compare(runs, standard("chaos"), tmp_path / "out") == 0
    assert commands.compare([runs[0], runs[1], runs[3]], standard("exact"), tmp_path / "out") == 0


def test_frames_that_are_matched_by_steps_are_told_by_their_step(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, x in (("one", "0.25"), ("two", "0.375")):
        frames = [
            f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 5\n0 5\n0 5\n"
            f"ITEM: ATOMS id x y z\n1 {x if step else 0.25} 2.0 3.0\n2 4.0 3.0 2.0\n"
            for step in (0, 20, 40)
        ]
        (tmp_path / name).write_text("".join(frames))
    files = [tmp_path / "one", tmp_path / "two"]
    assert commands.compare(files, standard("tolerance"), tmp_path / "out") == 1
    out = capsys.readouterr().out
    assert "first bits that differ: step 20, position x of particle 1: 0.25 against 0.375" in out
    assert "t = " not in out
    assert "step 20: position x" in (tmp_path / "out" / PAGE).read_text()
    assert commands.compare([files[0], *files], standard("exact"), tmp_path / "out") == 1
    assert "two left the others at step 20:" in capsys.readouterr().out


def test_tables_are_compared_by_their_statistics(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(1)
    for name in ("one", "two", "other"):
        shift = 2.0 if name == "other" else 0.0
        rows = "".join(f"{0.5 * k},{x!r}\n" for k, x in enumerate((rng.standard_normal(200) + shift).tolist()))
        (tmp_path / f"{name}.csv").write_text(f"# a comment\ntime,energy\n{rows}")
    assert commands.compare([tmp_path / "one.csv", tmp_path / "two.csv"], standard(), tmp_path / "out") == 0
    assert "same statistics" in capsys.readouterr().out
    assert commands.compare([tmp_path / "one.csv", tmp_path / "other.csv"], standard(), tmp_path / "out") == 1
    found = json.loads((tmp_path / "out" / DOCUMENT).read_text())
    assert found["verdict"] == "different_statistics"
    assert found["tested"][0]["name"] == "energy"


def test_a_thermostat_that_is_3_percent_off_shows_in_the_statistics(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gases = (("one", "1.0", "11"), ("two", "1.0", "22"), ("hot", "1.03", "33"))
    words = [word for name, *rest in gases for word in (str(tmp_path / f"{name}.bin"), *rest)]
    subprocess.run([sys.executable, "-P", thermostat.__file__, *words], check=True, timeout=300)
    one = tmp_path / "one.bin"
    assert commands.compare([one, tmp_path / "two.bin"], standard("statistics"), tmp_path / "out") == 0
    assert commands.compare([one, tmp_path / "hot.bin"], standard("statistics"), tmp_path / "out") == 1
    assert "different statistics: mean v" in capsys.readouterr().out
    assert commands.compare([one, tmp_path / "two.bin"], standard(), tmp_path / "out") == 1
    assert "other starts are compared by --mode statistics" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("names", "known", "message"),
    [
        (["base.npz"], {}, "give two or more files"),
        (["base.npz", "nowhere"], {}, r"nowhere: cannot be read \(No such file or directory\)"),
        (
            ["base.npz", "base.dump"],
            {"mode": "nearly"},
            "--mode nearly: give one of exact, tolerance, chaos, statistics",
        ),
        (["base.npz", "base.dump"], {"arithmetic": "half"}, "--arithmetic half: give one of double, single"),
        (["base.npz", "base.dump"], {"tolerance": 1.0}, "--tolerance: goes with --mode tolerance"),
        (["base.npz", "notes.txt"], {}, "notes.txt: none of the formats that are read"),
        (["base.npz", "table.csv"], {}, "table.csv is a table in time"),
        (["base.npz", "empty"], {}, "empty: no file of results in it"),
    ],
)
def test_mistakes_are_one_line(
    files: dict[str, Path], tmp_path: Path, names: list[str], known: dict[str, Any], message: str
) -> None:
    (tmp_path / "notes.txt").write_text("nothing")
    (tmp_path / "table.csv").write_text("time,energy\n0,1\n1,2\n")
    (tmp_path / "empty").mkdir()
    paths = [files.get(name, tmp_path / name) for name in names]
    with pytest.raises(UsageError, match=message) as raised:
        commands.compare(paths, standard(**known), tmp_path / "out")
    assert "\n" not in str(raised.value)


def test_repeat_says_whether_an_engine_is_deterministic(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    scene = liquid().changed(duration=0.2)
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    status = commands.repeat(tmp_path / "scene.toml", "refimpl", 1, [1, 2], standard(), tmp_path / "out")
    assert status == 0
    assert "refimpl is deterministic in this scene: one result in 2 runs" in capsys.readouterr().out
    (tmp_path / "engine.py").write_text(NOISY)
    engine = f"{tmp_path / 'engine.py'}:Noisy"
    status = commands.repeat(tmp_path / "scene.toml", engine, 3, [1], standard(), tmp_path / "noisy")
    assert status == 1
    out = capsys.readouterr().out
    assert "is not deterministic here: 3 different results in 3 runs" in out
    assert "left the others at t = 0.1" in out


#: An engine that adds something new to the velocities after the start in each process.
NOISY = """
import os
import numpy as np
from crosscheck.engines.refimpl import RefimplEngine


class Noisy(RefimplEngine):
    name = "noisy"

    def run(self, scene, method):
        run = super().run(scene, method)
        run["velocities"][1:] += 1e-9 * (1 + os.getpid())
        return run
"""
