"""Gravity: the fast kernel against the plain one, both against numpy, and what Newton's law implies."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from energies import potential_energy, virial
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    accelerate,
    kinetic_energy,
    status,
)
from refimpl.stepping.forces.gravity import FEW_BODIES, gravity, plain_acceleration
from refimpl.stepping.integrate import integrate
from refimpl.stepping.kernels import gravity as kernels

EPS = float(np.finfo(np.float64).eps)
CODATA_G = 6.67430e-11  # m^3 kg^-1 s^-2
MANY = FEW_BODIES + 30  # enough for vector code with a remainder


class Case(NamedTuple):
    """A random configuration; `r` is flat."""

    r: np.ndarray
    mass: np.ndarray
    dimension: int
    G: float
    softening: float | None

    @property
    def z(self) -> int | None:
        return None if self.dimension == 2 else 2

    @property
    def positions(self) -> np.ndarray:
        return self.r.reshape(-1, self.dimension)


@st.composite
def cases(draw: st.DrawFn, smallest: int = 1, largest: int = MANY) -> Case:
    n = draw(st.integers(smallest, largest))
    dimension = draw(st.sampled_from([2, 3]))
    length = 10.0 ** draw(st.integers(-6, 12))
    softening = draw(st.sampled_from([None, 0.3]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    mass = rng.random(n) * (rng.random(n) < 0.8)  # every fifth is a test particle
    return Case(
        length * rng.normal(size=n * dimension),
        mass,
        dimension,
        draw(st.sampled_from([1.0, CODATA_G])),
        None if softening is None else softening * length,
    )


def lattice_case(n: int, dimension: int, softening: float | None, seed: int = 3) -> Case:
    """Bodies on a shaken lattice: no close pairs, so that differences of energies are accurate."""
    rng = np.random.default_rng(seed)
    side = math.ceil(n ** (1 / dimension))
    sites = np.indices((side,) * dimension).reshape(dimension, -1).T[:n]
    r = (sites + 0.3 * rng.random((n, dimension))).ravel()
    return Case(r, 0.1 + rng.random(n), dimension, 1.5, softening)


def terms(case: Case) -> np.ndarray:
    """Acceleration of i by j, shape (N, N, d), straight from the equation."""
    x = case.positions
    separation = x[None, :, :] - x[:, None, :]
    square = (separation**2).sum(axis=2) + (case.softening or 0.0) ** 2
    np.fill_diagonal(square, np.inf)
    return np.asarray(case.G * (case.mass / square**1.5)[:, :, None] * separation)


def force_of(case: Case):  # type: ignore[no-untyped-def]
    return gravity(case.mass, case.dimension, case.G, case.softening)


@settings(deadline=None)
@given(cases())
def test_fast_and_plain_kernels_agree_to_round_off(case: Case) -> None:
    arguments = (case.r, case.mass, case.z, case.G, case.softening)
    plain, fast = plain_acceleration(*arguments), kernels.acceleration(*arguments, kernels.work(case.mass.size))
    scale = np.abs(terms(case)).sum(axis=1).ravel()
    assert np.all(np.abs(fast - plain) <= (case.mass.size + 12) * EPS * scale)
    expected = terms(case).sum(axis=1).ravel()
    assert np.all(np.abs(plain - expected) <= (case.mass.size + 16) * EPS * scale)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("softening", [None, 0.2])
def test_agreement_at_every_remainder_of_the_vector_length(dimension: int, softening: float | None) -> None:
    for n in (*range(1, 35), 511, 512, 513, 1030):
        case = lattice_case(n, dimension, softening)
        arguments = (case.r, case.mass, case.z, case.G, case.softening)
        scale = np.abs(terms(case)).sum(axis=1).ravel()
        difference = kernels.acceleration(*arguments, kernels.work(case.mass.size)) - plain_acceleration(*arguments)
        assert np.all(np.abs(difference) <= (n + 12) * EPS * scale), n


def test_plain_kernel_is_the_same_uncompiled() -> None:
    case = lattice_case(5, 3, 0.1)
    arguments = (case.r, case.mass, case.z, case.G, case.softening)
    np.testing.assert_allclose(plain_acceleration.py_func(*arguments), plain_acceleration(*arguments), rtol=1e-14)


@settings(deadline=None)
@given(cases(smallest=2))
def test_momentum_is_conserved_to_round_off(case: Case) -> None:
    a = accelerate(force_of(case), case.r, case.r).reshape(-1, case.dimension)
    forces = np.abs(case.mass[:, None, None] * terms(case)).sum(axis=(0, 1))
    for k in range(case.dimension):
        assert abs(math.fsum(case.mass * a[:, k])) <= (case.mass.size + 12) * EPS * forces[k]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("n", [FEW_BODIES, MANY, 521])
def test_threads_change_no_bit(n: int, dimension: int) -> None:
    case = lattice_case(n, dimension, None)
    runs = [
        integrate("leapfrog", gravity(case.mass, dimension, threads=threads), case.r, 0 * case.r, 1e-4, 40)
        for threads in (1, 2, 5)
    ]
    for run in runs[1:]:
        assert np.array_equal(run.r, runs[0].r)
        assert np.array_equal(run.v, runs[0].v)


def test_threads_must_be_one_or_more() -> None:
    with pytest.raises(ValueError, match="threads must be at least 1, got 0"):
        gravity(np.ones(3), 2, threads=0)


@settings(deadline=None)
@given(cases(smallest=2))
def test_energy_and_virial_are_their_sums(case: Case) -> None:
    force = force_of(case)
    i, j = np.triu_indices(case.mass.size, 1)
    square = ((case.positions[i] - case.positions[j]) ** 2).sum(axis=1)
    softened = square + (case.softening or 0.0) ** 2
    pairs = case.G * case.mass[i] * case.mass[j] / np.sqrt(softened)
    assert potential_energy(force, case.r) == pytest.approx(-math.fsum(pairs), rel=1e-13, abs=0)
    assert virial(force, case.r) == pytest.approx(-math.fsum(pairs * square / softened), rel=1e-13, abs=0)
    if case.softening is None:  # U is homogeneous of degree -1
        assert virial(force, case.r) == potential_energy(force, case.r)


@pytest.mark.parametrize("n", [FEW_BODIES, MANY])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("softening", [None, 0.5])
def test_virial_is_the_sum_of_position_times_force(n: int, dimension: int, softening: float | None) -> None:
    case = lattice_case(n, dimension, softening)
    force = force_of(case)
    forces = np.repeat(case.mass, dimension) * accelerate(force, case.r, case.r)
    assert virial(force, case.r) == pytest.approx(float(case.r @ forces), rel=1e-12)


@pytest.mark.parametrize("n", [2, 3, MANY])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("softening", [None, 0.5])
def test_force_is_minus_the_gradient_of_the_energy(n: int, dimension: int, softening: float | None) -> None:
    case = lattice_case(n, dimension, softening)
    force = force_of(case)
    forces = np.repeat(case.mass, dimension) * accelerate(force, case.r, case.r)
    step = 1e-5
    for q in range(0, n * dimension, max(1, n * dimension // 12)):
        ahead, behind = case.r.copy(), case.r.copy()
        ahead[q] += step
        behind[q] -= step
        slope = (potential_energy(force, ahead) - potential_energy(force, behind)) / (2 * step)
        # h^2 U'''/6, and the rounding of U over h
        assert forces[q] == pytest.approx(-slope, rel=1e-7, abs=1e-7 * np.abs(forces).max())


def test_two_bodies_attract_by_the_inverse_square_and_test_particles_only_feel() -> None:
    force = gravity(np.array([3.0, 4.0, 0.0]), 3, G=0.5)
    a = accelerate(force, np.array([0.0, 0, 0, 2, 0, 0, 0, 2, 0]), np.zeros(9)).reshape(3, 3)
    np.testing.assert_allclose(a[0], [0.5 * 4 / 4, 0, 0], rtol=1e-15)
    np.testing.assert_allclose(a[1], [-0.5 * 3 / 4, 0, 0], rtol=1e-15)
    diagonal = 0.5 * 4 / 8 / math.sqrt(2)
    np.testing.assert_allclose(a[2], [diagonal, -0.5 * 3 / 4 - diagonal, 0], rtol=1e-15)


def test_earth_falls_towards_the_sun_in_si_units() -> None:
    au, solar_mass = 1.495978707e11, 1.98841e30
    force = gravity(np.array([solar_mass, 5.97217e24]), 2, G=CODATA_G)
    a = accelerate(force, np.array([0.0, 0.0, au, 0.0]), np.zeros(4))
    assert a[2] == pytest.approx(-5.93008e-3, rel=1e-5)


def test_newtons_shell_theorem() -> None:
    n = 3000
    k = np.arange(n) + 0.5
    height, turn = 1 - 2 * k / n, math.pi * (1 + math.sqrt(5)) * k  # a Fibonacci lattice on the sphere
    ring = np.sqrt(1 - height**2)
    shell = np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    probes = np.array([[0.3, -0.2, 0.4], [1.0, 2.0, -2.0]])
    mass = np.append(np.full(n, 1 / n), [0.0, 0.0])
    a = accelerate(gravity(mass, 3), np.concatenate([shell, probes]).ravel(), np.zeros(3 * n + 6)).reshape(-1, 3)
    np.testing.assert_allclose(a[n], 0.0, atol=1e-4)
    np.testing.assert_allclose(a[n + 1], -probes[1] / 27, atol=1e-4)


@settings(deadline=None, max_examples=30)
@given(st.sampled_from([3, MANY]), st.sampled_from([2, 3]), st.integers(0, 2**32 - 1))
def test_translation_and_rotation(n: int, dimension: int, seed: int) -> None:
    case = lattice_case(n, dimension, None, seed)
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(dimension, dimension)))
    force = force_of(case)
    a = accelerate(force, case.r, case.r).reshape(-1, dimension)
    moved = case.positions @ turn + rng.normal(size=dimension)
    a_moved = accelerate(force, moved.ravel(), case.r).reshape(-1, dimension)
    np.testing.assert_allclose(a_moved, a @ turn, rtol=0, atol=1e-12 * np.abs(a).max() * n)
    assert potential_energy(force, moved.ravel()) == pytest.approx(potential_energy(force, case.r), rel=1e-12)


def test_the_plane_is_space_without_z() -> None:
    plane = lattice_case(MANY, 2, 0.1)
    space = np.column_stack([plane.positions, np.full(MANY, 7.0)]).ravel()
    flat = accelerate(force_of(plane), plane.r, plane.r).reshape(-1, 2)
    full = accelerate(gravity(plane.mass, 3, plane.G, 0.1), space, space).reshape(-1, 3)
    np.testing.assert_allclose(full[:, :2], flat, rtol=1e-12)
    assert not full[:, 2].any()


@pytest.mark.parametrize("n", [3, MANY])
def test_same_bits_in_every_call_wherever_the_array_lies(n: int) -> None:
    case = lattice_case(n, 3, None)
    force = force_of(case)
    first = accelerate(force, case.r, case.r)
    for offset in range(8):
        r = np.empty(case.r.size + 8)[offset : offset + case.r.size]
        r[:] = case.r
        np.testing.assert_array_equal(accelerate(force, r, r), first)


@pytest.mark.parametrize("n", [2, MANY])
@pytest.mark.parametrize("dimension", [2, 3])
def test_coincident_bodies_are_reported_not_raised(n: int, dimension: int) -> None:
    case = lattice_case(n, dimension, None)
    force, softened = force_of(case), gravity(case.mass, dimension, softening=0.1)
    together = case.r.copy()
    together[-dimension:] = together[:dimension]

    a = accelerate(force, together, together)
    assert not np.isfinite(a).all()
    assert status(force) == DIVERGED
    accelerate(force, case.r, case.r)
    assert status(force) == GOOD
    assert np.isfinite(accelerate(softened, together, together)).all()
    assert status(softened) == GOOD
    accelerate(softened, np.full_like(case.r, np.nan), together)
    assert status(softened) == DIVERGED


def test_one_body_feels_nothing() -> None:
    force = gravity(np.ones(1), 3)
    assert not accelerate(force, np.ones(3), np.ones(3)).any()
    assert potential_energy(force, np.ones(3)) == 0.0


@njit
def _every_answer(force, r, v):  # type: ignore[no-untyped-def]
    a = accelerate(force, r, v)
    return a, potential_energy(force, r), virial(force, r), kinetic_energy(force, v), status(force)


@pytest.mark.parametrize("n", [3, MANY])
@pytest.mark.parametrize(("dimension", "softening"), [(2, 0.2), (3, None)])
def test_same_answers_inside_a_kernel(n: int, dimension: int, softening: float | None) -> None:
    case = lattice_case(n, dimension, softening)
    force = force_of(case)
    v = case.r[::-1].copy()
    a, energy, w, kinetic, outcome = _every_answer(force, case.r, v)
    np.testing.assert_array_equal(a, accelerate(force, case.r, v))
    assert (energy, w) == (potential_energy(force, case.r), virial(force, case.r))
    assert kinetic == pytest.approx(float(0.5 * np.repeat(case.mass, dimension) @ v**2), rel=1e-13)
    assert kinetic == pytest.approx(kinetic_energy(force, v), rel=1e-14)
    assert outcome == GOOD


def test_masses_are_copied() -> None:
    mass = np.ones(2)
    force = gravity(mass, 2)
    mass[0] = 5.0
    assert force.mass[0] == 1.0


def test_zero_softening_is_none() -> None:
    assert gravity(np.ones(2), 3, softening=0.0).softening is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": [1.0, -2.0]}, "got -2.0 for body 1"),
        ({"mass": [math.nan, 1.0]}, "got nan for body 0"),
        ({"mass": [1.0, math.inf]}, "got inf for body 1"),
        ({"mass": [[1.0, 1.0]]}, r"got shape \(1, 2\)"),
        ({"mass": []}, r"got shape \(0,\)"),
        ({"mass": 1.0}, r"got shape \(\)"),
        ({"dimension": 1}, "dimension must be 2 or 3, got 1"),
        ({"G": 0.0}, "G must be positive"),
        ({"G": math.nan}, "G must be positive"),
        ({"softening": -0.1}, "softening must be a finite length"),
        ({"softening": math.inf}, "softening must be a finite length"),
    ],
)
def test_bad_input_is_named(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        gravity(**{"mass": np.ones(2), "dimension": 3} | arguments)  # type: ignore[arg-type]


def test_wrong_number_of_coordinates_is_refused() -> None:
    force, r = gravity(np.ones(2), 3), np.zeros(4)
    for question in (potential_energy, virial, kinetic_energy):
        with pytest.raises(ValueError, match="as many coordinates per body"):
            question(force, r)
    with pytest.raises(ValueError, match="as many coordinates per body"):
        accelerate(force, r, r)
