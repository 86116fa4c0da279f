"""Theory of lattice gases for any velocity set and any collision table: equilibrium, transport, modes, isotropy.

Units: lattice links, steps, particle masses. b channels with velocities c_i; d is the mean occupation of a channel, the
density per site rho = b d, u the mean velocity, f_i the mean occupations, with the channels on the last axis. D = 2.
<..> is the mean over the channels; <c_a c_b> = c_s^2 delta_ab.

Arguments that are the same throughout: model: the lattice gas. velocities: its velocity set. density: d, between 0 and
1, else ValueError. f: (..., b) mean occupations.

The transport coefficients are those of the Boltzmann approximation: occupations of a site are independent before a
collision. The true ones of FHP gases are larger away from d = 1/2, and grow with the size of the box.

Literature: U. Frisch, D. d'Humieres, B. Hasslacher, P. Lallemand, Y. Pomeau and J.-P. Rivet, Complex Systems 1, 649
(1987); M. Henon, Complex Systems 1, 762 (1987) (viscosity); L. P. Kadanoff, G. R. McNamara and G. Zanetti, Phys. Rev. A
40, 4527 (1989) (what the Boltzmann approximation misses); S. Wolfram, J. Stat. Phys. 45, 471 (1986) (isotropy of
polygons); F. Bach, Electron. J. Stat. 4, 384 (2010) (the damping of Newton's method).
"""

from __future__ import annotations

from functools import cache
from itertools import combinations
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.lattice.models import Model
from refimpl.lattice.velocities import VelocitySet

Floats: TypeAlias = NDArray[np.float64]

# -- equilibrium -------------------------------------------------------------------------------------------------------


def _densities(density: ArrayLike) -> Floats:
    d = np.asarray(density, dtype=np.float64)
    wrong = ~((d > 0) & (d < 1))
    if wrong.any():
        raise ValueError(f"the mean occupation must be between 0 and 1, got {d[wrong][0]}")
    return d


def _states(density: ArrayLike, velocity: ArrayLike) -> tuple[Floats, Floats]:
    """d (...) and u (..., 2), broadcast."""
    d, u = _densities(density), np.asarray(velocity, dtype=np.float64)
    if u.ndim == 0 or u.shape[-1] != 2:
        raise ValueError(f"a velocity has two components on the last axis, got an array of shape {u.shape}")
    shape = np.broadcast_shapes(d.shape, u.shape[:-1])
    return np.broadcast_to(d, shape), np.broadcast_to(u, (*shape, 2))


def fermi_dirac(velocities: VelocitySet, density: ArrayLike, velocity: ArrayLike) -> Floats:
    """Equilibrium f_i = 1/(1 + exp(h + q.c_i)) with sum_i f_i = b d, sum_i f_i c_i = b d u; (..., b).

    density (...) and velocity (..., 2) are broadcast. The sums are met to about 1e-15 b d. ValueError where d is not
    between 0 and 1, and where no occupations between 0 and 1 have this density and this velocity.
    """
    d, u = _states(density, velocity)
    f = np.repeat(d[..., None], velocities.channels, axis=-1)
    moving = u.any(axis=-1)
    if moving.any():
        f[moving] = _moving_equilibrium(velocities, d[moving], u[moving])
    return f


#: Points that are solved at once: their arrays stay in the cache.
_BATCH = 4096
#: More than any point needs: far from the solution an exponent changes by about ln 2 a step.
_ITERATIONS = 500


