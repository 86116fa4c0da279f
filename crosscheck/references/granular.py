"""Granular gases: impact rules, cooling, rough particles, collapse, the bouncing ball, and vibrating floors.

k_B = 1. alpha is the coefficient of normal restitution. Tangential restitution is alpha_t, v'_t = alpha_t v_t at the
contact: +1 smooth, -1 perfectly rough; much of the literature writes beta = -alpha_t. q = I/(m R^2): 2/5 solid spheres,
1/2 disks; the literature's kappa = 4 I/(m sigma^2) is q. Relative velocities are g = v_1 - v_2, the unit normal n
points from 2 to 1, so that g.n < 0 before an impact. Rates of collision count a particle's own collisions.

Literature: P. K. Haff, J. Fluid Mech. 134, 401 (1983); T. P. C. van Noije and M. H. Ernst, Granul. Matter 1, 57 (1998);
M. Huthmann and A. Zippelius, Phys. Rev. E 56, R6275 (1997); A. Santos, G. M. Kremer and M. dos Santos, Phys. Fluids 23,
030604 (2011); O. R. Walton, in Particulate Two-Phase Flow, ed. M. C. Roco (1993); S. F. Foerster et al., Phys. Fluids
6, 1108 (1994); S. McNamara and W. R. Young, Phys. Fluids A 4, 496 (1992); T. Zhou and L. P. Kadanoff, Phys. Rev. E 54,
623 (1996); B. Bernu and R. Mazighi, J. Phys. A 23, 5745 (1990).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import Estimate

Floats = NDArray[np.float64]


# -- impact ------------------------------------------------------------------------------------------------------------


class Body(NamedTuple):
    """Mass, radius, velocity (3,), angular velocity (3,) and q = I/(m R^2); a disk moves in the plane z = 0.

    Mass infinity: a wall, which moves as it likes; its radius is 0.
    """

    mass: float
    radius: float
    velocity: Floats
    spin: Floats
    q: float = 0.4

    @property
    def inertia(self) -> float:
        return self.q * self.mass * self.radius**2


class Impact(NamedTuple):
    """Velocities and spins after an impact, the impulse on body 1, and whether the contact slid."""

    velocities: tuple[Floats, Floats]
    spins: tuple[Floats, Floats]
    impulse: Floats
    sliding: bool


def contact_velocity(one: Body, two: Body, normal: Floats) -> Floats:
    """v_1 - v_2 - (R_1 w_1 + R_2 w_2) x n: of the surfaces that touch, n from 2 to 1."""
    spin = one.radius * one.spin + two.radius * two.spin
    return np.asarray(one.velocity - two.velocity - np.cross(spin, normal))


def impact(
    one: Body,
    two: Body,
    normal: Floats,
    alpha: float,
    alpha_t: float = 1.0,
    static_friction: float = np.inf,
    kinetic_friction: float = np.inf,
) -> Impact:
    """Rough impact with Coulomb's law on the impulses (Walton 1993; Foerster et al. 1994).

    Normal impulse J_n = (1 + alpha) mu |g_n|, mu the reduced mass. The sticking contact gives g'_t = alpha_t g_t, with
    tangential impulse m_t (1 - alpha_t) |g_t|, 1/m_t = 1/mu + R_1^2/I_1 + R_2^2/I_2. If that exceeds static_friction
    J_n, it is kinetic_friction J_n against the slip instead. ValueError if the bodies do not approach.
    """
    g = contact_velocity(one, two, normal)
    approach = float(g @ normal)
    if approach >= 0:
        raise ValueError("the bodies do not approach")
    bodies = (one, two)
    inverse = sum(1 / body.mass for body in bodies)
    turning = sum(0.0 if np.isinf(body.mass) else 1 / (body.q * body.mass) for body in bodies)
    normal_impulse = -(1 + alpha) * approach / inverse
    slip = g - approach * normal
    tangential = (alpha_t - 1) / (inverse + turning) * slip
    size = float(np.linalg.norm(tangential))
    sliding = size > static_friction * normal_impulse
    if sliding:
        tangential = tangential * (kinetic_friction * normal_impulse / size)
    impulse = normal_impulse * normal + tangential
    velocities, spins = [], []
    for body, sign in ((one, 1.0), (two, -1.0)):
        velocities.append(body.velocity + sign * impulse / body.mass)
        # the arm points from the centre to the contact: -R n for body 1, +R n for body 2, and the impulse changes sign
        turn = np.zeros(3) if np.isinf(body.mass) else -body.radius / body.inertia * np.cross(normal, tangential)
        spins.append(body.spin + turn)
    return Impact((velocities[0], velocities[1]), (spins[0], spins[1]), impulse, sliding)


def sliding_limit(alpha: float, alpha_t: float, static_friction: float, q: float) -> float:
    """|g_t|/|g_n| above which like bodies slide: static_friction (1 + alpha) (1 + 1/q)/(1 - alpha_t).

    Foerster's cot(gamma_0); 1 + 1/q = 7/2 for solid spheres, 3 for disks.
    """
    return static_friction * (1 + alpha) * (1 + 1 / q) / (1 - alpha_t)


def dissipated_energy(normal: ArrayLike, tangential: ArrayLike, alpha: float, alpha_t: float, q: float) -> Floats:
    """Energy lost by like bodies of mass 1 that stick: ((1 - alpha^2) g_n^2 + (q/(1+q)) (1 - alpha_t^2) g_t^2)/4."""
    n, t = np.asarray(normal, dtype=np.float64), np.asarray(tangential, dtype=np.float64)
    return np.asarray(0.25 * ((1 - alpha**2) * n**2 + q / (1 + q) * (1 - alpha_t**2) * t**2))


# -- homogeneous cooling of smooth particles ---------------------------------------------------------------------------


def fourth_cumulant(alpha: float, dimension: int) -> float:
    """a_2 = <c^4> 4/(d (d+2)) - 1 with <c^2> = d/2, linear Sonine theory (van Noije and Ernst 1998).

    16 (1 - alpha) (1 - 2 alpha^2)/(9 + 24 d - (41 - 8 d) alpha + 30 (1 - alpha) alpha^2). `FOURTH_CUMULANTS` says how
    far it is off.
    """
    d = dimension
    top = 16 * (1 - alpha) * (1 - 2 * alpha**2)
    return top / (9 + 24 * d - (41 - 8 * d) * alpha + 30 * (1 - alpha) * alpha**2)


#: (dimension, alpha): a_2 by direct simulation of the Boltzmann equation, own runs of 4e4 particles, momentum removed.
FOURTH_CUMULANTS = {
    (2, 0.95): Estimate(-0.0202, 0.0015),
    (2, 0.8): Estimate(-0.0283, 0.0015),
    (2, 0.7): Estimate(-0.0022, 0.0015),
    (2, 0.5): Estimate(0.0731, 0.0015),
    (2, 0.3): Estimate(0.1517, 0.0015),
    (3, 0.95): Estimate(-0.0107, 0.0015),
    (3, 0.8): Estimate(-0.0143, 0.0015),
    (3, 0.7): Estimate(-0.0018, 0.0015),
    (3, 0.5): Estimate(0.0497, 0.0015),
    (3, 0.3): Estimate(0.1034, 0.0015),
}


def moment_ratio(a2: float, dimension: int) -> float:
    """<v^4>/<v^2>^2 = (1 + 2/d) (1 + a_2)."""
    return (1 + 2 / dimension) * (1 + a2)


def rate_factor(a2: float) -> float:
    """Collision rate over that of a Maxwellian at the same temperature, 1 - a_2/16, linear in a_2; d = 2 and 3."""
    return 1 - a2 / 16


def cooling_rate(alpha: float, dimension: int, collision_rate: float, a2: float = 0.0) -> float:
    """zeta = -dln T/dt = (1 - alpha^2) w/d (1 + 3 a_2/16), w a particle's collision rate in a Maxwellian gas at T."""
    return (1 - alpha**2) * collision_rate / dimension * (1 + 3 * a2 / 16)


