"""A ball that comes to rest on a floor: infinitely many impacts in a finite time."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, quick
from crosscheck.checks.events.over_floor import FLOOR, FLOOR_OBSERVABLES, FLOOR_WORDS, GRAVITY, over_floor, vertical
from crosscheck.checks.events.rows import reported_partners, reported_time
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.collapse import BouncingBall
from crosscheck.scene import Face, Method, Output
from crosscheck.verdict import Judged, Judgement, bounded, round_off, within, worst


def _judge_zeno(laboratory: Laboratory, alpha: float) -> Judged:
    """When the run ends, when each impact that samples show takes place, and how long the path is."""
    ball = BouncingBall(1.0, alpha, GRAVITY)
    scene = over_floor(Face(restitution=alpha), np.array([ball.height]), np.zeros(1), 1.5 * ball.rest, ball.rest / 4000)
    run = laboratory.run(scene, EVENT_DRIVEN, may_end_early=True)
    tick = float(np.spacing(ball.rest))
    ended = within(
        "round_off", "time of the collapse", reported_time(run), ball.rest,
        run.cost.events * 2 * tick / (1 - alpha),
        "the clock's rounding d keeps a velocity of g d/(1 - e), and each impact may wait for twice that",
    )  # fmt: skip
    z, v = (values[:, 0] for values in vertical(run))
    bounce = run["wall_collisions"][:, FLOOR]
    # flights that are longer than the interval are all seen
    seen = range(1 + int(np.log(ball.fall * 4000 / ball.rest) / -np.log(alpha)))
    first = [int(np.flatnonzero(bounce == k)[0]) for k in seen if (bounce == k).any()]
    z, v, k = z[first], v[first], bounce[first]
    ends = run["time"][first] + (v + np.sqrt(v * v + 2 * GRAVITY * z)) / GRAVITY
    apexes = z + v * v / (2 * GRAVITY)
    times = np.array([ball.impact_time(int(one) + 1) for one in k])
    late = round_off(
        "largest error of an impact's time",
        float(abs(ends - times).max()),
        4 * tick * len(seen) * (1 + 1 / (1 - alpha)),
        "two roundings of the clock an impact, which also change the velocity of all later flights",
    )
    path = float(ball.height + 2 * apexes[1:].sum() + 2 * apexes[-1] * alpha**2 / (1 - alpha**2))
    whole = within(
        "round_off", "total path", path, ball.path, 8 * tick * len(seen) / (1 - alpha),
        "the same roundings; flights too short for a sample as a geometric series",
    )  # fmt: skip
    return worst([ended, late, whole, _named(laboratory, ball)], f"{len(first)} of {len(seen)} flights seen")


def _named(laboratory: Laboratory, ball: BouncingBall) -> Judgement:
    """Of four balls, the one that comes to rest first is the one that the reports of all schemes name."""
    heights = ball.height * np.array([1.5, 1.2, 1.0, 1.3])
    wrong = []
    for diameter in _DIAMETERS:
        floor = Face(restitution=ball.alpha)
        scene = over_floor(floor, heights, np.zeros(4), 1.5 * ball.rest, ball.rest, diameter=diameter)
        scene = scene.changed(output=Output())
        for name, claims in laboratory.claims.items():
            if claims.kind != EVENT_DRIVEN or laboratory.refusal(scene, Method(scheme=name)) is not None:
                continue
            run = laboratory.run(scene, Method(scheme=name), may_end_early=True)
            late = not abs(reported_time(run) - ball.rest) <= _ROUNDING * ball.rest
            if late or reported_partners(run) != {_LOWEST}:
                wrong.append(f"{name}, diameter {diameter:g}: {run.stopped or 'no end'}")
    why = f"the ball from the lowest place, number {_LOWEST}, comes to rest first; the time as above"
    text = "schemes whose report does not name the ball that collapses, alone, and when it does"
    return bounded(text, float(len(wrong)), 0.0, why, note="; ".join(wrong))


#: Number of the ball that starts lowest.
_LOWEST = 2
#: Of the balls: radii that numbers hold exactly or not, a little more or less.
_DIAMETERS = (0.0, 0.05, 0.1, 0.13)
#: Of the time of rest: a rounding of the height, 1e-16 of the drop, is a flight of 1e-8 of the fall.
_ROUNDING = 1e-7

CHECKS = (
    Check(
        name="events/zeno",
        title="A ball that comes to rest on a floor: infinitely many impacts in a finite time",
        equation="t = sqrt(2 h/g) (1 + e)/(1 - e), path h (1 + e^2)/(1 - e^2)",
        criterion="time of the reported collapse, times of impacts and path, to the rounding of the clock",
        citation="McNamara & Young, Phys. Fluids A 4, 496 (1992)",
        judge=_judge_zeno,
        variants=(*quick(**{"e0.5": 0.5}), *full(**{"e0.8": 0.8, "e0.9": 0.9, "e0.95": 0.95})),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=FLOOR_WORDS | {"acceleration", "box.faces.restitution"},
            observables=FLOOR_OBSERVABLES,
        ),
        interpreted=True,
        faults=(
            (
                "e0.8",
                Fault(
                    "floor-restitution-squared",
                    "events/rules.py",
                    "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * v)",
                    "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * alpha * v)",
                    "walls rebound with the square of the restitution",
                ),
            ),
        ),
    ),
)
