"""What checks of driven and confined systems share: consecutive runs, means over them, energy budgets, figures."""

from __future__ import annotations

import math

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory
from crosscheck.engines.protocol import Kind, Run
from crosscheck.figure import FieldMap, Figure, Frame, RoundFrame, Series, Snapshot
from crosscheck.references import EPSILON
from crosscheck.scene import Box, Face, Floats, HardSpheres, Lattice, Method, Observable, Output, Scene, explicit
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import Mean, mean_of_stretches, standard_error, student_quantile
from crosscheck.verdict import SUSPICIOUS, Judgement, bounded, round_off, statistical

#: Asked for by all driven scenes, so that they share their kernels.
OBSERVABLES: tuple[Observable, ...] = (
    "kinetic_energy",
    "potential_energy",
    "events",
    "collisions",
    "dissipated_energy",
    "wall_impulse",
    "wall_energy",
    "kinetic_energy_integral",
    "potential_energy_integral",
)
#: Stretches that a steady state is measured in.
STRETCHES = 16
STEADY = f"standard error over {STRETCHES} stretches of one run, of a steady state"


# -- runs ----------------------------------------------------------------------------------------------


def run_whole(
    laboratory: Laboratory, scene: Scene, method: Method | Kind = EVENT_DRIVEN, engine: str | None = None
) -> Run:
    """The scene for all of its duration, event-driven unless asked otherwise; see `Laboratory.run`.

    laboratory: runs it. method: or a kind of scheme. engine: another one than that under judgement.
    """
    return laboratory.run(scene, method, engine)


def run_on(laboratory: Laboratory, scene: Scene, stretches: int, warm_up: float) -> list[Run]:
    """The scene for its duration, `stretches` times, each from the end of the one before, after a time `warm_up`.

    Fields are measured over each stretch anew, which gives them standard errors. laboratory: runs it, event-driven, and
    gives the seeds of the scene.
    """
    run = run_whole(laboratory, scene.changed(duration=warm_up, output=Output(), seed=laboratory.seed("warm-up")))
    found = []
    for stretch in range(stretches):
        start = explicit(run["final_positions"], run["final_velocities"], run.get("final_angular_velocities"))
        run = run_whole(laboratory, scene.changed(initial=start, seed=laboratory.seed(f"stretch-{stretch}")))
        found.append(run)
    return found


def column(number: int, width: float, kinetic: float, duration: float, seed: int) -> Scene:
    """Elastic disks under gravity 1 on an elastic floor at rest, periodic sideways, open above; diameter and mass 1.

    number: of disks. width: of the floor. kinetic: temperature at the start. duration: of the run. seed: of the
    velocities.
    """
    return Scene(
        name="column",
        dimension=2,
        duration=duration,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(),
        box=Box(lengths=(width, 8 * kinetic), boundaries=("periodic", "hard"), faces={"y+": Face(open=True)}),
        initial=Lattice(kind="lattice", structure="square", number=number, temperature=kinetic, seed=seed),
        output=Output(interval=duration, observables=OBSERVABLES),
    )


# -- what is measured ----------------------------------------------------------------------------------


def last(runs: list[Run], name: str) -> Floats:
    """The observable `name` at the end of each stretch, (stretches, ...); runs: one a stretch."""
    return np.array([run[name][-1] for run in runs])


def field(runs: list[Run], name: str) -> Floats:
    """The field "field_`name`" of each stretch, (stretches, ...); runs: one a stretch."""
    return np.array([run[f"field_{name}"] for run in runs])


