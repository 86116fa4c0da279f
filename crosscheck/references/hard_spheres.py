"""Hard disks and spheres: speeds, equations of state, collision rates, walls, mixtures, diffusion, the Lorentz gas.

k_B = 1; the diameter sigma, the mass and the temperature are 1 where no argument says otherwise. d is the dimension, 2
or 3; n the number density; eta the packing fraction, pi n sigma^2/4 or pi n sigma^3/6; Z = p/(n T); g the pair
distribution function at contact, Z = 1 + 2^(d-1) eta g. Rates of collision count a particle's own collisions: each
collision of a pair counts for two particles.

Literature: S. Chapman and T. G. Cowling, The Mathematical Theory of Non-uniform Gases, 3rd ed. (1970); J.-P. Hansen and
I. R. McDonald, Theory of Simple Liquids; N. Clisby and B. M. McCoy, J. Stat. Phys. 122, 15 (2006) (virial
coefficients); N. F. Carnahan and K. E. Starling, J. Chem. Phys. 51, 635 (1969); D. Henderson, Mol. Phys. 30, 971
(1975); S. Luding, Phys. Rev. E 63, 042201 (2001) and Adv. Complex Syst. 4, 379 (2002); NIST Standard Reference
Simulation Website, hard-sphere page; T. Boublik, J. Chem. Phys. 53, 471 (1970); G. A. Mansoori et al., J. Chem. Phys.
54, 1523 (1971); J. T. Jenkins and F. Mancini, J. Appl. Mech. 54, 27 (1987); A. Santos, S. B. Yuste and M. Lopez de
Haro, Mol. Phys. 96, 1 (1999); J. L. Lebowitz and J. K. Percus, Phys. Rev. 122, 1675 (1961) (number of particles); I.-C.
Yeh and G. Hummer, J. Phys. Chem. B 108, 15873 (2004); C. Bruin, Phys. Rev. Lett. 29, 1670 (1972), with J. M. J. van
Leeuwen and A. Weijland, Physica 36, 457 (1967) and 38, 35 (1968).
"""

from __future__ import annotations

from math import gamma, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


class Estimate(NamedTuple):
    """What is expected, and how far it may be off: a standard error or the spread of theories, as the source says."""

    value: float
    uncertainty: float


def _check(dimension: int) -> None:
    if dimension not in (2, 3):
        raise ValueError(f"dimension must be 2 or 3, got {dimension}")


def packing_fraction(density: float, dimension: int, diameter: float = 1.0) -> float:
    """eta = pi n sigma^2/4 or pi n sigma^3/6."""
    _check(dimension)
    return float(np.pi / (2 * dimension) * density * diameter**dimension)


def number_density(eta: float, dimension: int, diameter: float = 1.0) -> float:
    """n of a packing fraction eta."""
    _check(dimension)
    return float(2 * dimension / np.pi * eta / diameter**dimension)


# -- speeds ------------------------------------------------------------------------------------------------------------


def maxwell_density(speed: ArrayLike, dimension: int, temperature: float = 1.0, mass: float = 1.0) -> Floats:
    """Probability density of the speed, 2 v^(d-1) exp(-v^2/w^2)/(Gamma(d/2) w^d), w^2 = 2T/m; 0 for v < 0.

    In two dimensions (2 v/V0^2) exp(-v^2/V0^2), with V0^2 = <v^2> = 2T/m.
    """
    _check(dimension)
    v, w2 = np.asarray(speed, dtype=np.float64), 2 * temperature / mass
    positive = np.maximum(v, 0.0)
    return np.asarray(
        2 * positive ** (dimension - 1) * np.exp(-(positive**2) / w2) / (gamma(dimension / 2) * w2 ** (dimension / 2))
    )


def maxwell_cumulative(speed: ArrayLike, dimension: int, temperature: float = 1.0, mass: float = 1.0) -> Floats:
    """Probability of a smaller speed: the regularised incomplete gamma function P(d/2, m v^2/2T)."""
    from scipy.special import gammainc

    _check(dimension)
    v = np.maximum(np.asarray(speed, dtype=np.float64), 0.0)
    return np.asarray(gammainc(dimension / 2, 0.5 * mass * v * v / temperature))


def maxwell_mean_speed(dimension: int, temperature: float = 1.0, mass: float = 1.0) -> float:
    """<v> = (2T/m)^(1/2) Gamma((d+1)/2)/Gamma(d/2): sqrt(pi T/2m), sqrt(8T/pi m)."""
    _check(dimension)
    return float((2 * temperature / mass) ** 0.5 * gamma((dimension + 1) / 2) / gamma(dimension / 2))


def degrees_of_freedom(number: int, dimension: int, momentum_conserved: bool) -> int:
    """d N, or d (N - 1) in a periodic box whose total momentum is zero; T = 2 K/f with this f and kinetic energy K."""
    _check(dimension)
    return dimension * (number - 1 if momentum_conserved else number)


