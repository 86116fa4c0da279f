"""A floor that always moves up: the limit of a sawtooth."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.over_floor import FLOOR, FLOOR_OBSERVABLES, FLOOR_WORDS, GRAVITY, over_floor
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON, floors
from crosscheck.scene import Face
from crosscheck.verdict import Judged, round_off, within, worst


def _judge_sawtooth(laboratory: Laboratory, e: float) -> Judged:
    """The floor stays at z = 0 and always has the velocity V0; one impact of each grain."""
    u = np.geomspace(0.2, 20.0, 40)
    fall = np.minimum(1.0, u)
    heights, velocities = u * fall - GRAVITY * fall**2 / 2, -u + GRAVITY * fall
    scene = over_floor(Face(velocity=1.0, restitution=e), heights, velocities, 1.25, 1.25)
    run = laboratory.run(scene, EVENT_DRIVEN)
    after = 0.5 * run["final_velocities"][:, 1] ** 2 + GRAVITY * run["final_positions"][:, 1]
    gains = after - (0.5 * velocities**2 + GRAVITY * heights)
    expected = np.array([floors.sawtooth_gain(float(one), 1.0, e) for one in u])
    rounding = 16 * EPSILON * float(u.max() ** 2)
    each = round_off(
        "largest error of the gain of one impact",
        float(abs(gains - expected).max()),
        rounding,
        "of velocities and heights on the way, in units of the largest energy",
    )
    together = within(
        "round_off", "energy given by the floor", float(run["wall_energy"][-1, FLOOR]), float(expected.sum()),
        rounding * u.size, "that of each grain",
    )  # fmt: skip
    once = within(
        "round_off", "impacts", float(run["wall_collisions"][-1, FLOOR]), float(u.size), 0.5,
        "one of each grain",
    )  # fmt: skip
    return worst([each, together, once], f"e = {e:g}, u = 0.2 ... 20 V0")


CHECKS = (
    Check(
        name="events/sawtooth",
        title="A floor that always moves up: the limit of a sawtooth",
        equation="dE = 2 V0 (V0 + u) for e = 1; v' = (1 + e) V0 + e u",
        criterion="each grain, to rounding",
        citation="McNamara & Barrat, Phys. Rev. E 55, 7767 (1997)",
        judge=_judge_sawtooth,
        variants=full(e1=1.0, **{"e0.9": 0.9}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=FLOOR_WORDS | {"acceleration", "box.faces.velocity"},
            observables=FLOOR_OBSERVABLES,
        ),
        faults=(
            (
                "e1",
                Fault(
                    "floor-velocity-once",
                    "events/rules.py",
                    "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * v)",
                    "rows[i, 3 + axis] = inwards * (own - alpha * v)",
                    "the floor's velocity counts once instead of 1 + alpha times",
                ),
            ),
        ),
    ),
)
