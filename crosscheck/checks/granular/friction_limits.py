"""Soft grains without friction, and with friction without limit.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.granular.impacts import (
    ANGLES,
    DURATION,
    RESOLUTIONS,
    STEP_LABEL,
    Law,
    after,
    impact_scene,
    lasting,
    make_impacts,
    ratio_judgement,
    rebound,
    turns,
    wander,
)
from crosscheck.checks.granular.soft_grains import soft_needs
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import SoftContact, stiffness
from crosscheck.references.stepped_contact import sticking_bound
from crosscheck.verdict import Judged, order, round_off, worst

#: Slip over speed of approach: friction without limit is linear in the slip, but at a large one a code whose mu is
#: large and finite slides in the step that finds F_n nearest to 0.
_WEAK_SLIPS = (1e-3, 1e-2)


class _Limit(NamedTuple):
    """Friction of mu = 0 or mu = infinity, in `dimension` dimensions; name: of the variant, in figures."""

    name: str
    dimension: int
    contact: SoftContact


LIMITS = (
    _Limit("frictionless-history", 2, SoftContact(0.8, -0.5, 0.0, 0.5, "history")),
    _Limit("frictionless-dashpot", 2, SoftContact(0.8, 0.3, 0.0, 0.5, "dashpot")),
    _Limit("no-limit-history", 2, SoftContact(0.8, -0.5, math.inf, 0.5, "history")),
    _Limit("no-limit-dashpot", 2, SoftContact(0.8, 0.3, math.inf, 0.5, "dashpot")),
    _Limit("3d-no-limit-history", 3, SoftContact(0.6, -0.9, math.inf, 0.4, "history")),
)


def _judge_frictionless(laboratory: Laboratory, limit: _Limit) -> Judged:
    """mu = 0: no torque, and no tangential force."""
    contact = limit.contact
    thetas = np.geomspace(0.1, 10.0, ANGLES)
    impacts = make_impacts(limit.dimension, thetas, laboratory.seed(), q=contact.q, central=True)
    law = Law(contact.alpha, contact)
    k = stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    dt, steps = RESOLUTIONS[1] * DURATION, lasting(RESOLUTIONS[1])
    run = laboratory.run(impact_scene(impacts, law, dt, steps), law.method(k, dt))
    velocities, spins = after(impacts, run)
    turned = impacts.radii[:, :, None] * abs(spins - impacts.spins)
    normal = impacts.normals[:, None, :]
    dragged = velocities - (velocities * normal).sum(axis=2)[..., None] * normal
    return worst(
        [
            round_off(
                "largest change of R w", float(turned.max()), 4 * EPSILON * float(abs(impacts.spins).max()),
                "without friction there is no torque: a rounding of the spins",
            ),
            round_off(
                "largest tangential velocity", float(abs(dragged).max()),
                wander(impacts, steps) * (1 + contact.alpha),
                "rounding of the places at every step turns the normal; grains of diameter 1 meet at speed 1",
            ),
        ],
        f"{ANGLES} central impacts with slips up to {thetas[-1]:g}",
    )  # fmt: skip


def _judge_no_limit(laboratory: Laboratory, limit: _Limit) -> Judged:
    """mu = infinity: u' = alpha_t u."""
    contact = limit.contact
    thetas = np.geomspace(*_WEAK_SLIPS, ANGLES)
    impacts = make_impacts(limit.dimension, thetas, laboratory.seed(), q=contact.q, central=True)
    law = Law(contact.alpha, contact)
    k = stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    errors, ratios = [], []
    for resolution in RESOLUTIONS:
        dt = resolution * DURATION
        run = laboratory.run(impact_scene(impacts, law, dt, lasting(resolution)), law.method(k, dt))
        _, slip = rebound(impacts, *after(impacts, run))
        apart = abs(slip / thetas - contact.alpha_t)
        errors.append(float(np.sqrt(np.mean(apart**2))))
        # rounding of the normal over the smallest slip
        turning = (turns(impacts) + wander(impacts, lasting(resolution))) / thetas
        ratios.append(float((apart / (sticking_bound(contact, resolution) + turning)).max()))
    figure = Figure(
        "friction without limit", STEP_LABEL, "rms error of u'/u", "log", "log",
        (
            Series(limit.name, list(RESOLUTIONS), errors),
            Series(
                f"{limit.name}, bound", list(RESOLUTIONS), [sticking_bound(contact, one) for one in RESOLUTIONS],
                theory=True,
            ),
        ),
    )  # fmt: skip
    return worst(
        [
            ratio_judgement(
                "largest error of u'/u at three steps", ratios, [1.0] * len(ratios),
                "1.5 steps of contact, the lag of the dashpots, rounding of the normal",
            ),
            order(
                "order of u'/u in dt", fitted_order(RESOLUTIONS, errors, EPSILON).value, 1.0, ORDER_TOLERANCE, WHY_ORDER
            ),
        ],
        f"alpha_t = {contact.alpha_t:g}; rms error {errors[-1]:.2g} at dt = t_c/640",
        (figure,),
    )  # fmt: skip


def _judge_friction_limits(laboratory: Laboratory, limit: _Limit) -> Judged:
    return (_judge_frictionless if limit.contact.mu == 0 else _judge_no_limit)(laboratory, limit)


CHECKS = (
    Check(
        name="granular/friction-limits",
        title="Soft grains without friction, and with friction without limit",
        equation="mu = 0: u' = u; mu -> infinity: u' = alpha_t u",
        criterion="spins and tangential velocities to rounding; a bound of order dt, and that order",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979)",
        judge=_judge_friction_limits,
        variants=variants_of({limit.name: limit for limit in LIMITS}, "full"),
        needs=soft_needs("method.contact.stiffness hard_spheres.restitution hard_spheres.friction"),
        faults=(
            (
                "no-limit-history",
                Fault(
                    "friction-never-without-limit",
                    "stepping/forces/grains.py",
                    "min(law.friction, NO_LIMIT)",
                    "min(law.friction, 1.0)",
                    "friction without limit is that of mu = 1",
                ),
            ),
        ),
    ),
)
