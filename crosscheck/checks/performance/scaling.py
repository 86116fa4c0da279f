"""How work, memory and time grow with the number of particles: counted exactly, and measured beside the memory itself.

An event costs what the nearest event costs to find (log N comparisons of a tree) and a number of predictions that does
not depend on N; a time step costs N, or N^2 where all pairs attract each other. Counts are exact, so no clock enters.
Time is judged too, since needless work need not be counted by anybody: but a particle that is no longer in a cache
costs more, whatever the algorithm. How much more is measured beside it, by a pointer chase through as many bytes, and
is a term of its own beside each law.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.events.cost import LINEAR_SCAN
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.granular.operations import ALL_PAIRS
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.checks.operations import counted, counting, exactly
from crosscheck.checks.performance.memory import chase
from crosscheck.checks.performance.stepping_races import cloud
from crosscheck.checks.stepping.fluids import PERIODIC, STEP, fluid
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.scene import Contact, Floats, Method, Output, Scene
from crosscheck.scene.observables import OPERATIONS
from crosscheck.statistics import model_comparison, standard_error
from crosscheck.verdict import Judged, Judgement, bounded, worst

#: Least difference of BIC between two laws.
_MARGIN = 10.0
_WHY_MARGIN = (
    "BIC of the next best of the laws minus that of this one; above 10: very strong (Kass & Raftery, J. Am. Stat. "
    "Assoc. 90, 773 (1995))"
)
_BATCHES = 20
#: Of the gases, spheres per diameter^3.
_DENSITY = 0.5
#: The schedulers of events that count in the quick tier, and those of the full one.
_EVENTS = {"tree": "event_driven", "lists": "event_driven_lists", "calendar": "event_driven_calendar"}
_WORDS = "dimension=3 box.boundaries=periodic output.collisions"


class _Queue(NamedTuple):
    """A scheduler; scheme: its name. sizes: numbers of particles. law: of its comparisons, "log N" or "constant"."""

    scheme: str
    sizes: tuple[int, ...]
    law: str


# -- events, counted ---------------------------------------------------------------------------------------------------


def _judge_counts(laboratory: Laboratory, queue: _Queue) -> Judged:
    """Comparisons, predictions and moves per event, and bytes a particle, against N."""
    mean, error, held = [], [], []
    for number in queue.sizes:
        operations, bytes_ = _counted_events(laboratory, number, queue.scheme)
        mean.append(operations.mean(axis=0))
        error.append(standard_error(operations))
        held.append(bytes_)
    values, errors = np.array(mean), np.array(error)
    judged = [
        _comparisons(queue, values[:, 0], errors[:, 0]),
        *(
            _no_growth(f"{name.replace('_', ' ')} per event", queue.sizes, values[:, column], errors[:, column])
            for column, name in enumerate(OPERATIONS)
            if name in ("list_moves", "predictions", "cell_crossings", "invalid_events")
        ),
        bounded(
            "bytes a particle at the largest N, over those at the smallest",
            held[-1] / held[0],
            1.1,
            "a particle holds the same whatever N; arrays with room to spare round up to a tenth more",
            note=f"{held[0]:.0f} bytes at N = {queue.sizes[0]}, {held[-1]:.0f} at {queue.sizes[-1]}",
        ),
    ]
    return worst(judged, f"N = {queue.sizes[0]} to {queue.sizes[-1]}", (_figure(queue, values, errors),))


def _counted_events(laboratory: Laboratory, number: int, scheme: str) -> tuple[Floats, float]:
    """Operations per event of batches after the start, (batches, operations), and bytes a particle at the end."""
    size = max(number // 4, 500)
    counts = tuple(4 * number + size * k for k in range(_BATCHES + 1))
    output = Output(collisions=counts, observables=("operation_counts", "events"))
    scene = spheres(number, _DENSITY, laboratory.seed() % 2**31, duration=1e6, output=output)
    worker = laboratory.pool.worker(laboratory.engine)
    with tempfile.TemporaryDirectory(prefix="crosscheck-scaling-") as directory:
        state = Path(directory) / "state.npz"
        run = worker.run(scene, Method(scheme=scheme), keep=state)
        with np.load(state) as arrays:
            held = sum(arrays[name].nbytes for name in arrays.files)
    laboratory.cost.add(run.cost)
    per_event = np.diff(run["operation_counts"][1:], axis=0) / np.diff(run["events"][1:])[:, None]
    return per_event, held / number


def _comparisons(queue: _Queue, costs: Floats, errors: Floats) -> Judgement:
    """That the comparisons grow as the queue promises."""
    if queue.law == "constant":
        return _no_growth("comparisons per event", queue.sizes, costs, errors)
    fits = model_comparison(queue.sizes, costs, errors)
    best = min((name for name in fits if name != queue.law), key=lambda name: fits[name].bic)
    a, b = fits[queue.law].coefficients
    return bounded(
        f"how much better {queue.law} explains the comparisons than {best}",
        float(fits[best].bic - fits[queue.law].bic),
        _MARGIN,
        _WHY_MARGIN,
        at_least=True,
        note=f"comparisons = {a:.3f} + {b:.4f} ln N, {b * np.log(2):.3f} a doubling",
    )


def _no_growth(quantity: str, sizes: tuple[int, ...], values: Floats, errors: Floats) -> Judgement:
    """That a number per event is as large at all N as at the smallest, but for how well cells fit into its box."""
    if not values.any():
        return exactly(quantity, 0, 0)
    across = int((sizes[0] / _DENSITY) ** (1 / 3))  # diameters, and cells
    return bounded(
        f"{quantity}, the largest over that at the smallest N",
        float(values.max() / values[0]),
        float((1 + 1 / across) ** 3 * (1 + 3 * errors[0] / values[0])),
        f"cells are 1 to 1 + 1/{across} diameters wide at the smallest N, and hold as many more; three standard errors",
        note=f"{values[0]:.4g} at N = {sizes[0]}, {values[-1]:.4g} at {sizes[-1]}",
    )


def _figure(queue: _Queue, values: Floats, errors: Floats) -> Figure:
    n = list(map(float, queue.sizes))
    return Figure(
        "Operations per event against the number of particles",
        "N",
        "operations per event",
        x_scale="log",
        series=tuple(
            Series(name.replace("_", " "), n, values[:, column].tolist(), errors[:, column].tolist())
            for column, name in enumerate(OPERATIONS)
            if values[:, column].any()
        ),
    )


# -- events, timed -----------------------------------------------------------------------------------------------------

#: Numbers of particles, and turns of each, of which the least counts.
_TIMED, _TURNS = (*(2**k for k in range(8, 18)), 2**20), 3
#: Scatter of times, as a share: what other processes take away. Sizes below which no law is compared.
_SCATTER, _FEWEST = 0.05, 7


def _judge_time(laboratory: Laboratory, scheme: str) -> Judged:
    """CPU time per event, explained by a law of N and by what a step through as much memory costs."""
    t, memory = _times(laboratory, scheme)
    n = np.array(_TIMED[: t.size], dtype=float)
    slow, growing, evidence, coefficients = _evidence(n, t, memory)
    explained = coefficients[0] + coefficients[-1] * memory + (coefficients[1] * np.log(n) if slow == "log N" else 0.0)
    figure = Figure(
        "CPU time per event",
        "N",
        "microseconds",
        x_scale="log",
        series=(
            Series("measured", n.tolist(), (1e6 * t).tolist(), (1e6 * _SCATTER * t).tolist()),
            Series(f"{slow} and memory", n.tolist(), (1e6 * explained).tolist(), theory=True),
            Series("ten steps through memory", n.tolist(), (1e7 * memory).tolist()),
        ),
    )
    judged = [
        bounded(
            f"how much better {growing} and memory explain the time than {slow} and memory",
            evidence,
            _MARGIN,
            "difference of BIC; only above 10 is there very strong evidence of growth (Kass & Raftery, J. Am. Stat. "
            "Assoc. 90, 773 (1995)); both laws have a term for memory",
            note=f"{coefficients[-1]:.1f} steps through memory an event",
        ),
        bounded(
            "time per event at the largest N over that at the smallest",
            float(t[-1] / t[0]),
            float(np.log(n[-1]) / np.log(n[0]) * memory[-1] / memory[0]),
            "log N, times what a step through as much memory costs, there over here",
            note=f"{1e6 * t[0]:.3g} microseconds at N = {n[0]:.0f}, {1e6 * t[-1]:.3g} at {n[-1]:.0f}",
        ),
    ]
    return worst(judged, f"{scheme}: N = {n[0]:.0f} to {n[-1]:.0f}", (figure,))


def _times(laboratory: Laboratory, scheme: str) -> tuple[Floats, Floats]:
    """Seconds per event, and of a step through as much memory, at the sizes `_TIMED`.

    Growth that is clear thrice over is not followed to larger systems: an event that looks at all particles would take
    hours there.
    """
    times: list[float] = []
    memory = np.zeros(0)
    for number in _TIMED:
        seconds, held = _timed_events(laboratory, number, scheme)
        if not times:
            memory = np.array(chase([held * size / number for size in _TIMED]))
        times.append(seconds)
        so_far = np.array(times), memory[: len(times)]
        if len(times) >= _FEWEST and _evidence(np.array(_TIMED[: len(times)]), *so_far)[2] > 3 * _MARGIN:
            break
    return so_far


def _evidence(n: Floats, t: Floats, memory: Floats) -> tuple[str, str, float, tuple[float, ...]]:
    """The better law without growth, the better one with it, by how much BIC prefers this, coefficients of the former.

    n: numbers of particles. t: seconds per event. memory: seconds of a step through as much memory.
    """
    fits = model_comparison(n, t, _SCATTER * t, beside=memory)
    slow = min(("constant", "log N"), key=lambda name: fits[name].bic)
    growing = min(("sqrt N", "N"), key=lambda name: fits[name].bic)
    return slow, growing, float(fits[slow].bic - fits[growing].bic), fits[slow].coefficients


def _timed_events(laboratory: Laboratory, number: int, scheme: str) -> tuple[float, float]:
    """Least CPU time per event of some turns in equilibrium, and the bytes of the state."""
    before = Output(collisions=(5 * number,), observables=("collisions",))
    scene = spheres(number, _DENSITY, laboratory.seed() % 2**31, duration=1e6, output=before)
    worker, method = laboratory.pool.worker(laboratory.engine), Method(scheme=scheme)
    with tempfile.TemporaryDirectory(prefix="crosscheck-scaling-") as directory:
        state = Path(directory) / "state.npz"
        worker.run(scene, method, keep=state)
        with np.load(state) as arrays:
            held = float(sum(arrays[name].nbytes for name in arrays.files))
        turn = scene.changed(output=Output(collisions=(100_000,), observables=("collisions",)))
        costs = [worker.run(turn, method, restart=state).cost for _ in range(_TURNS)]
    for cost in costs:
        laboratory.cost.add(cost)
    return min(cost.cpu / cost.events for cost in costs), held


# -- time steps --------------------------------------------------------------------------------------------------------


class _Steps(NamedTuple):
    """Time steps of one kind of scene.

    scene: of N particles, a seed and a number of steps. sizes: N. method: how. counts: names in `Cost` that grow as the
    time does. law: "N" or "N^2". work: of a turn, particle steps or pairs.
    """

    scene: Callable[[int, int, int], Scene]
    sizes: tuple[int, ...]
    method: Method
    counts: tuple[str, ...]
    law: str
    work: float


_SOFT = Method(scheme="velocity_verlet", dt=2e-4, contact=Contact(duration=0.01))
_CLOUD = Method(scheme="leapfrog", dt=1e-6)


def _lattice(size: int, seed: int, steps: int) -> Scene:
    """size: number of sites; the side of the square is its root."""
    side = round(size**0.5)
    return gas_scene("fhp", "fhp1", side, side, steps, filled(0.3, seed), Output())


_STEPS = {
    "lennard-jones": _Steps(
        lambda number, seed, steps: fluid(number, 0.8442, 1.44, seed, duration=steps * STEP.step),
        tuple(4 * cells**3 for cells in (5, 7, 10, 14, 20)),
        STEP,
        ("pair_tests", "list_tests"),
        "N",
        2e6,
    ),
    "grains": _Steps(
        lambda number, seed, steps: spheres(number, 1.3, seed % 2**31, duration=steps * _SOFT.step),
        tuple(4 * cells**3 for cells in (5, 7, 10, 14, 20)),
        _SOFT,
        ("pair_tests", "list_tests"),
        "N",
        4e6,
    ),
    "fhp": _Steps(
        _lattice,
        tuple((256 * 2**k) ** 2 for k in range(5)),
        Method(scheme="lattice_planes"),
        ("site_updates",),
        "N",
        1e9,
    ),
    "gravity": _Steps(
        lambda number, seed, steps: cloud(number, seed).changed(duration=steps * _CLOUD.step),
        (256, 512, 1024, 2048, 4096),
        _CLOUD,
        (),
        "N^2",
        1e8,
    ),
}


def _exponent(law: str) -> int:
    return 2 if law == "N^2" else 1


def _judge_step_counts(laboratory: Laboratory, steps: _Steps) -> Judged:
    """The power of N in each count of operations."""
    seed, taken = laboratory.seed() % 2**31, 20
    costs = [laboratory.run(steps.scene(number, seed, taken), steps.method).cost for number in steps.sizes]
    judged = []
    for name in steps.counts:
        found = np.array([counted(cost, name) for cost in costs])
        slope = float(np.polyfit(np.log(steps.sizes), np.log(found), 1)[0])
        judged.append(
            bounded(
                f"power of N in {name.replace('_', ' ')}, beyond {_exponent(steps.law)}",
                abs(slope - _exponent(steps.law)),
                0.1,
                "whole tiles and cells are looked at: of the smallest system a fifth too many; all pairs would add 1",
                note=", ".join(
                    f"{value / number:.4g} a particle" for number, value in zip(steps.sizes, found, strict=True)
                ),
            )
        )
    return worst(judged, f"N = {steps.sizes[0]} to {steps.sizes[-1]}")


def _judge_step_time(laboratory: Laboratory, steps: _Steps) -> Judged:
    """CPU time of a step against N."""
    seed = laboratory.seed() % 2**31
    times = []
    for number in steps.sizes:
        taken = max(4, int(steps.work / number ** _exponent(steps.law)))
        scene = steps.scene(number, seed, taken)
        costs = [laboratory.run(scene, steps.method).cost for _ in range(_TURNS)]
        times.append(min(cost.cpu / cost.steps for cost in costs))
    t, n = np.array(times), np.array(steps.sizes, dtype=float)
    # a law of growth is judged on a logarithmic scale: each size counts alike
    fits = model_comparison(n, t, 0.05 * t, laws=("constant", "log N", "sqrt N", "N", "N^2"))
    best = min((name for name in fits if name != steps.law), key=lambda name: fits[name].bic)
    slope, covariance = np.polyfit(np.log(n), np.log(t), 1, cov=True)
    judged = bounded(
        f"how much better {steps.law} explains the time of a step than {best}",
        float(fits[best].bic - fits[steps.law].bic),
        0.0,
        "the smaller BIC is that of the better law",
        at_least=True,
        note=f"exponent {slope[0]:.3f} +- {2 * float(np.sqrt(covariance[0, 0])):.3f} (two standard errors)",
        figures=(
            Figure(
                "CPU time of a step",
                "N",
                "seconds",
                x_scale="log",
                y_scale="log",
                series=(Series("measured", n.tolist(), t.tolist(), (0.05 * t).tolist()),),
            ),
        ),
    )
    return worst([judged], f"N = {steps.sizes[0]} to {steps.sizes[-1]}")


# -- checks ------------------------------------------------------------------------------------------------------------

_QUICK = tuple(2**k for k in range(8, 14))
_LARGE = (*(2**k for k in range(7, 18)), 10**6)
_LAWS = {"tree": "log N", "lists": "log N", "calendar": "constant"}
_NEEDS = {
    "lennard-jones": Needs("lennard_jones", words=PERIODIC, schemes=(STEP.scheme,)),
    "grains": Needs(
        "hard_spheres", words=frozenset({"dimension=3", "method.contact.duration"}), schemes=(_SOFT.scheme,)
    ),
    "fhp": Needs("lattice_gas", (LATTICE,), schemes=("lattice_planes",)),
    "gravity": Needs(
        "gravity", words=frozenset({"dimension=3", "gravity.softening"}), schemes=(_CLOUD.scheme,), promises=("speed",)
    ),
}
_OF_EVENTS = replace(
    event_driven(_WORDS, "operation_counts events", tuple(_EVENTS.values())), promises=("operations", "restarts")
)
_CITATION = "Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993); Paul, J. Comput. Phys. 221, 615 (2007)"

#: Work that no counter counts.
_LOOK_AT_ALL = Fault(
    "look-at-all",
    "events/kernels/loop.py",
    "        pair_time, own_time = rows[i, NEXT], own[i]\n",
    "        pair_time, own_time = rows[i, NEXT], own[i]\n"
    "        for k in range(own.size):\n            if own[k] < -1.0:\n                progress[FIRST] = k\n",
    "at each event the times of all particles are looked at, for nothing",
)

CHECKS = (
    Check(
        name="performance/scaling-events",
        title="Operations of an event, and bytes of a particle, against the number of particles",
        equation="comparisons = a + b ln N (calendar: a); predictions, moves, crossings, bytes a particle = const",
        criterion=f"log N explains the comparisons best, BIC by {_MARGIN:g}; nothing else grows",
        citation=_CITATION,
        judge=_judge_counts,
        variants=(
            *(
                Variant(name, _Queue(scheme, _QUICK, _LAWS[name]), "quick" if name == "tree" else "full")
                for name, scheme in _EVENTS.items()
            ),
            *(Variant(f"{name}-1e6", _Queue(scheme, _LARGE, _LAWS[name]), "full") for name, scheme in _EVENTS.items()),
        ),
        faults=(("tree", LINEAR_SCAN),),
        needs=_OF_EVENTS,
    ),
    Check(
        name="performance/scaling-event-time",
        title="CPU time of an event against the number of particles, beside what memory costs",
        equation="t = a + b ln N + c t_chase(bytes(N))",
        criterion="constant or log N explains it as well as sqrt N and N; it grows by log N times memory at most",
        citation=_CITATION,
        judge=_judge_time,
        variants=(Variant("tree", _EVENTS["tree"], "full"), Variant("calendar", _EVENTS["calendar"], "full")),
        faults=(("tree", _LOOK_AT_ALL),),
        needs=_OF_EVENTS,
        timing=True,
    ),
    Check(
        name="performance/scaling-steps",
        title="Operations of a time step against the number of particles or sites",
        equation="operations = a N",
        criterion="the power of N within 0.1",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 5.3",
        judge=_judge_step_counts,
        variants=tuple(
            Variant(name, steps, "quick" if name == "lennard-jones" else "full", needs=counting(_NEEDS[name]))
            for name, steps in _STEPS.items()
            if steps.counts
        ),
        faults=(
            (
                "grains",
                ALL_PAIRS,
            ),
        ),
        needs=tuple(counting(_NEEDS[name]) for name, steps in _STEPS.items() if steps.counts),
    ),
    Check(
        name="performance/scaling-step-time",
        title="CPU time of a time step against the number of particles or sites",
        equation="t = a + b N, of gravity between all pairs a + b N^2",
        criterion="this law explains it better than the others",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 5.3",
        judge=_judge_step_time,
        variants=tuple(Variant(name, steps, "full", needs=_NEEDS[name]) for name, steps in _STEPS.items()),
        faults=(("grains", ALL_PAIRS),),
        needs=tuple(_NEEDS.values()),
        timing=True,
    ),
)
