"""Rough disks in a turning drum: angle of the heap, work of the wall, torque of the weight."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import (
    OBSERVABLES,
    STRETCHES,
    energy_budget,
    field_figure,
    local_temperature,
    run_whole,
    snapshot_figure,
    steady_mean,
    temperature,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, RoundFrame, Series
from crosscheck.scene import Box, Cylinder, Floats, Friction, GrainFriction, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import Mean, correlated_mean, mean_of_stretches
from crosscheck.verdict import Judged, Judgement, bounded, statistical, worst

#: Radius of the drum, and time between samples of its runs.
DRUM_RADIUS, DRUM_SAMPLE = 10.0, 0.5
_DRUM_SPEED = 0.2
#: The runs, by t_c of the TC model as a share of the largest; the cylinder among the faces, after x-, x+, y- and y+.
_SHARES = {"t_c": 1.0, "t_c/2": 0.5, "t_c/4": 0.25}
_CYLINDER = 4


def drum_scene(seed: int, contact: float) -> Scene:
    """Rough disks that fill some 45 % of a drum; seed: of the start, contact: t_c of the TC model."""
    radius = DRUM_RADIUS
    return Scene(
        name="drum",
        dimension=2,
        duration=420.0,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(
            restitution=0.6,
            contact_duration=contact,
            friction=GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.5),
        ),
        box=Box(
            lengths=(2 * radius, 2 * radius),
            boundaries=("open", "open"),
            cylinder=Cylinder(
                radius=radius,
                angular_velocity=_DRUM_SPEED,
                restitution=0.6,
                friction=Friction(tangential_restitution=0.0, static=0.8, sliding=0.8),
            ),
        ),
        initial=Lattice(kind="lattice", structure="triangular", number=150, temperature=0.1, seed=seed),
        output=Output(
            interval=DRUM_SAMPLE, observables=(*OBSERVABLES, "wall_torque"), trajectory=True, fields=(16, 16)
        ),
    )


def fall_angles(positions: ArrayLike, middle: ArrayLike) -> Floats:
    """Degrees by which the centre of mass, seen from the middle, is turned from -y to +x.

    positions: (samples, N, 2); middle: of the drum, (2,); both lengths. Returns (samples,).
    """
    x, y = (np.asarray(positions).mean(axis=1) - np.asarray(middle)).T
    return np.asarray(np.degrees(np.arctan2(x, -y)))


def surface_angle(positions: Floats, middle: Floats, radius: float) -> float:
    """Angle, in degrees, of the line through the highest disks of a heap in a drum, by least squares.

    Highest are those of each strip, one diameter wide and normal to the line from the middle to the centre of mass
    turned by 90 degrees, within 0.6 radii of the middle. NaN with fewer than 4 of them. positions: (N, 2). middle: of
    the drum, (2,). radius: of the drum, in diameters.
    """
    centre = positions.mean(axis=0) - middle
    down = centre / np.hypot(*centre)
    along = np.array([-down[1], down[0]])
    x, height = (positions - middle) @ along, -(positions - middle) @ down
    strips = np.floor(x).astype(int)
    tops = [np.flatnonzero(strips == s)[np.argmax(height[strips == s])] for s in np.unique(strips)]
    tops = [i for i in tops if abs(x[i]) < 0.6 * radius]
    if len(tops) < 4:
        return math.nan
    slope = np.polyfit(x[tops], height[tops], 1)[0]
    return float(np.degrees(np.arctan2(along[1], along[0]) + np.arctan(slope)))


def _judge_drum(laboratory: Laboratory, contact: float) -> Judged:
    """Angles of the heap at t_c = `contact`, half and a quarter of it, and balances of energy and torque.

    The angle of the centre of mass scatters half as much as that of the surface. It changes linearly with t_c, so the
    second halving changes it half as much as the first.
    """
    runs = [
        run_whole(laboratory, drum_scene(laboratory.seed(f"drum-{part}"), contact * share))
        for part, share in enumerate(_SHARES.values())
    ]
    skip = round(15.0 / DRUM_SAMPLE)
    middle = np.full(2, DRUM_RADIUS)
    series = [np.array([surface_angle(x, middle, DRUM_RADIUS) for x in run["positions"]]) for run in runs]
    angles = [_mean_angle(run["positions"][skip:], middle) for run in runs]
    judgements = [energy_budget(runs), _second_halving(angles)]
    for run, angle, label in zip(runs, angles, _SHARES, strict=True):
        judgements += [
            bounded(
                f"angle of the centre of mass, degrees, {label}",
                angle.value,
                4 * angle.error,
                "the wall carries the heap the way that it turns: by its standard error at least four times",
                at_least=True,
            ),
            *_balances(run, skip, label),
        ]
    frame = RoundFrame(DRUM_RADIUS, DRUM_RADIUS, DRUM_RADIUS)
    run = runs[0]
    mass = run["field_mass"]
    inside = mass > 0.02 * mass.max()
    hot = np.where(inside, temperature(mass, run["field_momentum"], run["field_kinetic"]), math.nan)
    share = mass / run["time"][-1] * (math.pi / 4) / (DRUM_RADIUS / 8) ** 2
    figures = (
        snapshot_figure("Drum: grains", run, frame, 0.0, np.linalg.norm(run["final_velocities"], axis=1), "speed"),
        snapshot_figure(
            "Drum: granular temperature", run, frame, 0.0, local_temperature(run, 2.0, 0.0), "T of the neighbours"
        ),
        field_figure(
            "Drum: packing fraction", np.where(inside, share, math.nan), frame, "packing fraction, by centres"
        ),
        field_figure("Drum: mean temperature", hot, frame, "T"),
        Figure(
            "Drum: angle of the surface",
            "time",
            "degrees",
            series=tuple(
                Series(label, run["time"][10:].tolist(), one[10:].tolist())
                for label, one in zip(_SHARES, series, strict=True)
            ),
        ),
    )
    collisions = ", ".join(f"{int(run['collisions'][-1])}" for run in runs)
    return worst(judgements, f"{collisions} collisions", figures)


def _mean_angle(positions: Floats, middle: Floats) -> Mean:
    """Over stretches of the samples, (samples, N, 2), each more than half a turn of the drum; with their drift."""
    angles = fall_angles(positions, middle)
    each = angles.size // STRETCHES
    return mean_of_stretches(angles[: each * STRETCHES].reshape(STRETCHES, each).mean(axis=1))


def _second_halving(angles: list[Mean]) -> Judgement:
    """What halving t_c again changes of the angle, against half of what the first halving did; in degrees.

    Both have the second angle in them: the error is that of their difference. An angle that drifts is red.
    """
    first, second, third = angles
    bend = third.value - 1.5 * second.value + 0.5 * first.value
    error = math.hypot(third.error, 1.5 * second.error, 0.5 * first.error)
    expected = first.value + 1.5 * (second.value - first.value)
    return statistical(
        "angle of the centre of mass at t_c/4, degrees",
        expected + bend,
        error,
        expected,
        0.0,
        f"standard errors of {STRETCHES} stretches of three runs; the straight line through t_c and t_c/2, as the "
        "share of contacts that the TC model lets pass is of first order",
        samples=angles,
        needed=0.12,
        note=", ".join(f"{one.value:.2f} +- {one.error:.2f}" for one in angles),
    )


def _balances(run: Run, skip: int, label: str) -> list[Judgement]:
    """Of the steady part: the walls' work against the dissipated, their torque against that of the weight."""
    given, lost = np.diff(run["wall_energy"][skip:, _CYLINDER]), np.diff(run["dissipated_energy"][skip:])
    torque = np.diff(run["wall_torque"][skip:]) / DRUM_SAMPLE
    lever = (run["positions"][skip:, :, 0] - DRUM_RADIUS).sum(axis=1)
    lever = 0.5 * (lever[1:] + lever[:-1])
    why = "standard error of the correlated series of samples"
    supplied = _DRUM_SPEED * (run["wall_torque"][-1] - run["wall_torque"][0])
    share = float((run["wall_energy"][-1, _CYLINDER] - run["wall_energy"][0, _CYLINDER]) / supplied)
    return [
        steady_mean(
            correlated_mean((given - lost) / lost.mean()),
            f"walls' work less dissipation in pairs, over the latter, {label}",
            0.0,
            0.12,
            why,
        ),
        steady_mean(
            correlated_mean(torque / lever.mean() - lever / lever.mean()),
            f"torque of the wall less that of the weight, over the latter, {label}",
            0.0,
            0.1,
            why,
        ),
        bounded(
            f"energy given by the wall over torque times angular velocity, {label}",
            share,
            1.0,
            "impacts on the wall lose energy as well",
        ),
        bounded(
            f"the same, at least, {label}",
            share,
            0.5,
            "more is lost in the heap than at the wall; of a wall that turns at half the speed less than half arrives",
            at_least=True,
        ),
    ]


