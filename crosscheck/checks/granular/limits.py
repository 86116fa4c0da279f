"""Soft contacts at their limits: the time step, restitution 1 and 0, friction 0 and infinite, unlike grains.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996); L. E. Silbert et al., Phys. Rev. E 64,
051302 (2001).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from crosscheck.checks.base import Laboratory, fixed, legacy_check
from crosscheck.checks.granular.impacts import (
    ANGLES,
    CENTRAL_DURATION,
    DURATION,
    PHASES,
    RESOLUTIONS,
    STEP_LABEL,
    Floats,
    Law,
    SteppedContact,
    after,
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
from crosscheck.engines.protocol import Claims
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import (
    HookeImpact,
    SoftContact,
    damping,
    stability_limit,
    stable_resolution,
)
from crosscheck.references.soft_impact import stiffness as contact_stiffness
from crosscheck.scene import (
    Box,
    Face,
    HardSpheres,
    Lattice,
    Output,
    Scene,
    explicit,
)
from crosscheck.statistics import fitted_order, independent_mean, standard_error
from crosscheck.verdict import Judged, order, round_off, statistical, within, worst

# -- stability ---------------------------------------------------------------------------------------------------------

#: Steps of a grain between two walls, and its speed, in diameters and units of omega_0.
STABLE_STEPS, STABLE_SPEED = 4000, 1e-9
#: Growth beyond which it explodes: just below the limit it may grow with the steps, 2 a step (a Jordan block).
EXPLODED = 10.0 * STABLE_STEPS
_STABLE_ALPHAS = {"elastic": 1.0, "damped": 0.7, "strongly-damped": 0.05}
#: Relative width at which bisection ends.
_BISECTED = 2e-5


def bisect(explodes: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """The place from where on it explodes, to `width`. ValueError unless it is between low and high."""
    if explodes(low) or not explodes(high):
        raise ValueError(f"the limit does not lie between {low} and {high}")
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if explodes(middle) else (middle, high)
    return 0.5 * (low + high)


def _growth(laboratory: Laboratory, alpha: float, step: float, steps: int) -> float:
    """sqrt(v^2 + (omega_0 x)^2) over the speed at the start, m = k = 1, of a grain that fits between two walls."""
    scene = Scene(
        name="between-walls",
        dimension=2,
        duration=step * steps,
        hard_spheres=HardSpheres(restitution=alpha),
        box=Box(
            lengths=(4.0, 1.0),
            boundaries=("open", "hard"),
            faces={"y-": Face(restitution=alpha), "y+": Face(restitution=alpha)},
        ),
        initial=explicit(np.array([[2.0, 0.5]]), np.array([[0.0, STABLE_SPEED]])),
    )
    run = laboratory.run(scene, Law(alpha).method(1.0, step))
    size = math.hypot(run["final_velocities"][0, 1], run["final_positions"][0, 1] - 0.5) / STABLE_SPEED
    return math.inf if run.diverged or not math.isfinite(size) else size


def growth_delay(c: float) -> float:
    """How far, relatively, above the limit a step must be to grow by `EXPLODED` in `STABLE_STEPS`.

    Above it an eigenvalue is -(1 + d), d^2 + c h d = 2 h (h + c) epsilon at h (1 + epsilon), h the limit, to leading
    order in epsilon and d. The amplitude begins with a quarter of the speed or more.
    """
    rate = math.log(4 * EXPLODED) / STABLE_STEPS
    h = stability_limit(c)
    return rate * (rate + c * h) / (2 * h * (h + c))


def _judge_step_limit(laboratory: Laboratory, variant: str) -> Judged:
    alpha = _STABLE_ALPHAS[variant]
    c = damping(alpha)
    limit = stability_limit(c)
    per_contact = math.sqrt(1 - c * c / 4) / math.pi

    def explodes(share: float) -> bool:
        return _growth(laboratory, alpha, share * limit, STABLE_STEPS) > EXPLODED

    try:
        found = limit * bisect(explodes, 0.9, 1.1, _BISECTED)
    except ValueError:
        found = math.nan
    delay = growth_delay(c)
    steps, shares = 100, np.concatenate([np.linspace(0.5, 0.98, 13), np.linspace(0.99, 1.05, 13)])
    sizes = [_growth(laboratory, alpha, float(share) * limit, steps) for share in shares]
    x = [float(share) * limit * per_contact for share in shares]
    grown = Series(f"{variant}, alpha = {alpha:g}", x, [max(size, EPSILON) ** 2 for size in sizes])
    threshold = Series(
        f"{variant}, limit", [limit * per_contact] * 2, [min(grown.y), max(max(grown.y), 1.0)], theory=True
    )
    figure = Figure(
        "energy after 100 steps", STEP_LABEL, "energy over that at the start", "linear", "log", (grown, threshold)
    )
    return within(
        "round_off",
        "largest stable omega_0 dt",
        found,
        limit,
        limit * (delay + _BISECTED),
        f"bisected to {_BISECTED:g}, and a step must exceed the limit by {delay:.1e} to grow by {EXPLODED:g} in "
        f"{STABLE_STEPS} steps",
        note=f"c = {c:.4g}; the limit is dt/t_c = {stable_resolution(c):.4f}",
        figures=(figure,),
    )


# -- restitution towards 1 and 0 ---------------------------------------------------------------------------------------

NEARLY_ELASTIC = (0.99, 0.9999, 1 - 1e-6, 1.0)
NEARLY_PLASTIC = (1e-2, 1e-3, 1e-6)
#: dt/t_c; as alpha -> 0, t_c is long, and d ln alpha = -pi d zeta/(1 - zeta^2)^(3/2) asks for small steps.
_PLASTIC_RESOLUTIONS = (1e-3, 2.5e-4, 6.25e-5)


def _rebounds(laboratory: Laboratory, alpha: float, resolution: float) -> tuple[Floats, float]:
    """v'/v of head-on impacts at equally spaced phases of the step, and a bound on its relative error."""
    phases = (np.arange(PHASES) + 0.5) / PHASES
    impacts = make_impacts(2, np.zeros(PHASES), laboratory.seed(), phases=phases, central=True)
    dt, steps = resolution * CENTRAL_DURATION, lasting(resolution)
    stiffness = contact_stiffness(alpha, float(impacts.reduced[0]), CENTRAL_DURATION)
    run = laboratory.run(impact_scene(impacts, Law(alpha), dt, steps), Law(alpha).method(stiffness, dt))
    rounding = rounded_speed(impacts, steps, alpha, CENTRAL_DURATION) / alpha
    return rebound(impacts, *after(impacts, run))[0], hooke_bounds(alpha, resolution).restitution + rounding


