"""Kepler orbits: order of every scheme, what it conserves, how its orbit turns, and where rounding takes over."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks.base import Check, Laboratory, legacy_check, legacy_schemes_with
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, Limit, extrapolate
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON, kepler
from crosscheck.scene import Floats, Gravity, Kepler, Method, Output, Scene
from crosscheck.statistics import fitted_order
from crosscheck.verdict import Judged, bounded, order, round_off, within, worst

# Nothing is 1 that could hide a missing factor, but mu = G (m_0 + m_1) = a^3, so that n = 1 and the period is 2 pi.
MASSES, G, AXIS = (3.0, 1.0), 2.0, 2.0
MU = G * sum(MASSES)
PERIOD = 2 * np.pi
ECCENTRICITIES = (0.0, 0.5, 0.9, 0.99)
#: Samples a period.
SAMPLES = 16
#: Steps of the coarsest run, times the angular speed at pericentre: there, errors are asymptotic.
COARSEST = {1: 0.025, 2: 0.1}
#: Left to the full tier: each costs a compilation and shows nothing here that others do not.
RARE = ("euler", "modified_euler", "euler_pc", "beeman_pc")
#: Ratios of the step numbers of an extrapolation: errors in dt^2 up to dt^14 are removed.
SEQUENCE = np.array([1, 2, 3, 4, 6, 8, 12, 16])
#: Largest energy error of a run, to that of its first period: the secular part is as large as the oscillation.
DRIFT = 2.0
WHY_DRIFT = "twice that of the first period: a secular part as large as the oscillation"
#: Standard deviations of rounding: random ones stay within 5, and a bias of the same size within twice that.
SIGMAS = 10.0
WHY_ROUNDING = "10 standard deviations of independent roundings of r and v in every step, carried along the orbit"
#: Of schemes that solve the problem exactly: sqrt(steps) as much, in case the roundings of all steps are alike.
WHY_BIASED = "10 standard deviations of the rounding of r and v, alike in every step, carried along the orbit"


def kepler_scene(eccentricity: float, periods: float, samples: int | None = None) -> Scene:
    """The orbit from apocentre, with `samples` samples a period or none."""
    return Scene(
        name=f"kepler-e{eccentricity:g}",
        dimension=2,
        duration=periods * PERIOD,
        masses=MASSES,
        gravity=Gravity(G=G),
        initial=Kepler(kind="kepler", semi_major_axis=AXIS, eccentricity=eccentricity),
        output=Output() if samples is None else Output(interval=PERIOD / samples, trajectory=True),
    )


def position_error(run: Run, eccentricity: float) -> float:
    """Largest distance of a body from its place on the orbit, over all samples, in units of a; infinite if diverged."""
    if run.diverged:
        return np.inf
    exact, _ = kepler.two_bodies(run["time"], MASSES, eccentricity, AXIS, G)
    return float(np.linalg.norm(run["positions"] - exact, axis=-1).max() / AXIS)


def rounding_floor(scheme: str, eccentricity: float, periods: float, steps: float) -> float:
    """What rounding can make of the position, in units of a.

    Verlet's positions carry the velocity as a difference, so that a rounding of r is one of r/dt in v.
    """
    lever = steps / (PERIOD * periods) if scheme == "verlet" else 1.0
    return SIGMAS * lever * kepler.rounding_error(eccentricity, periods, steps)


def step_numbers(eccentricity: float, largest: float, runs: int, multiple: int = SAMPLES) -> Floats:
    """Steps a period: multiples of the samples, doubled each time; the first has a step of `largest` at pericentre."""
    coarsest = np.ceil(PERIOD * kepler.fastest(eccentricity) / largest / multiple)
    return np.asarray(multiple * coarsest * 2.0 ** np.arange(runs))


# -- order -------------------------------------------------------------------------------------------------------------


def nominal_order(scheme: str, claims: Claims) -> int:
    """Of the position. Gear's schemes start without the higher derivatives, which gravity does not tell: order 2."""
    assert claims.order is not None
    return min(claims.order[0], 2) if scheme.startswith("gear") else claims.order[0]


def _orbit(variant: str) -> tuple[float, str]:
    eccentricity, _, scheme = variant.partition("/")
    return float(eccentricity.removeprefix("e")), scheme


