"""Whatever an engine does to its process: an error that names the engine, and nothing of it is left."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError
from crosscheck.scene import Explicit, Method, Scene, Spring

SCENE = Scene(name="spring", dimension=1, duration=0.1, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))

#: `DEEDS` is a dictionary of functions by name; the scheme's name says which of them the engine runs before it returns.
ENGINE = '''
import ctypes, os, resource, signal, subprocess, sys, threading, time
from pathlib import Path
import numpy as np
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run, sample_times
from crosscheck.engines.workers import border, worker

HERE = Path(__file__).parent
DEEDS = {}

def deed(function):
    DEEDS[function.__name__] = function
    return function

@deed
def good(): pass

@deed
def leaves_at_once(): os._exit(0)

@deed
def exits_well(): sys.exit(0)

@deed
def exits_with_a_text(): sys.exit("no licence")

@deed
def exits_with_threads():
    threading.Thread(target=time.sleep, args=(1000,)).start()
    sys.exit(5)

@deed
def kills_itself(): os.kill(os.getpid(), signal.SIGKILL)

@deed
def kills_its_guard():
    os.kill(os.getppid(), signal.SIGKILL)
    signal.pause()

@deed
def kills_its_group(): os.killpg(0, signal.SIGTERM)

@deed
def interrupts(): raise KeyboardInterrupt

@deed
def prints_much():
    for _ in range(100):
        sys.stdout.write("x" * 1000000)
    raise ValueError("and then fails")

@deed
def floods_memory(): keep = [bytes(1 << 30) for _ in range(100000)]

@deed
def answers_itself():
    for pipe in range(3, 64):
        try:
            os.write(pipe, b'{"diverged": false}\\n')
        except OSError:
            pass

@deed
def answers_nonsense():
    for pipe in range(3, 64):
        try:
            os.write(pipe, bytes(range(10)) + b"\\n")
        except OSError:
            pass

@deed
def answers_without_end():
    for pipe in range(3, 64):
        try:
            while True:
                os.write(pipe, b"x" * 65536)
        except OSError:
            pass

@deed
def stores_nothing(): worker.hand_over = lambda path, arrays: {}

@deed
def stores_nonsense():
    def hand_over(path, arrays):
        path.write_text("nonsense")
        return {name: list(array.shape) for name, array in arrays.items()}
    worker.hand_over = hand_over

@deed
def stores_under_other_shapes():
    store = worker.hand_over
    worker.hand_over = lambda path, arrays: {name: [-1, "2"] for name in store(path, arrays)}

@deed
def opens_the_border():
    border.arrays = lambda given, *args, **more: {name: array * np.nan for name, array in given.items()}

@deed
def believes_itself():
    border.cost = lambda given: type(given)(wall=-1.0)

@deed
def forgets_json():
    import json
    json.dumps = json.loads = None

@deed
def closes_its_streams():
    sys.stdout.close()
    sys.stderr.close()
    os.close(1)
    os.close(2)

@deed
def changes_its_surroundings():
    os.chdir("/")
    os.environ.clear()
    os.umask(0o777)
    for number in range(1, 65):
        if number not in (9, 19, 32, 33):
            signal.signal(number, signal.SIG_IGN)
    sys.path.clear()
    sys.argv.clear()
    np.seterr(all="raise")

@deed
def leaves_a_thread(): threading.Thread(target=time.sleep, args=(1000,)).start()

@deed
def forks_and_both_come_back(): os.fork()

def child(ignores=False):
    """Says in the FIFO that it lives, and keeps it open as long as it does; it also holds all pipes of its parent."""
    pipe = os.open(HERE / "alive", os.O_WRONLY)
    os.set_inheritable(pipe, True)
    program = "import os, signal, time; os.setsid(); signal.signal(15, signal.SIG_IGN); time.sleep(1000)"
    subprocess.Popen([sys.executable, "-c", program], close_fds=False)
    os.write(pipe, b"%d" % os.getppid())
    return pipe

@deed
def leaves_a_child():
    child()
    os._exit(3)

@deed
def spins_with_a_child():
    child()
    for number in (1, 2, 15):
        signal.signal(number, signal.SIG_IGN)
    faulty = ctypes.PyDLL(None).pause
    faulty()  # holds the lock of the interpreter: nothing of Python runs in this process any more

class Engine:
    name = "hostile"
    schemes = {name: Claims((1, 1)) for name in DEEDS}
    capabilities = (capability("spring", "stepping", words="dimension=1", observables="positions velocities"),)

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        state = scene.initial_state()
        DEEDS[method.scheme]()
        return Run(
            time=sample_times(scene, method), final_positions=state.positions, final_velocities=state.velocities
        )
'''


@pytest.fixture(scope="module")
def worker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Worker]:
    """One worker for all, as in a run of the suite: it starts again where it has to."""
    file = tmp_path_factory.mktemp("engine") / "engine.py"
    file.write_text(ENGINE)
    worker = Worker(f"{file}:Engine", time_limit=60)
    yield worker
    worker.close()


def run(worker: Worker, deed: str) -> None:
    found = worker.run(SCENE, Method(scheme=deed, dt=0.1))
    np.testing.assert_array_equal(found["final_positions"], [[1.0]])


@pytest.mark.parametrize(
    ("deed", "message"),
    [
        ("leaves_at_once", "ended with exit status 0"),
        ("exits_well", "ended with exit status 0"),
        ("exits_with_a_text", "ended with exit status 1\nno licence"),
        ("exits_with_threads", "ended with exit status 5"),
        ("kills_itself", "was killed by signal 9, as when memory runs out"),
        ("kills_its_guard", "was killed by signal 9"),
        ("kills_its_group", "was killed by signal 15"),
        ("interrupts", "KeyboardInterrupt"),
        ("prints_much", "ValueError: and then fails"),
        ("floods_memory", "MemoryError"),
        ("answers_itself", "its answer cannot be read"),
        ("answers_nonsense", "its answer cannot be read"),
        ("answers_without_end", "its answer cannot be read"),
        ("stores_nothing", "its answer cannot be read: FileNotFoundError"),
        ("stores_nonsense", "its answer cannot be read"),
        ("stores_under_other_shapes", "its answer cannot be read"),
        ("opens_the_border", r"run\['time'\]\[0\] is nan"),
        ("believes_itself", "run.cost.wall is -1.0"),
    ],
)
def test_what_breaks_a_worker_is_an_error_that_names_the_engine(worker: Worker, deed: str, message: str) -> None:
    with pytest.raises(EngineError, match=message) as error:
        run(worker, deed)
    assert str(error.value).startswith(worker.engine)
    assert len(str(error.value)) < 10_000
    run(worker, "good")


@pytest.mark.parametrize(
    "deed",
    [
        "forgets_json",
        "closes_its_streams",
        "changes_its_surroundings",
        "leaves_a_thread",
        "forks_and_both_come_back",
    ],
)
def test_what_does_no_harm_is_no_error(worker: Worker, deed: str) -> None:
    run(worker, deed)
    run(worker, "good")
    worker._stop()  # the next one gets a process without a past


def alive(worker: Worker) -> Path:
    """A FIFO that is open for writing as long as the engine or a child of its lives."""
    fifo = Path(worker.engine.partition(":")[0]).parent / "alive"
    fifo.unlink(missing_ok=True)
    os.mkfifo(fifo)
    return fifo


def test_a_worker_whose_child_holds_the_pipe_is_dead(worker: Worker) -> None:
    """It is not hung: no time limit passes; and the child is gone, although it has a session of its own."""
    pipe = os.open(alive(worker), os.O_RDONLY | os.O_NONBLOCK)
    with pytest.raises(EngineError, match="ended with exit status 3"):
        run(worker, "leaves_a_child")
    os.set_blocking(pipe, True)
    with open(pipe, "rb") as file:
        assert file.read().isdigit(), "read to its end: nobody holds it any more"


def test_a_hung_worker_is_ended_with_its_children(worker: Worker) -> None:
    run(worker, "good")
    pipe = os.open(alive(worker), os.O_RDONLY | os.O_NONBLOCK)
    worker.time_limit = 0.5
    with pytest.raises(EngineError, match=r"gave no answer within 0.5 s and was stopped"):
        run(worker, "spins_with_a_child")
    worker.time_limit = 60
    os.set_blocking(pipe, True)
    with open(pipe, "rb") as file:
        assert file.read().isdigit()


PROGRAM = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background ignores it
from crosscheck import cli
sys.argv = ["crosscheck", *sys.argv[1:]]
cli.main()
"""
TOML = """
name = "one"
dimension = 1
duration = 0.1
spring = { k = 1.0 }
initial = { kind = "explicit", positions = [[1.0]] }
method = { scheme = "spins_with_a_child", dt = 0.1 }
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_when_the_suite_ends_everything_ends(worker: Worker, tmp_path: Path, number: signal.Signals) -> None:
    """The engine, which hangs in compiled code and ignores signals, its children, and its files."""
    (tmp_path / "scratch").mkdir()
    (tmp_path / "one.toml").write_text(TOML)
    fifo = alive(worker)
    words = ["simulate", "one.toml", "-e", worker.engine]
    suite = subprocess.Popen(
        [sys.executable, "-P", "-c", PROGRAM, *words],
        cwd=tmp_path,
        env=os.environ | {"TMPDIR": str(tmp_path / "scratch")},
        stderr=subprocess.PIPE,
        text=True,
    )
    with fifo.open("rb") as file:
        guard = os.pidfd_open(int(file.read1()))
        suite.send_signal(number)
        assert file.read() == b"", "the engine and its child are gone"
    select.select([guard], [], [])  # until the guard is gone
    os.close(guard)
    said = suite.communicate()[1]
    if number == signal.SIGKILL:
        assert suite.returncode == -number
    else:
        assert suite.returncode == 128 + number
        # on a slow machine, lines on the progress come before it
        assert said.splitlines()[-1] == "crosscheck: interrupted"
    assert list((tmp_path / "scratch").iterdir()) == []
