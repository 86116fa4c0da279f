"""The Lennard-Jones fluid: direct pair sums in plain numpy, long-range corrections, and published equations of state.

Reduced units: epsilon = sigma = m = k_B = 1 where nothing else is said. Literature: J. Kolafa and I. Nezbeda, Fluid
Phase Equilib. 100, 1 (1994); M. Thol et al., J. Phys. Chem. Ref. Data 45, 023101 (2016), both as implemented in teqp
(I. H. Bell et al., Ind. Eng. Chem. Res. 61, 6010 (2022)); M. P. Allen and D. J. Tildesley, Computer Simulation of
Liquids (1987), section 2.8, for the corrections.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.scene import Floats, LennardJones, Scene, State


class PairSum(NamedTuple):
    """Forces, potential energy and virial of a configuration, with the scale of their rounding.

    forces: (N, d), energy/length. energy, virial: energies. force_scale: (N,), sum over neighbours of |f_ij|.
    energy_scale, virial_scale: the same sums without signs. sensitivity: the largest relative rounding of one pair
    term, from that of its distance.
    """

    forces: Floats
    energy: float
    virial: float
    force_scale: Floats
    energy_scale: float
    virial_scale: float
    sensitivity: float


@lru_cache(maxsize=1)
def _start(scene: Scene) -> State:
    """The initial state, to be read only: the sums of one scene are asked for at many times."""
    return scene.initial_state()


def pair_sum(scene: Scene, positions: Floats | None = None) -> PairSum:
    """A configuration of the scene, pair by pair from scipy's k-d trees: no code in common with `refimpl`.

    scene: of [lennard_jones], whose units the result has. positions: (N, d), length; None: its initial ones.
    Derivation: the sum over pairs as it is defined, with Lorentz and Berthelot's rules for mixtures (Allen and
    Tildesley 1987): each particle with all images within the cutoff of all others, and with its own images; half of phi
    and of r . f belongs to each of the two partners.
    """
    lj, state = scene.lennard_jones, _start(scene)
    assert lj is not None
    x, d, number = state.positions if positions is None else positions, scene.dimension, scene.number
    i, j, difference = _directed_pairs(x, scene.periods(), lj.cutoff)
    r = np.sqrt((difference**2).sum(axis=1))

    kind, of_species = _kinds(scene), _mixed(lj)
    epsilon, sigma = (values[kind[i], kind[j]] for values in of_species)
    energy, slope = _potential(r, epsilon, sigma)
    at_cutoff, slope_at_cutoff = _potential(np.full_like(r, lj.cutoff), epsilon, sigma)
    if lj.truncation == "shifted":
        energy = energy - at_cutoff
    if lj.truncation == "force_shifted":
        energy = energy - at_cutoff - (r - lj.cutoff) * slope_at_cutoff
        slope = slope - slope_at_cutoff
    vectors = (-slope / r)[:, None] * difference
    forces = np.stack([np.bincount(i, vectors[:, axis], number) for axis in range(d)], axis=1)
    scale: Floats = np.bincount(i, abs(slope), number)
    total, wall_scale = 0.5 * float(energy.sum()), 0.0
    if scene.box is not None and scene.box.wall is not None:
        wall_energy, wall_forces = _walls(scene, x)
        forces += wall_forces
        scale += abs(wall_forces).sum(axis=1)
        total, wall_scale = total + wall_energy, abs(wall_energy)
    largest = float(abs(x).max()) if state.lengths is None else float(max(abs(x).max(), state.lengths.max()))
    return PairSum(
        forces,
        total,
        -0.5 * float((slope * r).sum()),
        scale,
        0.5 * float(abs(energy).sum()) + wall_scale,
        0.5 * float(abs(slope * r).sum()),
        # f ~ r^-13, and a coordinate difference is rounded like the coordinates
        14 * float(largest / r.min(initial=lj.cutoff)),
    )


def _directed_pairs(x: Floats, periods: Floats, cutoff: float) -> tuple[Floats, Floats, Floats]:
    """Particles i, images of particles j nearer than the cutoff, and the vectors from the images to the particles.

    x: (N, d), length. periods: (d,), length, 0 along axes that are not periodic. Each pair is found from both sides.
    """
    from scipy.spatial import cKDTree

    around = periods > 0
    wrapped = x.copy()
    wrapped[:, around] %= periods[around]
    shells = np.zeros(periods.size, dtype=int)
    shells[around] = np.ceil(cutoff / periods[around])
    boxes = np.array(list(product(*(range(-n, n + 1) for n in shells)))) * periods
    images = (wrapped + boxes[:, None]).reshape(-1, periods.size)
    near = ((images >= -cutoff) & (images <= periods + cutoff) | ~around).all(axis=1)
    places = np.flatnonzero(near)
    found = cKDTree(wrapped).sparse_distance_matrix(cKDTree(images[places]), cutoff, output_type="ndarray")
    i, images_j = found["i"], places[found["j"]]
    itself = len(x) * (len(boxes) // 2)  # the middle one of the boxes is that of the particles
    apart = images_j != itself + i
    i, images_j = i[apart], images_j[apart]
    return i, images_j % len(x), wrapped[i] - images[images_j]


def _potential(r: Floats, epsilon: Floats, sigma: Floats) -> tuple[Floats, Floats]:
    """phi and d phi/dr."""
    s6 = (sigma / r) ** 6
    return 4 * epsilon * (s6 * s6 - s6), -24 * epsilon * (2 * s6 * s6 - s6) / r


def _mixed(lj: LennardJones) -> tuple[Floats, Floats]:
    """epsilon_ij and sigma_ij of pairs of species, (S, S), by Lorentz and Berthelot's rules; S = 1 if all are alike."""
    epsilons, sigmas = np.broadcast_arrays(np.atleast_1d(lj.epsilon), np.atleast_1d(lj.length))
    if lj.length_form == "r_m":
        sigmas = sigmas / 2 ** (1 / 6)
    return np.sqrt(np.outer(epsilons, epsilons)), 0.5 * np.add.outer(sigmas, sigmas)