def _order_variants(full: bool) -> Any:
    def variants(engine: str, schemes: dict[str, Claims]) -> tuple[str, ...]:
        return tuple(
            f"e{e:g}/{name}"
            for e in ECCENTRICITIES
            for name, claims in schemes.items()
            if claims.order is not None
            # the start's dt^2 shows only far below the corrector's own error where the orbit is eccentric
            and not (name.startswith("gear") and name != "gear2" and e > 0.5)
            and (name in RARE or (e == 0.99 and (engine, name) != ("refimpl", "velocity_verlet"))) == full
            and not (e == 0.99 and claims.order[0] == 1)
        )

    return variants


def _judge_order(laboratory: Laboratory, variant: str) -> Judged:
    e, scheme = _orbit(variant)
    nominal = nominal_order(scheme, laboratory.claims[scheme])
    numbers = step_numbers(e, COARSEST.get(nominal, 0.2), 3 if e == 0.99 else 4)
    scene = kepler_scene(e, 1, SAMPLES)
    runs = [laboratory.run(scene, Method(scheme=scheme, dt=PERIOD / n)) for n in numbers]
    errors = np.array([position_error(run, e) for run in runs])
    x = kepler.fastest(e) * PERIOD / numbers
    figure = Figure(
        f"position error over a period, e = {e:g}",
        "dt times angular speed at pericentre",
        "largest position error/a",
        "log",
        "log",
        (Series(scheme, x.tolist(), errors.tolist()),),
    )
    floor = rounding_floor(scheme, e, 1, numbers[-1])
    biased = floor * np.sqrt(numbers[-1])
    if (errors <= biased).all():
        exact = f"exact for two bodies; {SIGMAS * errors[-1] / floor:.1f} standard deviations of independent roundings"
        return round_off("largest position error/a", errors.max(), biased, WHY_BIASED, note=exact, figures=(figure,))
    slope = fitted_order(x, errors, floor)
    return order(
        "order of the position error",
        slope.value,
        nominal,
        ORDER_TOLERANCE,
        WHY_ORDER,
        uncertainty=slope.error,
        note=f"error at {numbers[0]:.0f} steps a period: {errors[0]:.2g} a",
        figures=(figure,),
    )


# -- Gear's start ------------------------------------------------------------------------------------------------------


#: In the order of what an exact start would give them.
GEAR = ("gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity")


def _judge_start(laboratory: Laboratory, scheme: str) -> Judged:
    """The error that is left once the orbit is that of the changed starting velocity has the claimed order."""
    claimed = laboratory.claims[scheme].order
    assert claimed is not None
    e, nominal = 0.5, claimed[0]
    numbers = (512 if nominal > 5 else 1024) * np.array([1, 2, 4])
    # at apocentre r''' = -mu v/r^3
    r0, v0 = AXIS * (1 + e), np.sqrt(MU * (1 - e) / (AXIS * (1 + e)))
    rest, plain = [], []
    for n in numbers:
        dt = PERIOD / n
        run = laboratory.run(kepler_scene(e, 1, SAMPLES), Method(scheme=scheme, dt=dt))
        v = v0 * (1 + MU * dt**2 / (12 * r0**3))
        a = 1 / (2 / r0 - v**2 / MU)
        exact, _ = kepler.relative_orbit(run["time"], r0 / a - 1, a, MU)
        rest.append(float(np.linalg.norm(kepler.relative(run["positions"]) - exact, axis=-1).max() / AXIS))
        true, _ = kepler.relative_orbit(run["time"], e, AXIS, MU)
        plain.append(float(np.linalg.norm(kepler.relative(run["positions"]) - true, axis=-1).max() / AXIS))
    slope = fitted_order(1 / numbers, rest, rounding_floor(scheme, e, 1, numbers[-1]))
    series = (
        Series(f"{scheme}, zero start", (PERIOD / numbers).tolist(), plain),
        Series(f"{scheme}, start accounted for", (PERIOD / numbers).tolist(), rest),
    )
    return order(
        "order of the position error, start accounted for",
        slope.value,
        nominal,
        ORDER_TOLERANCE,
        WHY_ORDER,
        uncertainty=slope.error,
        note=f"position error/a at {numbers[-1]} steps a period: {plain[-1]:.3g}, start accounted for {rest[-1]:.3g}",
        figures=(Figure("cost of the zero start, e = 0.5", "n dt", "largest position error/a", "log", "log", series),),
    )