def _moving_equilibrium(velocities: VelocitySet, d: Floats, u: Floats) -> Floats:
    """As `fermi_dirac`, d (n,) and u (n, 2), no u zero."""
    charges = np.vstack([np.ones(velocities.channels), np.array(velocities.integers, dtype=np.float64).T])
    pairs = np.array(list(combinations(range(velocities.channels), 2))).T
    normals = np.cross(charges[:, pairs[0]].T, charges[:, pairs[1]].T)
    # the sums that occupations in (0, 1) can have fill a convex body, whose faces are spanned by pairs of channels
    heights = normals @ charges
    low, high = np.minimum(heights, 0).sum(axis=1)[:, None], np.maximum(heights, 0).sum(axis=1)[:, None]
    f = np.empty((d.size, velocities.channels))
    for first in range(0, d.size, _BATCH):
        part = slice(first, first + _BATCH)
        density, velocity = d[part], u[part]
        targets = np.vstack([np.ones(density.size), (velocity / np.array(velocities.unit)).T])
        targets *= velocities.channels * density
        level = normals @ targets
        wrong = ~((level > low) & (level < high)).all(axis=0)
        if wrong.any():
            found = tuple(velocity[wrong][0].tolist())
            raise ValueError(f"no occupations have mean {density[wrong][0]} and velocity {found}")
        f[part] = _newton(charges, pairs, normals, density, targets).T
    return f


def _newton(charges: Floats, pairs: NDArray[np.int64], normals: Floats, d: Floats, targets: Floats) -> Floats:
    """f_i = w/(1 + w), w = d/(1 - d) exp(theta.a_i), sum_i a_i f_i = targets, a_i the columns of charges; (b, n).

    theta minimises sum_i ln(1 + w_i) - theta.targets. The Newton step is scaled by ln(1 + r)/r, r its largest change of
    an exponent: that decreases the function from any point, and converges quadratically in the end.
    """
    # the exponents are kept, not theta: near a face theta is large and an exponent the small sum of large terms
    exponents, unmoved = np.zeros((len(charges.T), d.size)), d / (1 - d)
    volumes = (charges.T @ normals.T) ** 2 / 3
    rounding = 8 * np.finfo(float).eps * len(charges.T)
    left = np.arange(d.size)
    for _ in range(_ITERATIONS):
        odds = unmoved[left] * np.exp(exponents[:, left])
        f = odds / (1 + odds)
        gap = (targets[:, left] - charges @ f) / d[left]
        # sum_i f_i (1 - f_i) a_i a_i^T is inverted by Cauchy and Binet's sums of positive terms: no cancellation
        weight = f / (1 + odds) / d[left]
        both = weight[pairs[0]] * weight[pairs[1]]
        determinant = (weight * (volumes @ both)).sum(axis=0)
        step = charges.T @ (normals.T @ (both * (normals @ gap)) / determinant)
        reach = np.abs(step).max(axis=0)
        exponents[:, left] += step * np.log1p(reach) / np.maximum(reach, np.finfo(float).tiny)
        left = left[(reach > 1e-8) & (np.abs(gap).max(axis=0) > rounding)]
        if left.size == 0:
            break
    else:
        raise ArithmeticError(f"no equilibrium found for the sums {targets[:, left[0]].tolist()}")
    odds = unmoved * np.exp(exponents)
    return np.asarray(odds / (1 + odds))


def low_speed_equilibrium(velocities: VelocitySet, density: ArrayLike, velocity: ArrayLike) -> Floats:
    """Equilibrium to O(u^2); (..., b), for density (...) and velocity (..., 2).

    f_i = d [1 + u.c_i/c_s^2 + (1 - 2d)/(2 (1 - d) c_s^4) ((u.c_i)^2 - c_s^2 u^2)]: the sums are exactly b d and b d u.
    Without a rest channel c_s^2 = c^2/D, and this is Frisch et al.'s formula.
    """
    d, u = _states(density, velocity)
    d, square = d[..., None], sound_speed(velocities) ** 2
    along = u @ velocities.cartesian.T
    quadratic = along**2 - square * (u**2).sum(axis=-1, keepdims=True)
    return np.asarray(d * (1 + along / square + (1 - 2 * d) / (2 * (1 - d) * square**2) * quadratic))