def moment_ratio(dimension: int, freedoms: float = inf) -> float:
    """<v^4>/<v^2>^2 in equilibrium, f degrees of freedom at constant energy: (1 + 2/d) f/(f + 2); 2, 5/3 for f = inf.

    The velocities are uniform on a sphere in f dimensions (periodic box or hard walls alike).
    """
    _check(dimension)
    return (1 + 2 / dimension) * (1.0 if freedoms == inf else freedoms / (freedoms + 2))


def moment_ratio_fluctuation(number: int, dimension: int) -> float:
    """Standard deviation of one sample of <v^4>/<v^2>^2 in equilibrium: (8 (d+2)/(d^3 N))^(1/2), 2/sqrt(N) for disks.

    To leading order in 1/N, at constant energy: var x^2 - cov(x^2, x)^2/var x for x = v^2/<v^2>.
    """
    _check(dimension)
    return float((8 * (dimension + 2) / (dimension**3 * number)) ** 0.5)


class Relaxation(NamedTuple):
    """<v^4>/<v^2>^2 of a dilute gas that starts with one speed, after C collisions of pairs among N particles."""

    collisions_per_particle: float
    moment_ratio: float
    standard_error: float


#: From direct simulation of the homogeneous Boltzmann equation: 12 runs of 10^6 particles, pairs drawn at random and
#: accepted in proportion to their relative speed. The standard error is that of the mean of the 12.
MONO_SPEED: dict[int, tuple[Relaxation, ...]] = {
    2: (
        Relaxation(0.05, 1.02823, 0.00004),
        Relaxation(0.1, 1.05603, 0.00005),
        Relaxation(0.25, 1.13664, 0.00010),
        Relaxation(0.5, 1.26098, 0.00014),
        Relaxation(1.0, 1.47132, 0.00029),
        Relaxation(1.5, 1.63181, 0.00029),
        Relaxation(2.0, 1.74863, 0.00037),
        Relaxation(3.0, 1.88765, 0.00038),
        Relaxation(5.0, 1.97939, 0.00033),
        Relaxation(10.0, 1.99960, 0.00065),
    ),
    3: (
        Relaxation(0.05, 1.02254, 0.00003),
        Relaxation(0.1, 1.04461, 0.00007),
        Relaxation(0.25, 1.10784, 0.00006),
        Relaxation(0.5, 1.20243, 0.00012),
        Relaxation(1.0, 1.35345, 0.00017),
        Relaxation(1.5, 1.46081, 0.00018),
        Relaxation(2.0, 1.53368, 0.00027),
        Relaxation(3.0, 1.61361, 0.00026),
        Relaxation(5.0, 1.65878, 0.00034),
        Relaxation(10.0, 1.66622, 0.00032),
    ),
}


def mono_speed_moment_ratio(collisions_per_particle: float, number: float, dimension: int) -> Estimate:
    """<v^4>/<v^2>^2 of one run of N particles after C/N collisions, with what one run fluctuates by.

    Boltzmann limit. The fluctuation is that of equilibrium, an upper bound before: at the start it is zero. ValueError
    if C/N is not in the table.
    """
    _check(dimension)
    for row in MONO_SPEED[dimension]:
        if row.collisions_per_particle == collisions_per_particle:
            spread = 0.0 if number == inf else moment_ratio_fluctuation(int(number), dimension)
            return Estimate(row.moment_ratio, float(np.hypot(row.standard_error, spread)))
    known = ", ".join(str(row.collisions_per_particle) for row in MONO_SPEED[dimension])
    raise ValueError(f"no value after {collisions_per_particle} collisions a particle; there are {known}")


# -- equations of state ------------------------------------------------------------------------------------------------

#: B_k/B_2^(k-1), k = 1 ... 10; exact to k = 4 (B_4 of spheres to the digits given). Clisby and McCoy (2006), table 1.
VIRIAL_RATIOS: dict[int, tuple[float, ...]] = {
    2: (
        1.0,
        1.0,
        4 / 3 - 3**0.5 / np.pi,
        2 - 4.5 * 3**0.5 / np.pi + 10 / np.pi**2,
        0.33355604,
        0.1988425,
        0.1148728,
        0.0649930,
        0.0362193,
        0.0199537,
    ),
    3: (1.0, 1.0, 0.625, 0.2869495, 0.110252, 0.03888198, 0.01302354, 0.0041832, 0.0013094, 0.0004035),
}
#: Standard errors of the last digits, as published.
VIRIAL_ERRORS: dict[int, tuple[float, ...]] = {
    2: (0, 0, 0, 0, 1e-8, 4.2e-6, 4.3e-6, 3.4e-6, 3.5e-6, 8.0e-6),
    3: (0, 0, 0, 0, 1e-6, 9.1e-7, 9.1e-7, 1.1e-6, 1.3e-6, 1.5e-6),
}


