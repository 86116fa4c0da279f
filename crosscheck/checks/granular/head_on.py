"""Head-on impacts of soft grains: restitution, contact time and largest overlap.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996); D. Antypov and J. A. Elliott,
Europhys. Lett. 94, 50004 (2011).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.granular.impacts import (
    CENTRAL_DURATION,
    PHASES,
    RESOLUTIONS,
    STEP_LABEL,
    Law,
    after,
    impact_scene,
    lasting,
    make_impacts,
    overlaps,
    ratio_judgement,
    rebound,
    rounded_speed,
    wander,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, contact_needs, soft_needs
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.hertz_mindlin import Material, normal_modulus
from crosscheck.references.soft_impact import HertzImpact, HookeImpact, stiffness
from crosscheck.references.stepped_contact import Errors, impact_bounds
from crosscheck.scene import Contact
from crosscheck.verdict import Judged, order, worst

ALPHAS = (1.0, 0.9, 0.6, 0.2, 0.05)
SPEEDS = (0.5, 1.0, 2.0)


class _Setup(NamedTuple):
    """Law of the overlap, and whether grains hit a wall or each other; name: of the variant, in figures.

    own: the contact with coefficients of its own that has a given stiffness k and restitution alpha; None: stiffness
    and the scene's restitution are what is given. damped: that contact has its damping too.
    """

    name: str
    law: Literal["hooke", "hertz"] = "hooke"
    wall: bool = False
    own: Callable[[float, float], Contact] | None = None
    damped: bool = False


def _rates(k: float, alpha: float) -> Contact:
    """k_n and gamma_n of a linear contact: alpha = exp(-gamma_n t_c/2)."""
    return Contact(k_n=k, gamma_n=-2 * math.log(alpha) / CENTRAL_DURATION)


def _moduli(k: float, alpha: float) -> Contact:
    """E and nu of a contact with the stiffness k = (4/3) E_eff; alpha is the scene's."""
    softest = Material(1.0, 0.3)
    return Contact(law="hertz", E=0.75 * k / normal_modulus(softest, softest), nu=softest.poisson)


SETUPS = (
    _Setup("hooke"),
    _Setup("hertz", law="hertz"),
    _Setup("wall", wall=True),
    _Setup("hooke-rates", own=_rates, damped=True),
    _Setup("hertz-moduli", law="hertz", own=_moduli),
    _Setup("hertz-moduli-wall", law="hertz", wall=True, own=_moduli),
)


class _HeadOn(NamedTuple):
    """Relative errors and their bounds, of one restitution at one dt/t_c: the largest of all speeds and phases."""

    errors: Errors
    bounds: Errors


def _head_on(laboratory: Laboratory, alpha: float, resolution: float, setup: _Setup) -> _HeadOn:
    law, wall = Law(alpha, law=setup.law), setup.wall
    speeds = np.repeat(SPEEDS, PHASES)
    phases = np.tile((np.arange(PHASES) + 0.5) / PHASES, len(SPEEDS))
    impacts = make_impacts(
        2, np.zeros(speeds.size), laboratory.seed(), phases=phases, speeds=speeds, wall=wall, central=True
    )
    mass, radius = float(impacts.reduced[0]), 0.5 if wall else 0.25
    exact: list[HookeImpact | HertzImpact]
    if law.law == "hooke":
        k = stiffness(law.alpha, mass, CENTRAL_DURATION)
        exact = [HookeImpact(mass, k, float(v), law.alpha) for v in speeds]
    else:
        # the contact time, proportional to k^(-2/5), is CENTRAL_DURATION at speed 1
        k = (HertzImpact(mass, 1.0, radius, 1.0, law.alpha).contact_time / CENTRAL_DURATION) ** 2.5
        exact = [HertzImpact(mass, k, radius, float(v), law.alpha) for v in speeds]
    dt = resolution * CENTRAL_DURATION
    # of "hertz", slow contacts last longer
    steps = math.ceil(max(one.contact_time for one in exact) / CENTRAL_DURATION * lasting(resolution))
    given = law._replace(
        alpha=1.0 if setup.damped else alpha, own=None if setup.own is None else setup.own(k, law.alpha)
    )
    run = laboratory.run(impact_scene(impacts, given, dt, steps, sampled=True), given.method(k, dt))
    velocity, _ = rebound(impacts, *after(impacts, run))
    depth = overlaps(impacts, run)
    times = dt * (depth > 0).sum(axis=0).reshape(len(SPEEDS), PHASES).mean(axis=1)
    wanted = np.array([one.contact_time for one in exact])
    deepest = np.array([one.largest_overlap for one in exact])
    bounds = [impact_bounds(one, dt) for one in exact[::PHASES]]
    largest = Errors(*(max(column) for column in zip(*bounds, strict=True)))
    # a mean over equally spaced phases counts whole steps to one of the phases
    counting = dt / PHASES / float(wanted.min())
    rounding = rounded_speed(impacts, steps, law.alpha, CENTRAL_DURATION) / (law.alpha * min(SPEEDS))
    shallow = wander(impacts, steps) / float(deepest.min())
    return _HeadOn(
        Errors(
            float(abs(np.log(velocity / law.alpha)).max()),
            float(abs(times / wanted[::PHASES] - 1).max()),
            float(abs(np.log(depth.max(axis=0) / deepest)).max()),
        ),
        Errors(largest.restitution + rounding, largest.time + counting, largest.overlap + shallow),
    )