def sound_speed(velocities: VelocitySet) -> float:
    """c_s = (<c^2>/D)^(1/2): 1/sqrt(2), or sqrt(3/7) with a rest channel on the triangular lattice."""
    return float(np.mean(velocities.cartesian**2)) ** 0.5


def _fourth_moment(velocities: VelocitySet) -> float:
    """e of sum_i c_ia c_ib c_ic c_id = e Delta^(4); ValueError if it is not of this form."""
    tensor = velocity_tensor(velocities.cartesian, 4)
    if not is_isotropic(tensor):
        raise ValueError("the fourth-order velocity tensor is not isotropic")
    return float(tensor[0, 0, 1, 1])


def galilean_factor(velocities: VelocitySet, density: float) -> float:
    """g of the momentum flux rho g u_a u_b: <c_x^2 c_y^2>/c_s^4 (1 - 2d)/(1 - d); 1 would be Galilean invariance.

    D/(D + 2) (1 - 2d)/(1 - d) without a rest channel, 7 (1 - 2d)/(12 (1 - d)) with one. ValueError if the fourth-order
    velocity tensor is not isotropic, as of HPP: the flux is then not of this form.
    """
    d = float(_densities(density))
    moment = _fourth_moment(velocities) / (velocities.channels * sound_speed(velocities) ** 4)
    return moment * (1 - 2 * d) / (1 - d)


def momentum_flux(velocities: VelocitySet, f: ArrayLike) -> Floats:
    """P_ab = sum_i c_ia c_ib f_i; (..., 2, 2) of f (..., b)."""
    c = velocities.cartesian
    return np.asarray(np.einsum("...i,ia,ib->...ab", np.asarray(f, dtype=np.float64), c, c))


def entropy_density(f: ArrayLike) -> Floats:
    """sum_i f_i ln f_i + (1 - f_i) ln(1 - f_i), 0 ln 0 = 0; (...) of f (..., b). Not positive: minus the entropy.

    Occupations that round-off has carried past 0 or 1 count as 0 or 1.
    """
    occupations = np.asarray(f, dtype=np.float64)
    both = np.stack([occupations, 1 - occupations])
    return np.asarray((both * np.log(np.where(both > 0, both, 1.0))).sum(axis=(0, -1)))


# -- collisions --------------------------------------------------------------------------------------------------------


@cache
def _changes(model: Model) -> tuple[NDArray[np.bool_], Floats]:
    """Of the active states: the channels that are occupied, (n, b), and the mean change by a collision, (n, b)."""
    occupied = np.array([[s >> i & 1 for i in range(model.channels)] for s in range(model.velocities.states)])
    active = list(model.active)
    after = np.array([occupied[list(model.outcomes[s])].mean(axis=0) for s in active]).reshape(-1, model.channels)
    return occupied[active].astype(bool), after - occupied[active]


def collision_term(model: Model, f: ArrayLike) -> Floats:
    """Delta_i = sum_ss' (s'_i - s_i) A(s -> s') prod_j f_j^s_j (1 - f_j)^(1 - s_j); (..., b) of f (..., b).

    The mean change by a collision, if the occupations of a site are independent.
    """
    occupations = np.asarray(f, dtype=np.float64)
    occupied, change = _changes(model)
    probability = np.ones((*occupations.shape[:-1], len(occupied)))
    for i in range(model.channels):
        here = occupations[..., i, None]
        probability *= np.where(occupied[:, i], here, 1 - here)
    return np.asarray(probability @ change)


def collision_matrix(model: Model, f: ArrayLike) -> Floats:
    """J_ij = d Delta_i/d f_j, (b, b), at f (b,).

    At f = d: -1/2 sum_ss' (s_i - s'_i) A(s -> s') d^(p-1) (1 - d)^(b-p-1) (s_j - s'_j), p = sum_i s_i, if A is
    symmetric.
    """
    # Delta is linear in each f_j: its derivative is the difference between f_j = 1 and f_j = 0, exactly
    ends = np.tile(np.asarray(f, dtype=np.float64), (2, model.channels, 1))
    for value in (0, 1):
        np.fill_diagonal(ends[value], value)
    empty, full = collision_term(model, ends)
    return np.asarray((full - empty).T)