# -- invariants --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shadow:
    """H + dt^power correction is conserved to dt^(power + gain)."""

    correction: kepler.Modified
    power: int
    gain: int


_LEAP_FROG = Shadow(kepler.kick_drift_kick, 2, 2)
#: The modified Hamiltonians of (engine, scheme): the same name may stand for different maps.
SHADOWS = {
    **{("refimpl", scheme): _LEAP_FROG for scheme in ("verlet", "leapfrog", "velocity_verlet", "gear2")},
    ("refimpl", "symplectic_euler"): Shadow(kepler.kick_drift, 1, 1),
    ("lammps", "velocity_verlet"): _LEAP_FROG,
    ("rebound", "leapfrog"): Shadow(kepler.drift_kick_drift, 2, 2),
}


def _judge_invariants(laboratory: Laboratory, scheme: str) -> Judged:
    """20 periods at e = 0.5: energy, modified energy, angular momentum."""
    e, periods = 0.5, 20
    claimed = laboratory.claims[scheme].order
    assert claimed is not None
    shadow = SHADOWS.get((laboratory.engine, scheme))
    numbers = step_numbers(e, 0.1, 3)
    energies, shadows, turning = [], [], []
    for n in numbers:
        run = laboratory.run(kepler_scene(e, periods, SAMPLES), Method(scheme=scheme, dt=PERIOD / n))
        r, v = kepler.relative(run["positions"]), kepler.relative(run["velocities"])
        energy = kepler.energy(r, v, MU) * (2 * AXIS / MU)
        energies.append(_departure(energy))
        if shadow is not None:
            correction = shadow.correction(r, v, MU) * (2 * AXIS / MU)
            shadows.append(_departure(energy + (PERIOD / n) ** shadow.power * correction))
        momentum = kepler.angular_momentum(r, v)
        # a random walk; r v <= n a^2 on the orbit, and L = n a^2 sqrt(1 - e^2)
        lever = n / PERIOD if scheme == "verlet" else 1.0
        walk = EPSILON * np.sqrt(2 / 12 * n * periods / (1 - e**2)) * lever
        turning.append(_departure(momentum / momentum[0]) / walk)
    # r and v are rounded by eps/sqrt(12); r.a and v.v are at most (1 + e)/(1 - e) n^2 a^2, and |E| = n^2 a^2/2
    rounding = SIGMAS * EPSILON * np.sqrt(2 / 12 * numbers[-1] * periods) * 2 * (1 + e) / (1 - e)
    rounding *= numbers[-1] / PERIOD if scheme == "verlet" else 1.0
    biased = np.sqrt(numbers[-1] * periods)
    if max(energies) <= rounding * biased:
        judgements = [
            round_off("departure of E/E0", max(energies), rounding * biased, WHY_BIASED),
            round_off("departure of L, in standard deviations of rounding", max(turning), SIGMAS * biased, WHY_BIASED),
        ]
        return worst(judgements, "exact for two bodies")
    series = [Series(f"{scheme}, E", (PERIOD / numbers).tolist(), energies)]
    slope = fitted_order(1 / numbers, energies, rounding)
    judgements = [
        round_off(
            "departure of L, in standard deviations of rounding",
            max(turning),
            SIGMAS,
            "a random walk by the rounding of r and v; the kicks are central",
        ),
        order(
            "order of the energy error", slope.value, min(claimed), ORDER_TOLERANCE, WHY_ORDER, uncertainty=slope.error
        ),
        bounded(
            "largest energy error, 20 periods to the first",
            energies[-1] / _departure(energy[: SAMPLES + 1]),
            DRIFT,
            WHY_DRIFT,
        ),
    ]
    if shadow is not None:
        slope = fitted_order(1 / numbers, shadows, rounding)
        expected = shadow.power + shadow.gain
        judgements.append(
            order(
                "order of the modified energy's error",
                slope.value,
                expected,
                ORDER_TOLERANCE,
                WHY_ORDER,
                uncertainty=slope.error,
            )
        )
        series.append(Series(f"{scheme}, modified E", (PERIOD / numbers).tolist(), shadows))
    figure = Figure("energy over 20 periods, e = 0.5", "n dt", "largest |E - E0|/|E0|", "log", "log", tuple(series))
    chosen = worst(judgements, f"energy error at {numbers[0]:.0f} steps a period: {energies[0]:.2g}")
    return replace(chosen, figures=(figure,))


