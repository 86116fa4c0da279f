"""What is added is declared once: a throw-away thing in one file works end to end.

Each test copies the packages, changes or adds one file of the copy, and runs the command line on it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import crosscheck
from crosscheck.record import read

ROOT = Path(crosscheck.__path__[0]).parent
COMMAND = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of both packages."""
    ignored = shutil.ignore_patterns("__pycache__")
    for package in ("crosscheck", "refimpl"):
        shutil.copytree(ROOT / package, tmp_path / "copy" / package, ignore=ignored)
    return tmp_path / "copy"


@pytest.fixture
def command(copy: Path, tmp_path: Path) -> COMMAND:
    """Runs the command line of the copy."""

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        # plain Python is enough for short runs, and needs no compiled kernels
        environment = os.environ | {"PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": "1"}
        program = [sys.executable, "-P", "-m", "crosscheck.cli", *words]
        return subprocess.run(
            program, capture_output=True, text=True, check=False, env=environment, cwd=tmp_path, timeout=300
        )

    return run


def replace(file: Path, old: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{file.name}: {old!r} is there {text.count(old)} times"
    file.write_text(text.replace(old, new), encoding="utf-8")


SCENE = """
name = "two"
dimension = 2
duration = 0.2
masses = [1.0, 3.0]
gravity = { G = 1.0 }
initial = { kind = "kepler", eccentricity = 0.5 }
output = { interval = 0.1, observables = ["top_speed"], trajectory = true }
method = { scheme = "velocity_verlet", dt = 0.1 }
"""


def test_an_observable(copy: Path, command: COMMAND, tmp_path: Path) -> None:
    """One row of the table: every engine has it, the CSV file, its header and the reference pages name it."""
    row = (
        'Observable("top_speed", "particles", ("sample",), "length/time", "largest speed",\n'
        '               needs=("velocities",),\n'
        '               derive=lambda masses, samples: np.linalg.norm(samples["velocities"], axis=2).max(axis=1)),'
        "\n    "
    )
    table = copy / "crosscheck" / "scene" / "observables.py"
    replace(table, '_hard("collisions", ("sample",)', f'{row}_hard("collisions", ("sample",)')
    replace(table, "from numpy.typing import NDArray", "import numpy as np\nfrom numpy.typing import NDArray")
    (tmp_path / "two.toml").write_text(SCENE)
    done = command("simulate", "two.toml", "-e", "refimpl", "-e", "rebound", "-e", "lammps", "-o", "out")
    assert done.returncode == 2, "velocity Verlet is not REBOUND's: " + done.stderr
    done = command("simulate", "two.toml", "-e", "refimpl", "-e", "lammps", "-o", "out")
    assert done.returncode == 0, done.stderr
    columns = []
    for engine in ("refimpl", "lammps"):
        lines = (tmp_path / "out" / f"observables-{engine}.csv").read_text().splitlines()
        assert "# top_speed: largest speed (unit: length/time)" in lines
        assert lines[-4] == "time,top_speed"
        columns.append([float(line.split(",")[1]) for line in lines[-3:]])
    assert columns[0] == pytest.approx(columns[1], rel=1e-13)
    assert columns[0][0] > 0
    pages = "from crosscheck.documents import PAGES; print(PAGES['observables.md'](), PAGES['scene.schema.json']())"
    environment = os.environ | {"PYTHONPATH": str(copy)}
    shown = subprocess.run(
        [sys.executable, "-P", "-c", pages], capture_output=True, text=True, check=True, env=environment
    )
    assert "| `top_speed` |" in shown.stdout
    assert '"top_speed"' in shown.stdout


CHECK = '''
"""A throw-away check."""

from crosscheck.checks.base import Check, quick
from crosscheck.engines.capabilities import Needs
from crosscheck.scene import Explicit, Method, Output, Scene, Spring
from crosscheck.verdict import round_off


def _judge(laboratory, k):
    scene = Scene(name="still", dimension=1, duration=0.1, spring=Spring(k=k), initial=Explicit(positions=((0.0,),)))
    run = laboratory.run(scene, Method(scheme="velocity_verlet", dt=0.1))
    return round_off("place of a particle at rest", float(run["final_positions"][0, 0]), 1e-16, "nothing acts")


CHECKS = (
    Check(
        "stepping/throw-away", "A particle at rest rests", "r = 0", "exact", "none", _judge,
        quick(soft=1.0, stiff=2.0), (), Needs("spring", schemes=("velocity_verlet",)),
    ),
)
'''


def test_a_check(copy: Path, command: COMMAND, tmp_path: Path) -> None:
    """One file in the folder of its group: it is listed, run on every engine that declares its needs, and reported."""
    (copy / "crosscheck" / "checks" / "stepping" / "throw_away.py").write_text(CHECK)
    assert "stepping/throw-away" in command("list").stdout
    done = command("run", "stepping/throw-away", "-o", "out")
    assert done.returncode == 0, done.stdout + done.stderr
    cases = {(line["check"], line["variant"], line["engine"], line["outcome"]) for line in read(tmp_path / "out")}
    assert cases == {
        ("stepping/throw-away", variant, engine, "pass")
        for variant in ("soft", "stiff")
        for engine in ("refimpl", "lammps")
    }
    assert "A particle at rest rests" in (tmp_path / "out" / "report.html").read_text()


def test_an_engine(tmp_path: Path) -> None:
    """One file, and its name on the command line; its event-driven scheme may be called what it likes."""
    (tmp_path / "engine.py").write_text("""
from crosscheck.engines.refimpl import RefimplEngine

class Engine(RefimplEngine):
    name = "other"
    schemes = {"edmd": RefimplEngine.schemes["event_driven"]}
    capabilities = tuple(
        type(one)(one.interaction, one.kind, one.words, one.observables)
        for one in RefimplEngine.capabilities
        if one.kind == "event_driven"
    )[:1]

    def run(self, scene, method):
        return super().run(scene, method.model_copy(update={"scheme": "event_driven"}))
""")
    # a check whose scenes run as plain Python: nothing is compiled
    program = [sys.executable, "-P", "-m", "crosscheck.cli", "run", "events/zeno", "stepping/*"]
    words = ["-e", "engine.py:Engine", "-o", "out"]
    done = subprocess.run([*program, *words], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=300)
    lines = read(tmp_path / "out")
    assert lines, done.stderr
    assert {line["check"].partition("/")[0] for line in lines} == {"events"}
    assert {line["outcome"] for line in lines} == {"pass"}, done.stdout
    assert done.returncode == 0


FORMAT = '''
"""Numbers of samples and particles."""

from crosscheck.trajectories.formats import Format


def write(path, trajectory):
    path.write_text(f"{len(trajectory.time)} samples of {trajectory.positions.shape[1]} particles\\n")


FORMAT = Format("txt", write)
'''


def test_a_trajectory_format(copy: Path, command: COMMAND, tmp_path: Path) -> None:
    """One file in the folder of the writers: `--format` takes its name, and its help and messages have it."""
    (copy / "crosscheck" / "trajectories" / "writers" / "count.py").write_text(FORMAT)
    (tmp_path / "two.toml").write_text(SCENE.replace("top_speed", "kinetic_energy"))
    done = command("simulate", "two.toml", "-o", "out", "--format", "count", "--format", "dump")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "trajectory-refimpl.txt").read_text() == "3 samples of 2 particles\n"
    assert (tmp_path / "out" / "trajectory-refimpl.lammpsdump").is_file()
    refused = command("simulate", "two.toml", "-o", "out", "--format", "counts")
    assert refused.returncode == 2
    assert refused.stderr == "crosscheck: --format counts: unknown; take count, dump, extxyz, gsd, npz\n"
    assert "count, dump, extxyz, gsd" in " ".join(command("simulate", "--help").stdout.replace("│", " ").split())


PROPERTY = """
from crosscheck.inspect.property import Collector, Property, Told, none_of


class _Far(Collector):
    def __init__(self, setting):
        self._found = 0

    def add(self, view):
        self._found += int((abs(view.frame.positions) > 9).any())

    def judge(self, once):
        return Told((none_of("frames with a particle beyond 9", self._found, "it is near"),))


PROPERTY = Property("nearness", "structure", _Far)
"""


def test_a_property_of_a_trajectory(copy: Path, command: COMMAND, tmp_path: Path) -> None:
    """One file in the folder of properties: it is judged, and decides the exit status."""
    (copy / "crosscheck" / "inspect" / "properties" / "throw_away.py").write_text(PROPERTY)
    for far, status in ((1.0, 0), (10.0, 1)):
        frames = [f"2\ntime={time}\nX {time} 0 0\nX 5 {far} {time}\n" for time in range(4)]
        (tmp_path / "two.xyz").write_text("".join(frames))
        done = command("inspect", "two.xyz")
        assert done.returncode == status, done.stdout + done.stderr
        assert any(line.startswith("nearness") for line in done.stdout.splitlines())
    assert "nearness: fail: frames with a particle beyond 9" in done.stdout
