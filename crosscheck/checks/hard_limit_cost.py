"""What the hard-sphere limit costs: error against CPU time, and the density up to which event-driven is the cheaper."""

from __future__ import annotations

import math

import numpy as np

from crosscheck.checks.base import Check, Laboratory, fixed
from crosscheck.checks.hard_limit import EVENTS, RESOLUTION, cooling_gas, energies, relaxed, soft
from crosscheck.faults import Fault
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Figure, Judgement, Series, bounded

STIFFNESSES = (1e3, 1e4, 1e5, 1e6)
REPLICAS = 16
#: An error of T that the two methods are compared at.
ERROR = 0.01


def _judge_precision(laboratory: Laboratory, variant: str) -> Judgement:
    """|T(k)/T - 1| of a cooling gas against CPU seconds a run; event-driven has no such error."""
    gas = cooling_gas(2)
    starts = [relaxed(laboratory, gas, f"state {i}", 2.0) for i in range(REPLICAS)]
    for method in (EVENTS, soft(STIFFNESSES[0])):
        laboratory.run(starts[0], method, engine="refimpl" if method is EVENTS else None)  # warms caches
    hard = [laboratory.run(start, EVENTS, engine="refimpl") for start in starts]
    exact = float(np.mean([energies(run)[-1] for run in hard]))
    events = float(np.median([run.cost.cpu for run in hard]))
    seconds, errors, u_errors, steps = [], [], [], []
    for stiffness in STIFFNESSES:
        runs = [laboratory.run(start, soft(stiffness)) for start in starts]
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
    label = laboratory.engine
    figure = Figure(
        "Hard limit: error against CPU time of a cooling gas of 1000 disks",
        "CPU seconds a run",
        "|T(k)/T - 1|",
        "log",
        "log",
        (
            Series(f"soft, {label}, k = {STIFFNESSES[0]:.0e} ... {STIFFNESSES[-1]:.0e}", seconds, errors, u_errors),
            Series(
                f"event-driven, beside {label}: no such error",
                [events, events],
                [min(errors) / 2, max(errors)],
                theory=True,
            ),
        ),
    )
    rows = zip(STIFFNESSES, errors, u_errors, seconds, strict=True)
    values = ", ".join(f"k {k:.0e}: {error:.5f}({u:.5f}) in {time:.3g} s" for k, error, u, time in rows)
    return bounded(
        f"CPU time of soft disks that err by {ERROR:g}, over that of event-driven ones",
        ratio,
        1.0,
        "event-driven is the cheaper way to a gas of hard disks",
        at_least=True,
        note=f"event-driven {events:.3g} s; {values}; dt/t_c = {RESOLUTION:g}, packing fraction 0.5",
        figures=(figure,),
    )


PACKINGS = (0.1, 0.3, 0.5, 0.7, 0.8, 0.85, 0.88, 0.895)
_COLUMNS, _ROWS = 30, 34
#: Collisions a disk and steps that are timed.
_COLLISIONS, _STEPS = 30, 1500


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


def _judge_density(laboratory: Laboratory, variant: str) -> Judgement:
    """CPU seconds per grain and unit of time over the packing fraction, and omega t_c where soft gets cheaper."""
    hard, rates = [], []
    costs: dict[float, list[float]] = {stiffness: [] for stiffness in STIFFNESSES[:-1]}
    for fraction in PACKINGS:
        start = relaxed(laboratory, _dense_gas(fraction), f"state {fraction}", 2.0 if fraction < 0.65 else 0.5)
        number = start.number
        counted = start.changed(duration=1e3, output=Output(collisions=(_COLLISIONS * number,)))
        runs = [laboratory.run(counted, EVENTS, engine="refimpl") for _ in range(3)]
        duration = float(runs[0].time[-1])
        hard.append(float(np.median([run.cost.cpu for run in runs])) / number / duration)
        rates.append(2 * _COLLISIONS / duration)
        for stiffness, found in costs.items():
            duration = _STEPS * RESOLUTION * 2 * math.sqrt(math.pi**2 / 2 / stiffness)
            scene, method = start.changed(duration=duration), soft(stiffness)
            contact = method.contact
            assert contact is not None
            method = method.model_copy(update={"contact": contact.model_copy(update={"resolution": 2 * RESOLUTION})})
            turns = [laboratory.run(scene, method).cost.cpu for _ in range(3)]
            found.append(float(np.median(turns)) / number / duration)
    curves = [Series(f"event-driven, beside {laboratory.engine}", list(PACKINGS), hard)]
    curves += [Series(f"soft, {laboratory.engine}, k = {k:.0e}", list(PACKINGS), found) for k, found in costs.items()]
    figure = Figure(
        "Cost over density: CPU seconds per grain and unit of time",
        "packing fraction",
        "CPU s/(N t)",
        y_scale="log",
        series=tuple(curves),
    )
    crossings, note = [], []
    for stiffness, found in costs.items():
        duration = math.sqrt(math.pi**2 / 2 / stiffness)
        crossing = _crossing(np.array(PACKINGS), np.log(np.array(found) / hard), np.array(rates) * duration)
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


def _judge(laboratory: Laboratory, variant: str) -> Judgement:
    return (_judge_precision if variant == "work-precision" else _judge_density)(laboratory, variant)


CHECKS = (
    Check(
        name="granular/hard-limit-cost",
        title="Hard disks, event-driven or soft and stiff: error against CPU time, and cost over density",
        equation="error ~ omega t_c, steps ~ 1/t_c; events ~ omega",
        criterion="event-driven is the cheaper at an error of 1 %, and at any density at which omega t_c < 1",
        citation="Mitarai & Nakanishi, PRE 67, 021301 (2003); Bannerman et al., J. Comput. Chem. 32, 3329 (2011)",
        judge=_judge,
        variants=fixed("work-precision", "density"),
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
        engines=("refimpl", "lammps"),
        tier="full",
        timing=True,
    ),
)