def _judge_head_on(laboratory: Laboratory, setup: _Setup) -> Judged:
    found = {
        (alpha, resolution): _head_on(laboratory, alpha, resolution, setup)
        for alpha in ALPHAS
        for resolution in RESOLUTIONS
    }
    series: list[Series] = []
    for alpha in ALPHAS:
        curve = [found[alpha, resolution] for resolution in RESOLUTIONS]
        x = list(RESOLUTIONS)
        series.append(Series(f"alpha = {alpha:g}", x, [one.errors.restitution for one in curve]))
        series.append(Series(f"alpha = {alpha:g}, bound", x, [one.bounds.restitution for one in curve], theory=True))
    figure = Figure(
        f"restitution of head-on impacts, {setup.name}",
        STEP_LABEL,
        "largest relative error of v'/v",
        "log",
        "log",
        tuple(series),
    )
    why = "stepped contact against the closed form, and -ln(1 - c h) + h^2/4 for its ends between steps, h = omega_0 dt"
    judgements = [
        ratio_judgement(
            f"largest relative error of the {name}",
            [getattr(one.errors, key) for one in found.values()],
            [getattr(one.bounds, key) for one in found.values()],
            why,
        )
        for name, key in (("restitution", "restitution"), ("contact time", "time"), ("largest overlap", "overlap"))
    ]
    errors = [
        math.hypot(*(found[alpha, resolution].errors.restitution for alpha in ALPHAS if alpha < 1))
        for resolution in RESOLUTIONS
    ]
    judgements.append(
        order(
            "order of v'/v in dt, with dashpot", fitted_order(RESOLUTIONS, errors, EPSILON).value, 1.0,
            ORDER_TOLERANCE, WHY_ORDER,
        )
    )  # fmt: skip
    finest = found[ALPHAS[-1], RESOLUTIONS[-1]].errors
    note = (
        f"speeds {SPEEDS}, {PHASES} phases of the step; at alpha = {ALPHAS[-1]:g} and dt = t_c/640 relative errors of "
        f"{finest.restitution:.2g}, {finest.time:.2g} (time) and {finest.overlap:.2g} (overlap)"
    )
    return worst(judgements, note, (figure,))


CHECKS = (
    Check(
        name="granular/head-on",
        title="Head-on impacts of soft grains: restitution, contact time and largest overlap",
        equation="F_n = k delta - c sqrt(m k) v_n; v' = alpha v; t_c = sqrt((pi^2 + ln^2 alpha) m/k); "
        "delta_max = (v/omega_0) alpha^(chi/pi)",
        criterion="bounds of first order in c omega_0 dt and second in omega_0 dt, and the order of v'/v in dt",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996); Antypov & Elliott, EPL 94, 50004 (2011)",
        judge=_judge_head_on,
        variants=tuple(
            Variant(setup.name, setup, needs=None if setup.own is None else contact_needs(setup.own(1.0, 0.5)))
            for setup in SETUPS
        ),
        needs=soft_needs("dimension=2 method.contact.stiffness hard_spheres.restitution", "positions velocities"),
        faults=(
            (
                "hooke",
                Fault(
                    "dashpot-of-the-pair-mass",
                    CONTACTS,
                    "return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "return coefficient * np.sqrt(2.0 * mass * law[STIFFNESS] * scale)",
                    "the dashpot has twice the reduced mass",
                ),
            ),
        ),
    ),
)
