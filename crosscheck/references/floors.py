"""Grains on vibrating floors: gains of energy in single impacts and in whole visits, and flights between impacts.

z points up. A particle of mass 1 comes down with velocity -u, u > 0, onto a plate of infinite mass and restitution e,
whose velocity is V, positive upwards, of amplitude V0 = A omega. It leaves with v' = (1 + e) V + e u. In the limit of
high frequency, A to 0 at a given V0, the particle meets the plate at z = 0 with some phase. Units are the caller's, but
where V0 = 1 is said.

Literature: S. McNamara and J.-L. Barrat, Phys. Rev. E 55, 7767 (1997); R. Soto, Phys. Rev. E 69, 061305 (2004).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import Estimate

Floats = NDArray[np.float64]
#: Distribution of the phases that a floor draws: all alike, or weighted with the speed of approach.
Law = Literal["uniform", "flux"]


def rebound(u: ArrayLike, plate: ArrayLike, restitution: float = 1.0) -> Floats:
    """v' = (1 + e) V + e u, positive upwards; 2 V + u on an elastic plate. It may be negative where V < 0.

    u: speed downwards, plate: V, of shapes that broadcast, one unit of velocity. restitution: e, 0 to 1.
    """
    return np.asarray((1 + restitution) * np.asarray(plate) + restitution * np.asarray(u), dtype=np.float64)


def uniform_phase_density(plate: ArrayLike, amplitude: float) -> Floats:
    """p(V) = 1/(pi sqrt(V0^2 - V^2)) for |V| < V0: a plate seen at a time drawn at random, whatever u.

    plate: V, any shape, and amplitude: V0, in one unit of velocity. Gives 1/velocity, 0 for |V| >= V0.
    """
    x = np.asarray(plate, dtype=np.float64) / amplitude
    inside = abs(x) < 1
    return np.where(inside, 1 / (np.pi * amplitude * np.sqrt(np.where(inside, 1 - x * x, 1.0))), 0.0)


def flux_phase_density(plate: ArrayLike, u: float, amplitude: float) -> Floats:
    """p(V) proportional to (u + V)_+ / sqrt(V0^2 - V^2): phases weighted with the relative speed of approach.

    For u >= V0 the law of a vibrating plate's first impact in the limit: the path of each particle crosses the plate's
    once, and crossings are as dense as the relative speed. For u < V0 the path may cross more than once, of which only
    the first is an impact. A particle that leaves slowly is hit again: one visit is one impact for u >= 3 V0 only.
    `visit_gain` has the visit as a whole.

    plate: V, any shape; u: speed of approach; amplitude: V0; in one unit of velocity. Gives 1/velocity.
    """
    v = np.asarray(plate, dtype=np.float64)
    return uniform_phase_density(v, amplitude) * np.maximum(u + v, 0.0) / flux_mean_approach(u, amplitude)


def flux_mean_approach(u: float, amplitude: float) -> float:
    """<(u + V)_+> over uniform phases: u for u >= V0, else (u (pi - acos(u/V0)) + sqrt(V0^2 - u^2))/pi.

    u: speed of approach, and amplitude: V0, in one unit of velocity.
    """
    if u >= amplitude:
        return u
    return float((u * (np.pi - np.arccos(u / amplitude)) + (amplitude**2 - u**2) ** 0.5) / np.pi)


def uniform_phase_gain(u: float, amplitude: float, restitution: float = 1.0) -> float:
    """Mean energy gained at an impact under `uniform_phase_density`, V0^2 for e = 1.

    ((1 + e)^2 V0^2/2 - (1 - e^2) u^2)/2, for all u; it counts impacts with V < -u, which no plate makes.

    u: speed of approach, and amplitude: V0, in one unit of velocity. restitution: e. Gives energy per mass.
    """
    return 0.5 * ((1 + restitution) ** 2 * amplitude**2 / 2 - (1 - restitution**2) * u**2)


def flux_phase_gain(u: float, amplitude: float, restitution: float = 1.0) -> float:
    """Mean energy gained at an impact under `flux_phase_density`; 2 V0^2 for e = 1 and u >= V0.

    For u >= V0, where <V> = V0^2/2u and <V^2> = V0^2/2: ((1 + e)^2 V0^2/2 + 2 e (1 + e) V0^2/2 - (1 - e^2) u^2)/2.
    Below V0 by quadrature over the phase, to 1e-10.

    u: speed of approach, and amplitude: V0, in one unit of velocity. restitution: e. Gives energy per mass.
    """
    e = restitution
    if u >= amplitude:
        return 0.5 * ((1 + e) ** 2 * amplitude**2 / 2 + e * (1 + e) * amplitude**2 - (1 - e**2) * u**2)
    from scipy.integrate import quad

    # V = V0 cos(phase), and u + V > 0 up to the phase acos(-u/V0)
    last = np.arccos(-u / amplitude)

    def gain(phase: float) -> float:
        plate = amplitude * np.cos(phase)
        return float((u + plate) * 0.5 * (rebound(u, plate, e) ** 2 - u * u))

    total, _ = quad(gain, 0.0, last, epsabs=0, epsrel=1e-11)
    return float(total / np.pi / flux_mean_approach(u, amplitude))


def visit_gain(u: float, restitution: float = 1.0, phases: int = 4000) -> Estimate:
    """Mean energy gained in a whole visit to the plate in the limit of high frequency, V0 = 1, from `plate_visit`.

    Mean over equally spaced phases. Elastic: 1.667, 2.060, 2.087, 2.140, 2.134, 2 for u = 0.25, 0.5, 1, 1.5, 2, 3,
    where `flux_phase_gain` has 1.575, 1.774 and then 2, and a uniform phase 1. The gain has jumps as a function of the
    phase, each of at most 2 (1 + u) and off by one phase: the doubt is that of four of them.

    u: speed of approach, in units of V0. restitution: e, 0 to 1. phases: how many. Energy per mass, in units of V0^2.
    RuntimeError as `plate_visit`.
    """
    gains = [
        0.5 * (plate_visit(u, phase, restitution).velocity ** 2 - u * u)
        for phase in 2 * np.pi * (np.arange(phases) + 0.5) / phases
    ]
    return Estimate(float(np.mean(gains)), doubt=8 * (1 + u) / phases)


def sawtooth_gain(u: float, amplitude: float, restitution: float = 1.0) -> float:
    """Energy gained on a plate that always moves up with V0, ((1 + e) V0 + e u)^2/2 - u^2/2: 2 V0 (V0 + u) for e = 1.

    u: speed of approach, and amplitude: V0, in one unit of velocity. restitution: e. Gives energy per mass.
    """
    return float(0.5 * (rebound(u, amplitude, restitution) ** 2 - u * u))


def plate_impact_time(
    height: float,
    velocity: float,
    time: float,
    amplitude: float,
    omega: float,
    gravity: float = 0.0,
    horizon: float = np.inf,
) -> float:
    """First t > `time` at which z = height + velocity s - g s^2/2, s = t - time, meets A cos(omega t); long double.

    With F(s) the gap and M = g + A omega^2 >= |F''|, no root lies before s + (F' + sqrt(F'^2 + 2 M F))/M: steps of that
    length go up to the first root from below, cannot pass it, and are Newton's at the end (linear at a grazing hit). A
    particle that leaves the plate starts with F = 0, F' > 0. Infinity if the gap is still open after `horizon`.
    ValueError if the particle starts below the plate, or on it with F' <= 0.

    height: of the particle at `time`, length. velocity: positive upwards. amplitude: A, length. omega: radians per
    time. gravity: g, length/time^2. horizon: time after `time`. Any consistent units.
    """
    real = np.longdouble
    h, v, t0, a, w, g = (real(x) for x in (height, velocity, time, amplitude, omega, gravity))
    bound = g + a * w * w
    rounding = 8 * np.finfo(real).eps * (abs(h) + a)
    # on the plate, but for what float64 rounds of the height and the phase
    touching = 8 * np.finfo(np.float64).eps * (abs(h) + a * (1 + w * abs(t0)))

    def gap(s: np.longdouble) -> tuple[np.longdouble, np.longdouble]:
        phase = w * (t0 + s)
        return h + v * s - g * s * s / 2 - a * np.cos(phase), v - g * s + a * w * np.sin(phase)

    s = real(0)
    f, slope = gap(s)
    if f < -touching or (f <= touching and slope <= 0):
        raise ValueError("the particle must start above the plate, or on it and leave")
    f = real(0) if f <= touching else f
    while True:
        step = (slope + np.sqrt(slope * slope + 2 * bound * f)) / bound if slope > 0 else _falling(f, slope, bound)
        new = s + step
        if new > horizon:
            return float(np.inf)
        f, slope = gap(new)
        if f <= rounding or new == s:
            return float(t0 + new)
        s = new


def _falling(f: np.longdouble, slope: np.longdouble, bound: np.longdouble) -> np.longdouble:
    """(F' + sqrt(F'^2 + 2 M F))/M for F' <= 0, without cancellation."""
    return np.longdouble(2 * f / (np.sqrt(slope * slope + 2 * bound * f) - slope))


