"""The pair sum against a double loop, the tails against quadrature, and the equations of state against known values."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from crosscheck.references.lennard_jones import (
    PairSum,
    at_cutoff,
    cut_diffusion,
    energy_of_the_cut,
    equation_of_state,
    open_cluster,
    pair_sum,
    tail,
    tail_corrections,
)
from crosscheck.scene import Box, LennardJones, Scene, Wall, explicit

TRUNCATIONS = ("truncated", "shifted", "force_shifted")
CUTOFF = 1.9


def scattered(dimension: int, seed: int, number: int = 14) -> np.ndarray:
    """Particles at random in a box of side 4, none nearer than 0.75 to another, nor to a face."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < number:
        x = rng.uniform(0.75, 3.25, dimension)
        if all(np.linalg.norm(x - y) > 0.75 for y in found):
            found.append(x)
        elif rng.random() < 0.001:
            number -= 1
    return np.array(found)


def scene_of(positions: np.ndarray, box: str = "periodic", mixture: bool = False, **lennard_jones: Any) -> Scene:
    number, dimension = positions.shape
    boundaries = {
        "periodic": ("periodic",) * dimension,
        "open": ("periodic",) * (dimension - 1) + ("open",),
        "walls": ("wall",) + ("periodic",) * (dimension - 1),
        "none": None,
    }[box]
    wall = Wall(cutoff=1.2, epsilon=0.7, sigma=0.9) if box == "walls" else None
    if mixture:
        lennard_jones |= {"epsilon": (1.0, 0.6), "length": (1.0, 0.85)}
    return Scene(
        name="scattered",
        dimension=dimension,
        duration=0.0,
        species=tuple(i % 2 for i in range(number)) if mixture else None,
        box=None if boundaries is None else Box(lengths=(4.0,) * dimension, boundaries=boundaries, wall=wall),
        lennard_jones=LennardJones(cutoff=CUTOFF, **lennard_jones),
        initial=explicit(positions, np.zeros_like(positions)),
    )


def double_loop(scene: Scene) -> tuple[float, float]:
    """Energy and virial, by the book: every pair, its nearest image, the formula as it is printed."""
    state, lj = scene.initial_state(), scene.lennard_jones
    energy = virial = 0.0
    for i in range(scene.number):
        for j in range(i):
            apart = state.positions[i] - state.positions[j]
            for axis, boundary in enumerate(scene.boundaries):
                if boundary == "periodic":
                    apart[axis] -= round(apart[axis] / state.lengths[axis]) * state.lengths[axis]
            epsilon, sigma = lj.epsilon, lj.length
            if state.species is not None:
                a, b = state.species[[i, j]]
                epsilon, sigma = math.sqrt(lj.epsilon[a] * lj.epsilon[b]), (lj.length[a] + lj.length[b]) / 2
            if lj.length_form == "r_m":
                sigma /= 2 ** (1 / 6)
            r = math.sqrt((apart**2).sum())
            if r < lj.cutoff:
                phi, slope = potential(r, epsilon, sigma)
                at_cutoff, slope_at_cutoff = potential(lj.cutoff, epsilon, sigma)
                if lj.truncation == "shifted":
                    phi -= at_cutoff
                if lj.truncation == "force_shifted":
                    phi -= at_cutoff + (r - lj.cutoff) * slope_at_cutoff
                    slope -= slope_at_cutoff
                energy += phi
                virial -= r * slope
    if scene.box is not None and scene.box.wall is not None:
        wall = scene.box.wall
        for x in state.positions:
            for axis, boundary in enumerate(scene.boundaries):
                for z in (x[axis], state.lengths[axis] - x[axis]):
                    if boundary == "wall" and z < wall.cutoff:
                        energy += potential(z, wall.epsilon, wall.sigma)[0]
                        energy -= potential(wall.cutoff, wall.epsilon, wall.sigma)[0]
    return energy, virial


