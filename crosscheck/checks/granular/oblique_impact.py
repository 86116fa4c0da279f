"""Oblique impacts of soft grains: sticking, sliding, and the hard rule beside them.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); J. Schaefer, S. Dippel and D. E. Wolf, J.
Phys. I France 6, 5 (1996); S. F. Foerster et al., Phys. Fluids 6, 1108 (1994).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.granular.impacts import (
    ANGLES,
    DURATION,
    STEP_LABEL,
    Floats,
    Impacts,
    Law,
    after,
    impact_scene,
    lasting,
    make_impacts,
    ratio_judgement,
    rebound,
    rounded_speed,
    turns,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, granular
from crosscheck.references.granular import Body
from crosscheck.references.soft_impact import SoftContact, hard_impact, residual, soft_impact, stiffness
from crosscheck.references.stepped_contact import friction_bounds, hard_rule_bounds, hooke_bounds
from crosscheck.verdict import Judged, order, round_off, worst

#: Impacts reach this many times the hard rule's limit of sticking.
ANGLE_RANGE = 2.5
#: dt/t_c, down to errors far below what Coulomb's law does while the grains attract, which is
#: mu (1 + 1/q) (alpha^(2 chi/pi) - alpha) of u'/v, 0.007 in the first variant.
OBLIQUE_RESOLUTIONS = (1 / 160.4, 1 / 640.4, 1 / 2560.4)
#: dt/t_c where the soft contact is the hard rule: the error falls with dt^2, soon below that by the turn of the normal.
HARD_RULE_RESOLUTIONS = (1 / 10.4, 1 / 40.4, 1 / 160.4)


class _Oblique(NamedTuple):
    """Impacts in `dimension` dimensions, of grains or with a wall; name: of the variant, in figures.

    hard_rule: the soft contact is the hard rule at every angle.
    """

    name: str
    dimension: int
    contact: SoftContact
    wall: bool = False
    hard_rule: bool = False


OBLIQUE = (
    _Oblique("2d-history", 2, SoftContact(0.8, -0.5, 0.3, 0.5, "history")),
    _Oblique("2d-dashpot", 2, SoftContact(0.8, 0.3, 0.3, 0.5, "dashpot")),
    _Oblique("2d-wall-history", 2, SoftContact(0.6, -0.3, 0.4, 0.5, "history"), wall=True),
    _Oblique("2d-wall-dashpot", 2, SoftContact(0.6, 0.2, 0.4, 0.4, "dashpot"), wall=True),
    _Oblique("2d-hard-rule", 2, SoftContact(1.0, -1.0, 0.3, 0.5, "history"), hard_rule=True),
    _Oblique("3d-history", 3, SoftContact(0.9, -0.7, 0.5, 0.4, "history")),
    _Oblique("3d-dashpot", 3, SoftContact(0.5, 0.5, 0.2, 0.4, "dashpot")),
    _Oblique("3d-wall-history", 3, SoftContact(0.7, 0.0, 0.3, 0.4, "history"), wall=True),
)


def _judge_oblique(laboratory: Laboratory, case: _Oblique) -> Judged:
    contact, hard_rule = case.contact, case.hard_rule
    limit = granular.sliding_limit(contact.alpha, contact.alpha_t, contact.mu, contact.q)
    thetas = limit * ANGLE_RANGE * (np.arange(ANGLES) + 0.5) / ANGLES
    impacts = make_impacts(case.dimension, thetas, laboratory.seed(), q=contact.q, wall=case.wall)
    law = Law(contact.alpha, contact)
    k = stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    exact = soft_impact(thetas, contact)
    turning = turns(impacts)
    ladder = HARD_RULE_RESOLUTIONS if hard_rule else OBLIQUE_RESOLUTIONS
    slips, normals, ratios, errors = [], [], [], []
    for resolution in ladder:
        dt = resolution * DURATION
        scene = impact_scene(impacts, law, dt, lasting(resolution))
        run = laboratory.run(scene, law.method(k, dt))
        normal, slip = rebound(impacts, *after(impacts, run))
        bound = (hard_rule_bounds if hard_rule else friction_bounds)(thetas, contact, resolution)
        off = turning + rounded_speed(impacts, lasting(resolution), contact.alpha, DURATION)
        bound = bound + off
        ratios.append(float((abs(slip - exact.slip) / bound).max()))
        errors.append(float(np.sqrt(np.mean((slip - exact.slip) ** 2))))
        slips.append(slip)
        allowed = hooke_bounds(contact.alpha, resolution).restitution + off / contact.alpha
        normals.append(float((abs(np.log(normal / contact.alpha)) / allowed).max()))
    scene = impact_scene(impacts, law, ladder[0] * DURATION, lasting(ladder[0]))
    rigid = laboratory.run(scene, EVENT_DRIVEN, engine=REFERENCE)
    _, rigid_slip = rebound(impacts, *after(impacts, rigid))
    by_rule = _hard_errors(impacts, contact, *after(impacts, rigid))
    step_errors = "2 h^2 (Theta + mu (1 + 1/q))" if hard_rule else "1.5 steps of contact, the lag of the dashpot"
    why = f"{step_errors}, the turn of the normal by v t_c over the diameter, rounding"
    fastest = float(np.linalg.norm(impacts.velocities, axis=2).max())
    apart = residual(contact)
    judgements = [
        ratio_judgement("largest error of u'/v at three steps", ratios, [1.0] * 3, why),
        ratio_judgement("largest error of v'_n/v_n at three steps", normals, [1.0] * 3, why),
        order(
            "order of u'/v in dt", fitted_order(ladder, errors, EPSILON).value, 2.0 if hard_rule else 1.0,
            ORDER_TOLERANCE, WHY_ORDER,
        ),
        round_off(
            "largest error of velocities and of R w of event-driven grains against the hard rule", by_rule,
            16 * EPSILON * impacts.size / float(impacts.radii.max()) * fastest,
            "rounding of the places at contact: it turns the normal, by which every component changes",
        ),
    ]  # fmt: skip
    note = (
        f"soft contacts are off the hard rule by {apart.size:.4f} at most, at Theta = {apart.theta:.3g}, in the limit; "
        f"rms error {errors[-1]:.2g} at dt = t_c/{1 / ladder[-1]:.0f}"
    )
    curves = _Curves(case.name, contact, thetas, slips[-1], rigid_slip, ladder, errors)
    return worst(judgements, note, _oblique_figures(curves))


def _hard_errors(impacts: Impacts, contact: SoftContact, velocities: Floats, spins: Floats) -> float:
    """Largest error of the velocities and of R w after impacts by the hard rule."""
    errors = [0.0]
    for k in range(len(impacts.masses)):
        one, two = (
            Body(
                float(impacts.masses[k, i]), float(impacts.radii[k, i]), impacts.velocities[k, i], impacts.spins[k, i],
                impacts.q,
            )
            for i in (0, 1)
        )  # fmt: skip
        expected = granular.impact(one, two, impacts.normals[k], contact.alpha, contact.alpha_t, contact.mu, contact.mu)
        errors.append(float(abs(velocities[k] - expected.velocities).max()))
        errors.append(float(abs(impacts.radii[k][:, None] * (spins[k] - expected.spins)).max()))
    return max(errors)


class _Curves(NamedTuple):
    """Slips after against those before, of soft grains at the smallest step and of event-driven ones; the ladder."""

    name: str
    contact: SoftContact
    thetas: Floats
    soft: Floats
    rigid: Floats
    ladder: tuple[float, ...]
    errors: list[float]


def _oblique_figures(curves: _Curves) -> tuple[Figure, ...]:
    """Foerster's plot of the soft and the event-driven engine with both theories, and the error against the step."""
    x, fine = curves.thetas.tolist(), np.linspace(0, float(curves.thetas[-1]), 200)
    label = f"soft, dt = t_c/{1 / curves.ladder[-1]:.0f}"
    soft, hard = soft_impact(fine, curves.contact).slip, hard_impact(fine, curves.contact).slip
    apart = curves.soft - hard_impact(curves.thetas, curves.contact).slip
    return (
        Figure(
            f"oblique impacts, {curves.name}", "Theta = |u|/v_n before", "u'/v_n after",
            series=(
                Series(label, x, curves.soft.tolist()),
                Series("event-driven", x, curves.rigid.tolist()),
                Series("soft contact, closed form", fine.tolist(), soft.tolist(), theory=True),
                Series("hard rule", fine.tolist(), hard.tolist(), theory=True),
            ),
        ),
        Figure(
            f"soft less hard, {curves.name}", "Theta = |u|/v_n before", "difference of u'/v_n",
            series=(
                Series(label, x, apart.tolist()),
                Series("closed form", fine.tolist(), (soft - hard).tolist(), theory=True),
            ),
        ),
        Figure(
            "oblique impacts against the step", STEP_LABEL, "rms error of u'/v_n", "log", "log",
            (Series(curves.name, list(curves.ladder), curves.errors),),
        ),
    )  # fmt: skip


