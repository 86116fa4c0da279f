"""Floors that draw their phase at each impact: uniform, or weighted with the speed of approach."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.over_floor import FLOOR, FLOOR_OBSERVABLES, FLOOR_WORDS, over_floor, plate_figures
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON, floors
from crosscheck.scene import Face, RandomPhase
from crosscheck.statistics import standard_error
from crosscheck.verdict import Judged, round_off, statistical, worst

#: Grains of each run; laws of the phase, and velocities before the impact in units of V0.
GRAINS = 40000
LAWS: tuple[floors.Law, ...] = ("uniform", "flux")
SPEEDS = (1.0, 2.0, 3.0)


class _Draw(NamedTuple):
    """The law of the floor's phase, and the velocity u that grains come down with."""

    law: floors.Law
    u: float


def _judge_random(laboratory: Laboratory, draw: _Draw) -> Judged:
    """One visit of each grain, of one impact or of several at once where the wall recedes."""
    law, u = draw
    floor = Face(random_phase=RandomPhase(speed=1.0, law=law))
    scene = over_floor(
        floor, np.full(GRAINS, 0.5 * u), np.full(GRAINS, -u), 1.0, 1.0, gravity=False, seed=laboratory.seed(),
        width=4.0 * GRAINS,
    )  # fmt: skip
    run = laboratory.run(scene, EVENT_DRIVEN)
    gains = 0.5 * (run["final_velocities"][:, 1] ** 2 - u * u)
    single = {"uniform": floors.uniform_phase_gain, "flux": floors.flux_phase_gain}[law](u, 1.0)
    visit = floors.random_visit_gain(u, law)
    hits = float(run["wall_collisions"][-1, FLOOR]) / GRAINS
    expected, error = (single, 0.0) if u >= 2 else (visit, 1e-3)
    plates = (run["final_velocities"][:, 1] - u) / 2
    figures = plate_figures(plates, u, f"{law} phases, u = {u:g}") if u >= 2 else ()
    gained = statistical(
        "mean energy gained in a visit to the wall",
        float(gains.mean()),
        float(standard_error(gains)),
        expected,
        0.0,
        f"standard error over {GRAINS} independent grains" + (f"; quadrature, to {error:g}" if error else ""),
        samples=GRAINS,
        doubt=error,
        needed=0.15,
        figures=figures,
    )
    given = float(run["wall_energy"][-1, FLOOR])
    judgements = [
        gained,
        round_off(
            "energy that the wall reports over that of the grains' velocities, less 1",
            abs(given / float(gains.sum()) - 1),
            EPSILON * GRAINS * (u + 2) ** 2,
            "a rounding of the largest energy, (u + 2 V0)^2/2, an impact, at worst all alike, over the mean gain",
        ),
    ]
    if u >= 2:  # no wall that is slower overtakes the grain again
        judgements.append(
            round_off("impacts of a grain, less 1", abs(hits - 1), 0.5 / GRAINS, "one visit: not one impact more")
        )
    note = f"{hits:.4f} impacts a visit" + (f"; closed form of one impact {single:.4f}" if u < 2 else "")
    return worst(judgements, note)


CHECKS = (
    Check(
        name="events/random-phase",
        title="Floors that draw their phase at each impact: uniform, or weighted with the speed of approach",
        equation="<dE> = V0^2 (uniform), 2 V0^2 (flux) for u >= 2 V0; below, with the impacts that follow at once",
        criterion=f"mean over {GRAINS} grains",
        citation="McNamara & Barrat, Phys. Rev. E 55, 7767 (1997); Soto, Phys. Rev. E 69, 061305 (2004)",
        judge=_judge_random,
        variants=full(**{f"{law}-u{u:g}": _Draw(law, u) for law in LAWS for u in SPEEDS}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=FLOOR_WORDS | {"box.faces.random_phase"},
            observables=FLOOR_OBSERVABLES,
        ),
        faults=(
            (
                "flux-u2",
                Fault(
                    "flux-as-uniform",
                    "events/rules.py",
                    "if own > v and (motion == UNIFORM_PHASE or chance * (abs(top) - v) < own - v):",
                    "if own > v and (motion == UNIFORM_PHASE or chance < 2.0):",
                    "the flux law draws uniform phases",
                ),
            ),
        ),
    ),
)
