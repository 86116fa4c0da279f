"""Granular gases: impact rules, homogeneous cooling of smooth and of rough particles.

Collapse and floors have files of their own, `collapse` and `floors`.

k_B = 1. alpha is the coefficient of normal restitution. Tangential restitution is alpha_t, v'_t = alpha_t v_t at the
contact: +1 smooth, -1 perfectly rough; much of the literature writes beta = -alpha_t. q = I/(m R^2): 2/5 solid spheres,
1/2 disks; the literature's kappa = 4 I/(m sigma^2) is q. Relative velocities are g = v_1 - v_2, the unit normal n
points from 2 to 1, so that g.n < 0 before an impact. Rates of collision count a particle's own collisions.

Literature: P. K. Haff, J. Fluid Mech. 134, 401 (1983); T. P. C. van Noije and M. H. Ernst, Granul. Matter 1, 57 (1998);
M. Huthmann and A. Zippelius, Phys. Rev. E 56, R6275 (1997); A. Santos, G. M. Kremer and M. dos Santos, Phys. Fluids 23,
030604 (2011); O. R. Walton, in Particulate Two-Phase Flow, ed. M. C. Roco (1993); S. F. Foerster et al., Phys. Fluids
6, 1108 (1994); I. Goldhirsch and G. Zanetti, Phys. Rev. Lett. 70, 1619 (1993).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import Estimate

Floats = NDArray[np.float64]


# -- impact ------------------------------------------------------------------------------------------------------------


class Body(NamedTuple):
    """A disk, which moves in the plane z = 0, a sphere, or a wall.

    mass: m; infinite: a wall, which keeps its velocity. radius: R, length; of a wall 0. velocity: (3,), length/time.
    spin: angular velocity (3,), 1/time. q: I/(m R^2). Any consistent units.
    """

    mass: float
    radius: float
    velocity: Floats
    spin: Floats
    q: float = 0.4

    @property
    def inertia(self) -> float:
        """Moment of inertia I = q m R^2."""
        return self.q * self.mass * self.radius**2


class Impact(NamedTuple):
    """What an impact leaves behind.

    velocities, spins: of bodies one and two after it, (3,) each, length/time and 1/time. impulse: on body one, (3,),
    mass length/time. sliding: whether the contact slid.
    """

    velocities: tuple[Floats, Floats]
    spins: tuple[Floats, Floats]
    impulse: Floats
    sliding: bool


def contact_velocity(one: Body, two: Body, normal: Floats) -> Floats:
    """v_1 - v_2 - (R_1 w_1 + R_2 w_2) x n: of the surfaces that touch, n from 2 to 1.

    one, two: the bodies. normal: unit vector n, (3,). Gives (3,), length/time.
    """
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

    one, two: the bodies. normal: unit vector n, (3,), from two to one. alpha, alpha_t: normal and tangential
    restitution. static_friction, kinetic_friction: coefficients of friction; infinity: no limit.
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

    Foerster's cot(gamma_0); 1 + 1/q = 7/2 for solid spheres, 3 for disks. static_friction: a coefficient, the others as
    at the top; alpha_t < 1.
    """
    return static_friction * (1 + alpha) * (1 + 1 / q) / (1 - alpha_t)


def sliding_slip(slip: ArrayLike, alpha: float, kinetic_friction: float, q: float) -> Floats:
    """Tangential over normal contact velocity after an impact that slides, of like bodies.

    g'_t/|g_n| = g_t/|g_n| - kinetic_friction (1 + alpha) (1 + 1/q), along the slip before (Foerster et al. 1994); one
    that sticks has alpha_t g_t/|g_n|. slip: g_t/|g_n| before, any shape, above `sliding_limit`. q = I/(m R^2).

    alpha: 0 to 1. kinetic_friction: a coefficient.
    """
    return np.asarray(np.asarray(slip, dtype=np.float64) - kinetic_friction * (1 + alpha) * (1 + 1 / q))