def potential(r: float, epsilon: float, sigma: float) -> tuple[float, float]:
    """4 epsilon ((sigma/r)^12 - (sigma/r)^6), and its slope."""
    return (
        4 * epsilon * (sigma**12 / r**12 - sigma**6 / r**6),
        -4 * epsilon * (12 * sigma**12 / r**13 - 6 * sigma**6 / r**7),
    )


# -- pair sum ----------------------------------------------------------------------------------------


@given(
    dimension=st.sampled_from([2, 3]),
    box=st.sampled_from(["periodic", "open", "walls", "none"]),
    truncation=st.sampled_from(TRUNCATIONS),
    mixture=st.booleans(),
    form=st.sampled_from(["sigma", "r_m"]),
    seed=st.integers(0, 1000),
)
def test_energy_and_virial_are_those_of_a_double_loop(
    dimension: int, box: str, truncation: str, mixture: bool, form: str, seed: int
) -> None:
    number = 8 if dimension == 2 else 14
    scene = scene_of(
        scattered(dimension, seed, number), box=box, mixture=mixture, truncation=truncation, length_form=form
    )
    found, (energy, virial) = pair_sum(scene), double_loop(scene)
    assert found.energy == pytest.approx(energy, abs=1e-13 * found.energy_scale)
    assert found.virial == pytest.approx(virial, abs=1e-13 * found.virial_scale)


@pytest.mark.parametrize("box", ["periodic", "walls"])
def test_other_positions_are_those_of_another_start(box: str) -> None:
    one, other = scattered(3, 1), scattered(3, 2)
    assert pair_sum(scene_of(one, box), other).energy == pair_sum(scene_of(other, box)).energy
    assert pair_sum(scene_of(one, box), one).energy == pair_sum(scene_of(one, box)).energy


@pytest.mark.parametrize("truncation", TRUNCATIONS)
@pytest.mark.parametrize("box", ["periodic", "walls", "none"])
@pytest.mark.parametrize("mixture", [False, True])
def test_force_is_minus_the_gradient_of_the_energy(truncation: str, box: str, mixture: bool) -> None:
    positions, step = scattered(3, 5, 6), 1e-5

    def energy(x: np.ndarray) -> float:
        return pair_sum(scene_of(x, box=box, mixture=mixture, truncation=truncation)).energy

    forces = pair_sum(scene_of(positions, box=box, mixture=mixture, truncation=truncation)).forces
    for i, axis in ((0, 0), (2, 1), (5, 2)):
        change = np.zeros_like(positions)
        change[i, axis] = step
        slope = (energy(positions + change) - energy(positions - change)) / (2 * step)
        assert forces[i, axis] == pytest.approx(-slope, rel=1e-5, abs=1e-5)


def test_force_scale_adds_up_without_signs() -> None:
    sums = pair_sum(scene_of(np.array([[1.0, 2.0], [2.1, 2.0], [3.2, 2.0]]), box="none"))
    slope = abs(potential(1.1, 1.0, 1.0)[1])
    np.testing.assert_allclose(sums.forces[1], 0, atol=1e-13)
    np.testing.assert_allclose(sums.force_scale, [slope, 2 * slope, slope], rtol=1e-12)


@given(shift=st.tuples(st.integers(-3, 3), st.integers(-3, 3), st.integers(-3, 3)))
def test_any_image_of_a_particle_will_do(shift: tuple[int, int, int]) -> None:
    positions = scattered(3, 1)
    moved = positions.copy()
    moved[4] += 4.0 * np.array(shift)
    one, two = pair_sum(scene_of(positions)), pair_sum(scene_of(moved))
    np.testing.assert_allclose(two.forces, one.forces, rtol=0, atol=1e-12 * one.force_scale.max())
    assert two.energy == pytest.approx(one.energy, abs=1e-12 * one.energy_scale)


def test_r_m_is_the_place_of_the_minimum() -> None:
    sums = pair_sum(scene_of(np.array([[1.0, 1.0], [2.1, 1.0]]), box="none", length=1.1, length_form="r_m"))
    assert sums.energy == pytest.approx(-1, rel=1e-14)
    np.testing.assert_allclose(sums.forces, 0, atol=1e-12)