class Visit(NamedTuple):
    """Plate velocity at the first impact, velocity on leaving, and the number of impacts of one visit to the plate.

    plate: V at the first impact, and velocity: of the particle that leaves, positive upwards, in units of V0. impacts:
    their number.
    """

    plate: float
    velocity: float
    impacts: int


def plate_visit(u: float, phase: float, restitution: float = 1.0, most: int = 1000) -> Visit:
    """One visit to a sinusoidal plate in the limit of high frequency, exactly; velocities in units of V0.

    In units A = omega = V0 = 1 without gravity (it does nothing in the limit) the particle comes from z = 2 with
    velocity -u, u > 0, when the plate z = cos t has the phase `phase`; for a phase uniform in [0, 2 pi) this is the law
    that finite amplitudes converge to. It ends when the particle is above z = 1 and rises. RuntimeError after `most`
    impacts (restitution < 1 lets a particle settle on the plate).

    u: speed of approach, in units of V0. phase: radians. restitution: e, 0 to 1. most: impacts.
    """
    height, velocity, time = 2.0, -u, phase
    first = np.nan
    for impacts in range(1, most + 1):
        # one that rises passes z = 1 after at most 2/velocity; one that falls meets the plate before z = -1
        horizon = 2 / velocity + 1e-9 if velocity > 0 else np.inf
        hit = plate_impact_time(height, velocity, time, 1.0, 1.0, horizon=horizon)
        if hit == np.inf:
            return Visit(first, velocity, impacts - 1)
        plate = -np.sin(hit)
        first = plate if impacts == 1 else first
        velocity = (1 + restitution) * plate - restitution * velocity
        height, time = float(np.cos(hit)), hit
    raise RuntimeError(f"{most} impacts in one visit")