def _judge_towards(laboratory: Laboratory, variant: str) -> Judged:
    plastic = variant == "towards-0"
    alphas, resolutions = (NEARLY_PLASTIC, _PLASTIC_RESOLUTIONS) if plastic else (NEARLY_ELASTIC, RESOLUTIONS)
    found = {(a, r): _rebounds(laboratory, a, r) for a in alphas for r in resolutions}
    # a grain that does not come back is further off than any bound
    errors = {key: float(abs(np.log(np.maximum(v, 1e-300) / key[0])).max()) for key, (v, _) in found.items()}
    bounds = {key: bound for key, (_, bound) in found.items()}
    series: list[Series] = []
    for alpha in alphas:
        x = list(resolutions)
        label = f"alpha = {alpha:.7g}"
        series.append(Series(label, x, [errors[alpha, r] for r in resolutions]))
        series.append(Series(f"{label}, bound", x, [bounds[alpha, r] for r in resolutions], theory=True))
    figure = Figure(
        f"restitution {variant.replace('-', ' ')}", STEP_LABEL, "largest relative error of v'/v", "log", "log",
        tuple(series),
    )  # fmt: skip
    why = "stepped contact against the closed form, and -ln(1 - c h) + h^2/4 for its ends; rounding of the coordinates"
    judgements = [ratio_judgement("largest relative error of v'/v", list(errors.values()), list(bounds.values()), why)]
    expected = 1.0 if plastic else 2.0
    alpha = alphas[-1]
    slope = fitted_order(resolutions, [errors[alpha, r] for r in resolutions], EPSILON).value
    judgements.append(order(f"order of v'/v in dt at alpha = {alpha:g}", slope, expected, ORDER_TOLERANCE, WHY_ORDER))
    last = ", ".join(f"{a:.7g}: {found[a, resolutions[-1]][0].mean():.8g}" for a in alphas)
    return worst(judgements, f"mean v'/v at the smallest step, {last}", (figure,))