def test_particles_out_of_reach_have_no_energy() -> None:
    empty = pair_sum(scene_of(np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]]), box="none"))
    assert isinstance(empty, PairSum)
    assert empty.energy == empty.virial == empty.forces.any() == 0
    assert math.isfinite(empty.sensitivity)


@given(
    shares=st.lists(st.floats(0.3, 1.6), min_size=2, max_size=3),
    number=st.integers(1, 4),
    truncation=st.sampled_from(TRUNCATIONS),
    seed=st.integers(0, 1000),
)
def test_a_box_below_two_cutoffs_is_a_part_of_a_large_crystal(
    shares: list[float], number: int, truncation: str, seed: int
) -> None:
    """The cell repeated until nearest images are enough, by the double loop: energy and virial a cell, and forces."""
    rng = np.random.default_rng(seed)
    lengths = CUTOFF * np.array(shares)
    copies = np.ceil(2 * CUTOFF / lengths).astype(int)
    positions = rng.uniform(0, lengths, (number, lengths.size))
    scene = scene_of(positions, truncation=truncation, length=0.2)
    cells = np.stack(np.meshgrid(*map(np.arange, copies), indexing="ij"), axis=-1).reshape(-1, lengths.size)
    crystal = (positions + (cells * lengths)[:, None]).reshape(-1, lengths.size)
    large = scene_of(crystal, truncation=truncation, length=0.2).changed(box=Box(lengths=tuple(copies * lengths)))
    found = pair_sum(scene.changed(box=Box(lengths=tuple(lengths))))
    energy, virial = double_loop(large)
    assert found.energy == pytest.approx(energy / len(cells), rel=1e-9, abs=1e-12 * found.energy_scale)
    assert found.virial == pytest.approx(virial / len(cells), rel=1e-9, abs=1e-12 * found.virial_scale)
    forces = pair_sum(large).forces[: len(positions)]
    assert abs(found.forces - forces).max() <= 1e-9 * found.force_scale.max()


def test_one_particle_a_cell_has_the_lattice_sums_of_a_cubic_crystal() -> None:
    """A6 = 8.40192397, A12 = 6.20214905: J. E. Jones and A. E. Ingham, Proc. R. Soc. A 107, 636 (1925), extended."""
    side, cutoff = 1.05, 14.0
    sums = pair_sum(scene_of(np.zeros((1, 3))).changed(
        box=Box(lengths=(side,) * 3), lennard_jones=LennardJones(cutoff=cutoff)
    ))  # fmt: skip
    beyond = 4 * np.pi / 3 * (side / cutoff) ** 3  # of r^-6, sites of uniform density
    a6, a12 = 8.40192397 - beyond, 6.20214905
    assert sums.energy == pytest.approx(2 * (a12 / side**12 - a6 / side**6), rel=1e-4)
    assert sums.virial == pytest.approx(2 * (12 * a12 / side**12 - 6 * a6 / side**6), rel=2e-4)
    assert abs(sums.forces).max() <= 1e-15 * sums.force_scale.max()


# -- tails -------------------------------------------------------------------------------------------


@given(density=st.floats(0.01, 1.0), cutoff=st.floats(1.5, 6.0))
def test_tails_are_the_integrals_beyond_the_cutoff(density: float, cutoff: float) -> None:
    energy, _ = quad(lambda r: r**2 * potential(r, 1, 1)[0], cutoff, np.inf, epsabs=0, epsrel=1e-11)
    pressure, _ = quad(lambda r: r**3 * potential(r, 1, 1)[1], cutoff, np.inf, epsabs=0, epsrel=1e-11)
    found = tail(density, cutoff)
    assert found.energy == pytest.approx(2 * math.pi * density * energy, rel=1e-9)
    assert found.pressure == pytest.approx(-2 / 3 * math.pi * density**2 * pressure, rel=1e-9)


