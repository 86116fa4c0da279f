"""Whatever an engine does to its process is one error with its last lines, and the next call works."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing, Unsupported, UsageError
from crosscheck.scene import Box, Explicit, GrainFriction, HardSpheres, Lattice, Method, Output, Scene, Spring, explicit

STEP = Method(scheme="good", dt=0.1)
SCENE = Scene(name="spring", dimension=1, duration=0.1, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))
START = Callable[[str], Worker]

#: The scheme's name says what the engine does.
ENGINE = """
import ctypes, os, sys, time
import numpy as np
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times

class Engine:
    name = "trouble"
    schemes = {
        name: Claims((1, 1))
        for name in "good abort segfault sleep spin raise exit close short odd refuse".split() + ["no disk"]
    }
    capabilities = (capability("spring", "stepping", words="dimension=1", observables="positions velocities"),)

    def version(self):
        return "1"

    def supports(self, scene, method):
        return "it is too hard" if method.scheme == "refuse" else None

    def run(self, scene, method):
        print("about to", method.scheme, flush=True)
        if method.scheme == "abort":
            os.abort()
        if method.scheme == "segfault":
            ctypes.string_at(0)
        if method.scheme == "sleep":
            time.sleep(1000)
        if method.scheme == "spin":
            while True:
                pass
        if method.scheme == "raise":
            raise ArithmeticError("two and two are five")
        if method.scheme == "exit":
            sys.exit(7)
        if method.scheme == "no disk":
            raise OSError("no space left")
        if method.scheme == "close":
            os.closerange(3, 100)
            time.sleep(1000)
        state = scene.initial_state()
        positions = state.positions[:-1] if method.scheme == "short" else state.positions
        cost = Cost(steps=object()) if method.scheme == "odd" else Cost(steps=1)
        run = Run(cost=cost, time=sample_times(scene, method), final_positions=positions)
        run["final_velocities"] = state.velocities
        if scene.output.trajectory:
            run["positions"], run["velocities"] = np.array([[[1.0]], [[2.0]]]), np.array([[[3.0]], [[4.0]]])
        return run
"""


@pytest.fixture
def start(tmp_path: Path) -> Iterator[START]:
    """Starts a worker for an engine file of the given text."""
    workers = []

    def start(text: str) -> Worker:
        file = tmp_path / "engine.py"
        file.write_text(text)
        workers.append(Worker(f"{file}:Engine", time_limit=60))
        return workers[-1]

    yield start
    for worker in workers:
        worker.close()


@pytest.mark.parametrize(
    ("scheme", "message"),
    [
        ("abort", "was killed by signal 6"),
        ("segfault", "was killed by signal 11"),
        ("raise", "ArithmeticError: two and two are five"),
        ("exit", "ended with exit status 7"),
        ("no disk", "OSError: no space left"),
        ("close", "closed its pipe"),
        ("short", r"run\['final_positions'\] must have shape \(1, 1\), found shape \(0, 1\)"),
    ],
)
def test_failure_is_an_error_and_the_next_run_works(start: START, scheme: str, message: str) -> None:
    worker = start(ENGINE)
    with pytest.raises(EngineError, match=message) as error:
        worker.run(SCENE, STEP.model_copy(update={"scheme": scheme}))
    assert f"about to {scheme}" in str(error.value)
    np.testing.assert_array_equal(worker.run(SCENE, STEP)["final_positions"], [[1.0]])


@pytest.mark.parametrize("scheme", ["sleep", "spin"])
def test_hang_is_an_error_that_says_where(start: START, scheme: str) -> None:
    worker = start(ENGINE)
    worker.version()  # the process's start shall not count
    worker.time_limit = 0.5
    with pytest.raises(EngineError, match=r"gave no answer within 0.5 s") as error:
        worker.run(SCENE, STEP.model_copy(update={"scheme": scheme}))
    assert f"about to {scheme}" in str(error.value)
    assert "in run" in str(error.value)
    worker.time_limit = 60
    assert worker.version() == "1"


def test_answer_that_cannot_be_written_is_an_error(start: START) -> None:
    worker = start(ENGINE)
    with pytest.raises(EngineError, match=r"run.cost.steps is <object object.*: give a whole number"):
        worker.run(SCENE, STEP.model_copy(update={"scheme": "odd"}))
    assert worker.version() == "1"


def test_crash_says_where(start: START) -> None:
    with pytest.raises(EngineError, match=r"Segmentation fault(.|\n)*in run"):
        start(ENGINE).run(SCENE, STEP.model_copy(update={"scheme": "segfault"}))


def test_last_lines_are_the_last(start: START) -> None:
    worker = start(ENGINE.replace("os.abort()", "[print('line', i) for i in range(100000)]; os.abort()"))
    with pytest.raises(EngineError) as error:
        worker.run(SCENE, STEP.model_copy(update={"scheme": "abort"}))
    assert len(str(error.value).splitlines()) < 20


def test_worker_persists(start: START) -> None:
    worker = start(ENGINE.replace('return "1"', "return str(os.getpid())"))
    first = worker.version()
    worker.run(SCENE, STEP)
    assert worker.version() == first
    with pytest.raises(EngineError):
        worker.run(SCENE, STEP.model_copy(update={"scheme": "abort"}))
    assert worker.version() != first


def test_large_scene(start: START) -> None:
    positions = np.arange(30000.0)[:, None]
    run = start(ENGINE).run(SCENE.changed(initial=explicit(positions, positions)), STEP)
    np.testing.assert_array_equal(run["final_positions"], positions)


def test_hang_at_import(start: START) -> None:
    # a request larger than the pipe's buffer waits for the reader: within the time limit too
    worker = start("import time\nprint('importing', flush=True)\ntime.sleep(1000)")
    worker.time_limit = 1
    positions = np.arange(30000.0)[:, None]
    with pytest.raises(EngineError, match="gave no answer"):
        worker.run(SCENE.changed(initial=explicit(positions, positions)), STEP)


def test_unsupported(start: START) -> None:
    with pytest.raises(Unsupported, match="it is too hard"):
        start(ENGINE).run(SCENE, STEP.model_copy(update={"scheme": "refuse"}))


DISKS = Scene(
    name="disks",
    dimension=2,
    duration=1.0,
    hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)),
    box=Box(lengths=(5.0, 5.0), boundaries=("hard", "open")),
    initial=Explicit(positions=((1.0, 1.0), (3.0, 3.0))),
    output=Output(collisions=(1, 2), observables=("kinetic_energy", "collisions", "wall_impulse"), trajectory=True),
)
FROM_EVENT_TO_EVENT = """
import numpy as np
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Cost, Run, shapes

