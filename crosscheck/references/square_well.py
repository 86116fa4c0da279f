"""The square-well fluid: a hard core sigma, a well of depth epsilon out to lambda sigma; k_B = m = sigma = epsilon = 1.

T is then T k_B/epsilon. d is the dimension, 2 or 3; n the number density.

Literature: J. A. Barker and D. Henderson, Rev. Mod. Phys. 48, 587 (1976); B. J. Alder and T. E. Wainwright, J. Chem.
Phys. 31, 459 (1959) (dynamics); G. Orkoulas and A. Z. Panagiotopoulos, J. Chem. Phys. 110, 1581 (1999); L. Vega et al.,
J. Chem. Phys. 96, 2296 (1992); J. K. Singh, D. A. Kofke and J. R. Errington, J. Chem. Phys. 119, 3405 (2003).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_spheres import Estimate

Floats = NDArray[np.float64]


# -- the well's edge ---------------------------------------------------------------------------------------------------


class Crossing(NamedTuple):
    """Normal relative velocity after an event at the well's edge, and whether the particle is inside after it.

    velocity: u' along n, and inside: whether r < lambda after it.
    """

    velocity: float
    inside: bool


def entering(u: float, depth: float = 1.0, mass: float = 1.0) -> Crossing:
    """From outside, u = v_ij.n < 0: u' = -sqrt(u^2 + 4 epsilon/m). Energy with the reduced mass m/2.

    Each particle changes by (u' - u) n/2 along n = r_ij/|r_ij|. ValueError for u >= 0.

    u: length/time. depth: epsilon, energy. mass: m of one particle. Any consistent units. Alder and Wainwright (1959).
    """
    if u >= 0:
        raise ValueError(f"a pair that enters the well approaches, got u = {u}")
    return Crossing(-float((u * u + 4 * depth / mass) ** 0.5), True)


def leaving(u: float, depth: float = 1.0, mass: float = 1.0) -> Crossing:
    """From inside, u > 0: u' = sqrt(u^2 - 4 epsilon/m) if that is real and positive, else reflection, u' = -u.

    ValueError for u <= 0.

    u: length/time. depth: epsilon, energy. mass: m of one particle. Any consistent units. Alder and Wainwright (1959).
    """
    if u <= 0:
        raise ValueError(f"a pair that leaves the well recedes, got u = {u}")
    square = u * u - 4 * depth / mass
    return Crossing(float(square**0.5), False) if square > 0 else Crossing(-u, True)


def escaping_fraction(temperature: float) -> float:
    """Of pairs that reach the edge from inside, the share that leaves: exp(-1/T).

    u is flux-weighted with density u exp(-u^2/4T)/2T (m = 1).

    temperature: T, in units of epsilon. Exact in equilibrium.
    """
    return float(np.exp(-1 / temperature))


# -- one pair ----------------------------------------------------------------------------------------------------------


class Pair(NamedTuple):
    """Relative position and velocity of two particles of mass 1, and the events that they went through.

    position, velocity: (d,), in sigma and sqrt(epsilon/m). entered, left, reflected: events at the edge of the well;
    hits: of the core.
    """

    position: Floats
    velocity: Floats
    entered: int = 0
    left: int = 0
    reflected: int = 0
    hits: int = 0


def pair_path(position: Floats, velocity: Floats, duration: float, width: float, depth: float = 1.0) -> Pair:
    """Relative motion of one pair for a time `duration`: free flight, elastic core at 1, edge at `width`.

    position, velocity: (d,), of one particle relative to the other, in sigma and sqrt(epsilon/m). At the edge:
    `entering` and `leaving`. duration: time. width: lambda. depth: of the well, in units of epsilon. Exact to rounding.
    """
    r, v, left_over = np.array(position, dtype=np.float64), np.array(velocity, dtype=np.float64), duration
    inside = bool(r @ r < width**2)
    counts = {"entered": 0, "left": 0, "reflected": 0, "hits": 0}
    while True:
        b, w = float(r @ v), float(v @ v)
        to_core = _first_contact(b, w, float(r @ r) - 1.0)
        to_edge = (
            _last_contact(b, w, float(r @ r) - width**2) if inside else _first_contact(b, w, float(r @ r) - width**2)
        )
        span = min(to_core, to_edge) if inside else to_edge
        if span > left_over:
            return Pair(r + v * left_over, v, **counts)
        r, left_over = r + v * span, left_over - span
        n = r / np.sqrt(r @ r)
        u = float(v @ n)
        if inside and to_core < to_edge:
            after = -u
            counts["hits"] += 1
        elif inside:
            crossing = leaving(u, depth)
            after, inside = crossing
            counts["reflected" if inside else "left"] += 1
        else:
            after, inside = entering(u, depth)
            counts["entered"] += 1
        v = v + (after - u) * n


def _first_contact(b: float, w: float, c: float) -> float:
    """Smaller root of w t^2 + 2 b t + c = 0 for an approach from outside."""
    square = b * b - w * c
    return max(c / (np.sqrt(square) - b), 0.0) if b < 0 and square > 0 else np.inf


def _last_contact(b: float, w: float, c: float) -> float:
    """The positive root from inside, c <= 0."""
    root = np.sqrt(b * b - w * min(c, 0.0))
    if b > 0:
        return max(-min(c, 0.0) / (b + root), 0.0)
    return float((root - b) / w) if w > 0 else np.inf


# -- dilute gas --------------------------------------------------------------------------------------------------------


def _sphere(dimension: int) -> float:
    """Half the volume of the sphere of radius 1: pi/2, 2 pi/3."""
    return {2: np.pi / 2, 3: 2 * np.pi / 3}[dimension]


def second_virial(temperature: ArrayLike, width: float, dimension: int) -> Floats:
    """B_2 = (pi/2 or 2 pi/3) (1 - (lambda^d - 1) (exp(1/T) - 1)).

    temperature: T, any shape. width: lambda, above 1. dimension: d, 2 or 3, else KeyError. In sigma^d. Exact.
    """
    boltzmann = np.expm1(1 / np.asarray(temperature, dtype=np.float64))
    return np.asarray(_sphere(dimension) * (1 - (width**dimension - 1) * boltzmann))


def absolute_virial(temperature: float, width: float, dimension: int) -> float:
    """The integral of |f|/2, f of Mayer: B_2 as if core and well had one sign; the size of what each contributes.

    temperature: T. width: lambda, above 1. dimension: d, 2 or 3, else KeyError. In sigma^d.
    """
    return _sphere(dimension) * (1 + (width**dimension - 1) * float(np.expm1(1 / temperature)))


def third_virial(temperature: float, width: float, dimension: int) -> float:
    """B_3 = -(1/3) integral of f(r_12) f(r_13) f(r_23), f = exp(1/T) - 1 in the well and -1 in the core.

    f = g Theta(lambda) - (1 + g) Theta(1) is a sum of balls, whose convolutions are overlaps of two balls: one integral
    over r_12 remains. Barker and Henderson, Rev. Mod. Phys. 48, 587 (1976).

    temperature: T. width: lambda, above 1. dimension: d, 2 or 3. In sigma^(2d); exact to the quadrature.
    """
    from scipy.integrate import quad

    g = float(np.expm1(1 / temperature))
    balls = ((g, width), (-(1 + g), 1.0))
    surface = 2 * np.pi if dimension == 2 else 4 * np.pi

    def integrand(r: float) -> float:
        mayer = -1.0 if r < 1 else g
        chain = sum(a * b * common_volume(r, p, q, dimension) for a, p in balls for b, q in balls)
        return surface * r ** (dimension - 1) * mayer * chain

    inner, _ = quad(integrand, 0, 1, epsabs=1e-11, epsrel=1e-10, points=[width - 1])
    outer, _ = quad(integrand, 1, width, epsabs=1e-11, epsrel=1e-10)
    return float(-(inner + outer) / 3)


def common_volume(r: float, p: float, q: float, dimension: int) -> float:
    """Volume (area) common to two balls (disks) of radii p and q whose centres are r apart.

    r, p, q: lengths. dimension: 2 or 3. Length^dimension; by derivation from the volume of two caps.
    """
    if r >= p + q:
        return 0.0
    if r <= abs(p - q):
        least = min(p, q)
        return np.pi * least**2 if dimension == 2 else 4 / 3 * np.pi * least**3
    if dimension == 3:
        return float(np.pi * (p + q - r) ** 2 * (r * r + 2 * r * (p + q) - 3 * (p - q) ** 2) / (12 * r))
    one = np.arccos((r * r + p * p - q * q) / (2 * r * p))
    two = np.arccos((r * r + q * q - p * p) / (2 * r * q))
    return float(p * p * (one - np.sin(2 * one) / 2) + q * q * (two - np.sin(2 * two) / 2))


def boyle_temperature(width: float, dimension: int) -> float:
    """T at which B_2 = 0: 1/ln(lambda^d/(lambda^d - 1)); 2.84578 for lambda = 1.5 in three dimensions.

    width: lambda, above 1. dimension: d, 2 or 3. Exact.
    """
    power = width**dimension
    return float(-1 / np.log1p(-1 / power))


def dilute_compressibility(density: float, temperature: float, width: float, dimension: int) -> Estimate:
    """Z = 1 + B_2 n; off by (B n)^2 at most, B the larger of |B_2| and its value without the hard core's part.

    The size of the next term is B_3 n^2, and |B_3| may exceed B_2^2: for n |B| << 1 only.

    density: n, in sigma^-d. temperature: T. width: lambda, above 1. dimension: d, 2 or 3, else KeyError.
    """
    b2 = float(second_virial(temperature, width, dimension))
    size = absolute_virial(temperature, width, dimension)
    return Estimate(1 + b2 * density, doubt=(size * density) ** 2)


def dilute_energy(density: float, temperature: float, width: float, dimension: int) -> Estimate:
    """Potential energy a particle, -(pi/2 or 2 pi/3) n (lambda^d - 1) exp(1/T), to first order in n.

    g = exp(1/T) in the well. The next order is relatively of the size of n B, as in `dilute_compressibility`.

    density: n, in sigma^-d. temperature: T. width: lambda, above 1. dimension: d, 2 or 3, else KeyError. In epsilon;
    the doubt is that of the next order.
    """
    shell = _sphere(dimension) * (width**dimension - 1)
    size = absolute_virial(temperature, width, dimension)
    value = float(-shell * density * np.exp(1 / temperature))
    return Estimate(value, doubt=abs(value) * 2 * size * density)


# -- structure and pressure --------------------------------------------------------------------------------------------


def edge_ratio(temperature: float) -> float:
    """g(lambda-)/g(lambda+) = exp(1/T), exact at any density: the cavity function is continuous.

    temperature: T, in units of epsilon.
    """
    return float(np.exp(1 / temperature))


def virial_compressibility(
    density: float, core: float, inner: float, outer: float, width: float, dimension: int
) -> float:
    """Z = 1 + (pi/2 or 2 pi/3) n (g(1+) - lambda^d (g(lambda-) - g(lambda+))); core = g(1+), inner and outer at lambda.

    Exact. From -r phi' exp(-phi/T) = T (exp(1/T) delta(r - 1) - (exp(1/T) - 1) lambda delta(r - lambda)) times the
    cavity function.

    density: n, in sigma^-d. core, inner, outer: g, without unit. width: lambda. dimension: d, 2 or 3, else KeyError.
    """
    return float(1 + _sphere(dimension) * density * (core - width**dimension * (inner - outer)))


class StatePoint(NamedTuple):
    """A simulated state, in the units of the top.

    density: n. temperature: T. energy: potential, a particle. core: g at the core; inner, outer: g on both sides of the
    edge. compressibility: Z.
    """

    density: float
    temperature: float
    energy: Estimate
    core: Estimate
    inner: Estimate
    outer: Estimate
    compressibility: Estimate


def _point(n: float, t: float, u: tuple[float, float], g: tuple[float, float, float], z: float) -> StatePoint:
    core, inner, outer = (Estimate(x, doubt=0.01 * x) for x in g)
    # Z is a difference of terms, each off by up to 1 %
    size = 2 * np.pi / 3 * n
    error = 0.01 * size * (g[0] + 1.5**3 * (g[1] - g[2]))
    return StatePoint(n, t, Estimate(*u), core, inner, outer, Estimate(z, doubt=error))


#: lambda = 1.5, three dimensions: own Monte Carlo at constant N, V, T with N = 256, 9000 sweeps. The error of the
#: energy is statistical; that of g about 1 % (extrapolation to contact) and of Z what follows; no finite-size error is
#: assessed.
WIDTH = 1.5
STATES = (
    _point(0.1, 2.0, (-0.790, 0.003), (1.645, 1.570, 0.954), 0.909),
    _point(0.3, 1.5, (-2.435, 0.005), (1.851, 1.573, 0.808), 0.541),
    _point(0.7, 1.5, (-5.276, 0.004), (2.776, 1.152, 0.592), 2.30),
    _point(0.5, 2.0, (-3.660, 0.003), (2.007, 1.273, 0.772), 1.33),
)


class CriticalPoint(NamedTuple):
    """Critical temperature and density with their published errors.

    temperature: T. density: n. source: authors and year.
    """

    temperature: Estimate
    density: Estimate
    source: str


#: lambda = 1.5, three dimensions. From memory of the literature; the three agree within their errors, nothing else was
#: checked. The error of the density of Singh et al. was not at hand: half a unit of the third digit.
CRITICAL_POINTS = (
    CriticalPoint(Estimate(1.2180, 0.0002), Estimate(0.310, 0.001), "Orkoulas and Panagiotopoulos 1999"),
    CriticalPoint(Estimate(1.219, 0.008), Estimate(0.299, 0.023), "Vega et al. 1992"),
    CriticalPoint(Estimate(1.2172, 0.0007), Estimate(0.308, 0.0005), "Singh, Kofke and Errington 2003"),
)