def periodic_scene(dimension: int, species: int, **lennard_jones: Any) -> Scene:
    """Seven particles in a periodic box of sides 6, 7, 8, of one species or two."""
    x = 1.2 * np.arange(7.0)[:, None] % 5 + np.arange(dimension)
    mixture = {"epsilon": (1.7, 0.9), "length": (1.2, 1.0)} if species == 2 else {}
    return Scene(
        name="tails",
        dimension=dimension,
        duration=1.0,
        box=Box(lengths=(6.0, 7.0, 8.0)[:dimension]),
        species=(0, 0, 1, 0, 1, 0, 0) if species == 2 else None,
        lennard_jones=LennardJones(cutoff=2.7, **(mixture | lennard_jones)),
        initial=explicit(x, np.zeros_like(x)),
    )


@pytest.mark.parametrize("length_form", ["sigma", "r_m"])
@pytest.mark.parametrize("species", [1, 2])
@pytest.mark.parametrize("dimension", [2, 3])
def test_tails_of_a_scene_are_the_integrals_beyond_the_cutoff(dimension: int, species: int, length_form: str) -> None:
    """Over a uniform fluid: phi and r phi' of every kind of pair, by quadrature."""
    scene = periodic_scene(dimension, species, length_form=length_form)
    volume = math.prod((6.0, 7.0, 8.0)[:dimension])
    kinds = ((1.7, 1.2, 5), (0.9, 1.0, 2)) if species == 2 else ((1.0, 1.0, 7),)
    energy = pressure = 0.0
    for one_epsilon, one_length, one_count in kinds:
        for other_epsilon, other_length, other_count in kinds:
            epsilon, length = math.sqrt(one_epsilon * other_epsilon), (one_length + other_length) / 2
            sigma = length / 2 ** (1 / 6) if length_form == "r_m" else length

            def shell(r: float) -> float:
                return 4 * math.pi * r**2 if dimension == 3 else 2 * math.pi * r

            def phi(r: float, epsilon: float = epsilon, sigma: float = sigma) -> float:
                return shell(r) * 4 * epsilon * ((sigma / r) ** 12 - (sigma / r) ** 6)

            def work(r: float, epsilon: float = epsilon, sigma: float = sigma) -> float:
                return shell(r) * 24 * epsilon * (2 * (sigma / r) ** 12 - (sigma / r) ** 6)

            pairs = one_count * other_count / (2 * volume)
            energy += pairs * quad(phi, 2.7, math.inf, epsabs=0, epsrel=1e-11)[0]
            pressure += pairs * quad(work, 2.7, math.inf, epsabs=0, epsrel=1e-11)[0] / (dimension * volume)
    assert tail_corrections(scene) == pytest.approx((energy, pressure), rel=1e-10)


def test_tails_of_one_species_are_the_textbook_ones() -> None:
    scene = periodic_scene(3, 1)
    density = 7 / (6 * 7 * 8)
    expected = tail(density, 2.7)
    assert tail_corrections(scene) == pytest.approx((7 * expected.energy, expected.pressure), rel=1e-14)


def test_tails_are_refused_where_they_do_not_hold() -> None:
    with pytest.raises(ValueError, match="periodic box"):
        tail_corrections(periodic_scene(2, 1).changed(box=Box(lengths=(6.0, 7.0), boundaries=("periodic", "open"))))
    with pytest.raises(ValueError, match="truncation 'truncated'"):
        tail_corrections(periodic_scene(2, 1, truncation="shifted"))