WORDS = "dimension=2 hard_spheres.friction box.boundaries=hard box.boundaries=open output.collisions"
MEASURED = "positions velocities angular_velocities kinetic_energy collisions wall_impulse"

class Engine:
    name = "events"
    schemes = {"edmd": Claims(kind="event_driven"), "steps": Claims((1, 1))}
    capabilities = tuple(
        capability("hard_spheres", kind, words=WORDS, observables=MEASURED) for kind in ("event_driven", "stepping")
    )

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        state = scene.initial_state()
        run = Run({name: np.full(shape, 2.0) for name, shape in shapes(scene, 3).items()}, cost=Cost(events=7))
        run["time"] = np.array([0.0, 0.5, np.nan])
        run["angular_velocities"], run["final_angular_velocities"] = np.ones((3, 2, 1)), np.ones((2, 1))
        run.stopped = "inelastic collapse of particles 0 and 1"
        return run
"""


def test_arrays_of_hard_spheres_arrive(start: START) -> None:
    run = start(FROM_EVENT_TO_EVENT).run(DISKS, Method(scheme="edmd"))
    states = {f"{when}{what}" for when in ("", "final_") for what in ("positions", "velocities", "angular_velocities")}
    assert set(run) == {"time", *states, "kinetic_energy", "collisions", "wall_impulse"}
    np.testing.assert_array_equal(run["wall_impulse"], np.full((3, 4, 2), 2.0))
    np.testing.assert_array_equal(run["time"], [0.0, 0.5, np.nan])
    assert run["angular_velocities"].shape == (3, 2, 1)
    assert run.stopped == "inelastic collapse of particles 0 and 1"
    assert (run.cost.events, run.diverged) == (7, False)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "np.full(shape, 2.0)",
            "np.full(shape if name != 'wall_impulse' else shape[:1], 2.0)",
            r"run\['wall_impulse'\] must have shape \(3, 4, 2\)",
        ),
        (
            "{name: np.full",
            "{name.replace('ll', 'l'): np.full",
            r"run\['collisions'\] must have shape \(3,\), found nothing",
        ),
        (
            "np.ones((3, 2, 1)), np",
            "np.ones((3, 2, 3)), np",
            r"run\['angular_velocities'\] must have shape \(3, 2, 1\), found shape \(3, 2, 3\)",
        ),
        ("0.5, np.nan]", "0.5]", r"run\['time'\] has 2 samples, the scene asks for 3"),
    ],
)
def test_malformed_arrays_of_hard_spheres(start: START, old: str, new: str, message: str) -> None:
    assert FROM_EVENT_TO_EVENT.count(old) == 1
    with pytest.raises(EngineError, match=message):
        start(FROM_EVENT_TO_EVENT.replace(old, new)).run(DISKS, Method(scheme="edmd"))


@pytest.mark.parametrize(
    ("method", "message"),
    [
        (
            Method(scheme="edmd", dt=0.1),
            r"method.dt = 0.1: scheme 'edmd' goes from event to event: remove",
        ),
        (Method(scheme="steps"), r"method.dt is missing: scheme 'steps' takes time steps: add dt, as in dt = 0.005"),
        (
            Method(scheme="steps", tolerance=1e-6),
            r"method.tolerance = 1e-06: scheme 'steps' takes steps of dt: remove tolerance",
        ),
        (
            Method(scheme="edmd", tolerance=1e-6),
            r"method.tolerance = 1e-06: scheme 'edmd' goes from event to event: remove tolerance",
        ),
    ],
)
def test_a_step_for_those_that_take_one(start: START, method: Method, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        start(FROM_EVENT_TO_EVENT).run(DISKS, method)


def test_what_is_not_declared_never_reaches_an_engine(start: START) -> None:
    worker = start(FROM_EVENT_TO_EVENT)
    with pytest.raises(Unsupported, match=r"it declares no hard_spheres.restitution for \[hard_spheres\]"):
        worker.run(DISKS.changed(hard_spheres=HardSpheres(restitution=0.5)), Method(scheme="edmd"))
    assert worker.supports(SCENE, Method(scheme="steps", dt=0.1)) is not None


def test_derived_observables_come_from_what_they_need(start: START) -> None:
    """The engine measures velocities and has never heard of the momentum."""
    scene = SCENE.changed(masses=2.0, output=Output(interval=0.1, observables=("momentum",)))
    run = start(ENGINE).run(scene, STEP)
    assert set(run) == {"time", "final_positions", "final_velocities", "momentum"}
    np.testing.assert_array_equal(run["momentum"], [[6.0], [8.0]])
    with pytest.raises(KeyError, match="the run holds no 'velocities': the scene did not ask for it"):
        run["velocities"]


def test_missing_engine(start: START) -> None:
    worker = start(ENGINE.replace('return "1"', "import no_such_package"))
    for _ in range(2):
        with pytest.raises(EngineMissing, match="No module named 'no_such_package'"):
            worker.version()


def test_missing_when_run_cannot_import_it(start: START) -> None:
    broken = ENGINE.replace('return "1"', "import no_such_package").replace("print(", "self.version(); print(")
    with pytest.raises(EngineMissing, match="no_such_package"):
        start(broken).run(SCENE, STEP)


@pytest.mark.parametrize(
    ("engine", "message"),
    [
        ("no-such-engine", "unknown engine 'no-such-engine'; known: refimpl"),
        ("nowhere.py:Engine", "there is no file nowhere.py"),
    ],
)
def test_unknown_engine(engine: str, message: str) -> None:
    worker = Worker(engine, time_limit=60)
    with pytest.raises(UsageError, match=message):
        worker.version()
    worker.close()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("class Engine: name = 'x'", "class Engine lacks 'schemes'"),
        ("class Engine: name, schemes = 'x', {}", r"class Engine lacks 'capabilities' \(see docs/engines.md\)"),
        ("import no_such_package", "cannot be imported .ModuleNotFoundError"),
        ("class Other: pass", "has no class Engine"),
    ],
)
def test_bad_engine_file(start: START, text: str, message: str) -> None:
    worker = start(text)
    for _ in range(2):
        with pytest.raises(UsageError, match=message):
            worker.version()


def test_close_removes_everything(start: START) -> None:
    worker = start(ENGINE)
    worker.run(SCENE, STEP)
    directory = Path(worker._directory.name)
    assert directory.exists()
    worker.close()
    assert not directory.exists()


def test_interpreted_engine_compiles_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "numba"))
    lattice = Lattice(kind="lattice", structure="square", number=4, temperature=1.0, seed=1)
    discs = Scene(
        name="discs", dimension=2, duration=2.0, box=Box(density=0.3), hard_spheres=HardSpheres(), initial=lattice
    )
    worker = Worker("refimpl", interpreted=True)
    try:
        run = worker.run(discs, Method(scheme="event_driven"))
    finally:
        worker.close()
    assert run.cost.events > 0
    assert not list(tmp_path.iterdir())


def test_a_run_can_go_on_without_a_state_of_its_own_end(interpreted: Worker, tmp_path: Path) -> None:
    method, middle = Method(scheme="velocity_verlet", dt=0.1), tmp_path / "middle.npz"
    whole = interpreted.run(SCENE.changed(duration=0.2), method)
    interpreted.run(SCENE, method, keep=middle)
    for _ in range(2):  # the state is not used up
        end = interpreted.run(SCENE, method, restart=middle)
        assert end["final_positions"] == whole["final_positions"]