def _kinds(scene: Scene) -> NDArray[np.int64]:
    """Rows of `_mixed` of the particles, (N,): their species, or 0 if all are alike."""
    lj = scene.lennard_jones
    assert lj is not None
    alike = scene.species is None or np.size(lj.epsilon) == np.size(lj.length) == 1
    return np.zeros(scene.number, dtype=np.int64) if alike else np.array(scene.species, dtype=np.int64)


def at_cutoff(lj: LennardJones) -> tuple[float, float]:
    """Largest |phi| and |phi'| at the cutoff, among the pairs of species, before any shift.

    By the definition of the potential, with Lorentz and Berthelot's rules for mixtures (Allen and Tildesley 1987).

    lj: of a scene, whose units the result has: energy, and energy/length.
    """
    epsilon, sigma = _mixed(lj)
    energy, slope = _potential(np.full_like(epsilon, lj.cutoff), epsilon, sigma)
    return float(np.abs(energy).max()), float(np.abs(slope).max())


def energy_of_the_cut(scene: Scene, positions: Floats) -> float:
    """Sum of phi_ij(r_c) over the pairs and images within the cutoff: by which "truncated" is above "shifted".

    By definition (Allen and Tildesley 1987), with Lorentz and Berthelot's rules for mixtures. In the scene's own units.

    scene: of [lennard_jones]; its truncation does not count. positions: (N, d), length.
    """
    lj = scene.lennard_jones
    assert lj is not None
    i, j, _ = _directed_pairs(positions, scene.periods(), lj.cutoff)
    kind, (epsilon, sigma) = _kinds(scene), _mixed(lj)
    energy, _ = _potential(np.full_like(epsilon, lj.cutoff), epsilon, sigma)
    return 0.5 * float(energy[kind[i], kind[j]].sum())