def temperature(mass: Floats, momentum: Floats, kinetic: Floats) -> Floats:
    """T = m (<v^2> - <v>^2)/d from the fields' time integrals, of particles of mass 1; NaN in cells that stayed empty.

    mass, kinetic: (...); momentum: (..., d).
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = momentum / mass[..., None]
        square = 2 * kinetic / mass - np.sum(mean**2, axis=-1)
    return np.asarray(square / momentum.shape[-1])


def energy_defect(run: Run) -> tuple[float, float]:
    """Defect of the energy budget of `run`, and the largest term of that budget.

    The defect is the largest |change of K + U - (work of the walls - energy dissipated in pairs)| of all samples.
    """
    energy = run["kinetic_energy"] + run["potential_energy"]
    supplied, lost = run["wall_energy"].sum(axis=1), run["dissipated_energy"]
    defect = energy - energy[0] - (supplied - lost)
    sizes = [np.abs(term).max() for term in (run["kinetic_energy"], run["potential_energy"], supplied, lost)]
    return float(np.abs(defect).max()), float(max(sizes))


# -- judgements ----------------------------------------------------------------------------------------


def energy_budget(runs: list[Run]) -> Judgement:
    """K + U changes by the work of the walls less the energy dissipated in pairs; runs: each with its own budget."""
    defects = [energy_defect(run) for run in runs]
    events = max(float(run["events"][-1]) for run in runs)
    return round_off(
        "change of K + U - walls' work + dissipated, over the largest term",
        max(defect / size for defect, size in defects),
        EPSILON * events,
        f"one unit of the largest term at each of {events:.3g} events, at worst all alike",
    )


def steady_mean(values: Floats | Mean, quantity: str, expected: float, needed: float, why: str = STEADY) -> Judgement:
    """The mean of one value a stretch, or of a correlated series, against a number.

    values: (stretches,), or the mean of a series. quantity: what is measured, in words. expected: the number. needed:
    the relative deviation that must be visible. why: the reason of the tolerance, in words.
    """
    mean = values if isinstance(values, Mean) else mean_of_stretches(values)
    return statistical(quantity, mean.value, mean.error, expected, 0.0, why, samples=mean, needed=needed)


def significant(values: Floats, quantity: str) -> Judgement:
    """A control: the mean of `values`, (stretches,), is positive by more than chance explains.

    quantity: the difference that `values` are, in words.
    """
    mean = mean_of_stretches(values)
    return bounded(
        f"{quantity}, in standard errors",
        mean.value / mean.error,
        student_quantile(SUSPICIOUS, mean.freedom),
        f"Student's t of {len(values)} stretches, exceeded without a difference with the probability "
        f"{SUSPICIOUS:g} to either side, as the tolerance of a statistical judgement",
        at_least=True,
        control=True,
        note=f"the difference is {mean.value:.4g}",
    )


# -- figures -------------------------------------------------------------------------------------------


def curve(label: str, x: Floats, values: Floats) -> Series:
    """Mean and standard error over stretches; x: (points,), values: (stretches, points); label: of the curve."""
    error = standard_error(values)
    return Series(label, x.tolist(), values.mean(axis=0).tolist(), error.tolist())


def field_figure(title: str, values: Floats, frame: Frame | RoundFrame, label: str) -> Figure:
    """A map of the field `values`, (nx, ny); title: of the figure; frame: the container; label: of the colours."""
    return Figure(title, "x", "y", map=FieldMap(values.T.tolist(), frame, label))


def snapshot_figure(
    title: str, run: Run, frame: Frame | RoundFrame, period: float, values: Floats, label: str
) -> Figure:
    """Disks of diameter 1 at the end of `run`, coloured by `values`, (N,); label: of these.

    title: of the figure. frame: the container. period: of x, or 0.
    """
    x, y = wrapped(run["final_positions"], np.array([period, 0.0])).T
    ends = (0.0, float(np.nanquantile(values, 0.98)))
    return Figure(title, "x", "y", snapshot=Snapshot(x.tolist(), y.tolist(), 0.5, frame, values.tolist(), label, ends))


def local_temperature(run: Run, reach: float, period: float) -> Floats:
    """(<v^2> - <v>^2)/2 over each disk and its neighbours within `reach`, (N,); NaN for a disk without neighbours.

    run: of which the final state is taken. period: of x, or 0.
    """
    from scipy.spatial import cKDTree

    periods = np.array([period, 0.0])
    x, v = wrapped(run["final_positions"], periods), run["final_velocities"]
    near = cKDTree(x, boxsize=periods)
    groups = [near.query_ball_point(place, reach) for place in x]
    return np.array([0.5 * v[group].var(axis=0).sum() if len(group) > 1 else math.nan for group in groups])