def haff(time: ArrayLike, temperature: float, rate: float) -> Floats:
    """T(t) = T_0/(1 + zeta_0 t/2)^2; rate: zeta_0, the cooling rate at time 0. While the gas stays homogeneous."""
    return np.asarray(temperature / (1 + 0.5 * rate * np.asarray(time, dtype=np.float64)) ** 2)


def haff_collisions(time: ArrayLike, rate: float, collision_rate: float) -> Floats:
    """Collisions of one particle up to time t, (2 w_0/zeta_0) ln(1 + zeta_0 t/2)."""
    return np.asarray(2 * collision_rate / rate * np.log1p(0.5 * rate * np.asarray(time, dtype=np.float64)))


def temperature_after(collisions: ArrayLike, alpha: float, dimension: int, a2: float = 0.0) -> Floats:
    """T/T_0 = exp(-(1 - alpha^2) s/d (1 + 3 a_2/16)/(1 - a_2/16)) after s collisions of each particle."""
    s = np.asarray(collisions, dtype=np.float64)
    return np.asarray(np.exp(-(1 - alpha**2) * s / dimension * (1 + 3 * a2 / 16) / rate_factor(a2)))


# -- homogeneous cooling of rough particles ----------------------------------------------------------------------------


def rotational_freedoms(dimension: int) -> int:
    """1 of a disk, 3 of a sphere."""
    return {2: 1, 3: 3}[dimension]


