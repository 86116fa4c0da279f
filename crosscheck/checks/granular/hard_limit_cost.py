"""What the hard-sphere limit costs: error against CPU time, and the density up to which event-driven is the cheaper."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, soft, variants_of
from crosscheck.checks.granular.cooling import DISKS, cooling_gas
from crosscheck.checks.granular.gases import RESOLUTION, energies, relaxed
from crosscheck.checks.granular.soft_grains import REFERENCE, soft_needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Ladder, Series
from crosscheck.references.soft_impact import HookeImpact
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded

STIFFNESSES = (1e3, 1e4, 1e5, 1e6)
REPLICAS = 16
#: An error of T that the two methods are compared at.
ERROR = 0.01


def _judge_precision(laboratory: Laboratory) -> Judged:
    """|T(k)/T - 1| of a cooling gas against CPU seconds a run; event-driven has no such error."""
    gas = cooling_gas(DISKS)
    methods = [soft(stiffness=stiffness, resolution=RESOLUTION) for stiffness in STIFFNESSES]
    laboratory.demand(gas, methods[0])
    starts = [relaxed(laboratory, gas, f"state {i}", 2.0) for i in range(REPLICAS)]
    # alternated, so that a change of the machine's speed meets all; the first turn warms caches
    turns = [
        [laboratory.run(start, EVENT_DRIVEN, engine=REFERENCE)] + [laboratory.run(start, method) for method in methods]
        for start in (starts[0], *starts)
    ][1:]
    hard, *softs = zip(*turns, strict=True)
    exact = float(np.mean([energies(run)[-1] for run in hard]))
    events = float(np.median([run.cost.cpu for run in hard]))
    seconds, errors, u_errors, steps = [], [], [], []
    for runs in softs:
        mean, error = independent_mean([energies(a)[-1] - energies(b)[-1] for a, b in zip(runs, hard, strict=True)])
        errors.append(abs(mean) / exact)
        u_errors.append(error / exact)
        seconds.append(float(np.median([run.cost.cpu for run in runs])))
        steps.append(runs[0].cost.steps)
    # error x steps is constant in the limit: the weighted mean of the stiffer ones gives the steps for `ERROR`
    d, u, n = np.array(errors[1:]), np.array(u_errors[1:]), np.array(steps[1:])
    product = float(np.average(d * n, weights=1 / (u * n) ** 2))
    per_step = float(np.median(np.array(seconds[1:]) / n))
    ratio = product / ERROR * per_step / events
    figures = [_ladder("soft spheres", "k", STIFFNESSES, softs, errors, u_errors)]
    if laboratory.engine == REFERENCE:
        # event-driven runs have no such error: they are drawn at what the comparison resolves
        resolved = [min(u_errors)]
        figures.append(_ladder("event-driven", "disks", [gas.number], [hard], resolved, resolved))
    rows = zip(STIFFNESSES, errors, u_errors, seconds, strict=True)
    values = ", ".join(f"k {k:.0e}: {error:.5f}({u:.5f}) in {time:.3g} s" for k, error, u, time in rows)
    return bounded(
        f"CPU time of soft disks that err by {ERROR:g}, over that of event-driven ones",
        ratio,
        1.0,
        "event-driven is the cheaper way to a gas of hard disks",
        at_least=True,
        note=f"event-driven {events:.3g} s; {values}; dt/t_c = {RESOLUTION:g}, packing fraction 0.5",
        figures=tuple(figures),
    )


def _ladder(
    family: str,
    control: str,
    controls: Sequence[float],
    rungs: Sequence[Sequence[Run]],
    errors: list[float],
    u_errors: list[float],
) -> Figure:
    """Error against CPU time of the runs of each stiffness, in the figure of all methods."""
    seconds = [sorted(run.cost.cpu for run in runs) for runs in rungs]
    by_events = family == "event-driven"
    ladder = Ladder(
        label=family,
        family=family,
        control=control,
        controls=list(controls),
        error=errors,
        uncertainty=u_errors,
        cpu=[float(np.median(one)) for one in seconds],
        cpu_low=[one[0] for one in seconds],
        cpu_high=[one[-1] for one in seconds],
        count=[float(runs[0].cost.events if by_events else runs[0].cost.steps) for runs in rungs],
        count_label="events" if by_events else "steps",
        failures=[""] * len(errors),
    )
    title = "the hard limit of a cooling gas of 1000 disks, packing fraction 0.5"
    return Figure(title, "CPU time of a run/s", "|T(k)/T - 1|", "log", "log", ladder=ladder)


PACKINGS = (0.1, 0.3, 0.5, 0.7, 0.8, 0.85, 0.88, 0.895)
_COLUMNS, _ROWS = 30, 34
#: Collisions a disk and steps that are timed, and how often, alternated.
_COLLISIONS, _STEPS, _TURNS = 30, 1500, 5


def _dense_gas(fraction: float) -> Scene:
    """1020 elastic disks on a triangular lattice that the box holds exactly, T = 1."""
    apart = math.sqrt(math.pi / (2 * math.sqrt(3) * fraction))
    return Scene(
        name="dense",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(_COLUMNS * apart, _ROWS * math.sqrt(3) / 2 * apart)),
        initial=Lattice(kind="lattice", structure="triangular", number=_COLUMNS * _ROWS, temperature=1.0, seed=0),
        output=Output(),
    )


def _judge_density(laboratory: Laboratory) -> Judged:
    """CPU seconds per grain and unit of time over the packing fraction, and omega t_c where soft gets cheaper."""
    stiffnesses = STIFFNESSES[:-1]
    methods = [soft(stiffness=stiffness, resolution=2 * RESOLUTION) for stiffness in stiffnesses]
    durations = [HookeImpact(0.5, stiffness, 1.0).contact_time for stiffness in stiffnesses]
    costs, rates = [], []
    laboratory.demand(_dense_gas(PACKINGS[0]), methods[0])
    for fraction in PACKINGS:
        start = relaxed(laboratory, _dense_gas(fraction), f"state {fraction}", 2.0 if fraction < 0.65 else 0.5)
        number = start.number
        counted = start.changed(duration=1e3, output=Output(collisions=(_COLLISIONS * number,)))
        scenes = [start.changed(duration=_STEPS * 2 * RESOLUTION * t_c) for t_c in durations]
        spent: list[list[float]] = []
        for _ in range(_TURNS):
            run = laboratory.run(counted, EVENT_DRIVEN, engine=REFERENCE)
            softs = [laboratory.run(one, method) for one, method in zip(scenes, methods, strict=True)]
            times = [float(run["time"][-1]), *(scene.duration for scene in scenes)]
            spent.append([one.cost.cpu / number / t for one, t in zip((run, *softs), times, strict=True)])
        costs.append(np.median(spent, axis=0))
        rates.append(2 * _COLLISIONS / times[0])
    hard, *softer = np.array(costs).T
    curves = [Series(f"event-driven, beside {laboratory.engine}", list(PACKINGS), hard.tolist())]
    curves += [
        Series(f"soft, {laboratory.engine}, k = {k:.0e}", list(PACKINGS), found.tolist())
        for k, found in zip(stiffnesses, softer, strict=True)
    ]
    figure = Figure(
        "Cost over density: CPU seconds per grain and unit of time",
        "packing fraction",
        "CPU s/(N t)",
        y_scale="log",
        series=tuple(curves),
    )
    crossings, note = [], []
    for stiffness, duration, found in zip(stiffnesses, durations, softer, strict=True):
        crossing = _crossing(np.array(PACKINGS), np.log(found / hard), np.array(rates) * duration)
        if crossing is None:
            until, contacts = f"{PACKINGS[-1]:g} at least", rates[-1] * duration
        else:
            until, contacts = f"{crossing[0]:.3f}", crossing[1]
            crossings.append(contacts)
        note.append(f"k {stiffness:.0e}: event-driven cheaper up to {until}, where omega t_c = {contacts:.2g}")
    return bounded(
        "smallest omega t_c at which soft disks are the cheaper ones",
        min(crossings, default=math.inf),
        1.0,
        "omega t_c is the mean number of others that a disk touches: beyond 1 it is no gas of hard disks any more",
        at_least=True,
        note="; ".join(note),
        figures=(figure,),
    )


def _crossing(fractions: Floats, log_ratio: Floats, contacts: Floats) -> tuple[float, float] | None:
    """Packing fraction and omega t_c where soft spheres first cost less, interpolated; None if they never do."""
    cheaper = np.flatnonzero(log_ratio < 0)
    if not cheaper.size:
        return None
    i = int(cheaper[0])
    if i == 0:
        return float(fractions[0]), float(contacts[0])
    share = log_ratio[i - 1] / (log_ratio[i - 1] - log_ratio[i])
    log_contacts = np.log(contacts)
    between = log_contacts[i - 1] + share * (log_contacts[i] - log_contacts[i - 1])
    return float(fractions[i - 1] + share * (fractions[i] - fractions[i - 1])), math.exp(float(between))


def _judge(laboratory: Laboratory, judge: Callable[[Laboratory], Judged]) -> Judged:
    return judge(laboratory)


CHECKS = (
    Check(
        name="granular/hard-limit-cost",
        title="Hard disks, event-driven or soft and stiff: error against CPU time, and cost over density",
        equation="error ~ omega t_c, steps ~ 1/t_c; events ~ omega",
        criterion="event-driven is the cheaper at an error of 1 %, and at any density at which omega t_c < 1",
        citation="Mitarai & Nakanishi, PRE 67, 021301 (2003); Bannerman et al., J. Comput. Chem. 32, 3329 (2011)",
        judge=_judge,
        variants=variants_of({"work-precision": _judge_precision, "density": _judge_density}, "full"),
        needs=soft_needs("method.contact.stiffness"),
        faults=(
            (
                "density",
                Fault(
                    "one-cell",
                    "events/simulation.py",
                    "counts.append(max(1, int(length / natural)))",
                    "counts.append(max(1, int(length / natural) // 16))",
                    "cells are sixteen times too wide: a disk looks at hundreds of others for its next collision",
                ),
            ),
        ),
        timing=True,
    ),
)
