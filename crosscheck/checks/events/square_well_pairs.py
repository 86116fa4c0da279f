"""Single pairs in a square well: capture, escape, reflection inside, core; diameter, mass and depth are 1."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.square_wells import NEEDS_STATES, OBSERVABLES, fluid
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.square_well import WIDTH, pair_path
from crosscheck.scene import Box, Floats, Output, explicit
from crosscheck.verdict import Judged, round_off, worst

#: Pairs, distance of their centres, duration.
PAIRS, PAIR_SPACING, PAIR_TIME = 64, 24.0, 5.0


def pair_starts(dimension: int, seed: int) -> tuple[Floats, Floats]:
    """Relative positions and velocities, (pairs, d): a third outside and approaching, the others in the well.

    Those inside have a binding energy or an excess of up to the depth: half of them can never leave. dimension: 2 or 3.
    seed: of all that is random.
    """
    rng = np.random.default_rng(seed)
    n = rng.normal(size=(PAIRS, dimension))
    n /= np.linalg.norm(n, axis=1)[:, None]
    side = rng.normal(size=(PAIRS, dimension))
    side -= (side * n).sum(1)[:, None] * n
    side /= np.linalg.norm(side, axis=1)[:, None]
    outside = np.arange(PAIRS) < PAIRS // 3
    distance = np.where(outside, 2.5, rng.uniform(1.05, 1.45, PAIRS))
    impact = np.where(outside, rng.uniform(0, 1.45, PAIRS), rng.uniform(0, 0.9, PAIRS) * distance)
    speed = np.where(outside, rng.uniform(0.5, 2.5, PAIRS), 2 * np.sqrt(rng.uniform(0.1, 1.9, PAIRS)))
    along = -np.sqrt(1 - (impact / distance) ** 2)
    velocity = speed[:, None] * (along[:, None] * n + (impact / distance)[:, None] * side)
    return distance[:, None] * n, velocity


def _judge(laboratory: Laboratory, dimension: int) -> Judged:
    """Pairs too far apart to meet others, each against its own path from event to event."""
    relative, velocity = pair_starts(dimension, laboratory.seed())
    side = int(np.ceil(PAIRS ** (1 / dimension)))
    places = np.stack(np.meshgrid(*[np.arange(side)] * dimension), -1).reshape(-1, dimension)[:PAIRS] + 0.5
    centres = np.repeat(PAIR_SPACING * places, 2, axis=0)
    signs = np.tile([0.5, -0.5], PAIRS)[:, None]
    length = side * PAIR_SPACING
    scene = fluid(dimension, 2, 0.01, 0.0, 0).changed(
        duration=PAIR_TIME,
        box=Box(lengths=(length,) * dimension),
        initial=explicit(centres + signs * np.repeat(relative, 2, 0), signs * np.repeat(velocity, 2, 0)),
        output=Output(interval=0.05, observables=OBSERVABLES, trajectory=True),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    positions, velocities = run["final_positions"], run["final_velocities"]
    found = np.hstack([positions[::2] - positions[1::2], velocities[::2] - velocities[1::2]])
    expected, growth, seen = np.empty_like(found), np.empty(PAIRS), np.zeros(4, np.int64)
    shift = 1e-8
    for k in range(PAIRS):
        path = pair_path(relative[k], velocity[k], PAIR_TIME, WIDTH)
        expected[k] = np.concatenate(path[:2])
        seen += path[2:]
        twins = [
            np.concatenate(pair_path(relative[k] + dr, velocity[k] + dv, PAIR_TIME, WIDTH)[:2])
            for dr, dv in _disturbances(dimension, shift)
        ]
        growth[k] = max(1.0, max(abs(twin - expected[k]).max() for twin in twins) / shift)
    # a position is rounded to the box's last digit at every event; the path multiplies that by `growth`
    errors = abs(found - expected).max(axis=1)
    tolerance = 4 * EPSILON * length * growth * (1 + seen.sum() / PAIRS)
    path_error = round_off(
        "largest error of a pair's final place and velocity, in its own rounding",
        float((errors / tolerance).max()),
        1.0,
        "4 roundings of the box's length per event, times the growth of a disturbance of 1e-8 along the pair's path",
        note=f"largest error {errors.max():.1e}, growth of a disturbance {np.median(growth):.1f} (median)",
    )
    binding = 0.25 * (velocity**2).sum(axis=1) - 1.0
    bound = (np.linalg.norm(relative, axis=1) < WIDTH) & (binding < 0)
    separation = np.linalg.norm(run["positions"][:, ::2] - run["positions"][:, 1::2], axis=2)[:, bound]
    captive = round_off(
        "largest distance beyond the edge of pairs without the energy to part",
        max(float(separation.max()) - WIDTH, 0.0),
        4 * EPSILON * length,
        "rounding of a position in the box",
    )
    names = ("captures", "escapes", "reflections inside", "core hits")
    counted = ", ".join(f"{number} {name}" for name, number in zip(names, seen, strict=True))
    return worst([path_error, captive], f"{PAIRS} pairs, {bound.sum()} of them bound for ever; {counted}")


def _disturbances(dimension: int, shift: float) -> list[tuple[Floats, Floats]]:
    zero = np.zeros(dimension)
    steps = shift * np.eye(dimension)
    return [(step, zero) for step in steps] + [(zero, step) for step in steps]


CHECKS = (
    Check(
        name="events/square-well-pairs",
        title="Single pairs in a square well: capture, escape, reflection inside, core",
        equation="u'^2 = u^2 + 4 epsilon/m inwards, u^2 - 4 epsilon/m outwards, u' = -u where that is negative",
        criterion="final place and velocity to the rounding of the path; pairs without the energy to part never do",
        citation="Alder & Wainwright, J. Chem. Phys. 31, 459 (1959)",
        judge=_judge,
        variants=full(**{"2d": 2, "3d": 3}),
        needs=NEEDS_STATES,
        faults=(
            (
                "3d",
                Fault(
                    "no-reflection",
                    "events/rules.py",
                    "    if square < 0.0:\n        return -gn, inside",
                    "    if square < -0.5:\n        return -gn, inside\n    square = abs(square)",
                    "pairs that miss a little energy leave their well",
                ),
            ),
        ),
    ),
)