def rough_rates(
    translational: float, rotational: float, alpha: float, alpha_t: float, q: float, dimension: int, rate: float = 1.0
) -> tuple[float, float]:
    """dT_tr/dt and dT_rot/dt of like rough particles without friction limit, all velocities Maxwellian.

    rate: a particle's collision rate w at T_tr. With x = T_rot/T_tr, c = q (1 - alpha_t)/(2 (1 + q)) and d - 1
    tangents: dT_tr/dt = (w T_tr/d) [-(1 - alpha^2) + 2 (d-1) (-c + c^2 (1 + x/q))] and dT_rot/dt = (2 (d-1) w
    T_tr/d_rot) (-c x/q + (c^2/q) (1 + x/q)). Flux-weighted means <g_n^2> = 4 T_tr, <g_t^2> = 2 (d-1) T_tr (1 + x/q).
    """
    x, c, tangents = rotational / translational, q * (1 - alpha_t) / (2 * (1 + q)), dimension - 1
    spread = 1 + x / q
    energy = -(1 - alpha**2) + 2 * tangents * (-c + c * c * spread)
    turning = 2 * tangents * (-c * x / q + c * c / q * spread)
    return rate * translational / dimension * energy, rate * translational / rotational_freedoms(dimension) * turning


def rough_ratio(alpha: float, alpha_t: float, q: float, dimension: int) -> float:
    """T_rot/T_tr of the homogeneous cooling state, Maxwellian approximation; alpha_t < 1.

    theta = h + sqrt(1 + h^2) for spheres, h = (1 + q)^2/(2 q (1 - alpha_t)^2) [1 - alpha^2 - (1 - q)/(1 + q) (1 -
    alpha_t^2)] (Huthmann and Zippelius 1997; Santos et al. 2011); for disks the positive root of the same balance,
    dln T_tr/dt = dln T_rot/dt. 1 to 8 % above simulation, `ROUGH_RATIOS`. ValueError for smooth particles.
    """
    if alpha_t >= 1:
        raise ValueError("the spins of smooth particles do not change: there is no such ratio")
    d, dr, tangents = dimension, rotational_freedoms(dimension), dimension - 1
    c = q * (1 - alpha_t) / (2 * (1 + q))
    # [-(1 - a^2) + 2 t (-c + c^2 (1 + x/q))]/d = (2 t/(dr x)) (-c x/q + (c^2/q) (1 + x/q)), times x: a quadratic in x
    square = 2 * tangents * c * c / (q * d)
    linear = (-(1 - alpha**2) + 2 * tangents * (-c + c * c)) / d - 2 * tangents / dr * (-c / q + c * c / q**2)
    constant = -2 * tangents * c * c / (dr * q)
    return float((-linear + (linear**2 - 4 * square * constant) ** 0.5) / (2 * square))