def virial_coefficients(dimension: int) -> Floats:
    """b_k of Z = sum_k b_k eta^(k-1), k = 1 ... 10."""
    _check(dimension)
    ratios = np.array(VIRIAL_RATIOS[dimension])
    return np.asarray(ratios * 2.0 ** ((dimension - 1) * np.arange(ratios.size)))


def pade(eta: float, dimension: int, numerator: int = 4) -> float:
    """Z from the Pade approximant [numerator / 9 - numerator] of the virial series to B_10."""
    b = virial_coefficients(dimension)
    low = b.size - 1 - numerator
    # sum_j q_j b_(k-j) = 0 for the orders above the numerator's, q_0 = 1
    order = numerator + 1 + np.arange(low)
    index = order[:, None] - np.arange(1, low + 1)[None, :]
    matrix = np.where(index >= 0, b[np.maximum(index, 0)], 0.0)
    q = np.concatenate([[1.0], np.linalg.solve(matrix, -b[order])])
    p = np.convolve(b, q)[: numerator + 1]
    return float(np.polynomial.polynomial.polyval(eta, p) / np.polynomial.polynomial.polyval(eta, q))


def henderson(eta: float) -> float:
    """Z of disks, (1 + eta^2/8)/(1 - eta)^2 (1975). Too high by 0.15 % at eta = 0.4, 0.5 % at 0.5, 1.2 % at 0.6."""
    return (1 + eta**2 / 8) / (1 - eta) ** 2


def luding_fluid(eta: float) -> float:
    """Z of disks, 1 + 2 eta g, g = (1 - 7 eta/16)/(1 - eta)^2 - eta^3/(128 (1 - eta)^4) (2001); eta < 0.68."""
    return henderson(eta) - eta**4 / (64 * (1 - eta) ** 4)


def luding_global(eta: float) -> float:
    """Z of disks from dilute to close packing: the fluid merged into the crystal (Luding 2001, 2002).

    Z = Z_f + m (Z_d - Z_f), m = 1/(1 + exp(-(eta - 0.70)/0.0111)), Z_d = 2 eta_m/(eta_m - eta) h(eta_m - eta) with
    h(x) = 1 - 0.04 x + 3.25 x^3, eta_m = pi/(2 sqrt 3). The constants of m and h are from memory of the literature,
    checked against the free-volume expansion Z_d = 2/alpha + 1.90(1) + ..., alpha = eta_m/eta - 1, of B. J. Alder, W.
    G. Hoover and D. A. Young, J. Chem. Phys. 49, 3688 (1968) only: take a few per cent of doubt above eta = 0.68.
    """
    densest = np.pi / (2 * 3**0.5)
    if not 0 <= eta < densest:
        raise ValueError(f"eta must be at least 0 and below close packing, {densest:.6f}, got {eta}")
    gap = densest - eta
    dense = 2 * densest / gap * (1 - 0.04 * gap + 3.25 * gap**3)
    return float(luding_fluid(eta) + (dense - luding_fluid(eta)) / (1 + np.exp(-(eta - 0.70) / 0.0111)))


def disk_compressibility(eta: float) -> Estimate:
    """Z of the disk fluid, eta <= 0.65: the mean of the Pade approximant and Luding's formula, off by their gap.

    With a floor of 1e-4 (Z - 1) where the two cross. Henderson's formula lies outside above eta = 0.2. ValueError above
    0.65, where the hexatic phase is near.
    """
    if not 0 <= eta <= 0.65:
        raise ValueError(f"the fluid of disks is known for eta from 0 to 0.65, got {eta}")
    one, two = pade(eta, 2), luding_fluid(eta)
    value = 0.5 * (one + two)
    return Estimate(value, max(abs(one - two), 1e-4 * (value - 1)))


def carnahan_starling(eta: float) -> float:
    """Z of spheres, (1 + eta + eta^2 - eta^3)/(1 - eta)^3 (1969). Too low by 0.05 ... 0.3 % for n from 0.3 to 0.9."""
    return (1 + eta + eta**2 - eta**3) / (1 - eta) ** 3


#: Number density, p sigma^3/T and its quoted error: molecular dynamics, NIST Standard Reference Simulation Website.
NIST_PRESSURES = (
    (0.1, 0.123942),
    (0.2, 0.310649),
    (0.3, 0.590354),
    (0.4, 1.008452),
    (0.5, 1.634467),
    (0.6, 2.576640),
    (0.7, 4.008462),
    (0.8, 6.215551),
    (0.9, 9.685615),
)
#: Particles behind NIST's molecular dynamics: inferred from Z - 1 -> -1/N as n -> 0, and from the agreement with the
#: virial series to 2e-5 for n <= 0.6 that the correction for finite N brings; the page itself was not at hand.
NIST_PARTICLES = 4000


def nist_compressibilities() -> tuple[Floats, Floats]:
    """n, and Z of an infinite system from NIST's table: Z_MD + 1/N + (eta/2N) P''/P' (see `finite_compressibility`).

    The raw table is low by 1/N as n -> 0: the momentum of the centre of mass is missing from the ideal part.
    """
    n, p = np.array(NIST_PRESSURES).T
    shift = [1 / NIST_PARTICLES + _number_correction(packing_fraction(x, 3), NIST_PARTICLES, 3) for x in n]
    return n, p / n + np.array(shift)