# -- equations of state -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("temperature", "density", "pressures", "energies"),
    [
        (1.0, 0.7, (0.01778, 0.01434), (-4.88773, -4.88899)),
        (1.0, 0.8, (1.01478, 1.02327), (-5.53372, -5.53441)),
        (2.0, 0.5, (1.07392, 1.07516), (-3.15010, -3.15250)),
        (0.722, 0.8442, (0.16323, 0.16509), (-6.08302, -6.08008)),
        (1.5, 0.3, (0.22488, 0.22477), (-2.08619, -2.08123)),
        (2.0, 0.1, (0.17783, 0.17780), (-0.66854, -0.66743)),
        (1.0, 0.75, (0.39391, 0.39958), (-5.21878, -5.22125)),
    ],
)
def test_equations_of_state(
    temperature: float, density: float, pressures: tuple[float, float], energies: tuple[float, float]
) -> None:
    """Kolafa and Nezbeda (1994) first, Thol et al. (2016) second."""
    point = equation_of_state(temperature, density)
    assert point.pressure == pytest.approx(np.mean(pressures), abs=1e-5)
    assert point.energy == pytest.approx(np.mean(energies), abs=1e-5)
    assert point.pressure_uncertainty == pytest.approx(abs(np.diff(pressures)[0]) / 2, abs=1e-5)
    assert point.energy_uncertainty == pytest.approx(abs(np.diff(energies)[0]) / 2, abs=1e-5)


@pytest.mark.parametrize(("temperature", "b2"), [(0.8, -7.82094), (1.0, -5.31575), (1.5, -2.51512), (2.0, -1.31450)])
def test_dilute_gas_follows_the_second_virial_coefficient(temperature: float, b2: float) -> None:
    density = 1e-3
    point = equation_of_state(temperature, density)
    assert point.pressure / (density * temperature) - 1 == pytest.approx(b2 * density, rel=0.03)


def test_open_cluster_of_two_turns_about_its_centre_and_keeps_its_period() -> None:
    """Small radial oscillations about the minimum: omega^2 = phi''/mu = 2 * 72/2^(1/3); energy by a direct sum."""
    rest, shift = 2 ** (1 / 6), 1e-4
    x = np.array([[0.0, 0.0], [rest + shift, 0.0]])
    period = 2 * math.pi / math.sqrt(2 * 72 / 2 ** (1 / 3))
    times = np.array([period / 2, period])
    half, full = open_cluster(x, np.zeros((2, 2)), times)
    assert half[1, 0] - half[0, 0] - rest == pytest.approx(-shift, rel=2e-3)
    assert full[1, 0] - full[0, 0] - rest == pytest.approx(shift, rel=2e-3)
    assert full.mean(axis=0) == pytest.approx(x.mean(axis=0), abs=1e-12)


def test_open_cluster_keeps_a_pair_on_its_circle() -> None:
    """A pair at distance r turns on a circle if mu v^2/r balances -phi'(r): r = 1.3, of the attractive part."""
    r = 1.3
    pull = 24 * (r**-7 - 2 * r**-13)
    speed = math.sqrt(pull * r / 2)  # of each about the centre: v^2/(r/2) = pull
    x, v = np.array([[-r / 2, 0.0], [r / 2, 0.0]]), np.array([[0.0, -speed], [0.0, speed]])
    times = np.array([0.25, 0.5]) * 2 * math.pi * (r / 2) / speed
    quarter, half = open_cluster(x, v, times)
    assert quarter[1] == pytest.approx([0.0, r / 2], abs=1e-9)
    assert half == pytest.approx(-x, abs=1e-9)


@pytest.mark.parametrize("mixture", [False, True])
@pytest.mark.parametrize("length_form", ["sigma", "r_m"])
def test_the_energy_of_the_cut_is_what_a_shift_takes(mixture: bool, length_form: str) -> None:
    positions = scattered(3, 8)
    truncated, shifted = (
        scene_of(positions, mixture=mixture, length_form=length_form, truncation=one)
        for one in ("truncated", "shifted")
    )
    taken = pair_sum(truncated).energy - pair_sum(shifted).energy
    assert energy_of_the_cut(truncated, positions) == pytest.approx(taken, rel=1e-9)
    assert taken < 0
    sigma = 1.0 if length_form == "sigma" else 2 ** (-1 / 6)
    phi, slope = (abs(one) for one in potential(CUTOFF, 1.0, sigma))
    assert at_cutoff(truncated.lennard_jones) == pytest.approx((phi, slope), rel=1e-12)  # that of the largest species


