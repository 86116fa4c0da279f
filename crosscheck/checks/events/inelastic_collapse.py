"""Inelastic collapse on a line: found below the limit, and not above."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.cooling import RESTITUTION_SQUARED
from crosscheck.checks.events.gases import event_driven
from crosscheck.checks.events.rows import ROWS, Row, reported_partners, reported_time, row_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.collapse import line_collisions
from crosscheck.scene import Method
from crosscheck.verdict import Judged, bounded, within, worst


def _judge_collapse(laboratory: Laboratory, row: Row) -> Judged:
    """By all event-driven schemes of the engine."""
    scene = row_scene(row, row.below, 1.0)
    schemes = [name for name, claims in laboratory.claims.items() if claims.kind == EVENT_DRIVEN]
    able = [name for name in schemes if laboratory.refusal(scene, Method(scheme=name)) is None]
    return worst([_judge_scheme(laboratory, row, scheme) for scheme in able or schemes[:1]])


def _judge_scheme(laboratory: Laboratory, row: Row, scheme: str) -> Judged:
    """The exact time of the collapse just below the limit, the exact number of collisions just above it."""
    gaps, velocities, wall, limit, below, above, fixed = row
    method = Method(scheme=scheme)
    exact = line_collisions(gaps, velocities, below, wall)
    run = laboratory.run(row_scene(row, below, 2 * float(exact.times[-1])), method, may_end_early=True)
    time, stopped = reported_time(run), run.stopped
    rounding = 4 * EPSILON * float(np.sum(gaps) + velocities.size + fixed)
    left = exact.times[-1] - exact.times
    tolerance = float(np.sum(left * np.minimum(1.0, rounding / np.maximum(exact.gaps, 1e-300))))
    found = within(
        "round_off", f"{scheme}: time of the collapse at alpha = {below:.4g}", time, float(exact.times[-1]),
        tolerance,
        "four roundings of the coordinates change each gap, and the time left from there, in proportion",
    )  # fmt: skip
    # the last ones of so many collisions that a clock cannot tell their times apart: any neighbours may be named
    named = reported_partners(run)
    neighbours = [{i, i + 1} for i in range(velocities.size - 1 + fixed)] + ([{0}] if wall and not fixed else [])
    who = bounded(f"{scheme}: particles named that do not touch", float(named not in neighbours), 0.0,
                  "who collapses touches", note=stopped)  # fmt: skip
    sound = line_collisions(gaps, velocities, above, wall)
    run = laboratory.run(row_scene(row, above, 2 * float(sound.times[-1])), method, may_end_early=True)
    hits = run["collisions"][-1] + run["wall_collisions"][-1].sum()
    none = within(
        "round_off", f"{scheme}: collisions until all part at alpha = {above:.4g}", float(hits),
        sound.pairs + sound.wall, 0.5, "a count: exact",
    )  # fmt: skip
    return worst([found, who, none], f"limit {limit:.5f}; {scheme}: below it '{stopped}', above it '{run.stopped}'")


#: Variants of the quick tier.
_QUICK = ("three", "wall-2", "fixed-2")
_FIXED = event_driven("hard_spheres.fixed")

CHECKS = (
    Check(
        name="events/inelastic-collapse",
        title="Inelastic collapse on a line: three particles, and N thrown at a wall or at a fixed particle",
        equation="alpha < 7 - 4 sqrt 3; alpha < tan^2(pi/4 (1 - 1/N))",
        criterion="found below the limit, with its time and particles; none above, and the exact number of collisions",
        citation="McNamara & Young, Phys. Fluids A 4, 496 (1992); Bernu & Mazighi, J. Phys. A 23, 5745 (1990)",
        judge=_judge_collapse,
        variants=tuple(
            Variant(name, row, "quick" if name in _QUICK else "full", _FIXED if row.fixed else None)
            for name, row in ROWS.items()
        ),
        interpreted=True,
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {"box.boundaries=hard", "box.faces", "box.faces.open", "dimension=2", "hard_spheres.restitution"}
            ),
            observables=frozenset({"collisions", "wall_collisions", "kinetic_energy"}),
        ),
        faults=(
            ("wall-5", RESTITUTION_SQUARED),
            (
                "fixed-2",
                Fault(
                    "collapse-on-fixed-unseen",
                    "events/kernels/loop.py",
                    "at_once = age_i < instant and (fixed or age_j < instant)",
                    "at_once = age_i < instant and age_j < instant",
                    "collisions with a fixed particle are never at one time: their collapse does not end the run",
                ),
            ),
        ),
    ),
)
