"""What the checks of square wells, the Lorentz gas and Brownian motion compute by themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from crosscheck.checks.events import brownian, lorentz, square_well
from crosscheck.references import hard_spheres

seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("dimension", [2, 3])
def test_third_virial_of_a_hot_gas_is_that_of_hard_cores(dimension):
    exact = hard_spheres.virial_coefficients(dimension)[2] * hard_spheres.packing_fraction(1.0, dimension) ** 2
    assert square_well.third_virial(1e12, 1.5, dimension) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_third_virial_is_the_integral_over_triangles(dimension):
    temperature, width, number = 2.0, 1.5, 400_000
    rng = np.random.default_rng(1)
    f = lambda r: np.where(r < 1, -1.0, np.where(r < width, np.expm1(1 / temperature), 0.0))  # noqa: E731
    one, two = rng.uniform(-width, width, (2, number, dimension))
    sides = [np.linalg.norm(r, axis=1) for r in (one, two, one - two)]
    values = -(f(sides[0]) * f(sides[1]) * f(sides[2])) / 3 * (2 * width) ** (2 * dimension)
    error = values.std() / number**0.5
    assert abs(square_well.third_virial(temperature, width, dimension) - values.mean()) < 4 * error


@given(seeds, st.sampled_from([2, 3]))
@settings(max_examples=10, deadline=None)
def test_a_pair_keeps_energy_and_angular_momentum(seed, dimension):
    """Also backwards: the reversed path ends where it began."""
    relative, velocity = square_well.pair_starts(dimension, seed)
    for r, v in zip(relative[::8], velocity[::8], strict=True):
        path = square_well.pair_path(r, v, 3.0)
        energies = [
            0.25 * u @ u - float(x @ x < square_well.WIDTH**2) for x, u in ((r, v), (path.position, path.velocity))
        ]
        assert energies[1] == pytest.approx(energies[0], abs=1e-12)
        momenta = [np.outer(x, u) - np.outer(u, x) for x, u in ((r, v), (path.position, path.velocity))]
        assert np.abs(momenta[1] - momenta[0]).max() < 1e-12


def test_pairs_do_everything():
    relative, velocity = square_well.pair_starts(3, 1)
    paths = [square_well.pair_path(r, v, 5.0) for r, v in zip(relative, velocity, strict=True)]
    assert np.array([path[2:] for path in paths]).sum(axis=0).min() > 10


@given(seeds, st.sampled_from([(2, 0.1), (3, 0.05)]))
@settings(max_examples=10, deadline=None)
def test_scatterers_are_apart_and_points_outside_them(seed, case):
    dimension, x = case
    gas = lorentz.arrangement(dimension, x, 60, 30, seed, overlapping=False)
    assert (gas.centres.shape, gas.places.shape) == ((60, dimension), (30, dimension))
    assert 60 / gas.length**dimension == pytest.approx(x)
    tree = cKDTree(gas.centres, boxsize=gas.length)
    assert len(tree.query_pairs(2.0)) == 0
    assert tree.query(gas.places)[0].min() >= 1
    assert np.linalg.norm(gas.velocities, axis=1) == pytest.approx(1)


@pytest.mark.parametrize("variant", list(brownian.BATHS))
def test_autocorrelation_of_tracers_starts_with_the_exact_slope(variant):
    """-dC/dt(0) = (gamma + gamma_tt (k - 1)/k) T/M whatever the bath's size: momentum is conserved."""
    known = brownian.theory(int(variant[0]), brownian.BATHS[variant])
    start, soon = known.autocorrelation(np.array([0.0, 1e-6]))
    assert start == pytest.approx(known.variance)
    exact = (known.gamma + known.between * (known.number - 1) / known.number) / brownian.MASS
    # relative modes decay with both rates, the common one with the bath's
    assert (start - soon) / 1e-6 == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("variant", list(brownian.BATHS))
def test_tracers_fit_into_the_lattice(variant):
    dimension, bath = int(variant[0]), brownian.BATHS[variant]
    scene = brownian.brownian(dimension, bath, 0, 1.0)
    assert sum(scene.species) == bath.tracers
    assert (bath.sites - bath.tracers) / scene.volume() == pytest.approx(bath.density)
    scene.initial_state()
