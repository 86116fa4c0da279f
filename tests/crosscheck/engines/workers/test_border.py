"""Whatever an engine declares or returns: what is not as it should be is an error that blames the engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.engines.capabilities import Capability, capability
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, shapes
from crosscheck.engines.workers import border
from crosscheck.engines.workers.pool import Worker
from crosscheck.engines.workers.worker import Server
from crosscheck.errors import EngineError, UsageError
from crosscheck.scene import Explicit, HardSpheres, Method, Output, Scene, Spring

SCENE = Scene(
    name="spring",
    dimension=1,
    duration=0.4,
    spring=Spring(k=1.0),
    initial=Explicit(positions=((1.0,), (2.0,))),
    output=Output(interval=0.1, observables=("kinetic_energy", "momentum"), trajectory=True),
)
STEP = Method(scheme="steps", dt=0.1)
MEASURED = "positions velocities kinetic_energy"


class Engine:
    """An engine that is as it should be, but for what a test changes."""

    name = "good"
    schemes = {"steps": Claims((1, 1)), "events": Claims(kind="event_driven")}
    capabilities = (
        capability("spring", "stepping", words="dimension=1", observables=MEASURED),
        capability(
            "hard_spheres", "event_driven", words="dimension=2 output.collisions", observables=f"{MEASURED} collisions"
        ),
    )

    def version(self) -> Any:
        return "1"

    def supports(self, scene: Scene, method: Method) -> Any:
        return None

    def run(self, scene: Scene, method: Method) -> Any:
        return good(scene, method)


def good(scene: Scene, method: Method) -> Run:
    """What a run should be: all arrays are 1, the times those that the scene asks for."""
    times = sample_times(scene, method)
    run = Run({name: np.ones(shape) for name, shape in shapes(scene, times.size).items()})
    run["time"] = np.where(np.isnan(times), 0.5, times)
    return run


class Local(Worker):
    """A worker without a process: the engine answers in this one, and its answers are checked as ever."""

    server: Server

    def _call(self, request: dict[str, Any]) -> dict[str, Any]:
        return self._granted(self.server.reply(request))


Start = Callable[..., Local]


@pytest.fixture
def start(monkeypatch: pytest.MonkeyPatch) -> Iterator[Start]:
    """A worker of `Engine` with some members changed."""
    workers = []

    def start(**changes: Any) -> Local:
        changed = type("Changed", (Engine,), changes)
        monkeypatch.setattr("crosscheck.engines.workers.worker.load_class", lambda name: changed)
        worker = Local("hostile")
        worker.server = Server("hostile")
        workers.append(worker)
        return worker

    yield start
    for worker in workers:
        worker.close()


class Metres(np.ndarray):  # type: ignore[type-arg]
    """Numbers with a unit, as some packages have them: as plain numbers they would lose it."""


class Odd:
    """Everything about it raises."""

    def __repr__(self) -> str:
        raise ArithmeticError

    __str__ = __eq__ = __len__ = __array__ = __float__ = __bool__ = __iter__ = __repr__  # type: ignore[assignment]
    __hash__ = object.__hash__


def test_what_is_good_arrives(start: Start) -> None:
    worker = start()
    run = worker.run(SCENE, STEP)
    assert worker.version() == "1"
    assert worker.supports(SCENE, STEP) is None
    assert set(run) == set(SCENE.asked())
    np.testing.assert_array_equal(run["momentum"], np.full((5, 1), 2.0))
    declared = border.declared(worker.declarations())
    assert (declared.name, declared.schemes, declared.capabilities) == ("good", Engine.schemes, Engine.capabilities)


# -- declarations ------------------------------------------------------------------------------------------------

CAPABLE = Engine.capabilities[0]
WRONG_DECLARATIONS = [
    *(("name", name, "name is") for name in (None, 5, "", " ", b"x", Odd())),
    *(("schemes", schemes, "schemes is") for schemes in ({}, [], None, 5, "steps", ["steps"], Odd())),
    ("schemes", {1: Claims()}, "a name in schemes is 1"),
    ("schemes", {"": Claims()}, "a name in schemes is ''"),
    *(("schemes", {"steps": one}, r"schemes\['steps'\] is") for one in (None, (1, 1), Claims, {"order": (1, 1)})),
    *(
        ("schemes", {"steps": Claims(order=order)}, "order is")
        for order in (2, (2,), (2, 2, 2), (2.5, 2), "22", ("2", "2"), [2, 2], (0, 0), (True, 1), (np.nan, 1))
    ),
    ("schemes", {"steps": Claims(symplectic="no")}, "symplectic is 'no'"),
    ("schemes", {"steps": Claims(reversible=1)}, "reversible is 1"),
    *(("schemes", {"steps": Claims(kind=kind)}, "kind is") for kind in (None, "", "steps", 1, ["stepping"])),
    *(("capabilities", found, "capabilities is") for found in ((), [], None, [CAPABLE], CAPABLE, "spring")),
    ("capabilities", ("spring",), "capabilities holds 'spring'"),
    ("capabilities", (capability("magnets", "stepping", words="", observables=""),), "no such interaction"),
    ("capabilities", (capability("spring", "quick", words="", observables=""),), "kind is 'quick'"),
    ("capabilities", (capability("spring", "lattice", words="", observables=""),), "none of the engine's schemes"),
    ("capabilities", (Capability("spring", "stepping", "dimension=1", frozenset()),), "words is 'dimension=1'"),
    ("capabilities", (Capability("spring", "stepping", frozenset({1}), frozenset()),), "words is"),
    ("capabilities", (Capability("spring", "stepping", frozenset(), frozenset(), "steps"),), "schemes is 'steps'"),
    ("capabilities", (Capability("spring", "stepping", frozenset(), frozenset(), ("no",)),), "schemes names 'no'"),
    *(("promises", promises, "promises is") for promises in ("speed", ["speed"], ("fast",), None, 5)),
    *((member, None, f"{member} is None: make it a method") for member in ("version", "supports", "run")),
]


@pytest.mark.parametrize(("member", "value", "message"), WRONG_DECLARATIONS)
def test_a_wrong_declaration_is_a_mistake_of_the_engine(start: Start, member: str, value: Any, message: str) -> None:
    worker = start(**{member: value})
    for ask in (worker.declarations, lambda: worker.run(SCENE, STEP)):
        with pytest.raises(UsageError, match=f"^engine 'hostile': .*{message}") as error:
            ask()
        assert len(str(error.value)) < 500


# -- texts -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [None, 5, "", "\n", b"1.0", ("1",), Odd()])
def test_a_wrong_version(start: Start, value: Any) -> None:
    with pytest.raises(EngineError, match=r"^hostile: version\(\) returned .*return a text that is not empty"):
        start(version=lambda self: value).version()


@pytest.mark.parametrize("value", [True, False, "", " ", 5, 0, [], {}, b"no", np.bool_(False), Odd()])
def test_a_wrong_reason(start: Start, value: Any) -> None:
    """None of them is a refusal, which would be a skip, nor a consent."""
    worker = start(supports=lambda self, scene, method: value)
    for ask in (worker.supports, worker.run):
        with pytest.raises(EngineError, match=r"^hostile: supports\(\) returned .*return None if it can run the scene"):
            ask(SCENE, STEP)


def test_long_texts_are_capped(start: Start) -> None:
    endless = "no " * 10_000_000
    worker = start(version=lambda self: endless, supports=lambda self, scene, method: endless)
    assert len(worker.version()) < 600
    assert len(worker.supports(SCENE, STEP) or "") < 2100


def test_no_text_breaks_a_file(start: Start) -> None:
    assert start(version=lambda self: "1.\udc80").version() == "1.?"


class Mute(Exception):
    """It cannot be printed."""

    def __str__(self) -> str:
        raise RuntimeError


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (Mute(), "Mute"),
        (BaseException("base"), "BaseException: base"),
        (KeyboardInterrupt(), "KeyboardInterrupt"),
        (GeneratorExit(), "GeneratorExit"),
        (RecursionError(), "RecursionError"),
        (MemoryError(), "MemoryError"),
        (StopIteration(), "StopIteration"),
        (ValueError("x" * 10_000_000), "ValueError: xxx"),
        (ValueError("\udc80"), "ValueError: ?"),
        (UnicodeDecodeError("utf-8", b"", 0, 1, "odd"), "UnicodeDecodeError"),
        (OSError(28, "No space left on device"), "No space left"),
        (ImportError("no such module"), "no such module"),
    ],
)
def test_any_exception_is_an_error_of_the_engine(start: Start, error: BaseException, message: str) -> None:
    def run(self: Any, scene: Scene, method: Method) -> None:
        raise error

    with pytest.raises(EngineError, match=r"^hostile: ") as found:
        start(run=run).run(SCENE, STEP)
    assert message in str(found.value)
    assert len(str(found.value)) < 3000


# -- runs --------------------------------------------------------------------------------------------------------


def returning(change: Callable[[Run], Any]) -> Callable[..., Any]:
    """A method `run` that returns what `change` makes of a good run."""
    return lambda self, scene, method: change(good(scene, method))


def having(**values: Any) -> Callable[[Run], Run]:
    """A change of attributes of a run (diverged, stopped, cost, remarks), or else of its arrays."""

    def change(run: Run) -> Run:
        for name, value in values.items():
            if name in ("diverged", "stopped", "cost", "remarks"):
                setattr(run, name, value)
            else:
                run[name] = value
        return run

    return change


def without(*names: str) -> Callable[[Run], Run]:
    """A change that takes arrays out of a run."""
    return lambda run: Run({name: array for name, array in run.items() if name not in names})


def replaced(name: str, at: Any, value: float) -> Callable[[Run], Run]:
    """A change of some elements of an array."""

    def change(run: Run) -> Run:
        run[name][at] = value
        return run

    return change


TIME = np.arange(5) * 0.1
#: What is refused, and what the message says of it.
WRONG_RUNS: dict[str, tuple[Callable[[Run], Any], str]] = {
    "None": (lambda run: None, "run() returned None"),
    "a dict": (dict, "run() returned {"),
    "a list": (lambda run: list(run.values()), "run() returned ["),
    "the class": (lambda run: Run, "run() returned <class"),
    "a look-alike": (lambda run: SimpleNamespace(**run), "run() returned namespace"),
    "a generator": (lambda run: (one for one in run), "run() returned <generator"),
    "a text": (lambda run: "done", "run() returned 'done'"),
    "what raises": (lambda run: Odd(), "run() returned <Odd"),
    "nothing in it": (lambda run: Run(), "run['time'] must have shape (5,), found nothing"),
    "one missing": (without("kinetic_energy"), "run['kinetic_energy'] must have shape (5,), found nothing"),
    "a misspelt one": (having(kinetik_energy=np.ones(5)), "run holds 'kinetik_energy', which is no observable"),
    "a name that is no text": (lambda run: Run({**run, 5: np.ones(5)}), "run holds 5, which is no observable"),
    "no final state": (without("final_positions"), "run['final_positions'] must have shape (2, 1), found nothing"),
    # arrays
    "one sample short": (having(kinetic_energy=np.ones(4)), "run['kinetic_energy'] must have shape (5,)"),
    "a number": (having(kinetic_energy=1.0), "run['kinetic_energy'] must have shape (5,), found shape ()"),
    "0-d": (having(kinetic_energy=np.array(1.0)), "found shape ()"),
    "transposed": (having(final_positions=np.ones((1, 2))), "must have shape (2, 1), found shape (1, 2)"),
    "flat": (having(positions=np.ones(10)), "must have shape (5, 2, 1), found shape (10,)"),
    "None in it": (having(kinetic_energy=None), "run['kinetic_energy'] holds object"),
    "objects": (having(kinetic_energy=np.ones(5, dtype=object)), "run['kinetic_energy'] holds object"),
    "complex": (having(kinetic_energy=np.ones(5, dtype=complex)), "run['kinetic_energy'] holds complex128"),
    "texts": (having(kinetic_energy=np.array(["1"] * 5)), "run['kinetic_energy'] holds <U1"),
    "a text for an array": (having(kinetic_energy="11111"), "run['kinetic_energy'] holds <U5"),
    "bytes": (having(kinetic_energy=np.array([b"1"] * 5)), "run['kinetic_energy'] holds |S1"),
    "booleans": (having(kinetic_energy=np.ones(5, dtype=bool)), "run['kinetic_energy'] holds bool"),
    "dates": (having(kinetic_energy=np.ones(5, dtype="M8[s]")), "run['kinetic_energy'] holds datetime64"),
    "records": (having(kinetic_energy=np.ones(5, dtype="f8,f8")), "run['kinetic_energy'] holds"),
    "a ragged list": (having(positions=[[1.0], [1.0, 2.0]]), "run['positions'] is [[1.0], [1.0, 2.0]], no array"),
    "a dictionary": (having(kinetic_energy={0: 1.0}), "run['kinetic_energy'] holds object"),
    "a generator in it": (having(kinetic_energy=(1.0 for _ in range(5))), "run['kinetic_energy'] holds object"),
    "an array that raises": (having(kinetic_energy=Odd()), "run['kinetic_energy'] is <Odd"),
    "masked": (having(kinetic_energy=np.ma.masked_array(np.ones(5))), "is a MaskedArray: give a plain numpy array"),
    "with a unit": (having(final_positions=np.ones((2, 1)).view(Metres)), "is a Metres: give a plain numpy array"),
    "large integers": (having(kinetic_energy=np.full(5, 2**53 + 1)), "integers of 2^53 and more"),
    "integers that no type holds": (having(kinetic_energy=[10**400] * 5), "run['kinetic_energy'] holds object"),
    "long doubles": (having(kinetic_energy=np.ones(5, np.longdouble) / 3), "round it to float64"),
    # times
    "no times": (without("time"), "run['time'] must have shape (5,), found nothing"),
    "times of other samples": (having(time=TIME * 2), "run['time'][1] is 0.2"),
    "times in steps": (having(time=np.arange(5.0)), "run['time'][1] is 1, the scene asks for 0.1"),
    "times that stand still": (having(time=np.zeros(5)), "run['time'][1] is 0, the scene asks for 0.1"),
    "times backwards": (having(time=TIME[::-1]), "run['time'][0] is 0.4"),
    "slightly other times": (having(time=TIME * (1 + 1e-7)), "run['time'][1] is 0.1000000"),
    "too many samples": (having(time=np.arange(6) * 0.1), "run['time'] has 6 samples, the scene asks for 5"),
    "a time that is not a number": (replaced("time", 2, np.nan), "run['time'][2] is nan"),
    "an infinite time": (replaced("time", 4, np.inf), "run['time'][4] is inf"),
    # what is not finite
    "NaN, and all well": (replaced("kinetic_energy", 3, np.nan), "run['kinetic_energy'][3] is nan, although the run"),
    "infinite, and all well": (replaced("positions", (2, 1), np.inf), "run['positions'][2, 1, 0] is inf, although"),
    "a NaN at the end": (replaced("final_velocities", 0, np.nan), "run['final_velocities'][0, 0] is nan"),
    "NaN at the start": (replaced("velocities", 0, np.nan), "run['velocities'][0, 0, 0] is nan, although"),
    "diverged, and all is finite": (having(diverged=True), "run.diverged is True, yet all samples to the end"),
    "stopped, and all is there": (having(stopped="collapse"), "run.stopped is 'collapse', yet no sample"),
    "stopped in between": (
        lambda run: replaced("kinetic_energy", 3, np.nan)(having(stopped="a pause")(run)),
        "run['kinetic_energy'][3] is nan, with numbers after it",
    ),
    "stopped without a state": (
        lambda run: replaced("final_positions", 1, np.nan)(having(stopped="lost")(run)),
        "run['final_positions'][1, 0] is nan: give the state at which the run stopped",
    ),
    # flags
    "diverged in words": (having(diverged="yes"), "run.diverged is 'yes': give True or False"),
    "diverged as a number": (having(diverged=1), "run.diverged is 1"),
    "diverged unknown": (having(diverged=None), "run.diverged is None"),
    "diverged as an array": (having(diverged=np.array([False])), "run.diverged is array([False])"),
    "stopped as a flag": (having(stopped=True), "run.stopped is True: say why"),
    "stopped unknown": (having(stopped=None), "run.stopped is None"),
    "stopped blank": (having(stopped=" "), "run.stopped is ' '"),
    "stopped in bytes": (having(stopped=b"collapse"), "run.stopped is b'collapse'"),
    # costs
    "no cost": (having(cost=None), "run.cost is None: give a Cost"),
    "a cost in a dict": (having(cost={"wall": 1.0}), "run.cost is {'wall': 1.0}"),
    "a time for a cost": (having(cost=1.0), "run.cost is 1.0"),
    "a negative time": (having(cost=Cost(wall=-1.0)), "run.cost.wall is -1.0: give seconds from 0 to 1e9"),
    "NaN seconds": (having(cost=Cost(cpu=np.nan)), "run.cost.cpu is nan"),
    "infinite seconds": (having(cost=Cost(compile=np.inf)), "run.cost.compile is inf"),
    "ages": (having(cost=Cost(wall=1e10)), "run.cost.wall is 10000000000.0"),
    "seconds in words": (having(cost=Cost(wall="1 s")), "run.cost.wall is '1 s'"),
    "complex seconds": (having(cost=Cost(wall=1j)), "run.cost.wall is 1j"),
    "no seconds": (having(cost=Cost(wall=None)), "run.cost.wall is None"),
    "an array of seconds": (having(cost=Cost(wall=np.ones(2))), "run.cost.wall is array"),
    "half a test of a pair": (having(cost=Cost(pair_tests=0.5)), "run.cost.pair_tests is 0.5: give a whole number"),
    "lists in words": (having(cost=Cost(list_builds="3")), "run.cost.list_builds is '3'"),
    "steps that are not counted": (having(cost=Cost(steps=None)), "run.cost.steps is None"),
    "half a step": (having(cost=Cost(steps=0.5)), "run.cost.steps is 0.5: give a whole number"),
    "fewer than no steps": (having(cost=Cost(steps=-1)), "run.cost.steps is -1"),
    "a step that is a flag": (having(cost=Cost(steps=True)), "run.cost.steps is True"),
    "more events than can be": (having(cost=Cost(events=2**63)), "run.cost.events is 9223372036854775808"),
    "5000 digits of evaluations": (having(cost=Cost(evaluations=10**5000)), "run.cost.evaluations is"),
    # remarks
    "remarks in one text": (having(remarks="all well"), "run.remarks is 'all well': give a list"),
    "no remarks": (having(remarks=None), "run.remarks is None"),
    "a remark that is a number": (having(remarks=[5]), "run.remarks holds 5"),
    "a blank remark": (having(remarks=[""]), "run.remarks holds ''"),
    "too many remarks": (having(remarks=["again"] * 1000), "run.remarks is ['again',"),
}


@pytest.mark.parametrize("kind", WRONG_RUNS)
def test_a_wrong_run_is_an_error_of_the_engine(start: Start, kind: str) -> None:
    change, message = WRONG_RUNS[kind]
    with pytest.raises(EngineError, match=r"^hostile: ") as error:
        start(run=returning(change)).run(SCENE, STEP)
    assert message in str(error.value)
    assert len(str(error.value)) < 500


def read_only(array: Any) -> Any:
    array.flags.writeable = False
    return array


#: What is accepted: nothing is lost when it becomes float64.
ODD_RUNS: dict[str, Callable[[Run], Any]] = {
    "float32": having(kinetic_energy=np.ones(5, np.float32)),
    "float16": having(kinetic_energy=np.ones(5, np.float16)),
    "integers": having(kinetic_energy=np.ones(5, np.int64), positions=np.ones((5, 2, 1), np.uint8)),
    "big-endian": having(kinetic_energy=np.ones(5, ">f8"), time=TIME.astype(">f8")),
    "long doubles that are float64": having(kinetic_energy=np.ones(5, np.longdouble)),
    "lists": having(kinetic_energy=[1.0] * 5, positions=[[[1.0], [1]]] * 5, time=TIME.tolist()),
    "tuples of numpy's scalars": having(kinetic_energy=(np.float64(1.0), np.int32(1), 1, 1.0, np.float32(1))),
    "not contiguous": having(kinetic_energy=np.ones(10)[::2], positions=np.ones((1, 2, 5)).T),
    "read-only": having(kinetic_energy=read_only(np.ones(5))),
    "broadcast": having(positions=np.broadcast_to(1.0, (5, 2, 1))),
    "an alias": lambda run: having(velocities=run["positions"], final_positions=run["positions"][0])(run),
    "more than asked": having(potential_energy=np.full(7, np.nan)),
    "times added up": having(time=np.cumsum([0.0, 0.1, 0.1, 0.1, 0.1])),
    "numpy's flags": having(diverged=np.bool_(False), stopped=np.str_("")),
    "numpy's costs": having(
        cost=Cost(wall=np.float32(0.5), cpu=np.int64(1), steps=np.int32(4), evaluations=4.0, events=np.uint64(4))
    ),
    "remarks in a list": having(remarks=["The order of simultaneous events decides."]),
}


@pytest.mark.parametrize("kind", ODD_RUNS)
def test_what_becomes_float64_without_loss_is_accepted(start: Start, kind: str) -> None:
    run = start(run=returning(ODD_RUNS[kind])).run(SCENE, STEP)
    assert set(run) == set(SCENE.asked())
    assert {array.dtype for array in run.values()} == {np.dtype(np.float64)}
    np.testing.assert_array_equal(run["positions"], np.ones((5, 2, 1)))
    np.testing.assert_array_equal(run["momentum"], np.full((5, 1), 2.0))
    assert {type(value) for value in run.cost.known().values()} == {int, float}
    assert not run.diverged


def test_a_memory_map_is_an_array(start: Start, tmp_path: Any) -> None:
    mapped = np.memmap(tmp_path / "map", dtype=np.float64, mode="w+", shape=(5,))
    mapped[:] = 1.0
    run = start(run=returning(having(kinetic_energy=mapped))).run(SCENE, STEP)
    np.testing.assert_array_equal(run["kinetic_energy"], np.ones(5))


def test_a_run_that_diverged_is_not_a_number_from_there_on(start: Start) -> None:
    """Also where the engine says less than it knows: the energy is finite, and so is the state at the end."""
    change = having(diverged=np.bool_(True))
    run = start(run=returning(lambda run: replaced("positions", (3, 1), np.inf)(change(run)))).run(SCENE, STEP)
    assert run.diverged
    for name in ("positions", "velocities", "kinetic_energy", "momentum"):
        assert np.isfinite(run[name][:3]).all()
        assert np.isnan(run[name][3:]).all()
    assert np.isnan(run["final_positions"]).all()
    np.testing.assert_allclose(run["time"], TIME)


def test_a_run_that_stopped_has_a_state_at_its_end(start: Start) -> None:
    def change(run: Run) -> Run:
        for name in ("positions", "velocities", "kinetic_energy"):
            run[name][2:] = np.nan
        return having(stopped="collapse at t = 0.15")(run)

    run = start(run=returning(change)).run(SCENE, STEP)
    assert run.stopped == "collapse at t = 0.15"
    assert np.isnan(run["momentum"][2:]).all()
    assert np.isfinite(run["final_positions"]).all()


def test_an_engine_that_changes_the_scene_changes_its_own_copy(start: Start) -> None:
    """In its worker the run seems right; the suite knows what it asked for."""

    def run(self: Any, scene: Scene, method: Method) -> Run:
        scene.__dict__["duration"] = 0.8
        return good(scene, method)

    with pytest.raises(EngineError, match=r"^hostile: .*run\['time'\] has 9 samples, the scene asks for 5"):
        start(run=run).run(SCENE, STEP)


def test_an_engine_that_cannot_be_made(start: Start) -> None:
    with pytest.raises(EngineError, match=r"^hostile: TypeError: .*missing 1 required positional argument"):
        start(__init__=lambda self, argument: None).version()


COUNTED = Scene(
    name="disks",
    dimension=2,
    duration=1.0,
    hard_spheres=HardSpheres(),
    initial=Explicit(positions=((1.0, 1.0), (3.0, 3.0))),
    output=Output(collisions=(1, 2), observables=("collisions",)),
)


@pytest.mark.parametrize(
    ("times", "stopped", "message"),
    [
        ([0.0, 0.2, 0.7], "", None),
        ([0.0, 0.2, 0.2], "", None),
        ([0.0, 0.2, np.nan], "collapse", None),
        ([0.0, np.nan, np.nan], "collapse", None),
        ([0.0, 0.2, np.nan], "", r"run\['time'\]\[2\] is nan"),
        ([0.0, np.nan, 0.7], "collapse", r"run\['time'\]\[1\] is nan"),
        ([0.0, 0.7, 0.2], "", r"run\['time'\] goes backwards after sample 1"),
        ([0.0, 0.2, 1.5], "", r"run\['time'\]\[2\] is 1.5, after the end at 1"),
        ([0.1, 0.2, 0.7], "", r"run\['time'\]\[0\] is 0.1\d*, the scene asks for 0"),
        ([0.0, 0.2, 0.7], "collapse", "no sample up to the end is NaN"),
    ],
)
def test_times_of_collisions_are_a_result(start: Start, times: list[float], stopped: str, message: str | None) -> None:
    def run(self: Any, scene: Scene, method: Method) -> Run:
        return having(time=np.array(times), stopped=stopped)(good(scene, method))

    worker, method = start(run=run), Method(scheme="events")
    if message is None:
        np.testing.assert_array_equal(worker.run(COUNTED, method)["time"], times)
    else:
        with pytest.raises(EngineError, match=message):
            worker.run(COUNTED, method)


@given(value=st.recursive(st.none() | st.booleans() | st.text() | st.binary() | st.complex_numbers(), st.lists))
def test_no_value_escapes(value: Any) -> None:
    """Whatever stands for an array: the numbers that are asked for, or a misfit in a short line."""
    run = good(SCENE, STEP)
    run["kinetic_energy"] = value
    given, rest = border.outcome(run)
    with pytest.raises(border.Misfit, match=r"^run") as error:
        border.arrays(given, SCENE, STEP, diverged=rest["diverged"], stopped=rest["stopped"])
    assert len(str(error.value)) < 600


def test_operations_that_are_counted_arrive_and_the_others_stay_unknown(start: Start) -> None:
    cost = Cost(pair_tests=np.int64(12), predictions=0, site_updates=None)
    found = start(run=returning(having(cost=cost))).run(SCENE, STEP).cost
    assert (found.pair_tests, found.predictions, found.site_updates, found.list_builds) == (12, 0, None, None)
    assert type(found.pair_tests) is int