def dissipated_energy(normal: ArrayLike, tangential: ArrayLike, alpha: float, alpha_t: float, q: float) -> Floats:
    """Energy lost by like bodies of mass 1 that stick: ((1 - alpha^2) g_n^2 + (q/(1+q)) (1 - alpha_t^2) g_t^2)/4.

    normal, tangential: g_n and g_t before the impact, of shapes that broadcast, in one unit of velocity. Gives a
    velocity squared (mass 1). alpha, alpha_t, q: as at the top. Derivation: the energy before less that after `impact`.
    """
    n, t = np.asarray(normal, dtype=np.float64), np.asarray(tangential, dtype=np.float64)
    return np.asarray(0.25 * ((1 - alpha**2) * n**2 + q / (1 + q) * (1 - alpha_t**2) * t**2))


# -- homogeneous cooling of smooth particles ---------------------------------------------------------------------------


def fourth_cumulant(alpha: float, dimension: int) -> float:
    """a_2 = <c^4> 4/(d (d+2)) - 1 with <c^2> = d/2, linear Sonine theory (van Noije and Ernst 1998).

    16 (1 - alpha) (1 - 2 alpha^2)/(9 + 24 d - (41 - 8 d) alpha + 30 (1 - alpha) alpha^2). `FOURTH_CUMULANTS` says how
    far it is off.

    alpha: 0 to 1. dimension: 2 or 3.
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
    """<v^4>/<v^2>^2 = (1 + 2/d) (1 + a_2).

    a2: a_2 of `fourth_cumulant`. dimension: 2 or 3. Exact, by the definition of a_2.
    """
    return (1 + 2 / dimension) * (1 + a2)


def rate_factor(a2: float) -> float:
    """Collision rate over that of a Maxwellian at the same temperature, 1 - a_2/16, linear in a_2; d = 2 and 3.

    a2: a_2, small against 1. By derivation from the first Sonine polynomial (van Noije and Ernst 1998).
    """
    return 1 - a2 / 16


def cooling_rate(alpha: float, dimension: int, collision_rate: float, a2: float = 0.0) -> float:
    """zeta = -dln T/dt = (1 - alpha^2) w/d (1 + 3 a_2/16), w a particle's collision rate in a Maxwellian gas at T.

    alpha: 0 to 1. dimension: d, 2 or 3. collision_rate: w, 1/time. a2: a_2, to first order (van Noije and Ernst 1998).
    Gives 1/time.
    """
    return (1 - alpha**2) * collision_rate / dimension * (1 + 3 * a2 / 16)


def haff(time: ArrayLike, temperature: float, rate: float) -> Floats:
    """T(t) = T_0/(1 + zeta_0 t/2)^2; rate: zeta_0, the cooling rate at time 0. While the gas stays homogeneous.

    time: t, any shape. temperature: T_0, energy. rate: 1/time (Haff 1983).
    """
    return np.asarray(temperature / (1 + 0.5 * rate * np.asarray(time, dtype=np.float64)) ** 2)


def haff_collisions(time: ArrayLike, rate: float, collision_rate: float) -> Floats:
    """Collisions of one particle up to time t, (2 w_0/zeta_0) ln(1 + zeta_0 t/2).

    time: t, any shape. rate: zeta_0, and collision_rate: w_0, both at time 0, 1/time (Haff 1983).
    """
    return np.asarray(2 * collision_rate / rate * np.log1p(0.5 * rate * np.asarray(time, dtype=np.float64)))


def temperature_after(collisions: ArrayLike, alpha: float, dimension: int, a2: float = 0.0) -> Floats:
    """T/T_0 = exp(-(1 - alpha^2) s/d (1 + 3 a_2/16)/(1 - a_2/16)) after s collisions of each particle.

    collisions: s, any shape. alpha: 0 to 1. dimension: d, 2 or 3. a2: a_2, constant and small.
    """
    s = np.asarray(collisions, dtype=np.float64)
    return np.asarray(np.exp(-(1 - alpha**2) * s / dimension * (1 + 3 * a2 / 16) / rate_factor(a2)))


def best_cumulant(alpha: float, dimension: int) -> Estimate:
    """a_2 as simulated where it is known, `FOURTH_CUMULANTS`; else linear theory, which is off by up to 0.007 there.

    alpha: 0 to 1. dimension: 2 or 3.
    """
    known = FOURTH_CUMULANTS.get((dimension, alpha))
    return known or Estimate(fourth_cumulant(alpha, dimension), doubt=0.004)


def clustering_length(loss: float, density: float, dimension: int) -> float:
    """Box length above which shear modes grow against the cooling gas, in diameters: 2 pi sqrt(2 nu/zeta).

    A vortex of wave number k decays at nu k^2, the thermal speed at zeta/2 (Goldhirsch and Zanetti 1993). nu is that of
    a dilute gas (Chapman and Cowling, first approximation), hence k^2 = 2 pi n^2 loss for disks and 6.4 pi n^2 loss for
    spheres. loss: -dln T/ds per collision of a particle, which is zeta in units of its collision rate. density: number
    of particles per area or volume, diameter 1. dimension: 2 or 3.
    """
    factor = 2.0 if dimension == 2 else 6.4
    return float(2 * np.pi / (density * (factor * np.pi * loss) ** 0.5))


def vortex_excess(number: int, length: float, dimension: int) -> float:
    """Relative energy of the flow beyond equilibrium's, (d - 1)/(d N) sum over k of 1/((k/k*)^2 - 1), k* = 2 pi/L*.

    A shear mode decays, against the thermal speed, at nu k^2 - zeta/2 (Goldhirsch and Zanetti 1993), while noise feeds
    it as in equilibrium. Summed over the longest modes, k L/2 pi up to 2: an estimate. number: of particles. length: of
    the box, in units of `clustering_length`, below 1. dimension: 2 or 3.
    """
    axes = np.meshgrid(*[np.arange(-2, 3)] * dimension)
    squares = np.sum(np.square(axes), axis=0)
    squares = squares[(squares > 0) & (squares <= 4)] / length**2
    return float((dimension - 1) / (dimension * number) * np.sum(1 / (squares - 1)))


# -- homogeneous cooling of rough particles ----------------------------------------------------------------------------


def rotational_freedoms(dimension: int) -> int:
    """1 of a disk, 3 of a sphere.

    dimension: 2 or 3, else KeyError.
    """
    return {2: 1, 3: 3}[dimension]


def rough_rates(
    translational: float, rotational: float, alpha: float, alpha_t: float, q: float, dimension: int, rate: float = 1.0
) -> tuple[float, float]:
    """dT_tr/dt and dT_rot/dt of like rough particles without friction limit, all velocities Maxwellian.

    rate: a particle's collision rate w at T_tr. With x = T_rot/T_tr, c = q (1 - alpha_t)/(2 (1 + q)) and d - 1
    tangents: dT_tr/dt = (w T_tr/d) [-(1 - alpha^2) + 2 (d-1) (-c + c^2 (1 + x/q))] and dT_rot/dt = (2 (d-1) w
    T_tr/d_rot) (-c x/q + (c^2/q) (1 + x/q)). Flux-weighted means <g_n^2> = 4 T_tr, <g_t^2> = 2 (d-1) T_tr (1 + x/q).

    translational, rotational: T_tr and T_rot, energy per freedom. alpha, alpha_t, q: as at the top. dimension: d, 2 or
    3, else KeyError. rate: 1/time. Gives both in energy/time. Huthmann and Zippelius (1997).
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

    alpha, alpha_t, q: as at the top. dimension: 2 or 3, else KeyError.
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
    (3, 0.4, 0.9, 0.0): Estimate(0.546, doubt=0.003),
    (3, 0.4, 0.9, -0.5): Estimate(0.856, doubt=0.0045),
    (3, 0.4, 0.8, 0.0): Estimate(0.785, doubt=0.004),
    (3, 0.4, 0.9, -0.95): Estimate(1.102, doubt=0.0055),
    (2, 0.5, 0.9, 0.0): Estimate(0.443, doubt=0.0025),
    (2, 0.5, 0.9, -0.5): Estimate(0.770, doubt=0.004),
}