def relaxation_rate(model: Model, density: float, moment: ArrayLike) -> float:
    """lambda with J moment = -lambda moment, J at f = d; moment (b,). ValueError if it is no eigenvector, or zero."""
    vector = np.asarray(moment, dtype=np.float64)
    matrix = collision_matrix(model, np.full(model.channels, float(_densities(density))))
    square = float(vector @ vector)
    image = matrix @ vector
    rate = -float(vector @ image) / square if square > 0 else 0.0
    allowed = 1e-10 * float(np.linalg.norm(matrix)) * square**0.5
    if square == 0 or np.linalg.norm(image + rate * vector) > allowed:
        raise ValueError(f"not an eigenvector of the collisions of {model.name}: {vector.tolist()}")
    return rate


def shear_viscosity(model: Model, density: float) -> float:
    """nu = nu_c + nu_p = <c_x^2 c_y^2>/c_s^2 (1/lambda - 1/2), lambda the rate of c_x c_y, in links^2 per step.

    1/(4 lambda) - 1/8 for all FHP gases; nu_p = -c^2/(2 (D + 2)) is due to the propagation on a lattice. ValueError if
    the fourth-order velocity tensor is not isotropic, as of HPP: there is no one shear viscosity then.
    """
    velocities = model.velocities
    moment = _fourth_moment(velocities) / (velocities.channels * sound_speed(velocities) ** 2)
    return moment * (1 / relaxation_rate(model, density, velocities.cartesian.prod(axis=1)) - 0.5)


def bulk_viscosity(model: Model, density: float) -> float:
    """zeta/rho = <r^2>/(D^2 c_s^2) (1/lambda - 1/2), lambda the rate of r_i = c_i^2 - D c_s^2, in links^2 per step.

    (1/lambda - 1/2)/14 with a rest channel; 0 if all particles have one speed, for their energy is their mass.
    """
    c, square = model.velocities.cartesian, sound_speed(model.velocities) ** 2
    excess = (c**2).sum(axis=1) - 2 * square
    if np.allclose(excess, 0, atol=1e-12):
        return 0.0
    return float(np.mean(excess**2)) / (4 * square) * (1 / relaxation_rate(model, density, excess) - 0.5)


# -- modes -------------------------------------------------------------------------------------------------------------


class Modes(NamedTuple):
    """Eigenvalues of one step on a_i of f_i = f_i^eq + Re a_i exp(i k.r), and the hydrodynamic ones as rates.

    eigenvalues: (b,), all of them. shear_decay, sound_damping: alpha, 1/step. shear_frequency, sound_frequency: omega,
    radians/step.

    An eigenvalue exp(-alpha - i omega) multiplies its mode each step: exp(i (k.r - omega t) - alpha t). Shear is the
    mode of the momentum across k, `shear_frequency` its drift with the flow. Sound is the wave that runs along k; the
    other wave is the one of -k, and differs if the gas moves. In a gas at rest the two make a standing wave,
    exp(-alpha t) cos(omega t).
    """

    eigenvalues: NDArray[np.complex128]
    shear_decay: float
    shear_frequency: float
    sound_damping: float
    sound_frequency: float