CHECKS = (
    Check(
        name="granular/oblique-impact",
        title="Oblique impacts of soft grains: sticking, sliding, and the hard rule beside them",
        equation="|F_t| <= mu |F_n|; u'/v_n = mu (1 + 1/q) f(Theta q/((1 + q) mu); alpha, alpha_t)",
        criterion="bounds and order 1 in dt against the closed form; event-driven grains to rounding of the hard rule",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979); Foerster et al., Phys. Fluids 6, 1108 (1994)",
        judge=_judge_oblique,
        variants=variants_of({case.name: case for case in OBLIQUE}, "full"),
        needs=soft_needs("method.contact.stiffness hard_spheres.restitution hard_spheres.friction"),
        faults=(
            (
                "2d-history",
                Fault(
                    "no-friction-in-attraction",
                    CONTACTS,
                    "limit = law[FRICTION] * abs(normal)",
                    "limit = law[FRICTION] * max(normal, 0.0)",
                    "Coulomb's limit is 0 where the dashpot makes the grains attract",
                ),
            ),
            (
                "2d-dashpot",
                Fault(
                    "friction-without-its-limit",
                    CONTACTS,
                    "share = min(limit, damping * slip) / slip if slip > 0.0 else 0.0",
                    "share = damping if slip > 0.0 else 0.0",
                    "the tangential dashpot has no Coulomb limit",
                ),
            ),
        ),
    ),
)