def sphere_compressibility(eta: float) -> Estimate:
    """Z of the sphere fluid, n <= 0.9: Carnahan-Starling times the known correction; 5e-4 of it uncertain.

    The correction Z_MD/Z_CS comes from `nist_compressibilities`, by monotone cubic interpolation in n, 1 at n = 0. The
    Pade approximant agrees to 1e-4 for n <= 0.8 and to 3e-4 up to 0.9. ValueError above n = 0.9.
    """
    from scipy.interpolate import PchipInterpolator

    n = number_density(eta, 3)
    if not 0 <= n <= 0.9 + 1e-12:
        raise ValueError(f"the fluid of spheres is known for number densities from 0 to 0.9, got {n}")
    nodes, z = nist_compressibilities()
    ratio = z / np.array([carnahan_starling(packing_fraction(x, 3)) for x in nodes])
    correct = PchipInterpolator(np.concatenate([[0.0], nodes]), np.concatenate([[1.0], ratio]))
    value = carnahan_starling(eta) * float(correct(min(n, 0.9)))
    return Estimate(value, 5e-4 * value)


def compressibility(eta: float, dimension: int) -> Estimate:
    """Z of the fluid of disks or spheres in the limit of infinitely many."""
    _check(dimension)
    return disk_compressibility(eta) if dimension == 2 else sphere_compressibility(eta)


def contact_value(eta: float, dimension: int) -> Estimate:
    """g at contact, (Z - 1)/(2^(d-1) eta); 1 at eta = 0."""
    if eta == 0:
        return Estimate(1.0, 0.0)
    z = compressibility(eta, dimension)
    scale = 2.0 ** (dimension - 1) * eta
    return Estimate((z.value - 1) / scale, z.uncertainty / scale)


def collision_rate(
    eta: float, dimension: int, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0
) -> Estimate:
    """Collisions of one particle per time: 2 n sigma g sqrt(pi T/m) of disks, 4 n sigma^2 g sqrt(pi T/m) of spheres.

    Exact at equilibrium for the exact g (Enskog's is then no approximation); N = infinity.
    """
    g = contact_value(eta, dimension)
    n = number_density(eta, dimension, diameter)
    factor = 2 * (dimension - 1) * n * diameter ** (dimension - 1) * (np.pi * temperature / mass) ** 0.5
    return Estimate(factor * g.value, factor * g.uncertainty)


# -- few particles -----------------------------------------------------------------------------------------------------


def _smooth(eta: float, dimension: int) -> float:
    """A Z with smooth derivatives, for corrections of order 1/N."""
    return luding_fluid(eta) if dimension == 2 else pade(eta, 3, 5)


def _number_correction(eta: float, number: int, dimension: int) -> float:
    """(eta/2N) P''/P' with P = eta Z(eta)."""
    h = 1e-3
    low, mid, high = ((eta + k * h) * _smooth(eta + k * h, dimension) for k in (-1, 0, 1))
    return float(eta / number * (high - 2 * mid + low) / (h * (high - low)))


def finite_compressibility(eta: float, number: int, dimension: int) -> Estimate:
    """Z = 1 + sum of sigma |J|/(d N T t) over collisions, of N particles in a periodic box; T = 2K/f, f = d (N - 1).

    The density of pairs at fixed N is that of the infinite system minus (1/2) <dN^2> times its second derivative with
    respect to N (Lebowitz and Percus), <dN^2>/N = dn/d(p/T): Z_N = Z - (eta/2N) P''/P', P = eta Z. This holds to 1/N;
    to second order in density it has, to order 1/N, the exact virial series of N particles, (N-1)/N B_2 n +
    ((N-1)(N-2)/N^2 B_3 + 2 (N-1)/N^2 B_2^2) n^2. There is no kinetic correction: <u_n^2> = 2T with that T. The pressure
    of the box has the ideal part (N - 1)/N in place of 1. Measured, N = 8, 16 disks at eta = 0.3: 1.96623(28),
    2.01512(32), against 1.9664, 2.0148. Uncertainty: that of Z, and for the terms of order 1/N^2 and the periodic
    images twice the square of the correction over Z - 1.
    """
    z, shift = compressibility(eta, dimension), _number_correction(eta, number, dimension)
    higher = 2 * shift**2 / (z.value - 1) if eta > 0 else 0.0
    return Estimate(z.value - shift, float(np.hypot(z.uncertainty, higher)))


def finite_speed_factor(freedoms: int) -> float:
    """Mean relative speed at constant energy over that of the canonical ensemble at T = 2K/f.

    (f/2)^(1/2) Gamma(f/2)/Gamma((f+1)/2) = 1 + 1/4f + ...: the scaled relative velocity of a pair is a set of d
    components of a point uniform on a sphere in f dimensions.
    """
    from scipy.special import gammaln

    return float((freedoms / 2) ** 0.5 * np.exp(gammaln(freedoms / 2) - gammaln((freedoms + 1) / 2)))


