"""Single contacts of soft grains: head-on and oblique impacts, and two codes step by step.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); J. Schaefer, S. Dippel and D. E. Wolf, J.
Phys. I France 6, 5 (1996); S. F. Foerster et al., Phys. Fluids 6, 1108 (1994); D. Antypov and J. A. Elliott, Europhys.
Lett. 94, 50004 (2011).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory, fixed, legacy_check
from crosscheck.checks.granular.impacts import (
    ANGLES,
    CENTRAL_DURATION,
    DURATION,
    PHASES,
    RESOLUTIONS,
    STEP_LABEL,
    Errors,
    Floats,
    Impacts,
    Law,
    SteppedContact,
    after,
    bodies,
    hooke_bounds,
    impact_scene,
    lasting,
    make_impacts,
    overlaps,
    ratio_judgement,
    rebound,
    rounded_speed,
    turns,
    wander,
)
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, granular
from crosscheck.references.granular import Body
from crosscheck.references.soft_impact import (
    HertzImpact,
    HookeImpact,
    SoftContact,
    damping,
    force_impulse,
    hard_impact,
    residual,
    soft_impact,
)
from crosscheck.references.soft_impact import stiffness as contact_stiffness
from crosscheck.statistics import fitted_order
from crosscheck.verdict import Judged, order, round_off, worst

# -- head-on -----------------------------------------------------------------------------------------------------------

ALPHAS = (1.0, 0.9, 0.6, 0.2, 0.05)
SPEEDS = (0.5, 1.0, 2.0)


class _HeadOn(NamedTuple):
    """Relative errors and their bounds, of one restitution at one resolution: all bounds and errors are positive."""

    errors: Errors
    bounds: Errors


def _head_on(laboratory: Laboratory, law: Law, resolution: float, wall: bool) -> _HeadOn:
    speeds = np.repeat(SPEEDS, PHASES)
    phases = np.tile((np.arange(PHASES) + 0.5) / PHASES, len(SPEEDS))
    impacts = make_impacts(
        2, np.zeros(speeds.size), laboratory.seed(), phases=phases, speeds=speeds, wall=wall, central=True
    )
    mass, radius = float(impacts.reduced[0]), 0.5 if wall else 0.25
    exact: list[HookeImpact | HertzImpact]
    if law.law == "hooke":
        stiffness = contact_stiffness(law.alpha, mass, CENTRAL_DURATION)
        exact = [HookeImpact(mass, stiffness, float(v), law.alpha) for v in speeds]
    else:
        # the contact time, proportional to k^(-2/5), is CENTRAL_DURATION at speed 1
        stiffness = (HertzImpact(mass, 1.0, radius, 1.0, law.alpha).contact_time / CENTRAL_DURATION) ** 2.5
        exact = [HertzImpact(mass, stiffness, radius, float(v), law.alpha) for v in speeds]
    dt = resolution * CENTRAL_DURATION
    # of "hertz", slow contacts last longer
    steps = math.ceil(max(one.contact_time for one in exact) / CENTRAL_DURATION * lasting(resolution))
    run = laboratory.run(impact_scene(impacts, law, dt, steps, sampled=True), law.method(stiffness, dt))
    velocity, _ = rebound(impacts, *after(impacts, run))
    depth = overlaps(impacts, run)
    times = dt * (depth > 0).sum(axis=0).reshape(len(SPEEDS), PHASES).mean(axis=1)
    wanted = np.array([one.contact_time for one in exact])
    deepest = np.array([one.largest_overlap for one in exact])
    bounds = [_impact_bounds(law, one, dt) for one in exact[::PHASES]]
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


def _impact_bounds(law: Law, impact: HookeImpact | HertzImpact, dt: float) -> Errors:
    """`hooke_bounds`; of "hertz", of the linear contact that it is equivalent to, as stiff as at the largest overlap.

    There omega^2 = (5/4) k sqrt(R delta)/m (`soft_impact`), and less than that elsewhere. The time goes as the
    amplitude to the power -1/5, which in the end is off as much as restitution is.
    """
    if isinstance(impact, HookeImpact):
        return hooke_bounds(law.alpha, dt / impact.contact_time)
    depth = impact._replace(alpha=1.0).largest_overlap
    frequency = math.sqrt(1.25 * impact.stiffness * math.sqrt(impact.radius * depth) / impact.mass)
    bounds = hooke_bounds(law.alpha, dt * frequency / HookeImpact(1.0, 1.0, 1.0, law.alpha).contact_time)
    return bounds._replace(time=bounds.time + bounds.restitution / 5)


def _judge_head_on(laboratory: Laboratory, variant: str) -> Judged:
    wall, rule = variant == "wall", "hertz" if variant == "hertz" else "hooke"
    found = {
        (alpha, resolution): _head_on(laboratory, Law(alpha, law=rule), resolution, wall)  # type: ignore[arg-type]
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
        f"restitution of head-on impacts, {variant}",
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


# -- oblique impacts ---------------------------------------------------------------------------------------------------

#: Impacts reach this many times the hard rule's limit of sticking.
ANGLE_RANGE = 2.5
#: dt/t_c, down to errors far below what Coulomb's law does while the grains attract, which is
#: mu (1 + 1/q) (alpha^(2 chi/pi) - alpha) of u'/v, 0.007 in the first variant.
OBLIQUE_RESOLUTIONS = (1 / 160.4, 1 / 640.4, 1 / 2560.4)
#: Variants: dimension, contact, wall.
OBLIQUE: dict[str, tuple[int, SoftContact, bool]] = {
    "2d-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), False),
    "2d-dashpot": (2, SoftContact(0.8, 0.3, 0.3, 0.5, "dashpot"), False),
    "2d-wall-history": (2, SoftContact(0.6, -0.3, 0.4, 0.5, "history"), True),
    "2d-wall-dashpot": (2, SoftContact(0.6, 0.2, 0.4, 0.4, "dashpot"), True),
    "2d-hard-rule": (2, SoftContact(1.0, -1.0, 0.3, 0.5, "history"), False),
    "3d-history": (3, SoftContact(0.9, -0.7, 0.5, 0.4, "history"), False),
    "3d-dashpot": (3, SoftContact(0.5, 0.5, 0.2, 0.4, "dashpot"), False),
    "3d-wall-history": (3, SoftContact(0.7, 0.0, 0.3, 0.4, "history"), True),
}


#: Of the case that is the hard rule at every angle: there the error is of order 2 in dt, and soon that of the turn.
HARD_RULE_RESOLUTIONS = (1 / 10.4, 1 / 40.4, 1 / 160.4)


def friction_bounds(thetas: ArrayLike, contact: SoftContact, resolution: float) -> Floats:
    """Errors on errors of u'/v by the time step, in the units of `soft_impact`, w' = -T, |T| <= B, phi = pi t/t_c.

    The contact acts for at most 3/2 steps more or less than t_c, besides what the stepped contact is longer: a phase
    `shift`. It costs shift times the largest B; a stretch that is off by shift times u has T off by nu^2 x shift for
    the rest of the contact, and a dashpot at a velocity half a step old by lambda^2 x times half a step. B itself is
    off by as much as restitution is, relatively.
    """
    theta = np.asarray(thetas, dtype=np.float64)
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    c = damping(contact.alpha)
    stepped = SteppedContact(c, resolution * exact.contact_time)
    normal = hooke_bounds(contact.alpha, resolution)
    shift = math.pi * (1.5 * resolution + abs(stepped.duration / exact.contact_time - 1))
    largest = max(1.0, c / math.sqrt(1 - c**2 / 4))
    x = theta / contact.scale
    if contact.friction == "history":
        late = math.acos(contact.alpha_t) ** 2 / math.pi * x * shift
    else:
        late = math.log(contact.alpha_t) ** 2 / 2 * x * resolution
    return np.asarray(contact.scale * (largest * shift + late + normal.restitution * force_impulse(contact.alpha)))


def _judge_oblique(laboratory: Laboratory, variant: str) -> Judged:
    dimension, contact, wall = OBLIQUE[variant]
    limit = granular.sliding_limit(contact.alpha, contact.alpha_t, contact.mu, contact.q)
    thetas = limit * ANGLE_RANGE * (np.arange(ANGLES) + 0.5) / ANGLES
    impacts = make_impacts(dimension, thetas, laboratory.seed(), q=contact.q, wall=wall)
    law = Law(contact.alpha, contact)
    stiffness = contact_stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    exact = soft_impact(thetas, contact)
    turning, hard_rule = turns(impacts), variant == "2d-hard-rule"
    ladder = HARD_RULE_RESOLUTIONS if hard_rule else OBLIQUE_RESOLUTIONS
    slips, normals, ratios, errors = [], [], [], []
    for resolution in ladder:
        dt = resolution * DURATION
        scene = impact_scene(impacts, law, dt, lasting(resolution))
        run = laboratory.run(scene, law.method(stiffness, dt))
        normal, slip = rebound(impacts, *after(impacts, run))
        step = math.pi * resolution
        bound = 2 * step**2 * (thetas + contact.scale) if hard_rule else friction_bounds(thetas, contact, resolution)
        off = turning + rounded_speed(impacts, lasting(resolution), contact.alpha, DURATION)
        bound = bound + off
        ratios.append(float((abs(slip - exact.slip) / bound).max()))
        errors.append(float(np.sqrt(np.mean((slip - exact.slip) ** 2))))
        slips.append(slip)
        allowed = hooke_bounds(contact.alpha, resolution).restitution + off / contact.alpha
        normals.append(float((abs(np.log(normal / contact.alpha)) / allowed).max()))
    scene = impact_scene(impacts, law, ladder[0] * DURATION, lasting(ladder[0]))
    rigid = laboratory.run(scene, EVENT_DRIVEN, engine="refimpl")
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
    curves = _Curves(variant, contact, thetas, slips[-1], rigid_slip, ladder, errors)
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

    variant: str
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
            f"oblique impacts, {curves.variant}", "Theta = |u|/v_n before", "u'/v_n after",
            series=(
                Series(label, x, curves.soft.tolist()),
                Series("event-driven", x, curves.rigid.tolist()),
                Series("soft contact, closed form", fine.tolist(), soft.tolist(), theory=True),
                Series("hard rule", fine.tolist(), hard.tolist(), theory=True),
            ),
        ),
        Figure(
            f"soft less hard, {curves.variant}", "Theta = |u|/v_n before", "difference of u'/v_n",
            series=(
                Series(label, x, apart.tolist()),
                Series("closed form", fine.tolist(), (soft - hard).tolist(), theory=True),
            ),
        ),
        Figure(
            "oblique impacts against the step", STEP_LABEL, "rms error of u'/v_n", "log", "log",
            (Series(curves.variant, list(curves.ladder), curves.errors),),
        ),
    )  # fmt: skip


# -- two codes ---------------------------------------------------------------------------------------------------------

#: Contact time of the pairs that are followed step by step, and dt/t_c: long enough that the line of centres turns,
#: and that delta/R, by which the arms of `pair_style granular` are shorter, is seen.
FOLLOWED, FOLLOWED_RESOLUTION = 1e-2, 1 / 50
_FOLLOWED_PAIRS = 100
#: Who is asked for the other trajectory.
_OTHER = {"refimpl": "lammps"}
#: Variants: dimension, contact, whether grains are of unlike masses and sizes, whether they hit a wall.
TWO_CODES: dict[str, tuple[int, SoftContact | None, bool, bool]] = {
    "2d-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), False, False),
    "2d-dashpot": (2, SoftContact(0.8, 0.3, 0.3, 0.5, "dashpot"), False, False),
    "2d-wall-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), False, True),
    "2d-unlike-smooth": (2, None, True, False),
    "2d-unlike-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), True, False),
    "3d-history": (3, SoftContact(0.7, -0.6, 0.5, 0.4, "history"), False, False),
    "3d-unlike-dashpot": (3, SoftContact(0.7, 0.2, 0.5, 0.4, "dashpot"), True, False),
    "3d-unlike-history": (3, SoftContact(0.7, -0.6, 0.5, 0.4, "history"), True, False),
}


def _judge_two_codes(laboratory: Laboratory, variant: str) -> Judged:
    dimension, contact, unlike, wall = TWO_CODES[variant]
    rng = np.random.default_rng(laboratory.seed("grains"))
    shape = (_FOLLOWED_PAIRS, 2)
    masses, diameters = (rng.uniform(0.5, 2.0, shape), rng.choice([0.6, 1.0], shape)) if unlike else (1.0, 1.0)
    impacts = make_impacts(
        dimension,
        np.zeros(_FOLLOWED_PAIRS) if contact is None else rng.uniform(0.0, 4.0, _FOLLOWED_PAIRS),
        laboratory.seed(),
        masses=masses,
        diameters=diameters,
        q=None if contact is None else contact.q,
        wall=wall,
    )
    law = Law(0.7) if contact is None else Law(contact.alpha, contact)
    dt, steps = FOLLOWED_RESOLUTION * FOLLOWED, lasting(FOLLOWED_RESOLUTION)
    # of the longest contact
    steps = math.ceil(steps * math.sqrt(float(impacts.reduced.max() / impacts.reduced.min())))
    scene = impact_scene(impacts, law, dt, steps, sampled=True)
    method = law.method(contact_stiffness(law.alpha, float(impacts.reduced.min()), FOLLOWED), dt)
    runs = [laboratory.run(scene, method, engine) for engine in (None, _OTHER.get(laboratory.engine, "refimpl"))]

    def differences(name: str, spin: bool = False) -> Floats:
        """The largest of each sample."""
        one, two = (bodies(impacts, run[name], spin) for run in runs)
        return np.asarray(abs(one - two).reshape(len(one), -1).max(axis=1))

    places, velocities = differences("positions"), differences("velocities")
    wandered, tolerance = wander(impacts, steps), rounded_speed(impacts, steps, law.alpha, FOLLOWED)
    why = "a coordinate is rounded at every step, a random walk, and overlaps times omega_0^2 t_c are velocities"
    judgements = [
        round_off("largest difference of velocities", float(velocities.max()), tolerance, why),
        round_off(
            "largest difference of positions", float(places.max()), wandered + tolerance * FOLLOWED,
            "rounding of the coordinates, and the velocities' difference for a contact",
        ),
    ]  # fmt: skip
    times = (FOLLOWED_RESOLUTION * np.arange(places.size)).tolist()
    curves = [Series(f"{variant}, velocities", times, velocities.tolist())]
    if contact is not None:
        spins = differences("angular_velocities", spin=True)
        curves.append(Series(f"{variant}, spins", times, spins.tolist()))
        radius = float(impacts.radii[impacts.radii > 0].min())
        judgements.append(
            round_off(
                "largest difference of spins", float(spins.max()), tolerance / (contact.q * radius),
                f"{why}, and R w changes by 1/q as much",
            )
        )  # fmt: skip
    figure = Figure("two codes, step by step", "time / t_c", "largest difference", "linear", "log", tuple(curves))
    kinds = "unlike masses and sizes" if unlike else "like grains"
    note = f"{_FOLLOWED_PAIRS} impacts at once, {kinds}, {steps} steps, coordinates up to {impacts.size:.0f}"
    return worst(judgements, note, (figure,))


# -- the checks --------------------------------------------------------------------------------------------------------

_ENGINES = ("refimpl", "lammps")
_CONTACTS = "stepping/kernels/contacts.py"

CHECKS = (
    legacy_check(
        name="granular/head-on",
        title="Head-on impacts of soft grains: restitution, contact time and largest overlap",
        equation="F_n = k delta - c sqrt(m k) v_n; v' = alpha v; t_c = sqrt((pi^2 + ln^2 alpha) m/k); "
        "delta_max = (v/omega_0) alpha^(chi/pi)",
        criterion="bounds of first order in c omega_0 dt and second in omega_0 dt, and the order of v'/v in dt",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996); Antypov & Elliott, EPL 94, 50004 (2011)",
        judge=_judge_head_on,
        variants=fixed("hooke", "hertz", "wall"),
        faults=(
            (
                "hooke",
                Fault(
                    "dashpot-of-the-pair-mass",
                    _CONTACTS,
                    "return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "return coefficient * np.sqrt(2.0 * mass * law[STIFFNESS] * scale)",
                    "the dashpot has twice the reduced mass",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="quick",
    ),
    legacy_check(
        name="granular/oblique-impact",
        title="Oblique impacts of soft grains: sticking, sliding, and the hard rule beside them",
        equation="|F_t| <= mu |F_n|; u'/v_n = mu (1 + 1/q) f(Theta q/((1 + q) mu); alpha, alpha_t)",
        criterion="bounds and order 1 in dt against the closed form; event-driven grains to rounding of the hard rule",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979); Foerster et al., Phys. Fluids 6, 1108 (1994)",
        judge=_judge_oblique,
        variants=fixed(*OBLIQUE),
        faults=(
            (
                "2d-history",
                Fault(
                    "no-friction-in-attraction",
                    _CONTACTS,
                    "limit = law[FRICTION] * abs(normal)",
                    "limit = law[FRICTION] * max(normal, 0.0)",
                    "Coulomb's limit is 0 where the dashpot makes the grains attract",
                ),
            ),
            (
                "2d-dashpot",
                Fault(
                    "friction-without-its-limit",
                    _CONTACTS,
                    "share = min(limit, damping * slip) / slip if slip > 0.0 else 0.0",
                    "share = damping if slip > 0.0 else 0.0",
                    "the tangential dashpot has no Coulomb limit",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    legacy_check(
        name="granular/two-codes",
        title="A hundred impacts at once, step by step in two codes",
        equation="gran/hooke, gran/hooke/history and pair_style granular of LAMMPS",
        criterion="positions, velocities and spins at every step, to rounding",
        citation="Silbert et al., Phys. Rev. E 64, 051302 (2001)",
        judge=_judge_two_codes,
        variants=fixed(*TWO_CODES),
        faults=(
            (
                "2d-unlike-history",
                Fault(
                    "torque-on-the-other-arm",
                    _CONTACTS,
                    "_add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[j] - shorter), n, f)",
                    "_add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[i] - shorter), n, f)",
                    "the torque on the second grain has the arm of the first",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
)