def _departure(series: Floats) -> float:
    return float(abs(series - series[0]).max())


def _judge_drift(laboratory: Laboratory, scheme: str) -> Judged:
    """An expected failure: the energy of the other schemes must be seen to drift."""
    claimed = laboratory.claims[scheme].order
    assert claimed is not None
    e = 0.5
    number, periods = (2048, 20) if claimed[0] == 1 else (64, 100)
    run = laboratory.run(kepler_scene(e, periods, SAMPLES), Method(scheme=scheme, dt=PERIOD / number))
    energy = kepler.energy(kepler.relative(run["positions"]), kepler.relative(run["velocities"]), MU) * (2 * AXIS / MU)
    first = _departure(energy[: SAMPLES + 1])
    curve = Series(scheme, (run["time"] / PERIOD).tolist(), (energy + 1).tolist())
    return bounded(
        f"largest energy error, {periods} periods to the first",
        _departure(energy) / first,
        DRIFT,
        WHY_DRIFT,
        expected_failure=True,
        note=f"{number} steps a period; energy error in the first {first:.2g} |E0|",
        figures=(Figure(f"energy, e = 0.5, {number} steps a period", "periods", "(E - E0)/|E0|", series=(curve,)),),
    )


# -- precession --------------------------------------------------------------------------------------------------------

