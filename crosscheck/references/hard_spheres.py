"""Hard disks and spheres of one size: equations of state, collision rates, and what changes with few particles.

k_B = 1; the diameter sigma, the mass m and the temperature T (an energy) are 1 where no argument says otherwise.
dimension, d, is 2 or 3; density, n, particles per length^d; eta the packing fraction, pi n sigma^2/4 or pi n sigma^3/6;
number, N, of particles; Z = p/(n T); g the pair distribution function at contact, Z = 1 + 2^(d-1) eta g. Rates of
collision count a particle's own collisions: each collision of a pair counts for two particles.

Literature: S. Chapman and T. G. Cowling, The Mathematical Theory of Non-uniform Gases, 3rd ed. (1970); J.-P. Hansen and
I. R. McDonald, Theory of Simple Liquids; N. Clisby and B. M. McCoy, J. Stat. Phys. 122, 15 (2006) (virial
coefficients); N. F. Carnahan and K. E. Starling, J. Chem. Phys. 51, 635 (1969); D. Henderson, Mol. Phys. 30, 971
(1975); S. Luding, Phys. Rev. E 63, 042201 (2001) and Adv. Complex Syst. 4, 379 (2002); NIST Standard Reference
Simulation Website, hard-sphere page; J. L. Lebowitz and J. K. Percus, Phys. Rev. 122, 1675 (1961) (number of
particles).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


class Estimate(NamedTuple):
    """What is expected, and how far it may be off, by chance and otherwise.

    value: what is expected. uncertainty: its standard error, where it was measured or simulated. doubt: a bound on what
    is systematically wrong with it (spread of theories, orders that are left out, rounded digits). Both are absolute,
    in the unit of the value; a tolerance is a quantile times the one, plus the other.
    """

    value: float
    uncertainty: float = 0.0
    doubt: float = 0.0


def demand_dimension(dimension: int) -> None:
    """ValueError unless the dimension is 2 or 3."""
    if dimension not in (2, 3):
        raise ValueError(f"dimension must be 2 or 3, got {dimension}")


def packing_fraction(density: float, dimension: int, diameter: float = 1.0) -> float:
    """eta = pi n sigma^2/4 or pi n sigma^3/6.

    density: n, 1/length^d. dimension: d, 2 or 3. diameter: sigma, length.
    """
    demand_dimension(dimension)
    return float(np.pi / (2 * dimension) * density * diameter**dimension)


def number_density(eta: float, dimension: int, diameter: float = 1.0) -> float:
    """n of a packing fraction eta.

    eta: packing fraction. dimension: d, 2 or 3. diameter: sigma, length. Gives 1/length^d.
    """
    demand_dimension(dimension)
    return float(2 * dimension / np.pi * eta / diameter**dimension)


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
    """b_k of Z = sum_k b_k eta^(k-1), k = 1 ... 10.

    dimension: 2 or 3. Gives (10,). `VIRIAL_ERRORS` are their standard errors (Clisby and McCoy 2006).
    """
    demand_dimension(dimension)
    ratios = np.array(VIRIAL_RATIOS[dimension])
    return np.asarray(ratios * 2.0 ** ((dimension - 1) * np.arange(ratios.size)))


def pade(eta: float, dimension: int, numerator: int = 4) -> float:
    """Z from the Pade approximant [numerator / 9 - numerator] of the virial series to B_10.

    eta: packing fraction. dimension: 2 or 3. numerator: its degree, 1 to 8.
    """
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
    """Z of disks, (1 + eta^2/8)/(1 - eta)^2 (1975). Too high by 0.15 % at eta = 0.4, 0.5 % at 0.5, 1.2 % at 0.6.

    eta: packing fraction.
    """
    return (1 + eta**2 / 8) / (1 - eta) ** 2


def luding_fluid(eta: float) -> float:
    """Z of disks, 1 + 2 eta g, g = (1 - 7 eta/16)/(1 - eta)^2 - eta^3/(128 (1 - eta)^4) (2001); eta < 0.68.

    eta: packing fraction.
    """
    return henderson(eta) - eta**4 / (64 * (1 - eta) ** 4)


def luding_global(eta: float) -> float:
    """Z of disks from dilute to close packing: the fluid merged into the crystal (Luding 2001, 2002).

    Z = Z_f + m (Z_d - Z_f), m = 1/(1 + exp(-(eta - 0.70)/0.0111)), Z_d = 2 eta_m/(eta_m - eta) h(eta_m - eta) with
    h(x) = 1 - 0.04 x + 3.25 x^3, eta_m = pi/(2 sqrt 3). The constants of m and h are from memory of the literature,
    checked against the free-volume expansion Z_d = 2/alpha + 1.90(1) + ..., alpha = eta_m/eta - 1, of B. J. Alder, W.
    G. Hoover and D. A. Young, J. Chem. Phys. 49, 3688 (1968) only: take a few per cent of doubt above eta = 0.68.

    eta: packing fraction; ValueError unless 0 <= eta < eta_m.
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

    eta: packing fraction.
    """
    if not 0 <= eta <= 0.65:
        raise ValueError(f"the fluid of disks is known for eta from 0 to 0.65, got {eta}")
    one, two = pade(eta, 2), luding_fluid(eta)
    value = 0.5 * (one + two)
    return Estimate(value, doubt=max(abs(one - two), 1e-4 * (value - 1)))


def carnahan_starling(eta: float) -> float:
    """Z of spheres, (1 + eta + eta^2 - eta^3)/(1 - eta)^3 (1969). Too low by 0.05 ... 0.3 % for n from 0.3 to 0.9.

    eta: packing fraction.
    """
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
    shift = [1 / NIST_PARTICLES + number_correction(packing_fraction(x, 3), NIST_PARTICLES, 3) for x in n]
    return n, p / n + np.array(shift)


def sphere_compressibility(eta: float) -> Estimate:
    """Z of the sphere fluid, n <= 0.9: Carnahan-Starling times the known correction; 5e-4 of it uncertain.

    The correction Z_MD/Z_CS comes from `nist_compressibilities`, by monotone cubic interpolation in n, 1 at n = 0. The
    Pade approximant agrees to 1e-4 for n <= 0.8 and to 3e-4 up to 0.9. ValueError above n = 0.9.

    eta: packing fraction.
    """
    from scipy.interpolate import PchipInterpolator

    n = number_density(eta, 3)
    if not 0 <= n <= 0.9 + 1e-12:
        raise ValueError(f"the fluid of spheres is known for number densities from 0 to 0.9, got {n}")
    nodes, z = nist_compressibilities()
    ratio = z / np.array([carnahan_starling(packing_fraction(x, 3)) for x in nodes])
    correct = PchipInterpolator(np.concatenate([[0.0], nodes]), np.concatenate([[1.0], ratio]))
    value = carnahan_starling(eta) * float(correct(min(n, 0.9)))
    return Estimate(value, doubt=5e-4 * value)


def compressibility(eta: float, dimension: int) -> Estimate:
    """Z of the fluid of disks or spheres in the limit of infinitely many.

    eta: packing fraction. dimension: 2 or 3. ValueError as `disk_compressibility` and `sphere_compressibility`.
    """
    demand_dimension(dimension)
    return disk_compressibility(eta) if dimension == 2 else sphere_compressibility(eta)


def contact_value(eta: float, dimension: int) -> Estimate:
    """g at contact, (Z - 1)/(2^(d-1) eta); 1 at eta = 0.

    eta: packing fraction. dimension: d, 2 or 3. ValueError as `compressibility`.
    """
    if eta == 0:
        return Estimate(1.0)
    z = compressibility(eta, dimension)
    scale = 2.0 ** (dimension - 1) * eta
    return Estimate((z.value - 1) / scale, doubt=z.doubt / scale)


def collision_rate(
    eta: float, dimension: int, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0
) -> Estimate:
    """Collisions of one particle per time: 2 n sigma g sqrt(pi T/m) of disks, 4 n sigma^2 g sqrt(pi T/m) of spheres.

    Exact at equilibrium for the exact g (Enskog's is then no approximation); N = infinity.

    eta: packing fraction. dimension: 2 or 3. temperature: T, energy. mass: m. diameter: sigma, length. Any consistent
    units; gives 1/time. ValueError as `compressibility`.
    """
    g = contact_value(eta, dimension)
    n = number_density(eta, dimension, diameter)
    factor = 2 * (dimension - 1) * n * diameter ** (dimension - 1) * (np.pi * temperature / mass) ** 0.5
    return Estimate(factor * g.value, doubt=factor * g.doubt)


# -- few particles -----------------------------------------------------------------------------------------------------


def degrees_of_freedom(number: int, dimension: int, momentum_conserved: bool) -> int:
    """d N, or d (N - 1) in a periodic box whose total momentum is zero; T = 2 K/f with this f and kinetic energy K.

    number: N. dimension: d. momentum_conserved: whether the total momentum is zero.
    """
    demand_dimension(dimension)
    return dimension * (number - 1 if momentum_conserved else number)


def smooth_compressibility(eta: float, dimension: int) -> float:
    """A Z of the fluid with smooth derivatives, for corrections of order 1/N: without an uncertainty.

    eta: packing fraction. dimension: 2 or 3.
    """
    return luding_fluid(eta) if dimension == 2 else pade(eta, 3, 5)


def number_correction(eta: float, number: int, dimension: int) -> float:
    """By how much Z of N particles is below Z of infinitely many: (eta/2N) P''/P' with P = eta Z(eta).

    Derived in `finite_compressibility`.

    eta: packing fraction. number: N. dimension: 2 or 3.
    """
    h = 1e-3
    low, mid, high = ((eta + k * h) * smooth_compressibility(eta + k * h, dimension) for k in (-1, 0, 1))
    return float(eta / number * (high - 2 * mid + low) / (h * (high - low)))


def finite_compressibility(eta: float, number: int, dimension: int) -> Estimate:
    """Z = 1 + sum of sigma |J|/(d N T t) over collisions, of N particles in a periodic box; T = 2K/f, f = d (N - 1).

    The density of pairs at fixed N is that of the infinite system minus (1/2) <dN^2> times its second derivative with
    respect to N (Lebowitz and Percus), <dN^2>/N = dn/d(p/T): Z_N = Z - (eta/2N) P''/P', P = eta Z. This holds to 1/N;
    to second order in density it has, to order 1/N, the exact virial series of N particles, (N-1)/N B_2 n +
    ((N-1)(N-2)/N^2 B_3 + 2 (N-1)/N^2 B_2^2) n^2. There is no kinetic correction: <u_n^2> = 2T with that T. The pressure
    of the box has the ideal part (N - 1)/N in place of 1. Measured, N = 8, 16 disks at eta = 0.3: 1.96623(28),
    2.01512(32), against 1.9664, 2.0148. Doubt: that of Z, and for the terms of order 1/N^2 and the periodic
    images twice the square of the correction over Z - 1.

    eta: packing fraction. number: N, 2 or more. dimension: d, 2 or 3. ValueError as `compressibility`.
    """
    z, shift = compressibility(eta, dimension), number_correction(eta, number, dimension)
    higher = 2 * shift**2 / (z.value - 1) if eta > 0 else 0.0
    return Estimate(z.value - shift, doubt=z.doubt + higher)


def finite_speed_factor(freedoms: int) -> float:
    """Mean relative speed at constant energy over that of the canonical ensemble at T = 2K/f.

    (f/2)^(1/2) Gamma(f/2)/Gamma((f+1)/2) = 1 + 1/4f + ...: the scaled relative velocity of a pair is a set of d
    components of a point uniform on a sphere in f dimensions.

    freedoms: f, 1 or more. Exact.
    """
    from scipy.special import gammaln

    return float((freedoms / 2) ** 0.5 * np.exp(gammaln(freedoms / 2) - gammaln((freedoms + 1) / 2)))


def finite_collision_rate(
    eta: float, number: int, dimension: int, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0
) -> Estimate:
    """Collisions of one of N particles per time in a periodic box; T = 2K/(d (N - 1)).

    The rate of the infinite system times (Z_N - 1)/(Z - 1), the pairs at contact, and `finite_speed_factor`. Measured,
    N = 8, 16 disks at eta = 0.3: 2.2196(7), 2.3091(5), against 2.2201, 2.3093.

    eta: packing fraction. number: N. dimension: d, 2 or 3. temperature: T, energy. mass: m. diameter: sigma, length.
    Any consistent units; gives 1/time. ValueError as `compressibility`.
    """
    rate = collision_rate(eta, dimension, temperature, mass, diameter)
    if eta == 0:
        return rate
    z, few = compressibility(eta, dimension), finite_compressibility(eta, number, dimension)
    factor = (few.value - 1) / (z.value - 1) * finite_speed_factor(degrees_of_freedom(number, dimension, True))
    return Estimate(rate.value * factor, doubt=rate.value * factor * few.doubt / (few.value - 1))


def excess_from_rate(rate: ArrayLike, number: int, dimension: int) -> Floats:
    """Z_N - 1 of N particles in a periodic box, from the collisions of one of them per time; T = 2K/(d (N - 1)) = 1.

    rate sqrt(pi)/(2 d), over `finite_speed_factor`: the mean impulse of a collision times sigma. Exact in equilibrium
    at constant energy. rate: of any shape, in sqrt(T/m)/sigma. number: N. dimension: d, 2 or 3.
    """
    slowness = finite_speed_factor(degrees_of_freedom(number, dimension, True))
    return np.asarray(np.asarray(rate) * np.pi**0.5 / (2 * dimension * slowness))
