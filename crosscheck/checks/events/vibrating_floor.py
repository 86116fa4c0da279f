"""Elastic balls on a sinusoidal floor, and a shaken column: no impact missed, no grain below the floor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.over_floor import FLOOR, GRAVITY, over_floor, vertical
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame, Snapshot
from crosscheck.references import EPSILON, floors
from crosscheck.scene import Box, Face, HardSpheres, Lattice, Oscillation, Output, Scene
from crosscheck.verdict import Judged, bounded, round_off, within, worst

#: Heights of the drops, in amplitudes: from chatter to flights of many periods.
_DROPS = np.geomspace(1e-3, 30.0, 16)
_INTERVAL, _SAMPLES = 1.5, 40


class _Shaken(NamedTuple):
    """What is on the floor, elastic balls or a column of inelastic disks, and A omega^2/g, `shaking`."""

    shaking: float
    column: bool = False


def _compare(state: tuple[float, float, float], found: tuple[float, float], omega: float) -> tuple[float, int]:
    """Error of a state one interval later in units of what rounding may do, and the impacts between."""
    z, v, t = state
    exact = floors.flight(z, v, t, _INTERVAL, 1.0, omega)
    rounding = EPSILON * np.array([abs(z) + _DROPS[-1], abs(v) + omega, t + 1.0])
    # its effect through the derivatives, by differences ten thousand times larger
    scale, size = 1e4, np.zeros(2)
    for k in range(3):
        moved = np.array(state)
        moved[k] += scale * rounding[k]
        height, velocity, time = moved.tolist()
        other = floors.flight(height, velocity, time, _INTERVAL - (time - t), 1.0, omega)
        size += abs(np.array(other[:2]) - exact[:2]) / scale
    size += EPSILON * np.array([abs(exact.height) + _DROPS[-1], abs(exact.velocity) + omega])
    error = abs(np.array(found) - exact[:2])
    return float((error / (8 * (1 + exact.impacts) * size)).max()), exact.impacts


def _judge_vibrating(laboratory: Laboratory, floor: _Shaken) -> Judged:
    return (_judge_column if floor.column else _judge_balls)(laboratory, floor.shaking)


def _judge_balls(laboratory: Laboratory, shaking: float) -> Judged:
    """Every ball over every interval, against its exact flight from the state at the start of the interval."""
    omega = shaking**0.5
    floor = Face(oscillation=Oscillation(amplitude=1.0, frequency=omega))
    scene = over_floor(floor, 1 + _DROPS, np.zeros(_DROPS.size), _INTERVAL * _SAMPLES, _INTERVAL)
    run = laboratory.run(scene, EVENT_DRIVEN)
    z, v = vertical(run)
    gap = float((z - np.cos(omega * run["time"])[:, None]).min())
    touch = 4 * EPSILON * float(_DROPS[-1] + 1 + omega * run["time"][-1])
    above = bounded("deepest place below the floor", -gap, touch, "rounding of the coordinates and of the phase")
    if -gap > touch:
        return above
    worst_error, impacts = 0.0, 0
    for k in range(_SAMPLES):
        for ball in range(_DROPS.size):
            start = (float(z[k, ball]), float(v[k, ball]), float(run["time"][k]))
            error, number = _compare(start, (float(z[k + 1, ball]), float(v[k + 1, ball])), omega)
            worst_error, impacts = max(worst_error, error), impacts + number
    like = round_off(
        "largest error of a state after an interval",
        worst_error,
        1.0,
        "in units of eight roundings an impact of height, velocity and time, through the derivatives of the flight",
    )
    counted = float(run["wall_collisions"][-1, FLOOR])
    all_hits = within("round_off", "impacts", counted, float(impacts), 0.5, "a count: none missed or doubled")
    return worst([above, like, all_hits], f"{_DROPS.size} balls, {_SAMPLES} intervals of {_INTERVAL:g}")


#: t_c of the shaken column: a bed at rest collides about once a grain and t_c.
_CONTACT_DURATION = 1e-2


def _judge_column(laboratory: Laboratory, shaking: float) -> Judged:
    """Inelastic disks between side walls on a floor with A = 0.5: no grain falls through it."""
    amplitude, omega, number = 0.5, (shaking / 0.5) ** 0.5, 60
    scene = Scene(
        name="vibrated-column",
        dimension=2,
        duration=10.0,
        acceleration=(0.0, -GRAVITY),
        hard_spheres=HardSpheres(restitution=0.9, contact_duration=_CONTACT_DURATION),
        box=Box(
            lengths=(6.0, 20.0),
            boundaries=("hard", "hard"),
            faces={
                "y-": Face(restitution=0.9, oscillation=Oscillation(amplitude=amplitude, frequency=omega)),
                "y+": Face(open=True),
            },
        ),
        initial=Lattice(kind="lattice", structure="square", number=number, temperature=0.1, seed=laboratory.seed()),
        output=Output(interval=0.05, observables=("wall_collisions", "collisions"), trajectory=True),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    x, y = run["positions"][:, :, 0], run["positions"][:, :, 1]
    gaps = np.stack([y - 0.5 - amplitude * np.cos(omega * run["time"])[:, None], x - 0.5, 5.5 - x])
    deepest = float(0.0 - gaps.min()) if np.isfinite(gaps).all() else np.inf
    figure = Figure(
        f"shaken column, A omega^2/g = {shaking:g}", "x", "y",
        snapshot=Snapshot(
            x[-1].tolist(), y[-1].tolist(), 0.5,
            Frame(0.0, 6.0, amplitude * float(np.cos(omega * run["time"][-1])), 20.0, ("left", "right", "bottom")),
        ),
    )  # fmt: skip
    return bounded(
        "deepest penetration of floor and side walls",
        deepest,
        # the phase omega t, and places of up to the height of the box
        4 * EPSILON * (20.0 + amplitude * omega * 10.0),
        "rounding of the coordinates and of the clock",
        note=f"{run['wall_collisions'][-1, FLOOR]:.0f} impacts on the floor, {run.cost.events} events",
        figures=(figure,),
    )


CHECKS = (
    Check(
        name="events/vibrating-floor",
        title="Elastic balls on a sinusoidal floor, and a shaken column: no impact missed, no grain below the floor",
        equation="z + v s - g s^2/2 = A cos(omega (t + s)), A omega^2/g from 0.1 to 100",
        criterion="every interval of every ball against an independent root finder in long double, to rounding",
        citation="Soto, Phys. Rev. E 69, 061305 (2004)",
        judge=_judge_vibrating,
        variants=(
            *full(**{f"{shaking:g}": _Shaken(shaking) for shaking in (0.1, 1.0, 10.0, 100.0)}),
            *full(**{f"column-{shaking:g}": _Shaken(shaking, column=True) for shaking in (0.1, 1.0, 3.0, 10.0, 100.0)}),
        ),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "acceleration",
                    "box.boundaries=hard",
                    "box.faces",
                    "box.faces.open",
                    "box.faces.oscillation",
                    "dimension=2",
                }
            ),
            observables=frozenset({"wall_collisions", "positions", "velocities"}),
        ),
        faults=(
            (
                "10",
                Fault(
                    "steps-too-long",
                    "events/prediction.py",
                    "steepest = abs(a) + amplitude * frequency * frequency",
                    "steepest = abs(a) + 0.25 * amplitude * frequency * frequency",
                    "the search for the next impact passes roots",
                ),
            ),
        ),
    ),
)