def modes(model: Model, density: float, wavevector: ArrayLike, velocity: ArrayLike = (0.0, 0.0)) -> Modes:
    """Modes of the linearised lattice Boltzmann equation about equilibrium: a -> (1 + J) exp(-i k.c) a.

    wavevector k (2,), in 1/links, not only small; velocity u (2,). As k -> 0 and u = 0: shear decay nu k^2, sound
    frequency c_s k, sound damping (nu + zeta/rho) k^2/2. A shear mode is the one with the largest part in the
    autocorrelation of the transverse momentum, sound that of c_s times mass plus longitudinal momentum. Models that are
    not isotropic have rates that depend on the direction of k; HPP along an axis keeps the transverse momentum of each
    line, and has no decay of shear. ValueError for k = 0, and as `fermi_dirac`.
    """
    k = np.asarray(wavevector, dtype=np.float64)
    if not k.any():
        raise ValueError("a mode needs a wave vector that is not zero")
    along = k / np.linalg.norm(k)
    c, speed = model.velocities.cartesian, sound_speed(model.velocities)
    f = fermi_dirac(model.velocities, density, velocity)
    operator = (np.eye(model.channels) + collision_matrix(model, f)) * np.exp(-1j * (c @ k))
    values, right = np.linalg.eig(operator)
    left = np.linalg.inv(right)
    # rows: mass, momentum along k, momentum across k; `prepared` changes one of them alone, within local equilibrium
    conserved = np.stack([np.ones(model.channels), c @ along, c @ np.array([-along[1], along[0]])])
    response = f * (1 - f) * conserved
    prepared = response.T @ np.linalg.inv(conserved @ response.T)

    def part(measured: Floats, excited: Floats) -> Floats:
        return np.asarray(np.abs((measured @ conserved @ right) * (left @ prepared @ excited)))

    across = np.array([0.0, 0.0, 1.0])
    shear = int(part(across, across).argmax())
    wave = part(np.array([speed, 1.0, 0.0]), np.array([1.0, speed, 0.0]))
    wave[shear] = 0
    exponents = np.log(values[[shear, int(wave.argmax())]])
    (decay, damping), (drift, frequency) = -exponents.real, -exponents.imag
    return Modes(values, float(decay), float(drift), float(damping), float(frequency))


# -- isotropy ----------------------------------------------------------------------------------------------------------


def polygon(corners: int) -> Floats:
    """Unit vectors (cos 2 pi i/M, sin 2 pi i/M), i = 0 ... M - 1; (M, 2), M = `corners`. ValueError for M < 1."""
    if corners < 1:
        raise ValueError(f"a polygon has at least one corner, got {corners}")
    angles = 2 * np.pi * np.arange(corners) / corners
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def velocity_tensor(vectors: ArrayLike, order: int) -> Floats:
    """E^(n) = sum_i c_i c_i ... c_i, n = `order` factors; n axes of length D, for vectors (M, D). ValueError: n < 1."""
    if order < 1:
        raise ValueError(f"a velocity tensor has order 1 or more, got {order}")
    c = np.asarray(vectors, dtype=np.float64)
    product = c
    for _ in range(order - 1):
        product = product[..., None] * c.reshape(len(c), *(1,) * (product.ndim - 1), -1)
    return np.asarray(product.sum(axis=0))


def _pairings(dimension: int, order: int) -> Floats:
    """Delta^(2n): the sum over the (2n - 1)!! ways to pair the indices of the products of Kronecker's delta."""
    if order == 0:
        return np.ones(())
    first = np.multiply.outer(np.eye(dimension), _pairings(dimension, order - 2))
    return np.asarray(sum(np.moveaxis(first, 1, j) for j in range(1, order)))


def is_isotropic(tensor: ArrayLike, tolerance: float = 1e-12) -> bool:
    """Whether a totally symmetric tensor is isotropic: zero if its order n is odd, a multiple of Delta^(n) if even.

    To `tolerance` in each component, absolute, relative to the largest component if that is above 1.
    """
    entries = np.asarray(tensor, dtype=np.float64)
    form = np.zeros(entries.shape)
    if entries.ndim % 2 == 0:
        pairings = _pairings(entries.shape[0], entries.ndim)
        form = pairings * ((entries * pairings).sum() / (pairings**2).sum())
    return bool(np.abs(entries - form).max() <= tolerance * max(1.0, float(np.abs(entries).max())))