def finite_collision_rate(
    eta: float, number: int, dimension: int, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0
) -> Estimate:
    """Collisions of one of N particles per time in a periodic box; T = 2K/(d (N - 1)).

    The rate of the infinite system times (Z_N - 1)/(Z - 1), the pairs at contact, and `finite_speed_factor`. Measured,
    N = 8, 16 disks at eta = 0.3: 2.2196(7), 2.3091(5), against 2.2201, 2.3093.
    """
    rate = collision_rate(eta, dimension, temperature, mass, diameter)
    if eta == 0:
        return rate
    z, few = compressibility(eta, dimension), finite_compressibility(eta, number, dimension)
    factor = (few.value - 1) / (z.value - 1) * finite_speed_factor(degrees_of_freedom(number, dimension, True))
    return Estimate(rate.value * factor, rate.value * factor * few.uncertainty / (few.value - 1))


# -- walls -------------------------------------------------------------------------------------------------------------


def mono_speed_temperature(speed: float, dimension: int, mass: float = 1.0) -> float:
    """T = m V0^2/d of a gas whose particles all have speed V0."""
    _check(dimension)
    return mass * speed**2 / dimension


def ideal_wall_pressure(
    number: int, length: float, dimension: int, temperature: float = 1.0, diameter: float = 0.0
) -> float:
    """Force per wall area L^(d-1) of particles that meet only the walls: n T L/(L - sigma), n = N/L^d.

    Centres are confined to (L - sigma)^d. With T = m V0^2/d it holds for a gas of one speed in all directions, too.
    """
    _check(dimension)
    return number * temperature / ((length - diameter) * length ** (dimension - 1))


def wall_hit_rate(density: float, temperature: float = 1.0, mass: float = 1.0) -> float:
    """Hits per time and wall area in equilibrium, n <|v_x|>/2 = n sqrt(T/2 pi m); n is the density at the wall."""
    return float(density * (temperature / (2 * np.pi * mass)) ** 0.5)


#: Surface term of the third cluster integral of disks at a hard wall, in sigma^5: -(1/6) times the integral of f12 f13
#: + f12 f23 + f13 f23 + f12 f13 f23 times the depth of the cluster; by Monte Carlo, error 1.3e-4.
_SURFACE_CLUSTER = -1.47764


def disk_wall_tension(density: float) -> float:
    """gamma sigma/T of disks at a flat hard wall, per length of the line where centres stop.

    -(n^2/3) (1 + 1.850 n + ...) from the second and third cluster integrals, resummed as (n^2/3)/(1 - 1.850 n/2)^2, the
    form of scaled-particle theory. The adsorption is Gamma = -d gamma/d mu = (2/3) n^2 - 0.244 n^3 + ...
    """
    third = 4 / 3 * (np.pi / 2) + _SURFACE_CLUSTER
    return float(-(density**2) / 3 / (1 - 1.5 * third * density) ** 2)


def disk_box_pressure(number: int, length: float, temperature: float = 1.0) -> Estimate:
    """Mean force per length L on the hard walls of a square box with N disks of diameter 1; eta <= 0.1, L >= 10.

    Centres live in a square of side l = L - 1, with bulk density n: N = n l^2 + 4 l Gamma, and from the work done when
    l grows, p = (l/L) (n T Z_N(n) - 2 gamma/l): the adsorption Gamma = -d gamma/d mu lowers n, and the corners, where
    contact is likelier, give back a quarter of that. Z_N holds the correction for finite N of `finite_compressibility`.
    Uncertainty 1.2e-3 (eta/0.1)^2 of p: it covers what event-driven runs gave for p L^2/(N T), 1.07473(5) and 1.3341(2)
    for N = 25 at N pi/4L^2 = 0.02 and 0.1, 1.2862(3) for N = 100 at 0.1, 1.0498(2) and 1.2620(2) for N = 400 at 0.02
    and 0.1, against 1.07478, 1.3326, 1.2855, 1.0498, 1.2610. Z at the mean density, pi N/4L^2, is low by 2 to 7 %.
    """
    side = length - 1
    mean = number / side**2

    def adsorption(n: float) -> float:
        h = 1e-4
        slope = (disk_wall_tension(n + h) - disk_wall_tension(n - h)) / (2 * h)
        low, high = ((n + k * h) * _smooth(packing_fraction(n + k * h, 2), 2) for k in (-1, 1))
        return float(-slope * n * 2 * h / (high - low))

    n = mean
    for _ in range(50):
        n = mean - 4 * adsorption(n) / side
    eta = packing_fraction(n, 2)
    z = disk_compressibility(eta).value - _number_correction(eta, number, 2)
    pressure = temperature * side / length * (n * z - 2 * disk_wall_tension(n) / side)
    return Estimate(pressure, 1.2e-3 * (eta / 0.1) ** 2 * pressure)