def _judge_zero(laboratory: Laboratory) -> Judged:
    """Restitution 0 has no soft contact: it must be refused."""
    reason = ""
    impacts = make_impacts(2, np.zeros(2), laboratory.seed(), central=True)
    try:
        laboratory.run(impact_scene(impacts, Law(0.0), 0.01, 10), Law(0.0).method(1.0, 0.01))
    except Unsupported as refusal:
        reason = str(refusal)
    return within("round_off", "refusals", float(bool(reason)), 1.0, 0.5, "a count: exact", note=reason or "it was run")


#: Disks of the elastic gas, packing fraction, contact time and duration in units of diameter and thermal speed.
_GAS, _GAS_PACKING, _GAS_CONTACT, _GAS_TIME = 100, 0.3, 0.02, 4.0
#: Steps in a contact: the relative motion's energy changes by h^2 (B_2(s) - B_2(s')), s and s' the phases of the step
#: at its ends: as if independent where B_4 = 0, at a fraction of 0.24; elsewhere in many steps only.
_GAS_STARTS, _GAS_STEPS = 24, (20.24, 60.24, 180.24)


def _judge_gas(laboratory: Laboratory) -> Judged:
    """Energy of elastic grains, with that of their springs."""
    # whole numbers of steps
    interval = 25 * _GAS_CONTACT
    stiffness = contact_stiffness(1.0, 0.5, _GAS_CONTACT)
    rms, largest = np.zeros((2, _GAS_STARTS, len(_GAS_STEPS)))
    contacts = np.zeros(_GAS_STARTS)
    for start in range(_GAS_STARTS):
        scene = Scene(
            name="elastic-gas",
            dimension=2,
            duration=_GAS_TIME,
            hard_spheres=HardSpheres(),
            box=Box(packing_fraction=_GAS_PACKING),
            initial=Lattice(
                kind="lattice", structure="square", number=_GAS, temperature=1.0, seed=laboratory.seed(str(start))
            ),
            output=Output(interval=interval, observables=("kinetic_energy", "potential_energy", "contact_time")),
        )
        for rung, steps in enumerate(_GAS_STEPS):
            run = laboratory.run(scene, Law(1.0).method(stiffness, _GAS_CONTACT / steps))
            energy = run["kinetic_energy"] + run["potential_energy"]
            error = abs(energy / energy[0] - 1)
            rms[start, rung], largest[start, rung] = np.sqrt(np.mean(error**2)), error.max()
        contacts[start] = run["contact_time"][-1] / _GAS_CONTACT
    resolutions = 1 / np.array(_GAS_STEPS)
    bounds = contacts[:, None] * (math.pi * resolutions) ** 2 / 4 / _GAS
    orders = np.polyfit(np.log(resolutions), np.log(rms.T), 1)[0]
    mean, spread = np.exp(np.log(rms).mean(axis=0)), standard_error(np.log(rms))
    figure = Figure(
        "energy of an elastic gas", STEP_LABEL, "rms relative error of the energy", "log", "log",
        (Series("soft disks", resolutions.tolist(), mean.tolist(), (mean * spread).tolist()),),
    )  # fmt: skip
    return worst(
        [
            ratio_judgement(
                "largest error of the energy", largest.ravel().tolist(), bounds.ravel().tolist(),
                "a contact changes the energy by h^2/4 of the relative motion's at most, k_B T on average",
            ),
            statistical(
                "order of the energy in dt", *independent_mean(orders), 2.0, 0.0,
                f"standard error over {_GAS_STARTS} gases, whose energies walk at random from contact to contact",
                samples=_GAS_STARTS, needed=0.25,
            ),
        ],
        f"{_GAS_STARTS} gases of {_GAS} disks, {contacts.min():.0f} contacts or more each",
        (figure,),
    )  # fmt: skip