#: Schemes that are leap-frog seen at other times, or whose positions are leap-frog's.
TURNING = ("symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "beeman_pc", "gear2")
#: Step of the coarser run, times the angular speed at pericentre.
TURNING_STEP = 0.1


def _turning_variants(full: bool) -> Any:
    return lambda engine, schemes: tuple(
        f"e{e:g}/{name}" for e in (0.5, 0.9) for name in TURNING if name in schemes and (name in RARE) == full
    )


def _judge_precession(laboratory: Laboratory, variant: str) -> Judged:
    """Angle of the eccentricity vector per radian of mean anomaly, from apocentre to apocentre over 10 periods."""
    e, scheme = _orbit(variant)
    numbers = step_numbers(e, TURNING_STEP, 2)
    rates, theory = [], [kepler.precession(e, PERIOD / n) for n in numbers]
    for n in numbers:
        run = laboratory.run(kepler_scene(e, 10, 1), Method(scheme=scheme, dt=PERIOD / n))
        vector = kepler.eccentricity_vector(kepler.relative(run["positions"]), kepler.relative(run["velocities"]), MU)
        angle = np.unwrap(np.arctan2(vector[:, 1], vector[:, 0]))
        angle -= angle[0]
        rates.append(float(np.polyfit(run["time"], angle, 1)[0]))
    coarse, fine = np.array(rates) / np.array(theory)
    periods = run["time"] / PERIOD
    series = (
        Series(scheme, periods.tolist(), angle.tolist()),
        Series(
            f"theory, {numbers[1]:.0f} steps a period",
            periods.tolist(),
            (theory[1] * run["time"]).tolist(),
            theory=True,
        ),
    )
    return within(
        "order",
        "rate of precession/theory, extrapolated",
        (4 * fine - coarse) / 3,
        1.0,
        (PERIOD * kepler.fastest(e) / numbers[0]) ** 3,
        "terms of third and higher order in the step times the angular speed at pericentre, which extrapolation leaves",
        note=f"{coarse:.6f} and {fine:.6f} at {numbers[0]:.0f} and {numbers[1]:.0f} steps a period",
        figures=(Figure(f"precession, e = {e:g}", "periods", "angle of the apsides/rad", series=series),),
    )


# -- the limit of rounding ---------------------------------------------------------------------------------------------


def _extrapolated(laboratory: Laboratory, e: float, periods: int) -> tuple[Limit, float, Floats]:
    """Final relative position/a of velocity Verlet at no step, what rounding adds to it, and the steps a period."""
    numbers = step_numbers(e, 0.4, 1, 1)[0] * SEQUENCE
    runs = [
        laboratory.run(kepler_scene(e, periods), Method(scheme="velocity_verlet", dt=PERIOD / n), engine="refimpl")
        for n in numbers
    ]
    limit = extrapolate(1 / numbers, [kepler.relative(run["final_positions"]) / AXIS for run in runs])
    each = np.array([rounding_floor("velocity_verlet", e, periods, n * periods) for n in numbers])
    return limit, float(np.sqrt(((limit.weights * each) ** 2).sum())), numbers


def _rounding_variants(engine: str, schemes: dict[str, Claims]) -> tuple[str, ...]:
    if engine == "refimpl":  # e = 0.99 costs much, and is extrapolated against REBOUND
        return tuple(f"e{e:g}/velocity_verlet" for e in ECCENTRICITIES[:-1])
    adaptive = [name for name, claims in schemes.items() if claims.kind == "stepping" and claims.order is None]
    return tuple(f"e{e:g}/{name}" for e in ECCENTRICITIES for name in adaptive)


def _judge_rounding(laboratory: Laboratory, variant: str) -> Judged:
    e, scheme = _orbit(variant)
    exact, _ = kepler.relative_orbit(0.0, e)
    if laboratory.engine == "refimpl":
        limit, rounding, numbers = _extrapolated(laboratory, e, 3)
        return round_off(
            "position error/a after 3 periods, extrapolated to no step",
            float(np.linalg.norm(limit.value - exact)),
            limit.error + rounding,
            f"the extrapolation's own error, and {WHY_ROUNDING}, added with the weights of the extrapolation",
            note=f"{numbers[0]:.0f} to {numbers[-1]:.0f} steps a period; extrapolation {limit.error:.1g}, "
            f"rounding {rounding:.1g}",
        )
    run = laboratory.run(kepler_scene(e, 10), Method(scheme=scheme, dt=PERIOD / 1000))
    return round_off(
        "position error/a after 10 periods",
        float(np.linalg.norm(kepler.relative(run["final_positions"]) / AXIS - exact)),
        SIGMAS * kepler.rounding_error(e, 10, run.cost.steps),
        WHY_ROUNDING,
        note=f"{run.cost.steps / 10:.0f} steps a period",
    )


def _judge_against_rebound(laboratory: Laboratory, variant: str) -> Judged:
    """Velocity Verlet extrapolated to no step against IAS15, each with its own uncertainty."""
    e = float(variant.removeprefix("e"))
    reference = laboratory.run(kepler_scene(e, 1), Method(scheme="ias15", dt=PERIOD / 1000), engine="rebound")
    limit, rounding, _ = _extrapolated(laboratory, e, 1)
    theirs = SIGMAS * kepler.rounding_error(e, 1, reference.cost.steps)
    return round_off(
        "distance/a of the two final positions",
        float(np.linalg.norm(limit.value - kepler.relative(reference["final_positions"]) / AXIS)),
        limit.error + rounding + theirs,
        f"the extrapolation's own error, and of either code {WHY_ROUNDING}",
        note=f"extrapolation {limit.error:.1g}, its rounding {rounding:.1g}, IAS15's {theirs:.1g}",
    )


# -- the checks --------------------------------------------------------------------------------------------------------

_ORBITS = "Danby, Fundamentals of Celestial Mechanics (1988), chapter 6; Murray & Dermott, Solar System Dynamics (1999)"
_SHADOW = "Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), chapter IX"
_EQUATION = "r'' = -mu r/|r|^3;  E - e sin E = n t + pi,  r = a (e - cos E, -sqrt(1 - e^2) sin E)"


def _scheme_fault(name: str, old: str, new: str, breaks: str) -> Fault:
    return Fault(name, "stepping/schemes.py", old, new, breaks)


def _gravity_fault(name: str, old: str, new: str, breaks: str) -> Fault:
    return Fault(name, "stepping/forces/gravity.py", old, new, breaks)


_ORDER_FAULTS = (
    (
        "e0.5/leapfrog",
        _scheme_fault(
            "leapfrog-start",
            "return (v + 0.5 * dt * accelerate(force, r, v),)",
            "return (v,)",
            "the half-step velocity starts without its half kick: order 1",
        ),
    ),
    (
        "e0/velocity_verlet",
        _gravity_fault(
            "gravity-own-mass",
            "from_j = inverse_cube * mass[j]",
            "from_j = inverse_cube * mass[i]",
            "a body is pulled by its own mass, not by the other's",
        ),
    ),
)
_ORDER_FAULTS_FULL = (
    (
        "e0.5/beeman_pc",
        _scheme_fault(
            "beeman-start",
            "return a, accelerate(force, r - dt * v + 0.5 * dt**2 * a, v - dt * a)",
            "return a, 0.0 * a",
            "a(-dt) starts as zero: order 1",
        ),
    ),
)
_DRIFT_FAULTS = (
    (
        "gear5",
        _scheme_fault(
            "gear-two-derivatives",
            "            scaled[q] += self.corrector[q] * change\n",
            "            if q == 1 or q == 2:\n                scaled[q] += change\n",
            "r_1 and r_2 alone are corrected: velocity Verlet, whose energy does not drift",
        ),
    ),
)
_DRIFT_FAULTS_FULL = (
    (
        "euler_pc",
        _scheme_fault(
            "euler-pc-not-predicted",
            "v_new = v + dt * accelerate(force, r + dt * v, v + dt * a)",
            "v_new = v + dt * a",
            "the prediction is not used: symplectic Euler, whose energy does not drift",
        ),
    ),
)
_PRECESSION_FAULTS = (
    (
        "e0.5/velocity_verlet",
        _gravity_fault(
            "gravity-exponent",
            "inverse_cube = G / (square * sqrt(square))",
            "inverse_cube = G / (square * sqrt(square)) ** 1.000001",
            "the exponent of the law is off by 3e-6: the orbit turns by itself",
        ),
    ),
)
_PRECESSION_FAULTS_FULL = (
    (
        "e0.5/beeman_pc",
        _scheme_fault(
            "beeman-pc-coefficients",
            "r = r + dt * v + dt**2 / 6.0 * (4.0 * a - a_before)\n        v_predicted",
            "r = r + dt * v + dt**2 / 6.0 * (3.96 * a - 0.96 * a_before)\n        v_predicted",
            "the position's coefficients are 3.96 and 0.96 for 4 and 1: still of order 2, but not Verlet's",
        ),
    ),
)


def _order_check(full: bool) -> Check:
    return legacy_check(
        name="stepping/kepler-order" + _FULL * full,
        title="Order of convergence on Kepler orbits, e = 0 to 0.99, against the closed form" + _REST * full,
        equation=_EQUATION,
        criterion=f"fitted order of the largest position error over a period = claimed +- {ORDER_TOLERANCE}: "
        f"{WHY_ORDER}; 2 for Gear's schemes, whose higher derivatives start at zero",
        citation=_ORBITS,
        judge=_judge_order,
        variants=_order_variants(full),
        faults=_ORDER_FAULTS_FULL if full else _ORDER_FAULTS,
        engines=("refimpl", "lammps", "rebound"),
        tier="full" if full else "quick",
    )


def _drift_check(full: bool) -> Check:
    return legacy_check(
        name="stepping/kepler-drift" + _FULL * full,
        title="The energy of schemes that are not symplectic drifts on a Kepler orbit" + _REST * full,
        equation="E = v^2/2 - mu/r",
        criterion=f"expected failure: energy error of the whole run >= {DRIFT:g} times that of the first period",
        citation=_SHADOW,
        judge=_judge_drift,
        variants=legacy_schemes_with(partial(_drifts, full)),
        faults=_DRIFT_FAULTS_FULL if full else _DRIFT_FAULTS,
        tier="full" if full else "quick",
    )


def _drifts(full: bool, name: str, claims: Claims) -> bool:
    """Beeman's positions are Verlet's; the schemes with a zero start are the others here."""
    others = claims.order is not None and claims.symplectic is False and not name.endswith("zero_start")
    return others and not name.startswith("beeman") and (name in RARE) == full


def _precession_check(full: bool) -> Check:
    return legacy_check(
        name="stepping/kepler-precession" + _FULL * full,
        title="Precession of the apsides under leap-frog steps, against the modified Hamiltonian's" + _REST * full,
        equation="d(varpi)/d(n t) = -(n dt)^2 (4 + e^2)/(16 (1 - e^2)^3), from <H_2> by Lagrange's planetary equation",
        criterion="rate extrapolated from two steps = theory +- (omega_p dt)^3; omega_p: angular speed at pericentre",
        citation=f"{_SHADOW}; Murray & Dermott, Solar System Dynamics (1999), chapter 6",
        judge=_judge_precession,
        variants=_turning_variants(full),
        faults=_PRECESSION_FAULTS_FULL if full else _PRECESSION_FAULTS,
        engines=("refimpl", "lammps", "rebound"),
        tier="full" if full else "quick",
    )


_FULL, _REST = "-full", ": the schemes left out of the quick tier"

CHECKS = (
    *map(_order_check, (False, True)),
    legacy_check(
        name="stepping/kepler-start",
        title="Gear's zero start on a Kepler orbit: a starting velocity off by dt^2 r'''/12, full order beside that",
        equation="v(0) -> v(0) - dt^2 r'''(0)/12, r''' = -mu v/r^3 at apocentre",
        criterion=f"fitted order of what is left = that claimed for an exact start +- {ORDER_TOLERANCE}: {WHY_ORDER}",
        citation="Gear, Numerical Initial Value Problems in ODEs (1971); derivation in docs/kepler.md",
        judge=_judge_start,
        variants=lambda engine, schemes: GEAR if engine == "refimpl" else (),
        faults=(
            (
                "gear5",
                _scheme_fault(
                    "gear5-third",
                    "_GEAR5 = (3 / 20, 251 / 360, 1.0, 11 / 18",
                    "_GEAR5 = (3 / 20, 251 / 360, 1.0, 11.011 / 18",
                    "alpha_3 is off by 1e-3",
                ),
            ),
        ),
    ),
    legacy_check(
        name="stepping/kepler-invariants",
        title="Energy, modified energy and angular momentum of symplectic schemes over 20 periods of a Kepler orbit",
        equation="velocity Verlet: E + dt^2 (v.U''.v/12 - |grad U|^2/24); symplectic Euler: E - dt v.grad U/2",
        criterion="L to rounding; order of the energy error as claimed, of the modified energy's 4 (symplectic Euler: "
        f"2); no drift: error over 20 periods <= {DRIFT:g} times that of the first",
        citation=_SHADOW,
        judge=_judge_invariants,
        variants=legacy_schemes_with(lambda name, claims: claims.order is not None and bool(claims.symplectic)),
        faults=(
            (
                "velocity_verlet",
                _scheme_fault(
                    "velocity-verlet-half-kick",
                    "return r, v_half + 0.5 * dt * a, (a,)",
                    "return r, v_half + 0.5 * dt * memory[0], (a,)",
                    "the second half kick takes the old acceleration",
                ),
            ),
            (
                "symplectic_euler",
                _gravity_fault(
                    "gravity-not-central",
                    "a[p + 1] += from_j * dy",
                    "a[p + 1] += 1.0000000001 * from_j * dy",
                    "one component of the force on the later body of a pair is off by 1e-10: not central",
                ),
            ),
        ),
        engines=("refimpl", "lammps", "rebound"),
    ),
    *map(_drift_check, (False, True)),
    *map(_precession_check, (False, True)),
    legacy_check(
        name="stepping/kepler-round-off",
        title="Kepler orbits in the limit of rounding: adaptive schemes, and velocity Verlet extrapolated to no step",
        equation=_EQUATION,
        criterion=WHY_ROUNDING,
        citation=f"Brouwer, Astron. J. 46, 149 (1937); Rein & Spiegel, MNRAS 446, 1424 (2015); {_ORBITS}",
        judge=_judge_rounding,
        variants=_rounding_variants,
        faults=(
            (
                "e0.5/velocity_verlet",
                _scheme_fault(
                    "velocity-verlet-slightly",
                    "v_half = v + 0.5 * dt * memory[0]",
                    "v_half = v + 0.50000000005 * dt * memory[0]",
                    "the first half kick is too strong by 1e-10",
                ),
            ),
        ),
        engines=("refimpl", "rebound"),
    ),
    legacy_check(
        name="stepping/kepler-against-rebound",
        title="Velocity Verlet extrapolated to no step against REBOUND's IAS15, after one period",
        equation="r'' = -mu r/|r|^3",
        criterion="distance <= the extrapolation's own error + 10 standard deviations of the rounding of either",
        citation="Rein & Spiegel, MNRAS 446, 1424 (2015); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.9",
        judge=_judge_against_rebound,
        variants=lambda engine, schemes: ("e0.5", "e0.9", "e0.99") if engine == "refimpl" else (),
        faults=(
            (
                "e0.5",
                _gravity_fault(
                    "gravity-weaker",
                    "inverse_cube = G / (square * sqrt(square))",
                    "inverse_cube = 0.9999999999 * G / (square * sqrt(square))",
                    "the attraction is too weak by 1e-10",
                ),
            ),
        ),
    ),
)