# -- mixtures ----------------------------------------------------------------------------------------------------------


class Mixture(NamedTuple):
    """Number densities, diameters and masses of the species, each of shape (k,)."""

    densities: Floats
    diameters: Floats
    masses: Floats

    @property
    def packing_fraction(self) -> tuple[float, float]:
        """Of disks and of spheres with these diameters."""
        n, s = self.densities, self.diameters
        return float(np.pi / 4 * (n * s**2).sum()), float(np.pi / 6 * (n * s**3).sum())


def mixture(densities: ArrayLike, diameters: ArrayLike, masses: ArrayLike = 1.0) -> Mixture:
    """ValueError unless densities and diameters have one shape (k,)."""
    n, s = np.asarray(densities, dtype=np.float64), np.asarray(diameters, dtype=np.float64)
    if n.ndim != 1 or n.shape != s.shape:
        raise ValueError(f"one density and one diameter per species, got shapes {n.shape} and {s.shape}")
    return Mixture(n, s, np.broadcast_to(np.asarray(masses, dtype=np.float64), n.shape))


def mixture_contact_values(species: Mixture, dimension: int) -> Floats:
    """g_ij at contact, (k, k).

    Spheres: Boublik; Mansoori et al., 1/(1-x3) + 3 D x2/(1-x3)^2 + 2 D^2 x2^2/(1-x3)^3, D = s_i s_j/(s_i + s_j), x_k =
    (pi/6) sum n s^k. Disks: Jenkins and Mancini, 1/(1-eta) + (9/16) eta/(1-eta)^2 (<s>/<s^2>) s_i s_j/s_ij; close to
    simulation (S. Luding and A. Santos, J. Chem. Phys. 121, 8458 (2004)). Both exact for a point among the others; take
    1 % of doubt at moderate density.
    """
    _check(dimension)
    n, s = species.densities, species.diameters
    product, total = np.outer(s, s), s[:, None] + s[None, :]
    if dimension == 2:
        eta = species.packing_fraction[0]
        width = 2 * product / total * (n * s).sum() / (n * s**2).sum()
        return np.asarray(1 / (1 - eta) + 9 / 16 * eta / (1 - eta) ** 2 * width)
    x2, x3 = (np.pi / 6 * (n * s**k).sum() for k in (2, 3))
    width = product / total
    return np.asarray(1 / (1 - x3) + 3 * width * x2 / (1 - x3) ** 2 + 2 * (width * x2) ** 2 / (1 - x3) ** 3)


def bmcsl(species: Mixture) -> float:
    """Z of a mixture of spheres: x0 Z = x0/(1-x3) + 3 x1 x2/(1-x3)^2 + x2^3 (3 - x3)/(1-x3)^3, x_k = (pi/6) sum n s^k.

    Boublik; Mansoori, Carnahan, Starling and Leland. One species: Carnahan-Starling.
    """
    x0, x1, x2, x3 = (np.pi / 6 * (species.densities * species.diameters**k).sum() for k in range(4))
    return float(1 / (1 - x3) + (3 * x1 * x2 / (1 - x3) ** 2 + x2**3 * (3 - x3) / (1 - x3) ** 3) / x0)


def mixture_compressibility(species: Mixture, dimension: int) -> Estimate:
    """Z of a mixture of hard disks or spheres.

    Disks: Santos, Yuste and Lopez de Haro, Z = (1 - x)/(1 - eta) + x Z_1(eta), x = <s>^2/<s^2>, with Z_1 of one
    species; with Henderson's Z_1 it is the Z of Jenkins and Mancini's contact values. Spheres: `bmcsl` plus what the
    best Z of one species at that eta has over Carnahan-Starling. Uncertainty: that of Z_1 and 1 % of the departure from
    one species, for diameters within a factor of 3.
    """
    _check(dimension)
    n, s = species.densities, species.diameters
    if dimension == 2:
        eta = species.packing_fraction[0]
        pure = disk_compressibility(eta)
        x = float((n * s).sum() ** 2 / (n.sum() * (n * s**2).sum()))
        value = (1 - x) / (1 - eta) + x * pure.value
    else:
        eta = species.packing_fraction[1]
        pure = sphere_compressibility(eta)
        value = bmcsl(species) + pure.value - carnahan_starling(eta)
    return Estimate(value, float(np.hypot(pure.uncertainty, 0.01 * (value - pure.value))))


def species_collision_rates(species: Mixture, dimension: int, temperature: float = 1.0) -> Floats:
    """Rate at which one particle of species i collides with those of species j, (k, k).

    n_j s_ij g_ij sqrt(2 pi T/mu_ij) of disks, 2 n_j s_ij^2 g_ij sqrt(2 pi T/mu_ij) of spheres, mu_ij the reduced mass.
    """
    g, n, m = mixture_contact_values(species, dimension), species.densities, species.masses
    distance = 0.5 * (species.diameters[:, None] + species.diameters[None, :])
    speed = (2 * np.pi * temperature * (1 / m[:, None] + 1 / m[None, :])) ** 0.5
    return np.asarray((dimension - 1) * n[None, :] * distance ** (dimension - 1) * g * speed)


