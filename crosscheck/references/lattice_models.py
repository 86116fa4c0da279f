"""Lattice gases as they are defined in print: velocities and collisions, and the Boltzmann equation that follows.

Units: links and steps. A site has b channels, each empty or filled; channel i moves its particle by c_i in a step. Bit
i of a site's state is the occupation of channel i; f_i is its mean. On the square lattice the channels are the four
links, counter-clockwise from +x, on the triangular one the six links at multiples of 60 degrees, and the particle at
rest last. Everything is summed over the states of a site: slow, and short enough to be read.

Literature: J. Hardy, Y. Pomeau and O. de Pazzis, J. Math. Phys. 14, 1746 (1973) (HPP); U. Frisch, B. Hasslacher and Y.
Pomeau, Phys. Rev. Lett. 56, 1505 (1986) (FHP-I); U. Frisch et al., Complex Systems 1, 649 (1987) (FHP-II, equilibrium,
linear modes); D. d'Humieres and P. Lallemand, Complex Systems 1, 599 (1987) (FHP-III); M. Henon, Complex Systems 1, 762
(1987) (collision matrix of any table).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

_SQUARE = ((1, 0), (0, 1), (-1, 0), (0, -1))
_HEXAGON = ((2, 0), (1, 1), (-1, 1), (-2, 0), (-1, -1), (1, -1))
_HALF = (0.5, math.sqrt(3) / 2)


@dataclass(frozen=True)
class Velocities:
    """The velocities of the channels of a model.

    integers: (b, 2), c_i in the units `unit`. unit: (2,), x and y, in links per step.
    """

    integers: tuple[tuple[int, int], ...]
    unit: tuple[float, float]

    @property
    def channels(self) -> int:
        """b."""
        return len(self.integers)

    @property
    def rest(self) -> bool:
        """There is a particle at rest."""
        return (0, 0) in self.integers

    @property
    def cartesian(self) -> NDArray[np.float64]:
        """c_i, (b, 2), in links per step."""
        return np.array(self.integers) * np.array(self.unit)

    @property
    def row_height(self) -> float:
        """Distance between rows of sites, in links."""
        return self.unit[1]


_TRIANGULAR = Velocities(_HEXAGON, _HALF)
_TRIANGULAR_REST = Velocities((*_HEXAGON, (0, 0)), _HALF)
#: By the name of the model. fhp_saturated: all collisions of six bits; with "_identity", nothing happening is one of
#: the equally likely outcomes.
VELOCITIES = {
    "hpp": Velocities(_SQUARE, (1.0, 1.0)),
    "fhp1": _TRIANGULAR,
    "fhp2": _TRIANGULAR_REST,
    "fhp3": _TRIANGULAR_REST,
    "fhp_saturated": _TRIANGULAR,
    "fhp_saturated_identity": _TRIANGULAR,
}
MODELS = tuple(VELOCITIES)


def momenta(model: str, counts: ArrayLike) -> NDArray[np.float64]:
    """sum_i c_i n_i in units of `Velocities.unit`, (..., 2), whole numbers for whole n; counts: n_i, (..., b).

    model: a name of `MODELS`, else KeyError.
    """
    return np.asarray(np.asarray(counts, dtype=np.float64) @ np.array(VELOCITIES[model].integers, dtype=float))


def momentum_flux(model: str, occupations: ArrayLike) -> NDArray[np.float64]:
    """P_ab = sum_i c_ia c_ib f_i, (..., 2, 2), in particles per site; occupations: f_i, (..., b).

    model: a name of `MODELS`, else KeyError.
    """
    c = VELOCITIES[model].cartesian
    return np.asarray(np.einsum("...i,ia,ib->...ab", np.asarray(occupations, dtype=np.float64), c, c))


# -- equilibrium -----------------------------------------------------------------------------------------


def fermi_dirac(model: str, density: ArrayLike, velocity: ArrayLike) -> NDArray[np.float64]:
    """Equilibrium f_i = 1/(1 + exp(h + q.c_i)) with sum f_i = b d and sum f_i c_i = b d u, (..., b), to rounding.

    density: d (...), the mean occupation, between 0 and 1. velocity: u (..., 2), links per step; not near the largest
    that d allows: ArithmeticError where Newton's method from a gas at rest does not converge.

    model: a name of `MODELS`, else KeyError.
    """
    c, d = VELOCITIES[model].cartesian, np.asarray(density, dtype=np.float64)
    charges = np.column_stack([np.ones(len(c)), c])
    sums = len(c) * d[..., None] * np.insert(np.asarray(velocity, dtype=np.float64), 0, 1.0, axis=-1)
    unknown = np.zeros_like(sums)
    unknown[..., 0] = np.log(1 / d - 1)
    for _ in range(50):
        f = 1 / (1 + np.exp(unknown @ charges.T))
        curvature = np.einsum("ia,...i,ib->...ab", charges, f * (1 - f), charges)
        step = np.linalg.solve(curvature, (f @ charges - sums)[..., None])[..., 0]
        unknown = unknown + step
        if np.abs(step).max() < 1e-14 * max(1.0, np.abs(unknown).max()):
            return np.asarray(1 / (1 + np.exp(unknown @ charges.T)))
    raise ArithmeticError(f"no equilibrium found for d = {d.tolist()}, u = {np.asarray(velocity).tolist()}")


def low_speed_equilibrium(model: str, density: float, velocity: ArrayLike) -> NDArray[np.float64]:
    """f_i to O(u^2), (b,): d [1 + u.c_i/c_s^2 + (1 - 2d)/(2 (1 - d) c_s^4) ((u.c_i)^2 - c_s^2 u^2)].

    density: d. velocity: u (2,), links per step. U. Frisch et al. (1987), with c_s^2 = <c^2>/2 for any velocities.

    model: a name of `MODELS`, else KeyError. density between 0 and 1; |u| well below c_s.
    """
    c, d, u = VELOCITIES[model].cartesian, density, np.asarray(velocity, dtype=np.float64)
    square = float((c**2).mean())
    second = (1 - 2 * d) / (2 * (1 - d) * square**2) * ((c @ u) ** 2 - square * (u @ u))
    return np.asarray(d * (1 + c @ u / square + second))


def entropy_density(occupations: ArrayLike) -> NDArray[np.float64]:
    """H of a site, sum_i f_i ln f_i + (1 - f_i) ln(1 - f_i), 0 ln 0 = 0.

    occupations: f_i, (..., b), 0 to 1. Gives (...,).
    """
    f = np.asarray(occupations, dtype=np.float64)
    both = np.stack([f, 1 - f])
    return np.asarray((both * np.log(np.where(both > 0, both, 1.0))).sum(axis=(0, -1)))


# -- collisions ------------------------------------------------------------------------------------------


@cache
def states(model: str) -> NDArray[np.float64]:
    """s_i of every state, (2^b, b).

    model: a name of `MODELS`, else KeyError.
    """
    b = VELOCITIES[model].channels
    return (np.arange(2**b)[:, None] >> np.arange(b) & 1).astype(np.float64)


@cache
def _partners(model: str) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Which states a state can become, (2^b, 2^b), all equally likely, and how many they are, (2^b, 1)."""
    s = states(model)
    mass, (along_x, along_y) = s.sum(axis=1), momenta(model, s).T
    still = np.asarray((along_x == 0) & (along_y == 0))
    resting = s[:, 6] if VELOCITIES[model].rest else np.zeros(len(s))
    movers = mass - resting

    def same(values: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.asarray(values[:, None] == values)

    conserved = same(mass) & same(along_x) & same(along_y)
    if model == "fhp1":  # head-on pairs, and triples at 120 degrees
        conserved &= (still & (mass <= 3))[:, None]
    elif model == "fhp2":  # the same, beside a particle at rest or not; and one at rest and a mover <-> two movers
        turning = (still & (movers <= 3))[:, None] & same(resting)
        conserved &= turning | (~still & (mass == 2))[:, None]
    elif model == "fhp3":  # all, but that without momentum the particle at rest takes no part
        conserved &= ~still[:, None] | same(resting)
    identity = np.eye(len(s), dtype=bool)
    partners = conserved | identity if model == "fhp_saturated_identity" else conserved & ~identity
    partners |= identity & ~partners.any(axis=1, keepdims=True)
    return partners, partners.sum(axis=1, keepdims=True)


def transitions(model: str) -> NDArray[np.float64]:
    """A(s -> t), the probability that a collision turns state s into t, (2^b, 2^b).

    model: a name of `MODELS`, else KeyError.
    """
    partners, number = _partners(model)
    return np.asarray(partners / number)


@cache
def _changes(model: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of the states that a collision can change: s_i, and the mean change of it, both (n, b)."""
    s = states(model)
    partners, number = _partners(model)
    change = partners @ s / number - s
    active = change.any(axis=1)
    return s[active], change[active]


def mean_collision(model: str, occupations: ArrayLike) -> NDArray[np.float64]:
    """Delta_i = sum_s P(s) sum_t A(s -> t) (t_i - s_i), (..., b), P the product of f_j or 1 - f_j.

    The channels are independent. occupations: f_i (..., b) before the collision.

    model: a name of `MODELS`, else KeyError.
    """
    f = np.asarray(occupations, dtype=np.float64)[..., None, :]
    s, change = _changes(model)
    return np.asarray(np.where(s > 0, f, 1 - f).prod(axis=-1) @ change)


def linearised_collision(model: str, occupations: ArrayLike) -> NDArray[np.float64]:
    """J_ij = d Delta_i/d f_j, (b, b), by dP/df_j = P (s_j - f_j)/(f_j (1 - f_j)).

    occupations: f_i (b,), none of them 0 or 1.

    model: a name of `MODELS`, else KeyError.
    """
    f = np.asarray(occupations, dtype=np.float64)
    s, change = _changes(model)
    probability = np.where(s > 0, f, 1 - f).prod(axis=1)
    return np.asarray(change.T @ (probability[:, None] * (s - f) / (f * (1 - f))))


# -- linear modes ----------------------------------------------------------------------------------------


class Modes(NamedTuple):
    """Rates of small waves exp(i (k.r - omega t) - alpha t), per step: of shear, and of the sound that runs along k.

    shear_decay, sound_damping: alpha. shear_frequency, sound_frequency: omega, radians; all per step. kinetic: the
    largest factor, 0 to 1, that a mode which is not hydrodynamic is multiplied by in a step.
    """

    shear_decay: float
    shear_frequency: float
    sound_damping: float
    sound_frequency: float
    kinetic: float


def modes(model: str, density: float, wavevector: ArrayLike, velocity: ArrayLike = (0.0, 0.0)) -> Modes:
    """Hydrodynamic modes of the linearised lattice Boltzmann equation about equilibrium, a -> (1 + J) exp(-i k.c) a.

    They are the three slowest: shear, whose frequency is the smallest, and two sound waves. density: d. wavevector: k
    (2,), in 1/links, so small that these three decay less in a step than all others: c_s |k| and k^2 nu below the
    slowest relaxation rate. velocity: u (2,), links per step, |u| well below c_s.

    model: a name of `MODELS`, else KeyError.
    """
    k, c = np.asarray(wavevector, dtype=np.float64), VELOCITIES[model].cartesian
    collision = linearised_collision(model, fermi_dirac(model, density, velocity))
    values = np.linalg.eigvals((np.eye(len(c)) + collision) * np.exp(-1j * (c @ k)))
    values = values[np.argsort(np.abs(values))]
    sound, shear, _ = sorted(np.log(values[-3:]), key=lambda exponent: float(exponent.imag))
    return Modes(-shear.real, -shear.imag, -sound.real, -sound.imag, float(np.abs(values[-4])))


def green_kubo(model: str, density: float, weights: ArrayLike, frequency: float) -> float:
    """(sum_t C(t) cos(omega t) - C(0)/2)/chi of the moment sum_i w_i f_i of a gas at rest, links^2 per step.

    C(t) = w.(1 + J)^t w, chi = c_y.c_y, by the linearised lattice Boltzmann equation: a transport coefficient at the
    frequency of a wave, without what the length of the wave changes. U. Frisch et al. (1987).

    density: d. weights: w (b,), links^2 per step^2, orthogonal to what is conserved, so that C decays. frequency:
    omega, radians per step.

    model: a name of `MODELS`, else KeyError.
    """
    w, c_y = np.asarray(weights, dtype=np.float64), VELOCITIES[model].cartesian[:, 1]
    step = np.eye(len(w)) + linearised_collision(model, fermi_dirac(model, density, (0.0, 0.0)))
    # least squares: at frequency 0 the matrix has no inverse, for what is conserved
    sums = np.linalg.lstsq(np.eye(len(w)) - np.exp(1j * frequency) * step, w.astype(np.complex128), rcond=1e-12)[0]
    return float((w @ sums.real - w @ w / 2) / (c_y @ c_y))