def _judge_limits(laboratory: Laboratory, variant: str) -> Judged:
    if variant == "elastic-gas":
        return _judge_gas(laboratory)
    return _judge_zero(laboratory) if variant == "zero" else _judge_towards(laboratory, variant)


# -- no friction, and friction without limit ---------------------------------------------------------------------------

#: Slip over speed of approach: friction without limit is linear in the slip, but at a large one a code whose mu is
#: large and finite slides in the step that finds F_n nearest to 0.
_WEAK_SLIPS = (1e-3, 1e-2)
_LIMITS: dict[str, tuple[int, SoftContact]] = {
    "frictionless-history": (2, SoftContact(0.8, -0.5, 0.0, 0.5, "history")),
    "frictionless-dashpot": (2, SoftContact(0.8, 0.3, 0.0, 0.5, "dashpot")),
    "no-limit-history": (2, SoftContact(0.8, -0.5, math.inf, 0.5, "history")),
    "no-limit-dashpot": (2, SoftContact(0.8, 0.3, math.inf, 0.5, "dashpot")),
    "3d-no-limit-history": (3, SoftContact(0.6, -0.9, math.inf, 0.4, "history")),
}


def sticking_bound(contact: SoftContact, resolution: float) -> float:
    """Bound on the error of u'/u of a contact that sticks, by the time step.

    A tangential spring is the leapfrog's oscillator: after N steps u' = u cos((N + 1/2) theta)/cos(theta/2),
    theta = arccos(alpha_t) dt/t_c to second order, and N steps last as long as the stepped contact but for one. A
    dashpot leaves u (1 + ln(alpha_t) dt/t_c)^N.
    """
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    stepped = SteppedContact(damping(contact.alpha), resolution * exact.contact_time)
    off = abs(stepped.duration / exact.contact_time - 1)
    if contact.friction == "history":
        turn = math.acos(contact.alpha_t)
        return turn * (off + 1.5 * resolution) + (turn * resolution) ** 2
    decay = -math.log(contact.alpha_t)
    return contact.alpha_t * math.expm1(decay * (off + resolution) + decay**2 * resolution)