def _walls(scene: Scene, x: Floats) -> tuple[float, Floats]:
    assert scene.box is not None
    assert scene.box.wall is not None
    wall, lengths = scene.box.wall, scene.lengths()
    assert lengths is not None
    energy, forces = 0.0, np.zeros_like(x)
    epsilon, sigma = np.array(wall.epsilon), np.array(wall.sigma)
    shift = _potential(np.array(wall.cutoff), epsilon, sigma)[0]
    for axis, boundary in enumerate(scene.boundaries):
        if boundary == "wall":
            for sign, distance in ((1.0, x[:, axis]), (-1.0, lengths[axis] - x[:, axis])):
                near = distance < wall.cutoff
                value, slope = _potential(distance[near], epsilon, sigma)
                energy += float((value - shift).sum())
                forces[near, axis] -= sign * slope
    return energy, forces


class Tail(NamedTuple):
    """Long-range corrections of a one-species fluid beyond the cutoff, in reduced units.

    energy: a particle. pressure: energy/length^3.
    """

    energy: float
    pressure: float


def tail(density: float, cutoff: float) -> Tail:
    """Three dimensions, g(r) = 1 beyond the cutoff.

    u = (8/3) pi rho (rc^-9/3 - rc^-3), p = (16/3) pi rho^2 ((2/3) rc^-9 - rc^-3).

    density: rho, 1/length^3, and cutoff: rc, length, in reduced units. Allen and Tildesley (1987), section 2.8.
    """
    r3, r9 = cutoff**-3, cutoff**-9
    return Tail(8 / 3 * np.pi * density * (r9 / 3 - r3), 16 / 3 * np.pi * density**2 * (2 / 3 * r9 - r3))


def tail_corrections(scene: Scene) -> tuple[float, float]:
    """Total potential energy and pressure of the pairs beyond the cutoff, if they were distributed uniformly (g = 1).

    U = (1/2V) sum_ij int_rc^inf phi_ij(r) S r^(d-1) dr, p = -(1/2dV^2) sum_ij int_rc^inf r phi_ij'(r) S r^(d-1) dr,
    with S = 4 pi in three dimensions and 2 pi in two, sums over all i and j; mixtures by Lorentz and Berthelot. In the
    scene's own units. Allen and Tildesley (1987), section 2.8.

    scene: of [lennard_jones]. ValueError unless all axes are periodic and the truncation is "truncated": of the shifted
    potentials the tail is not all that differs from phi.
    """
    lj, state, d = scene.lennard_jones, scene.initial_state(), scene.dimension
    assert lj is not None
    if set(scene.boundaries) != {"periodic"}:
        raise ValueError("tail corrections need a periodic box: they assume a uniform fluid beyond the cutoff")
    if lj.truncation != "truncated":
        raise ValueError("tail corrections belong to truncation 'truncated', not to a shifted potential")
    lengths = np.atleast_1d(lj.length) / (2 ** (1 / 6) if lj.length_form == "r_m" else 1.0)
    parameters = np.stack(np.broadcast_arrays(np.atleast_1d(lj.epsilon), lengths))  # (2, species)
    species: Floats = np.zeros(scene.number, dtype=int)
    if parameters.shape[1] > 1 and state.species is not None:
        species = state.species
    (epsilons, sigmas), counts = np.unique(parameters[:, species], axis=1, return_counts=True)
    epsilon = np.sqrt(np.outer(epsilons, epsilons))
    s6 = (0.5 * np.add.outer(sigmas, sigmas)) ** 6
    volume, sphere = scene.volume(), 4 * np.pi if d == 3 else 2 * np.pi
    pairs = np.outer(counts, counts) / (2 * volume) * sphere
    repulsion = 4 * epsilon * s6**2 * lj.cutoff ** (d - 12) / (12 - d)
    attraction = 4 * epsilon * s6 * lj.cutoff ** (d - 6) / (6 - d)
    energy = float((pairs * (repulsion - attraction)).sum())
    virial = float((pairs * (12 * repulsion - 6 * attraction)).sum())
    return energy, virial / (d * volume)


