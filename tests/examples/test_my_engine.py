"""The worked example of one's own engine runs in a worker and is right."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from crosscheck.checks import all_checks
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import Unsupported
from crosscheck.record import read
from crosscheck.scene import Explicit, Gravity, Kepler, LennardJones, Method, Output, Scene, Spring

EXAMPLE = Path(__file__).parents[2] / "examples" / "my_engine.py"
STEP = Method(scheme="velocity_verlet", dt=0.001)


@pytest.fixture(scope="module")
def worker() -> Iterator[Worker]:
    worker = Worker(f"{EXAMPLE}:MyEngine", time_limit=60)
    yield worker
    worker.close()


def test_spring(worker: Worker) -> None:
    scene = Scene(
        name="spring",
        dimension=1,
        duration=5.0,
        masses=2.0,
        spring=Spring(k=8.0),
        initial=Explicit(positions=((1.0,),)),
        output=Output(interval=0.1, observables=("kinetic_energy", "potential_energy"), trajectory=True, forces=True),
    )
    run = worker.run(scene, STEP)
    np.testing.assert_allclose(run["positions"][:, 0, 0], np.cos(2 * run["time"]), atol=2e-6)
    np.testing.assert_allclose(run["velocities"][:, 0, 0], -2 * np.sin(2 * run["time"]), atol=4e-6)
    np.testing.assert_allclose(run["potential_energy"], 4 * run["positions"][:, 0, 0] ** 2, rtol=1e-14)
    np.testing.assert_allclose(run["kinetic_energy"], run["velocities"][:, 0, 0] ** 2, rtol=1e-14)
    np.testing.assert_allclose(run["forces"], -8 * run["final_positions"], rtol=1e-14)
    assert run.cost.evaluations == run.cost.steps + 1 == 5001


def test_gravity(worker: Worker) -> None:
    # a circular orbit of period 2 pi
    scene = Scene(
        name="circle",
        dimension=2,
        duration=6.0,
        masses=(0.75, 0.25),
        gravity=Gravity(),
        initial=Kepler(kind="kepler", eccentricity=0.0),
        output=Output(interval=1.0, observables=("kinetic_energy", "potential_energy")),
    )
    run = worker.run(scene, STEP)
    assert "positions" not in run
    np.testing.assert_allclose(run["final_positions"][1], 0.75 * np.array([np.cos(6), np.sin(6)]), atol=1e-5)
    np.testing.assert_allclose(run["potential_energy"], -0.1875, rtol=1e-5)
    np.testing.assert_allclose(run["kinetic_energy"], 0.09375, rtol=1e-5)


def test_refuses_what_it_cannot_do(worker: Worker) -> None:
    scene = Scene(
        name="pair",
        dimension=3,
        duration=0.0,
        lennard_jones=LennardJones(cutoff=2.5),
        initial=Explicit(positions=((0.0, 0.0, 0.0), (1.2, 0.0, 0.0))),
    )
    with pytest.raises(Unsupported, match=r"is for \[gravity\] and \[spring\], not for \[lennard_jones\]"):
        worker.run(scene, STEP)


def test_the_readme_s_command_judges_it(tmp_path: Path) -> None:
    """As the README says it: from the root of the project, all checks of the quick tier that its declarations match."""
    command = "crosscheck run --engine examples/my_engine.py:MyEngine"
    assert command in (EXAMPLE.parents[1] / "README.md").read_text(encoding="utf-8")
    _, *words = command.split()
    done = subprocess.run(
        [sys.executable, "-P", "-m", "crosscheck.cli", *words, "-o", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
        cwd=EXAMPLE.parents[1],
        timeout=300,
    )
    lines = read(tmp_path)
    assert done.returncode == 0, done.stdout
    assert {line["outcome"] for line in lines} == {"pass"}
    assert {line["check"].partition("/")[0] for line in lines} <= {"stepping", "performance", "extreme"}
    assert len(lines) > 10
    said = re.search(r"my_engine.py:MyEngine: (\d+) checks match what it declares, (\d+) need more", done.stdout)
    assert said is not None
    # some of them have variants of the full tier only
    assert int(said[1]) >= len({line["check"] for line in lines})
    assert int(said[1]) + int(said[2]) == len(all_checks())


def test_its_tests_are_green_and_turn_red_with_a_bug(tmp_path: Path) -> None:
    """As in one's own suite: the tests beside the engine, a copy of both, the copy with a bug."""
    for directory, old, new in (
        ("right", "", ""),
        ("wrong", "0.5 * dt * f / m\n                r =", "dt * f / m\n                r ="),
    ):
        (tmp_path / directory).mkdir()
        text = EXAMPLE.read_text(encoding="utf-8")
        assert not old or text.count(old) == 1
        (tmp_path / directory / EXAMPLE.name).write_text(text.replace(old, new) if old else text, encoding="utf-8")
        tests = EXAMPLE.with_name("test_my_engine.py").read_text(encoding="utf-8")
        (tmp_path / directory / f"test_{directory}.py").write_text(tests, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "pytest", "-v", "-k", "gravity_steps or gravity-steps or e0/", "."],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=300,
    )
    found = re.findall(r"^(right|wrong)/.*(PASSED|FAILED)", done.stdout, re.MULTILINE)
    assert done.returncode == 1, done.stdout
    assert {outcome for where, outcome in found if where == "right"} == {"PASSED"}
    assert {outcome for where, outcome in found if where == "wrong"} == {"FAILED"}
    assert len(found) == 4
    assert "again: crosscheck run stepping/gravity-steps/velocity_verlet" in done.stdout
