"""Two bodies under Newton's gravity: the closed form, and the errors of leap-frog steps and of rounding.

Coordinates are relative, r = r_1 - r_0, with mu = G (m_0 + m_1); energies are per reduced mass. At time 0 the bodies
are at apocentre on the +x axis and move towards +y, as `crosscheck.scene.Kepler` places them. n = sqrt(mu/a^3) is the
mean motion, P = 2 pi/n the period.

Literature: J. M. A. Danby, Fundamentals of Celestial Mechanics, 2nd ed., Willmann-Bell (1988), chapter 6; C. D. Murray
and S. F. Dermott, Solar System Dynamics, Cambridge University Press (1999), chapters 2 and 6 (perturbation equations);
E. Hairer, C. Lubich and G. Wanner, Geometric Numerical Integration, 2nd ed., Springer (2006), chapter IX (modified
Hamiltonians); D. Brouwer, Astron. J. 46, 149 (1937) (how rounding errors add up).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references import EPSILON

Floats = NDArray[np.float64]


# -- the orbit ---------------------------------------------------------------------------------------------------------


def minus_sine(x: ArrayLike) -> Floats:
    """x - sin x without cancellation.

    x: radians, any shape; relative error of the size of rounding. By derivation: Taylor's series for |x| < 1.
    """
    x = np.asarray(x, dtype=np.float64)
    square, series = x * x, np.ones_like(x)
    # x^3/6 (1 - x^2/(4 5) (1 - x^2/(6 7) (...))): what is left out is below rounding for |x| < 1
    for k in range(16, 2, -2):
        series = 1.0 - square / (k * (k + 1)) * series
    return np.where(abs(x) < 1.0, x * square / 6.0 * series, x - np.sin(x))


def eccentric_anomaly(mean_anomaly: ArrayLike, eccentricity: float) -> Floats:
    """E of Kepler's equation E - e sin E = M, both in [-pi, pi], for 0 <= e < 1; to round-off in E (1 - e cos E).

    Newton's method on f(E) = (1 - e) E + e (E - sin E) - M. f is convex on [0, pi], so from a start to the right of the
    root every iterate stays there and the descent always ends at it, to rounding. Three bounds from the right are
    M + e, M/(1 - e), and (pi^2 M/e)^(1/3) since E - sin E >= E^3/pi^2; the least of them starts it.

    mean_anomaly: M, radians, any shape. eccentricity: e. Gives radians, of the shape of M.
    """
    e = eccentricity
    mean = np.remainder(np.asarray(mean_anomaly, dtype=np.float64) + np.pi, 2 * np.pi) - np.pi
    sign, target = np.sign(mean), abs(mean)
    x = np.minimum(np.minimum(target + e, target / (1.0 - e)), np.pi)
    if e > 0:
        x = np.minimum(x, np.cbrt(np.pi**2 * target / e))
    for _ in range(60):
        defect = (1.0 - e) * x + e * minus_sine(x) - target
        new = np.maximum(x - defect / (1.0 - e * np.cos(x)), 0.0)
        if not (new < x).any():
            break
        x = np.minimum(new, x)
    return sign * x


def relative_orbit(
    time: ArrayLike, eccentricity: float, a: float = 1.0, mu: float = 1.0, phase: float = 0.0
) -> tuple[Floats, Floats]:
    """r(t), v(t), shape (..., 2), of the ellipse with its apocentre on +x; `phase` is the mean anomaly there at time 0.

    With E from pericentre, r = (-a (cos E - e), -b sin E), b = a sqrt(1 - e^2), and dE/dt = n/(1 - e cos E).

    time: t, any shape (...). eccentricity: e, 0 <= e < 1. a: semi-major axis, length. mu: length^3/time^2. phase:
    radians. Any consistent units.
    """
    t, e = np.asarray(time, dtype=np.float64), eccentricity
    n = np.sqrt(mu / a**3)
    x = eccentric_anomaly(n * t + phase - np.pi, e)
    b = a * np.sqrt((1.0 - e) * (1.0 + e))
    # cos E - e = (1 - e) - 2 sin^2(E/2): exact where it is small
    half = np.sin(0.5 * x) ** 2
    rate = n / ((1.0 - e) + 2.0 * e * half)
    r = np.stack([-a * ((1.0 - e) - 2.0 * half), -b * np.sin(x)], axis=-1)
    v = np.stack([a * np.sin(x) * rate, -b * np.cos(x) * rate], axis=-1)
    return r, v


def two_bodies(
    time: ArrayLike, masses: ArrayLike, eccentricity: float, a: float = 1.0, G: float = 1.0
) -> tuple[Floats, Floats]:
    """Positions and velocities of both bodies, shape (..., 2, 2), about their centre of mass at rest.

    time: t, any shape (...). masses: (2,), of body 0 and 1. eccentricity: e, 0 <= e < 1. a: semi-major axis of the
    relative orbit, length. G: length^3/(mass time^2). Any consistent units.
    """
    m = np.asarray(masses, dtype=np.float64)
    r, v = relative_orbit(time, eccentricity, a, G * float(m.sum()))
    share = (np.array([-m[1], m[0]]) / m.sum())[:, None]
    return share * r[..., None, :], share * v[..., None, :]


def relative(bodies: Floats) -> Floats:
    """r_1 - r_0 of positions or velocities.

    bodies: (..., 2, d), of both bodies. Gives (..., d), in the same unit.
    """
    return bodies[..., 1, :] - bodies[..., 0, :]


# -- what is conserved -------------------------------------------------------------------------------------------------


def energy(r: Floats, v: Floats, mu: float) -> Floats:
    """v^2/2 - mu/r; -mu/2a on the orbit.

    r, v: (..., 2), length and length/time. mu: length^3/time^2. Gives (...,), energy per reduced mass.
    """
    return np.asarray(0.5 * (v * v).sum(-1) - mu / np.sqrt((r * r).sum(-1)))


def angular_momentum(r: Floats, v: Floats) -> Floats:
    """r x v; sqrt(mu a (1 - e^2)) on the orbit.

    r, v: (..., 2), length and length/time. Gives (...,), length^2/time.
    """
    return np.asarray(r[..., 0] * v[..., 1] - r[..., 1] * v[..., 0])


def eccentricity_vector(r: Floats, v: Floats, mu: float) -> Floats:
    """Laplace, Runge and Lenz's vector v x L/mu - r/|r|: towards pericentre, of length e.

    r, v: (..., 2), length and length/time. mu: length^3/time^2. Gives (..., 2).
    """
    turned = np.stack([v[..., 1], -v[..., 0]], axis=-1) * angular_momentum(r, v)[..., None]
    return np.asarray(turned / mu - r / np.sqrt((r * r).sum(-1))[..., None])


# -- what a scheme conserves instead -----------------------------------------------------------------------------------
#
# A symplectic map of step h conserves H + h H_1 + h^2 H_2 + ... (Hairer, Lubich and Wanner, IX.3). With U = -mu/r,
# v.U''.v = mu (v^2/r^3 - 3 (r.v)^2/r^5) and |grad U|^2 = mu^2/r^4:


def _curvature(r: Floats, v: Floats, mu: float) -> Floats:
    square, rv = (r * r).sum(-1), (r * v).sum(-1)
    return np.asarray(mu * ((v * v).sum(-1) - 3.0 * rv**2 / square) / square**1.5)


def _steepness(r: Floats, mu: float) -> Floats:
    return np.asarray(mu**2 / (r * r).sum(-1) ** 2)


def kick_drift_kick(r: Floats, v: Floats, mu: float) -> Floats:
    """H_2 of velocity Verlet (and of Verlet and leap-frog, read out at whole steps): v.U''.v/12 - |grad U|^2/24.

    r, v: (..., 2), length and length/time. mu: length^3/time^2. Gives (...,), energy per reduced mass over time^2.
    """
    return _curvature(r, v, mu) / 12.0 - _steepness(r, mu) / 24.0


def drift_kick_drift(r: Floats, v: Floats, mu: float) -> Floats:
    """H_2 of position Verlet: |grad U|^2/12 - v.U''.v/24.

    r, v: (..., 2), length and length/time. mu: length^3/time^2. Gives (...,), energy per reduced mass over time^2.
    """
    return _steepness(r, mu) / 12.0 - _curvature(r, v, mu) / 24.0


def kick_drift(r: Floats, v: Floats, mu: float) -> Floats:
    """H_1 of symplectic Euler, velocity first: -v.grad U/2.

    r, v: (..., 2), length and length/time. mu: length^3/time^2. Gives (...,), energy per reduced mass over time.
    """
    return np.asarray(-0.5 * mu * (r * v).sum(-1) / (r * r).sum(-1) ** 1.5)


Modified = Callable[[Floats, Floats, float], Floats]


class Shadow(NamedTuple):
    """Modified Hamiltonian of a symplectic map of step dt, H + dt^power correction, conserved to dt^(power + gain).

    correction: of (r, v, mu), r and v of shape (..., 2), as `kick_drift_kick`. power: of dt, the order of the map.
    gain: 2 for a reversible map, whose modified Hamiltonian has even powers of dt alone, else 1.
    """

    correction: Modified
    power: int
    gain: int


#: Of velocity Verlet, and of Verlet and leap-frog read out at whole steps; of position Verlet; of symplectic Euler.
KICK_DRIFT_KICK = Shadow(kick_drift_kick, 2, 2)
DRIFT_KICK_DRIFT = Shadow(drift_kick_drift, 2, 2)
KICK_DRIFT = Shadow(kick_drift, 1, 1)


def precession(eccentricity: float, n_dt: float) -> float:
    """Turn of the apsides, in radians per radian of mean anomaly, under leap-frog steps; to leading order in n dt.

    -(n dt)^2 (4 + e^2)/(16 (1 - e^2)^3): the orbit turns backwards. From Lagrange's equation for the pericentre,
    d(varpi)/dt = -sqrt(1 - e^2)/(n a^2 e) d<H_2>/de, with the average over the orbit
    <H_2> = mu^2/(48 a^4) (2 + e^2) (1 - e^2)^(-5/2). That is the same for kick-drift-kick and drift-kick-drift: one is
    the other seen half a step later. It is also symplectic Euler's, which is leap-frog with the velocities of half a
    step before, and Beeman's, whose positions are Verlet's.

    eccentricity: e, 0 <= e < 1. n_dt: n dt, radians of mean anomaly a step; what is left out is of order (n dt)^4.
    """
    e2 = eccentricity**2
    return -(n_dt**2) * (4.0 + e2) / (16.0 * (1.0 - e2) ** 3)


# -- what Gear's schemes make of a start without higher derivatives ----------------------------------------------------


def zero_start_orbit(time: ArrayLike, eccentricity: float, a: float, mu: float, dt: float) -> tuple[Floats, Floats]:
    """r(t), v(t), shape (..., 2), of the orbit that Gear's schemes follow if r_3 = d^3r/dt^3 and higher start as zero.

    In the limit of small steps dt, the missing third derivative leaves the velocity off by -dt^2 r_3(0)/12 for ever
    (the left eigenvector of the Nordsieck step that measures the velocity is (0, 1, 1, 1/2, 0, ...), whatever the
    corrector), and the missing fourth nothing. At apocentre r_3 = -mu v/r^3: the body starts too fast by
    mu v dt^2/(12 r^3). What is left out is of order dt^4. Source: C. W. Gear, Numerical Initial Value Problems in
    Ordinary Differential Equations, Prentice-Hall (1971); the derivation is in docs/kepler.md.

    time: t, any shape (...). eccentricity: e, 0 <= e < 1. a: semi-major axis, length. mu: length^3/time^2. dt: time.
    Any consistent units.
    """
    r0, v0 = a * (1 + eccentricity), np.sqrt(mu * (1 - eccentricity) / (a * (1 + eccentricity)))
    v = v0 * (1 + mu * dt**2 / (12 * r0**3))
    axis = 1 / (2 / r0 - v**2 / mu)
    return relative_orbit(time, r0 / axis - 1, axis, mu)


# -- what rounding does ------------------------------------------------------------------------------------------------


def fastest(eccentricity: float) -> float:
    """Angular speed at pericentre, in units of n: sqrt(1 + e)/(1 - e)^(3/2).

    eccentricity: e, 0 <= e < 1.
    """
    return float(np.sqrt(1.0 + eccentricity) / (1.0 - eccentricity) ** 1.5)


def rounding_error(eccentricity: float, periods: float, steps: float) -> float:
    """Standard deviation of the final relative position, in units of a, if every step rounds r and v independently.

    Each addition r + dt v, v + dt a leaves an error of eps/sqrt(12) times the value in every component. An error at
    time t is carried to the end by d x(T)/d x(t) = J(T) J(t)^-1, with J the derivative of the closed form with respect
    to its elements. The share of the mean motion grows with T - t: the sum goes as steps^(1/2) periods (Brouwer).

    eccentricity: e, 0 <= e < 1. periods: length of the run. steps: in all of it.
    """
    return EPSILON * (steps / 12.0) ** 0.5 * _carried(eccentricity, periods)


def energy_rounding(eccentricity: float, periods: float, per_period: float) -> float:
    """Bound on the standard deviation of E/|E_0| after `periods` of `per_period` independent roundings of r and v each.

    r and v are rounded by eps/sqrt(12) of themselves; that changes the energy by r.a and v.v, which are at most
    (1 + e)/(1 - e) n^2 a^2, and |E| = n^2 a^2/2. A random walk: the deviation grows as steps^(1/2) (Brouwer).

    eccentricity: e, 0 <= e < 1. periods: length of the run. per_period: roundings a period.
    """
    walk = np.sqrt(2 / 12 * per_period * periods)
    return float(EPSILON * walk * 2 * (1 + eccentricity) / (1 - eccentricity))


def momentum_rounding(eccentricity: float, periods: float, per_period: float) -> float:
    """Bound on the standard deviation of L/L_0 after `periods` of `per_period` independent roundings of r and v each.

    r v <= n a^2 on the orbit, and L = n a^2 sqrt(1 - e^2). Central kicks change L by rounding alone.

    eccentricity: e, 0 <= e < 1. periods: length of the run. per_period: roundings a period.
    """
    return float(EPSILON * np.sqrt(2 / 12 * per_period * periods / (1 - eccentricity**2)))


@cache
def _carried(eccentricity: float, periods: float) -> float:
    """Root mean square, over the time t, of sum_k (d x_j(T)/d x_k(t) x_k(t))^2, j = 1, 2, to the power 1/2."""
    e = max(eccentricity, 1e-2)  # the elements of a circle are degenerate, its errors are not
    nodes = 400 * max(1, round(periods))
    # even in the eccentric anomaly, counted from apocentre, so that pericentre is resolved
    anomaly = 2 * np.pi * periods * (np.arange(nodes) + 0.5) / nodes
    t, weight = anomaly + e * np.sin(anomaly), 1.0 + e * np.cos(anomaly)
    final = _element_derivatives(np.array([2 * np.pi * periods]), e)[0]
    carried = (final @ np.linalg.inv(_element_derivatives(t, e)))[:, :2, :]
    state = np.concatenate(relative_orbit(t, e), axis=-1)
    return float(np.sqrt((((carried * state[:, None, :]) ** 2).sum((1, 2)) * weight).mean()))


def _element_derivatives(t: Floats, e: float) -> Floats:
    """d(x, y, vx, vy)/d(a, e, phase, orientation) at times t, shape (..., 4, 4), for a = mu = 1."""
    h = 1e-6 * (1.0 - e)

    def state(**element: float) -> Floats:
        return np.concatenate(relative_orbit(t, **({"eccentricity": e} | element)), axis=-1)

    def difference(name: str, centre: float) -> Floats:
        return (state(**{name: centre + h}) - state(**{name: centre - h})) / (2 * h)

    x, y, vx, vy = np.moveaxis(state(), -1, 0)
    turn = np.stack([-y, x, -vy, vx], axis=-1)
    columns = [difference("a", 1.0), difference("eccentricity", e), difference("phase", 0.0), turn]
    return np.stack(columns, axis=-1)