def cut_diffusion(scene: Scene, temperature: float, dt: float, volume: float) -> float:
    """Variance of the energy that a step of the force at the cutoff adds per time, in steps of Verlet's kind.

    A pair that passes the cutoff with the relative velocity v along its line within a step of length dt gets the force
    F = phi'(rc) for a part of the step that is off by up to dt/2: the energy changes by up to |F v| dt/2, evenly
    distributed, with the variance (F v dt)^2/12. Pairs of the species i and j pass at the rate n_i n_j/(2V) S rc^(d-1)
    <|v|>, with S = 4 pi in three dimensions and 2 pi in two, g(rc) = 1, and v normal with the variance T (1/m_i +
    1/m_j) = s^2; in the mean over those that pass, <v^2> = 2 s^2, and <|v|> = (2/pi)^(1/2) s. 0 for truncation
    "force_shifted".

    scene: of [lennard_jones]. temperature: T, energy. dt: time. volume: V, length^d, that they fill. By the derivation
    above.
    """
    lj, state, d = scene.lennard_jones, _start(scene), scene.dimension
    assert lj is not None
    if lj.truncation == "force_shifted":
        return 0.0
    (kinds, masses), counts = np.unique(np.vstack([_kinds(scene), state.masses]), axis=1, return_counts=True)
    species = np.ix_(kinds.astype(int), kinds.astype(int))
    epsilon, sigma = (values[species] for values in _mixed(lj))
    _, force = _potential(np.full_like(epsilon, lj.cutoff), epsilon, sigma)
    s2 = temperature * np.add.outer(1 / masses, 1 / masses)
    surface = (4 * np.pi if d == 3 else 2 * np.pi) * lj.cutoff ** (d - 1)
    rates = np.outer(counts, counts) / (2 * volume) * surface * np.sqrt(2 / np.pi * s2)
    return float((rates * force**2 * 2 * s2).sum()) * dt**2 / 12


def open_cluster(positions: Floats, velocities: Floats, times: Floats) -> Floats:
    """Positions (times, N, d) of untruncated Lennard-Jones particles of mass 1 in open space.

    Dormand and Prince's method of order 8 (Hairer, Norsett and Wanner, 1993, section II.5), relative tolerance 1e-13.

    positions, velocities: (N, d) at time 0. times: (times,), ascending from 0 or later; reduced units.
    """
    from scipy.integrate import solve_ivp

    shape = positions.shape

    def derivative(_: float, state: Floats) -> Floats:
        x, v = state.reshape(2, *shape)
        apart = x[:, None, :] - x[None, :, :]
        square = (apart**2).sum(axis=-1)
        np.fill_diagonal(square, np.inf)
        s6 = square**-3
        a = ((48 * s6 * s6 - 24 * s6) / square)[:, :, None] * apart
        return np.concatenate([v.ravel(), a.sum(axis=1).ravel()])

    start = np.concatenate([positions.ravel(), velocities.ravel()])
    done = solve_ivp(derivative, (0.0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13)
    return np.asarray(done.y[: positions.size].T.reshape(-1, *shape))


class StatePoint(NamedTuple):
    """Residual internal energy a particle and pressure, each the mean of two equations of state, and half their gap.

    energy, pressure: reduced units. energy_uncertainty, pressure_uncertainty: the half gaps, in the same units.
    """

    energy: float
    energy_uncertainty: float
    pressure: float
    pressure_uncertainty: float


def equation_of_state(temperature: float, density: float) -> StatePoint:
    """Kolafa-Nezbeda (1994) and Thol et al. (2016); fluid states, 0.7 < T < 6, density < 1.

    temperature: T, and density: rho, 1/length^3, in reduced units. ImportError without teqp.
    """
    import teqp

    values = []
    for kind in ("LJ126_KolafaNezbeda1994", "LJ126_TholJPCRD2016"):
        model = teqp.make_model({"kind": kind, "model": {}})
        z = np.array([1.0])
        energy = temperature * model.get_Ar10(temperature, density, z)
        pressure = density * temperature * (1 + model.get_Ar01(temperature, density, z))
        values.append((energy, pressure))
    (u1, p1), (u2, p2) = values
    return StatePoint((u1 + u2) / 2, abs(u1 - u2) / 2, (p1 + p2) / 2, abs(p1 - p2) / 2)