class Flight(NamedTuple):
    """Height and velocity after an interval, and the number of impacts in it.

    height: length. velocity: positive upwards, length/time. impacts: their number.
    """

    height: float
    velocity: float
    impacts: int


def flight(
    height: float, velocity: float, time: float, span: float, amplitude: float, omega: float, gravity: float = 1.0
) -> Flight:
    """An elastic ball above the floor A cos(omega t), from impact to impact, by `plate_impact_time`.

    height, velocity: of the ball at `time`, above the floor or leaving it, length and length/time. span: length of the
    interval, time. amplitude: A, length; omega: 2 pi times the frequency, 1/time. gravity: g, length/time^2. Any
    consistent units. ValueError if the ball starts below the floor.
    """
    end, impacts = time + span, 0
    while True:
        hit = plate_impact_time(height, velocity, time, amplitude, omega, gravity, horizon=end - time)
        s = min(hit, end) - time
        height, velocity = height + velocity * s - gravity * s * s / 2, velocity - gravity * s
        if hit >= end:
            return Flight(height, velocity, impacts)
        plate = -amplitude * omega * float(np.sin(omega * hit))
        height, velocity, time = amplitude * float(np.cos(omega * hit)), 2 * plate - velocity, hit
        impacts += 1


def random_visit_gain(speed: float, law: Law) -> float:
    """Mean energy gained in a visit to an elastic wall at z = 0 that draws V = cos(phase), V > -u, at each impact.

    G(u) = <((2 V + u)^2 - u^2)/2 + G(-2 V - u) [2 V + u < 0]>: a particle that does not leave hits again at once.
    Solved by iteration on a grid of u in [0, 2], where alone that happens; for u >= 2 it is the mean of one impact,
    `uniform_phase_gain` or `flux_phase_gain`. Error below 1e-3. speed: u, in units of V0 = 1. law: of the phases
    (McNamara and Barrat 1997; Soto 2004).
    """
    plates = np.cos(np.pi * (np.arange(500) + 0.5) / 500)
    grid = np.append(np.linspace(0.0, 2.0, 101)[1:], speed)[:, None]
    weights = np.where(plates > -grid, 1.0 if law == "uniform" else grid + plates, 0.0)
    weights /= weights.sum(axis=1, keepdims=True)
    out = 2 * plates + grid
    once = (weights * 0.5 * (out**2 - grid**2)).sum(axis=1)
    gains = once
    # at most 0.6 hit again: 40 impacts are more than enough
    for _ in range(40):
        again = np.where(out < 0, np.interp(-out, grid[:-1, 0], gains[:-1]), 0.0)
        gains = once + (weights * again).sum(axis=1)
    return float(gains[-1])