CHECKS = (
    Check(
        name="events/drum",
        title="Rough disks in a turning drum: angle of the heap, work of the wall, torque of the weight",
        equation="d(K+U)/dt = wall - dissipation; torque of the wall = M g x_cm in the mean; angle = a - b t_c",
        criterion="round-off for the budget of the run; standard errors of correlated samples for the rest",
        citation="S. Luding and S. McNamara, Granular Matter 1, 113 (1998); O. R. Walton, in Particulate Two-Phase "
        "Flow (1993); G. H. Ristow, Pattern Formation in Granular Materials, Springer (2000)",
        judge=_judge_drum,
        faults=(
            (
                "disks",
                Fault(
                    "torque-at-the-centre",
                    "events/kernels/measure.py",
                    "_add(tallies, TORQUE, stretch * (x * py - y * px))",
                    "_add(tallies, TORQUE, 0.8 * stretch * (x * py - y * px))",
                    "the torque is taken with an arm that is too short",
                ),
            ),
        ),
        variants=full(disks=4e-4),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "acceleration",
                    "box.boundaries=open",
                    "box.cylinder",
                    "box.cylinder.angular_velocity",
                    "box.cylinder.friction",
                    "box.cylinder.friction.sliding",
                    "box.cylinder.friction.static",
                    "box.cylinder.restitution",
                    "dimension=2",
                    "hard_spheres.contact_duration",
                    "hard_spheres.friction",
                    "hard_spheres.friction.sliding",
                    "hard_spheres.friction.static",
                    "hard_spheres.restitution",
                    "output.fields",
                }
            ),
            observables=frozenset({*OBSERVABLES, "wall_torque", "positions", "velocities", "angular_velocities"}),
        ),
    ),
)