# -- diffusion ---------------------------------------------------------------------------------------------------------

#: D of the Boltzmann equation over its first Sonine approximation: exact to the digits given. Spheres: 1.01896 in the
#: literature; both from the twelfth approximation with exact integrals, which the tests repeat.
SONINE_DIFFUSION = {2: 1.027094, 3: 1.018954}


def enskog_diffusion(
    eta: float, dimension: int, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0, sonine: bool = True
) -> Estimate:
    """Self-diffusion in Enskog's theory, T/(m zeta) with zeta of `friction` for equal masses, times the Sonine factor.

    First approximation: sqrt(T/pi m)/(2 n sigma g) of disks, 3 sqrt(T/pi m)/(8 n sigma^2 g) of spheres. The uncertainty
    is that of g, not of the theory: an infinite system of spheres diffuses 37 % faster than D_E at n = 0.5 and 17 %
    slower at n = 0.9; in two dimensions D grows without bound with the box (long-time tails) and the dilute limit only
    is sharp.
    """
    n, g = number_density(eta, dimension, diameter), contact_value(eta, dimension)
    heavy = friction(n, diameter, mass, mass, dimension, temperature, g.value)
    value = temperature / (mass * heavy) * (SONINE_DIFFUSION[dimension] if sonine else 1.0)
    return Estimate(value, value * g.uncertainty / g.value)


def enskog_viscosity(eta: float, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0) -> float:
    """Shear viscosity of spheres in Enskog's theory, first approximation times 1.016 (Chapman and Cowling).

    (5/16 sigma^2) sqrt(m T/pi) b (1/(b g) + 4/5 + 0.7614 b g), b = 4 eta; within some 5 % for n <= 0.7.
    """
    b = 4 * eta
    bg = b * contact_value(eta, 3).value
    dilute = 1.016 * 5 / 16 / diameter**2 * (mass * temperature / np.pi) ** 0.5
    return float(dilute * b * (1 / bg + 0.8 + 0.7614 * bg))


#: Number density, D/(sigma sqrt(T/m)) and its quoted error: molecular dynamics, NIST Standard Reference Simulation
#: Website, with `NIST_PARTICLES` spheres.
NIST_DIFFUSION = (
    (0.1, 1.934599, 33e-4),
    (0.3, 0.541249, 7e-4),
    (0.5, 0.253873, 3e-4),
    (0.7, 0.114739, 2e-4),
    (0.9, 0.034327, 9e-5),
)


def periodic_diffusion_shift(density: float, number: float) -> float:
    """What D of spheres in a periodic cube lacks against an infinite system: 2.837297 T/(6 pi viscosity L).

    Yeh and Hummer; the box must be long against the mean free path. T = m = sigma = 1, viscosity from Enskog's theory.
    """
    if number == inf:
        return 0.0
    viscosity = enskog_viscosity(packing_fraction(density, 3))
    return float(2.837297 / (6 * np.pi * viscosity * (number / density) ** (1 / 3)))


def sphere_diffusion(density: float, number: float = inf) -> Estimate:
    """D/(sigma sqrt(T/m)) of N spheres in a periodic cube, 0.1 <= n <= 0.9; number may be infinite.

    NIST's D, taken to infinite N with `periodic_diffusion_shift` and back to N; between its densities D/D_E is
    interpolated (monotone cubic). Own event-driven runs gave 0.4982(15), 0.2206(5), 0.1000(5) for N = 108 at n = 0.3,
    0.5, 0.7, against 0.490, 0.222, 0.098. Uncertainty: quoted error, 20 % of the difference of the shifts (Enskog's
    viscosity, higher orders in 1/L: 16 % found at n = 0.3) and, off the table's densities, 1 % of D.
    ValueError outside the densities.
    """
    from scipy.interpolate import PchipInterpolator

    n, d, error = np.array(NIST_DIFFUSION).T
    if not n[0] <= density <= n[-1]:
        raise ValueError(f"diffusion is tabulated for number densities from {n[0]} to {n[-1]}, got {density}")

    def enskog(x: float) -> float:
        return enskog_diffusion(packing_fraction(x, 3), 3).value

    infinite = np.array([y + periodic_diffusion_shift(x, NIST_PARTICLES) for x, y in zip(n, d, strict=True)])
    ratio = PchipInterpolator(n, infinite / np.array([enskog(x) for x in n]))
    shift = periodic_diffusion_shift(density, number)
    value = float(ratio(density)) * enskog(density)
    doubt = 0.2 * abs(shift - periodic_diffusion_shift(density, NIST_PARTICLES))
    between = 0.0 if np.isclose(n, density, rtol=0, atol=1e-9).any() else 0.01 * value
    return Estimate(value - shift, float(np.sqrt(np.interp(density, n, error) ** 2 + doubt**2 + between**2)))