# -- the step of the force at the cutoff ---------------------------------------------------------------


def test_a_pair_that_passes_the_cutoff_gains_or_loses_energy_evenly_up_to_half_a_step() -> None:
    """Velocity Verlet of one coordinate, by hand: the error of the energy has the variance (F v dt)^2/12."""
    dt, reduced, rng = 0.01, 0.5, np.random.default_rng(1)
    v = np.full(4000, 1.5)
    r = CUTOFF - 0.1 + rng.uniform(0, dt * 1.5, 4000)  # a step long: all phases are as likely

    def cut(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        phi, slope = potential(r, 1.0, 1.0)
        inside = r < CUTOFF
        return np.where(inside, phi - potential(CUTOFF, 1.0, 1.0)[0], 0.0), np.where(inside, -slope, 0.0)

    start = cut(r)[0] + 0.5 * reduced * v**2
    force = cut(r)[1]
    for _ in range(20):
        v = v + 0.5 * dt * force / reduced
        r = r + dt * v
        force = cut(r)[1]
        v = v + 0.5 * dt * force / reduced
    assert (r > CUTOFF).all()
    change = cut(r)[0] + 0.5 * reduced * v**2 - start
    largest = abs(potential(CUTOFF, 1.0, 1.0)[1]) * v.mean() * dt / 2
    assert abs(change).max() == pytest.approx(largest, rel=0.05)
    assert change.std() == pytest.approx(largest / 3**0.5, rel=0.05)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("mixture", [False, True])
def test_the_variance_per_time_is_a_sum_over_pairs(dimension: int, mixture: bool) -> None:
    number = 8
    scene = scene_of(scattered(dimension, 3, number), mixture=mixture)
    scene = scene.changed(masses=tuple(1.0 + (i % 3) for i in range(number)))
    temperature, dt, expected = 1.3, 0.004, 0.0
    lj = scene.lennard_jones
    for i in range(number):
        for j in range(i):
            epsilon, sigma = 1.0, 1.0
            if mixture:
                epsilon = math.sqrt(lj.epsilon[i % 2] * lj.epsilon[j % 2])
                sigma = (lj.length[i % 2] + lj.length[j % 2]) / 2
            spread = temperature * (1 / scene.masses[i] + 1 / scene.masses[j])
            surface = 4 * math.pi * CUTOFF**2 if dimension == 3 else 2 * math.pi * CUTOFF
            # flux of the pairs, and the mean square of the velocity of those that pass, by quadrature
            density = lambda v, s=spread: math.exp(-(v**2) / (2 * s)) / math.sqrt(2 * math.pi * s)  # noqa: E731
            flux = quad(lambda v, f=density: 2 * v * f(v), 0, 20)[0]
            square = quad(lambda v, f=density: 2 * v**3 * f(v), 0, 20)[0] / flux
            force = potential(CUTOFF, epsilon, sigma)[1]
            expected += surface * flux / scene.volume() * (force * dt) ** 2 * square / 12
    # N^2/2 pairs of the formula against N (N - 1)/2: as if particles met themselves
    assert cut_diffusion(scene, temperature, dt, scene.volume()) == pytest.approx(
        expected * number / (number - 1), rel=0.2
    )
    smooth = scene.changed(lennard_jones=lj.model_copy(update={"truncation": "force_shifted"}))
    assert cut_diffusion(smooth, temperature, dt, 1.0) == 0.0


def test_the_variance_per_time_of_one_species_is_the_printed_one() -> None:
    scene = scene_of(scattered(3, 3, 8))
    rate = 8**2 / (2 * 4.0**3) * 4 * math.pi * CUTOFF**2 * math.sqrt(2 / math.pi * 2 * 1.3)
    expected = rate * (potential(CUTOFF, 1.0, 1.0)[1] * 0.004) ** 2 * 2 * 2 * 1.3 / 12
    assert cut_diffusion(scene, 1.3, 0.004, 4.0**3) == pytest.approx(expected, rel=1e-12)