#: (dimension, q, alpha, alpha_t): T_rot/T_tr by direct simulation of the Boltzmann equation, own runs; 0.5 % uncertain.
ROUGH_RATIOS = {
    (3, 0.4, 0.9, 0.0): Estimate(0.546, 0.003),
    (3, 0.4, 0.9, -0.5): Estimate(0.856, 0.0045),
    (3, 0.4, 0.8, 0.0): Estimate(0.785, 0.004),
    (3, 0.4, 0.9, -0.95): Estimate(1.102, 0.0055),
    (2, 0.5, 0.9, 0.0): Estimate(0.443, 0.0025),
    (2, 0.5, 0.9, -0.5): Estimate(0.770, 0.004),
}


# -- collapse and the bouncing ball ------------------------------------------------------------------------------------

#: Three particles on a line collapse if alpha is below 7 - 4 sqrt 3 (McNamara and Young 1992).
THREE_PARTICLE_COLLAPSE = 7 - 4 * 3**0.5
#: In two and three dimensions that collapse is stable below 9 - 4 sqrt 5 (Zhou and Kadanoff 1996).
STABLE_COLLAPSE = 9 - 4 * 5**0.5


def wall_collapse(number: int) -> float:
    """alpha below which N particles thrown at a wall, all restitutions alike, collapse: tan^2(pi/4 (1 - 1/N)).

    Bernu and Mazighi (1990). The wall has the particles' restitution: it stands for the mirror image of the N, and 2 N
    free particles have the same limit (3, put for 2 N, gives 7 - 4 sqrt 3). One particle never collapses: 0. From
    memory of the literature, checked for N = 2 ... 5 against the eigenvalues of waves of collisions.
    """
    return float(np.tan(np.pi / 4 * (1 - 1 / number)) ** 2)


class BouncingBall(NamedTuple):
    """A ball dropped from `height` on a floor at rest at time 0, with restitution alpha < 1; a point."""

    height: float
    alpha: float
    gravity: float

    @property
    def fall(self) -> float:
        """Time of the first impact, sqrt(2 h/g)."""
        return (2 * self.height / self.gravity) ** 0.5

    @property
    def rest(self) -> float:
        """Time by which infinitely many impacts are over: sqrt(2 h/g) (1 + alpha)/(1 - alpha)."""
        return self.fall * (1 + self.alpha) / (1 - self.alpha)

    @property
    def path(self) -> float:
        """Length of the whole path, h (1 + alpha^2)/(1 - alpha^2)."""
        return self.height * (1 + self.alpha**2) / (1 - self.alpha**2)

    def apex(self, bounce: int) -> float:
        """Height after the given number of impacts, h alpha^(2 k)."""
        return self.height * self.alpha ** (2 * bounce)

    def impact_time(self, bounce: int) -> float:
        """Time of impact 1, 2, ...: fall (1 + 2 (alpha + ... + alpha^(k-1)))."""
        a = self.alpha
        return self.fall * (1 + 2 * a * (1 - a ** (bounce - 1)) / (1 - a))


# -- vibrating floors --------------------------------------------------------------------------------------------------
#
# z points up. A particle comes down with velocity -u, u > 0; the plate has velocity V, positive upwards, of amplitude
# V0 = A omega. Of a plate of infinite mass and restitution e the particle leaves with v' = (1 + e) V + e u; particles
# of mass 1. Frequency to infinity, A to 0: the particle meets the plate at z = 0 with some phase.


def rebound(u: ArrayLike, plate: ArrayLike, restitution: float = 1.0) -> Floats:
    """v' = (1 + e) V + e u, positive upwards; 2 V + u on an elastic plate. It may be negative where V < 0."""
    return np.asarray((1 + restitution) * np.asarray(plate) + restitution * np.asarray(u), dtype=np.float64)