# -- Lorentz gas -------------------------------------------------------------------------------------------------------


def lorentz_free_path(density: float, radius: float, dimension: int, overlapping: bool = False) -> float:
    """Mean free path of a point among fixed disks or spheres of that radius; exact for any arrangement.

    By the invariant measure it is pi A/l of the free area and its perimeter in two dimensions, 4 V/S in three: (1 - pi
    n R^2)/(2 n R), (1 - 4 pi n R^3/3)/(pi n R^2) without overlaps, on a lattice or at random; 1/(2 n R), 1/(pi n R^2)
    for centres placed at random with overlaps, where free volume and surface shrink alike. Time average over
    collisions; on a lattice with open corridors the mean exists, too. ValueError if the scatterers fill all.
    """
    _check(dimension)
    cross_section = 2 * radius if dimension == 2 else np.pi * radius**2
    filled = density * (np.pi * radius**2 if dimension == 2 else 4 / 3 * np.pi * radius**3)
    if overlapping:
        return float(1 / (density * cross_section))
    if filled >= 1:
        raise ValueError(f"scatterers of volume fraction {filled} leave no room")
    return float((1 - filled) / (density * cross_section))


def lorentz_boltzmann_diffusion(density: float, radius: float, dimension: int, speed: float = 1.0) -> float:
    """D in the dilute limit, v/(d n sigma_tr): 3 v/(16 n R) of disks (sigma_tr = 8R/3), v/(3 pi n R^2) of spheres.

    The transport cross-section is the integral of (1 - cos of the angle of deflection) over the impact parameter;
    spheres scatter isotropically.
    """
    _check(dimension)
    transport = 8 * radius / 3 if dimension == 2 else np.pi * radius**2
    return float(speed / (dimension * density * transport))


#: D/D_Boltzmann of a point among overlapping scatterers placed at random, by dimension and n R^d: own runs, slope of
#: the mean-square displacement from 20 to 40 mean free paths, 10^4 points in each of 96 (disks) or 16 (spheres) boxes
#: of side 60 R or more. Standard errors over the boxes; from 10 to 30 paths the slopes are the same within them.
LORENTZ_DIFFUSION = {
    2: {0.02: Estimate(0.9103, 0.0029), 0.05: Estimate(0.8094, 0.0027), 0.1: Estimate(0.6660, 0.0024)},
    3: {0.02: Estimate(0.9722, 0.0021), 0.05: Estimate(0.9357, 0.0034), 0.1: Estimate(0.8703, 0.0033)},
}


def lorentz_series(density: float, radius: float = 1.0) -> float:
    """D/D_Boltzmann of a point among overlapping disks at random, 1/(1 - (4/3) x ln x - 0.8775 x + 4.519 (x ln x)^2).

    x = n R^2 <= 0.05. Van Leeuwen and Weijland (1967, 1968), Bruin (1972): from memory of the literature, checked
    against `LORENTZ_DIFFUSION` only: 1.5 and 2 % low at x = 0.02 and 0.05, 3 % high at 0.1.
    """
    x = density * radius**2
    y = x * np.log(x)
    return float(1 / (1 - 4 / 3 * y - 0.8775 * x + 4.519 * y * y))


# -- Brownian motion ---------------------------------------------------------------------------------------------------


def friction(
    density: float,
    distance: float,
    mass: float,
    tracer_mass: float,
    dimension: int,
    temperature: float = 1.0,
    contact: float = 1.0,
) -> float:
    """Rate gamma of the initial decay of a tracer's velocity autocorrelation in a bath of density n and mass m.

    gamma M = 4 (S_d/d) n s^(d-1) g mu <u_+>, with S_d = 2 pi, 4 pi, <u_+> = sqrt(T/2 pi mu), mu the reduced mass, s the
    distance of the centres at contact, g the bath's density there over n: 2 n s g sqrt(2 pi mu T) for disks, (8/3) n
    s^2 g sqrt(2 pi mu T) for spheres. For M >> m the whole decay is exp(-gamma t) in Enskog's theory; in a dense bath
    recollisions and the backflow (Stokes) lower gamma.
    """
    _check(dimension)
    mu = mass * tracer_mass / (mass + tracer_mass)
    factor = 2.0 if dimension == 2 else 8 / 3
    force = factor * density * distance ** (dimension - 1) * contact * (2 * np.pi * mu * temperature) ** 0.5
    return float(force / tracer_mass)


def brownian_autocorrelation(time: ArrayLike, gamma: float, temperature: float, tracer_mass: float) -> Floats:
    """<v_x(0) v_x(t)> = (T/M) exp(-gamma t), Ornstein and Uhlenbeck; M >> m. D = T/(M gamma)."""
    return np.asarray(temperature / tracer_mass * np.exp(-gamma * np.asarray(time, dtype=np.float64)))