def _judge_friction_limits(laboratory: Laboratory, variant: str) -> Judged:
    dimension, contact = _LIMITS[variant]
    limited = contact.mu == 0
    thetas = np.geomspace(0.1, 10.0, ANGLES) if limited else np.geomspace(*_WEAK_SLIPS, ANGLES)
    impacts = make_impacts(dimension, thetas, laboratory.seed(), q=contact.q, central=True)
    law = Law(contact.alpha, contact)
    stiffness = contact_stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    if limited:
        dt, steps = RESOLUTIONS[1] * DURATION, lasting(RESOLUTIONS[1])
        run = laboratory.run(impact_scene(impacts, law, dt, steps), law.method(stiffness, dt))
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
    errors, ratios = [], []
    for resolution in RESOLUTIONS:
        dt = resolution * DURATION
        run = laboratory.run(impact_scene(impacts, law, dt, lasting(resolution)), law.method(stiffness, dt))
        _, slip = rebound(impacts, *after(impacts, run))
        apart = abs(slip / thetas - contact.alpha_t)
        errors.append(float(np.sqrt(np.mean(apart**2))))
        # rounding of the normal over the smallest slip
        turning = (turns(impacts) + wander(impacts, lasting(resolution))) / thetas
        ratios.append(float((apart / (sticking_bound(contact, resolution) + turning)).max()))
    figure = Figure(
        "friction without limit", STEP_LABEL, "rms error of u'/u", "log", "log",
        (
            Series(variant, list(RESOLUTIONS), errors),
            Series(
                f"{variant}, bound", list(RESOLUTIONS), [sticking_bound(contact, one) for one in RESOLUTIONS],
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


# -- unlike grains -----------------------------------------------------------------------------------------------------

MASS_RATIOS = tuple(10.0**power for power in range(7))
SIZE_RATIOS = (1.0, 2.0, 5.0, 10.0, 30.0)
_RATIO_ALPHA, _RATIO_RESOLUTION = 0.5, 1 / 160


def _judge_ratios(laboratory: Laboratory, variant: str) -> Judged:
    """Heavy or large grains at rest, hit by those of mass and diameter 1."""
    of_mass = variant != "sizes"
    ratios = np.repeat(MASS_RATIOS if of_mass else SIZE_RATIOS, PHASES)
    pairs = np.stack([np.ones(ratios.size), ratios], axis=1)
    phases = np.tile((np.arange(PHASES) + 0.5) / PHASES, ratios.size // PHASES)
    sizes = pairs if variant == "sizes" else np.minimum(pairs, SIZE_RATIOS[-1]) if variant == "both" else 1.0
    masses = pairs if of_mass else 1.0
    impacts = make_impacts(
        2, np.zeros(ratios.size), laboratory.seed(), phases=phases, masses=masses, diameters=sizes, central=True
    )
    reduced, law = impacts.reduced, Law(_RATIO_ALPHA)
    stiffness = contact_stiffness(_RATIO_ALPHA, float(reduced.min()), CENTRAL_DURATION)
    dt = _RATIO_RESOLUTION * CENTRAL_DURATION
    expected = CENTRAL_DURATION * np.sqrt(reduced / reduced.min())
    steps = math.ceil(float(expected.max()) / CENTRAL_DURATION * lasting(_RATIO_RESOLUTION))
    run = laboratory.run(impact_scene(impacts, law, dt, steps, sampled=True), law.method(stiffness, dt))
    velocities, spins = after(impacts, run)
    normal, _ = rebound(impacts, velocities, spins)
    grouped = (-1, PHASES)
    lasted = dt * (overlaps(impacts, run) > 0).sum(axis=0).reshape(grouped).mean(axis=1)
    wanted = expected.reshape(grouped)[:, 0]
    bounds = [hooke_bounds(_RATIO_ALPHA, dt / float(duration)) for duration in wanted]
    rounding = rounded_speed(impacts, steps, _RATIO_ALPHA, CENTRAL_DURATION) / _RATIO_ALPHA
    restitution = abs(np.log(normal / _RATIO_ALPHA)).reshape(grouped).max(axis=1)
    masses = impacts.masses[:, :, None]
    momenta = [(masses * v).sum(axis=1) for v in (velocities, impacts.velocities)]
    carried = (masses * abs(velocities)).sum(axis=(1, 2)) + (masses * abs(impacts.velocities)).sum(axis=(1, 2))
    lost = abs(momenta[0] - momenta[1]).max(axis=1) / carried
    kind = "size" if variant == "sizes" else "mass"
    ratio = ratios.reshape(grouped)[:, 0].tolist()
    figure = Figure(
        "contact time of unlike grains", "ratio of masses or sizes", "t_c over the shortest", "log", "linear",
        (
            Series(variant, ratio, (lasted / wanted.min()).tolist()),
            Series(f"{variant}, sqrt(m_eff)", ratio, (wanted / wanted.min()).tolist(), theory=True),
        ),
    )  # fmt: skip
    why = "stepped contact against the closed form, -ln(1 - c h) + h^2/4 for its ends, rounding of the coordinates"
    return worst(
        [
            ratio_judgement(
                "largest relative error of the restitution", restitution.tolist(),
                [one.restitution + rounding for one in bounds], why,
            ),
            ratio_judgement(
                "largest relative error of the contact time", abs(lasted / wanted - 1).tolist(),
                [one.time + dt / PHASES / float(d) for one, d in zip(bounds, wanted, strict=True)],
                "stepped contact against the closed form, and whole steps, averaged over equally spaced phases",
            ),
            round_off(
                "largest change of a pair's momentum, relative to what its grains carry", float(lost.max()),
                4 * EPSILON * math.sqrt(steps), "rounding of the velocities at every step, a random walk",
            ),
        ],
        f"{kind} ratios 1 to {ratio[-1]:g}, alpha = {_RATIO_ALPHA:g}, dt = t_c/{1 / _RATIO_RESOLUTION:.0f}",
        (figure,),
    )  # fmt: skip


# -- the checks --------------------------------------------------------------------------------------------------------

_ENGINES = ("refimpl", "lammps")
_CONTACTS = "stepping/kernels/contacts.py"


def _limits_variants(engine: str, schemes: dict[str, Claims]) -> tuple[str, ...]:
    """LAMMPS has no energy of granular contacts."""
    return ("towards-1", "towards-0", "zero", *(() if engine == "lammps" else ("elastic-gas",)))


CHECKS = (
    legacy_check(
        name="granular/step-limit",
        title="Largest stable time step of a soft contact",
        equation="omega_0 dt < sqrt(c^2 + 4) - c",
        criterion="a grain that fits between two walls, so that one always touches: the limit by bisection",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_step_limit,
        variants=fixed(*_STABLE_ALPHAS),
        faults=(
            (
                "damped",
                Fault(
                    "wall-of-the-pair-mass",
                    _CONTACTS,
                    "mass, approach = 1.0 / inverse_masses[i], _product(g, n)",
                    "mass, approach = 0.5 / inverse_masses[i], _product(g, n)",
                    "the reduced mass at a wall is that of a pair",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    legacy_check(
        name="granular/restitution-limits",
        title="Restitution towards 1 and towards 0",
        equation="alpha = exp(-pi c/sqrt(4 - c^2)), c -> 0 and c -> 2; E = const at alpha = 1",
        criterion="bounds and order in dt; energy of an elastic gas to order 2, over 24 gases; 0 is refused",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_limits,
        variants=_limits_variants,
        faults=(
            (
                "towards-0",
                Fault(
                    "grains-never-attract",
                    _CONTACTS,
                    "* scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "* max(0.0, scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach "
                    "/ law[STIFFNESS])",
                    "the normal force is cut off where the dashpot makes it attract",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    legacy_check(
        name="granular/friction-limits",
        title="Soft grains without friction, and with friction without limit",
        equation="mu = 0: u' = u; mu -> infinity: u' = alpha_t u",
        criterion="spins and tangential velocities to rounding; a bound of order dt, and that order",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979)",
        judge=_judge_friction_limits,
        variants=fixed(*_LIMITS),
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
        engines=_ENGINES,
        tier="full",
    ),
    legacy_check(
        name="granular/ratios",
        title="Head-on impacts of grains of very unlike masses and sizes",
        equation="t_c = sqrt((pi^2 + ln^2 alpha) m_eff/k); v' = alpha v; m_1 v_1 + m_2 v_2 = const",
        criterion="bounds of first order in c omega_0 dt and second in omega_0 dt; momentum to rounding",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_ratios,
        variants=fixed("masses", "sizes", "both"),
        faults=(
            (
                "masses",
                Fault(
                    "reduced-mass-of-like-grains",
                    _CONTACTS,
                    "mass = 1.0 / (inverse_masses[i] + inverse_masses[j])",
                    "mass = 0.5 / inverse_masses[i]",
                    "the reduced mass is half that of the first grain",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
)