def uniform_phase_density(plate: ArrayLike, amplitude: float) -> Floats:
    """p(V) = 1/(pi sqrt(V0^2 - V^2)) for |V| < V0: a plate seen at a time drawn at random, whatever u."""
    x = np.asarray(plate, dtype=np.float64) / amplitude
    inside = abs(x) < 1
    return np.where(inside, 1 / (np.pi * amplitude * np.sqrt(np.where(inside, 1 - x * x, 1.0))), 0.0)


def flux_phase_density(plate: ArrayLike, u: float, amplitude: float) -> Floats:
    """p(V) proportional to (u + V)_+ / sqrt(V0^2 - V^2): phases weighted with the relative speed of approach.

    For u >= V0 the law of a vibrating plate's first impact in the limit: the path of each particle crosses the plate's
    once, and crossings are as dense as the relative speed. For u < V0 the path may cross more than once, and the first
    crossing shadows the others. A particle that leaves slowly is hit again: one visit is one impact for u >= 3 V0 only.
    `visit_gain` has the visit as a whole.
    """
    v = np.asarray(plate, dtype=np.float64)
    return uniform_phase_density(v, amplitude) * np.maximum(u + v, 0.0) / flux_mean_approach(u, amplitude)


def flux_mean_approach(u: float, amplitude: float) -> float:
    """<(u + V)_+> over uniform phases: u for u >= V0, else (u (pi - acos(u/V0)) + sqrt(V0^2 - u^2))/pi."""
    if u >= amplitude:
        return u
    return float((u * (np.pi - np.arccos(u / amplitude)) + (amplitude**2 - u**2) ** 0.5) / np.pi)


def uniform_phase_gain(u: float, amplitude: float, restitution: float = 1.0) -> float:
    """Mean energy gained at an impact under `uniform_phase_density`, V0^2 for e = 1.

    ((1 + e)^2 V0^2/2 - (1 - e^2) u^2)/2, for all u; it counts impacts with V < -u, which no plate makes.
    """
    return 0.5 * ((1 + restitution) ** 2 * amplitude**2 / 2 - (1 - restitution**2) * u**2)


def flux_phase_gain(u: float, amplitude: float, restitution: float = 1.0) -> float:
    """Mean energy gained at an impact under `flux_phase_density`; 2 V0^2 for e = 1 and u >= V0.

    For u >= V0, where <V> = V0^2/2u and <V^2> = V0^2/2: ((1 + e)^2 V0^2/2 + 2 e (1 + e) V0^2/2 - (1 - e^2) u^2)/2.
    Below V0 by quadrature over the phase, to 1e-10.
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
    phase, each of at most 2 (1 + u) and off by one phase: the uncertainty is that of four of them.
    """
    gains = [
        0.5 * (plate_visit(u, phase, restitution).velocity ** 2 - u * u)
        for phase in 2 * np.pi * (np.arange(phases) + 0.5) / phases
    ]
    return Estimate(float(np.mean(gains)), 8 * (1 + u) / phases)


def sawtooth_gain(u: float, amplitude: float, restitution: float = 1.0) -> float:
    """Energy gained on a plate that always moves up with V0: 2 V0 (V0 + u) for e = 1."""
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
    """Plate velocity at the first impact, velocity on leaving, and the number of impacts of one visit to the plate."""

    plate: float
    velocity: float
    impacts: int


def plate_visit(u: float, phase: float, restitution: float = 1.0, most: int = 1000) -> Visit:
    """One visit to a sinusoidal plate in the limit of high frequency, exactly; velocities in units of V0.

    In units A = omega = V0 = 1 without gravity (it does nothing in the limit) the particle comes from z = 2 with
    velocity -u, u > 0, when the plate z = cos t has the phase `phase`; for a phase uniform in [0, 2 pi) this is the law
    that finite amplitudes converge to. It ends when the particle is above z = 1 and rises. RuntimeError after `most`
    impacts (restitution < 1 lets a particle settle on the plate).
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
