"""Cost of an event against the number of particles: the trees, the calendar queue, the naive algorithm."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.scene import Method, Output
from crosscheck.statistics import model_comparison, standard_error
from crosscheck.verdict import Judged, bounded

#: Numbers of particles.
SIZES = tuple(2**k for k in range(8, 18))
_WORDS = "dimension=3 box.boundaries=periodic output.collisions"
_MARGIN = 10.0
_WHY_MARGIN = (
    "BIC of the next best of the laws minus that of this one; above 10: very strong (Kass & Raftery, J. Am. Stat. "
    "Assoc. 90, 773 (1995))"
)


class _Scheduler(NamedTuple):
    """A scheduler; name: in figures; scheme: its name among those of the engine."""

    name: str
    scheme: str


def _judge_tree(laboratory: Laboratory, scheduler: _Scheduler) -> Judged:
    """Exact comparisons per event against N: which law fits them best."""
    costs, errors, other, times = [], [], [], []
    for number in SIZES:
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6)
        batches = 20
        size = max(number // 4, 500)
        counts = tuple(4 * number + size * k for k in range(batches + 1))
        output = Output(collisions=counts, observables=("operation_counts", "events"))
        run = laboratory.run(scene.changed(output=output), Method(scheme=scheduler.scheme))
        operations, events = np.diff(run["operation_counts"][1:], axis=0), np.diff(run["events"][1:])
        per_event = operations / events[:, None]
        costs.append(per_event[:, 0].mean())
        errors.append(float(standard_error(per_event[:, 0])))
        other.append(per_event[:, 1:3].mean(axis=0))
        times.append(run.cost.cpu / run.cost.events)
    fits = model_comparison(SIZES, costs, errors)
    best = min((name for name in fits if name != "log N"), key=lambda name: fits[name].bic)
    margin = fits[best].bic - fits["log N"].bic
    a, b = fits["log N"].coefficients
    local = np.array(other)
    n = np.array(SIZES, dtype=float)
    figures = (
        Figure(
            "Operations per event against the number of particles",
            "N",
            "operations per event",
            x_scale="log",
            series=(
                Series(f"comparisons, {scheduler.name}", list(map(float, SIZES)), [float(c) for c in costs], errors),
                Series(f"{a:.2f} + {b:.3f} ln N", n.tolist(), (a + b * np.log(n)).tolist(), theory=True),
                Series(f"list moves, {scheduler.name}", n.tolist(), local[:, 0].tolist()),
                Series(f"pairs examined / 10, {scheduler.name}", n.tolist(), (local[:, 1] / 10).tolist()),
            ),
        ),
        Figure(
            "CPU time per event",
            "N",
            "microseconds",
            x_scale="log",
            series=(Series(scheduler.name, n.tolist(), [1e6 * t for t in times]),),
        ),
    )
    return bounded(
        f"how much better log N explains the comparisons than {best}",
        float(margin),
        _MARGIN,
        _WHY_MARGIN,
        at_least=True,
        note=f"comparisons = {a:.3f} + {b:.4f} ln N, {b * np.log(2):.3f} a doubling",
        figures=figures,
    )


def _judge_calendar(laboratory: Laboratory, scheme: str) -> Judged:
    """Exact comparisons per event of the calendar queue, the start included: they must not grow."""
    sizes, batches = SIZES[:7], 20
    costs, errors = [], []
    for number in sizes:
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6)
        counts = tuple(10 * number // batches * k for k in range(1, batches + 1))
        output = Output(collisions=counts, observables=("operation_counts", "events"))
        run = laboratory.run(scene.changed(output=output), Method(scheme=scheme))
        comparisons, events = run["operation_counts"][:, 0], run["events"]
        costs.append(float(comparisons[-1] / events[-1]))
        later = np.diff(comparisons[1:]) / np.diff(events[1:])  # in equilibrium: the scatter of the start is not known
        errors.append(float(standard_error(later)))
    n = np.array(sizes, dtype=float)
    slope, covariance = np.polyfit(np.log2(n), costs, 1, w=1 / np.array(errors), cov="unscaled")
    return bounded(
        "growth of the comparisons per event at each doubling of N",
        float(slope[0]),
        3 * float(np.sqrt(covariance[0, 0])),
        "three standard errors of the slope, one-sided: false alarm 0.1 %; a tree adds one comparison",
        note=f"{costs[0]:.3f} comparisons per event at N = {sizes[0]}, {costs[-1]:.3f} at {sizes[-1]}",
        figures=(
            Figure(
                "Comparisons per event of the calendar queue",
                "N",
                "comparisons per event",
                x_scale="log",
                series=(Series("calendar", n.tolist(), costs, errors),),
            ),
        ),
    )


def _judge_naive(laboratory: Laboratory, scheme: str) -> Judged:
    """CPU time per event of the naive algorithm against N."""
    sizes = (128, 256, 512, 1024, 2048)
    times, errors = [], []
    for number in sizes:
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6)
        taken = []
        for _ in range(5):
            output = Output(collisions=(200_000 // number,), observables=("collisions",))
            run = laboratory.run(scene.changed(output=output), Method(scheme=scheme))
            taken.append(run.cost.cpu / run.cost.events)
        times.append(float(np.median(taken)))
        errors.append(float(standard_error(taken)) + 0.01 * times[-1])
    fits = model_comparison(sizes, times, errors, laws=("constant", "log N", "N", "N^2"))
    best = min((name for name in fits if name != "N^2"), key=lambda name: fits[name].bic)
    slope, covariance = np.polyfit(np.log(sizes[1:]), np.log(times[1:]), 1, cov="unscaled")
    spread = 1.96 * float(np.sqrt(covariance[0, 0])) * float(np.max(np.array(errors) / np.array(times)))
    return bounded(
        f"how much better N^2 explains the time per event than {best}",
        float(fits[best].bic - fits["N^2"].bic),
        _MARGIN,
        _WHY_MARGIN,
        at_least=True,
        note=f"exponent {slope[0]:.3f} +- {spread:.3f} (95 %) between N = {sizes[1]} and {sizes[-1]}",
        figures=(
            Figure(
                "CPU time per event, naive",
                "N",
                "microseconds",
                x_scale="log",
                y_scale="log",
                series=(Series("naive", list(map(float, sizes)), [1e6 * t for t in times], [1e6 * e for e in errors]),),
            ),
        ),
    )


_LINEAR = """    number = queue.keys.size // 2
    found = 0
    for k in range(1, number):
        tick(counts, COMPARISONS, 1)
        if queue.keys[number + k] < queue.keys[number + found]:
            found = k
    return np.int64(found)"""

LINEAR_SCAN = Fault(
    "linear-scan",
    "events/kernels/schedule.py",
    "    return np.int64(queue.nodes[1])",
    _LINEAR,
    "the earliest event is found by a scan of all events, not in the tree",
)

CHECKS = (
    Check(
        name="events/cost",
        title="Operations per event against the number of particles: O(log N)",
        equation="comparisons per event = a + b ln N",
        criterion=f"log N explains the exact counts better than constant, sqrt N and N: BIC by {_MARGIN:g} at least",
        citation="Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993); Marin & Cordero, CPC 92, 214 (1995)",
        judge=_judge_tree,
        variants=full(tree=_Scheduler("tree", "event_driven"), lists=_Scheduler("lists", "event_driven_lists")),
        needs=event_driven(_WORDS, "operation_counts events", ("event_driven", "event_driven_lists")),
        faults=(("tree", LINEAR_SCAN),),
        timing=True,
    ),
    Check(
        name="events/cost-calendar",
        title="Comparisons per event of the calendar queue against the number of particles: O(1)",
        equation="comparisons per event = a",
        criterion="from the start on, no growth with N beyond three standard errors",
        citation="Brown, Commun. ACM 31, 1220 (1988); Paul, J. Comput. Phys. 221, 615 (2007)",
        judge=_judge_calendar,
        variants=full(spheres="event_driven_calendar"),
        needs=event_driven(_WORDS, "operation_counts events", ("event_driven_calendar",)),
        faults=(
            (
                "spheres",
                Fault(
                    "wake-by-queue",
                    "events/kernels/loop.py",
                    "if unpredicted < rows.shape[0]:",
                    "if unpredicted < 0:",
                    "at the start the queue is asked for the earliest of N equal times, which all wait in one bucket",
                ),
            ),
        ),
    ),
    Check(
        name="events/cost-naive",
        title="Time per event of the naive algorithm: O(N^2)",
        equation="t = a + b N^2",
        criterion=f"N^2 explains the CPU time better than constant, log N and N: BIC by {_MARGIN:g} at least",
        citation="Soto, Cordero & Risso, SCAT workshop, Valparaiso (2007)",
        judge=_judge_naive,
        variants=full(**{"v1.0": "event_driven_naive"}),
        needs=event_driven(_WORDS, "collisions", ("event_driven_naive",)),
        faults=(
            (
                "v1.0",
                Fault(
                    "few-partners",
                    "events/naive.py",
                    "for j in range(i + 1, rows.shape[0]):",
                    "for j in range(i + 1, min(i + 9, rows.shape[0])):",
                    "only eight partners are looked at: linear, and wrong",
                ),
            ),
        ),
        timing=True,
    ),
)
