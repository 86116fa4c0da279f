"""The fast force against the plain one, against its own energy, and against what is known."""

from math import pi

import numpy as np
import pytest
from energies import potential_energy, virial
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_lennard_jones import pair_energy, pair_slope, plain_forces

from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    NEEDS_CAPACITY,
    accelerate,
    enlarge,
    kinetic_energy,
    operations,
    status,
)
from refimpl.stepping.forces.lennard_jones import (
    FORCE_EVALUATIONS,
    LIST_BUILDS,
    MINIMUM,
    TRUNCATIONS,
    LennardJones,
    Walls,
    lennard_jones,
)
from refimpl.stepping.integrate import integrate

#: Sums of a few hundred terms in another order.
ROUND_OFF = 1e-12


def evaluated(force: LennardJones, r: np.ndarray) -> tuple[LennardJones, np.ndarray]:
    """Acceleration at r, of a force enlarged as often as it asks."""
    a = accelerate(force, r, np.zeros_like(r))
    while status(force) == NEEDS_CAPACITY:
        assert np.isnan(a).all()
        force = enlarge(force)
        a = accelerate(force, r, np.zeros_like(r))
    return force, a


def jittered_lattice(rng: np.random.Generator, number: int, dimension: int, spacing: float) -> np.ndarray:
    """`number` places of a square or cubic lattice in random order, each displaced by up to 0.15 spacings."""
    edge = int(np.ceil(number ** (1 / dimension)))
    places = np.stack(np.meshgrid(*[np.arange(edge)] * dimension), axis=-1).reshape(-1, dimension)
    chosen = rng.permutation(places)[:number] + 0.5
    return ((chosen + rng.uniform(-0.15, 0.15, (number, dimension))) * spacing).ravel()


def assert_like_plain(
    force: LennardJones, r: np.ndarray, masses: np.ndarray | float = 1.0, *, symmetric: bool = False
) -> LennardJones:
    """`symmetric`: forces may cancel, so their rounding is compared with the size of the virial."""
    forces, energy, work = plain_forces(force, r)
    force, a = evaluated(force, r)
    assert status(force) == GOOD
    scale = np.abs(forces).max() + (abs(work) if symmetric else 0.0) + 1e-300
    np.testing.assert_allclose(
        a * np.repeat(np.broadcast_to(masses, len(force.neighbours.order)), len(force.lengths)),
        forces,
        rtol=0,
        atol=ROUND_OFF * scale,
    )
    assert potential_energy(force, r) == pytest.approx(energy, rel=ROUND_OFF, abs=ROUND_OFF * (1 + abs(work)))
    assert virial(force, r) == pytest.approx(work, rel=ROUND_OFF, abs=ROUND_OFF * (1 + abs(energy)))
    return force


#: (periodic axes, truncation, species, mass, boundary of the other axes): each a compilation of its own.
FEATURES = [
    ((True, True, True), "truncated", 1, "one", None),
    ((True, True, True), "force_shifted", 3, "each", None),
    ((True, False, True), "shifted", 1, "each", "walls"),
    ((False, False, False), "force_shifted", 1, "common", "open"),
    ((True, True), "shifted", 2, "common", None),
    ((False, True), "truncated", 2, "one", "walls"),
    ((False, False), "force_shifted", 1, "each", "open"),
]


@pytest.mark.parametrize(("periodic", "truncation", "kinds", "masses", "boundary"), FEATURES)
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(1, 150), images_away=st.sampled_from([0, 3]))
def test_fast_equals_plain(periodic, truncation, kinds, masses, boundary, seed, number, images_away):
    rng = np.random.default_rng(seed)
    dimension = len(periodic)
    r = jittered_lattice(rng, number, dimension, 1.05)
    side = max(1.05 * np.ceil(number ** (1 / dimension)), 5.01)
    mass = {"one": 1.0, "common": 2.5, "each": rng.uniform(0.5, 2.0, number)}[masses]
    force = lennard_jones(
        number=number,
        dimension=dimension,
        lengths=[side] * dimension,
        periodic=periodic,
        cutoff=2.5,
        truncation=truncation,
        species=rng.integers(0, kinds, number) if kinds > 1 else None,
        epsilon=rng.uniform(0.5, 1.5, kinds),
        sigma=rng.uniform(0.8, 1.1, kinds),
        mass=mass,
        walls=Walls(0.7, 0.4, 1.3) if boundary == "walls" else None,
    )
    r = r + np.where(np.tile(periodic, number), side, 0.0) * images_away * rng.integers(-1, 2, r.size)
    for _ in range(3):
        force = assert_like_plain(force, r, mass)
        r = r + rng.uniform(-0.04, 0.04, r.size)


@pytest.mark.parametrize(("periodic", "truncation", "kinds", "masses", "boundary"), FEATURES[:6])
@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    number=st.integers(1, 12),
    shares=st.lists(st.floats(0.35, 2.2), min_size=3, max_size=3),
)
def test_fast_equals_plain_in_boxes_shorter_than_two_cutoffs(
    periodic, truncation, kinds, masses, boundary, seed, number, shares
):
    """Each periodic side 0.35 to 2.2 cutoffs: images in one to three shells, also of a particle itself."""
    rng = np.random.default_rng(seed)
    dimension = len(periodic)
    cutoff, lengths = 2.5, 2.5 * np.array(shares[:dimension])
    number = min(number, int(np.prod(lengths)) + 1)
    places = np.stack(np.meshgrid(*[np.arange(np.ceil(side)) for side in lengths]), axis=-1).reshape(-1, dimension)
    chosen = (rng.permutation(places)[:number] + 0.5) / np.ceil(lengths)
    r = (chosen * lengths + rng.uniform(-0.05, 0.05, chosen.shape)).ravel()
    mass = {"one": 1.0, "common": 2.5, "each": rng.uniform(0.5, 2.0, number)}[masses]
    force = lennard_jones(
        number=number,
        dimension=dimension,
        lengths=lengths,
        periodic=periodic,
        cutoff=cutoff,
        truncation=truncation,
        species=rng.integers(0, kinds, number) if kinds > 1 else None,
        epsilon=rng.uniform(0.5, 1.5, kinds),
        sigma=rng.uniform(0.4, 0.5, kinds),
        mass=mass,
        walls=Walls(0.7, 0.1, 1.3) if boundary == "walls" else None,
    )
    for _ in range(3):
        force = assert_like_plain(force, r, mass, symmetric=True)
        r = r + rng.uniform(-0.02, 0.02, r.size)


def test_one_particle_and_its_images_have_the_lattice_sum():
    """A simple cubic lattice of constant L: 2 U = 4 (A12 L^-12 - A6 L^-6), within the cutoff."""
    side, cutoff = 1.05, 12.0
    force = lennard_jones(number=1, dimension=3, lengths=[side] * 3, periodic=[True] * 3, cutoff=cutoff)
    force, a = evaluated(force, np.array([0.3, 0.1, 0.2]))
    beyond = 4 * pi / 3 * (cutoff / side) ** -3  # of r^-6, as of a uniform density of sites
    # J. E. Jones and A. E. Ingham, Proc. R. Soc. A 107, 636 (1925): A6 = 8.4019, A12 = 6.2021
    expected = 2 * (6.2021 / side**12 - (8.4019 - beyond) / side**6)
    assert potential_energy(force, np.array([0.3, 0.1, 0.2])) == pytest.approx(expected, rel=2e-4)
    np.testing.assert_allclose(a, 0, atol=1e-12)


@pytest.fixture(scope="module")
def melt() -> tuple[LennardJones, np.ndarray]:
    number = 1000
    r = jittered_lattice(np.random.default_rng(5), number, 3, (1 / 0.8442) ** (1 / 3))
    side = (number / 0.8442) ** (1 / 3)
    force = lennard_jones(number=number, dimension=3, lengths=[side] * 3, periodic=[True] * 3, cutoff=2.5)
    return force, r


def test_dense_fluid_to_round_off(melt):
    force, r = melt
    forces, energy, work = plain_forces(force, r)
    _, a = evaluated(force, r)
    assert np.abs(a - forces).max() < 1e-13 * np.sqrt(np.mean(forces**2))
    assert potential_energy(force, r) == pytest.approx(energy, rel=1e-13)
    assert virial(force, r) == pytest.approx(work, rel=1e-13, abs=1e-13 * abs(energy))


def test_momentum_is_kept_in_a_periodic_box(melt):
    force, r = melt
    _, a = evaluated(force, r)
    assert np.abs(a.reshape(-1, 3).sum(axis=0)).max() < 1e-13 * np.abs(a).sum()


def test_a_mixture_whose_lists_grow_keeps_its_species():
    """Twice from one force, as a run is after its compilation: a drop in a box so wide that the first lists are small.

    The second time, the counters of the first said that the new slots had their parameters: all forces were 0.
    """
    rng = np.random.default_rng(9)
    r = jittered_lattice(rng, 64, 3, 1.1)
    force = lennard_jones(
        number=64,
        dimension=3,
        lengths=(40.0,) * 3,
        periodic=(True,) * 3,
        cutoff=2.5,
        epsilon=(1.0, 0.5),
        sigma=(1.0, 0.9),
        species=np.arange(64) % 2,
    )
    first, a = evaluated(force, r)
    assert first is not force
    np.testing.assert_array_equal(evaluated(force, r)[1], a)
    np.testing.assert_allclose(a, plain_forces(force, r)[0], rtol=0, atol=ROUND_OFF * np.abs(a).max())


def test_same_coordinates_give_the_same_bits(melt):
    force, r = melt
    _, first = evaluated(force, r)
    evaluated(force, r + 1.0)
    _, again = evaluated(force, r)
    fresh = force._replace(neighbours=enlarge(force).neighbours)
    np.testing.assert_array_equal(evaluated(fresh, r)[1], again)
    np.testing.assert_allclose(again, first, rtol=0, atol=1e-12 * np.abs(first).max())


@pytest.mark.parametrize(
    ("truncation", "dimension", "boundary"),
    [
        ("shifted", 3, "walls"),
        ("force_shifted", 3, "periodic"),
        ("force_shifted", 2, "walls"),
        ("shifted", 2, "periodic"),
    ],
)
def test_force_is_minus_the_gradient_of_the_energy(truncation, dimension, boundary):
    rng = np.random.default_rng(6)
    number = 40
    r = jittered_lattice(rng, number, dimension, 1.05)
    side = 1.05 * np.ceil(number ** (1 / dimension))
    force = lennard_jones(
        number=number,
        dimension=dimension,
        lengths=[side] * dimension,
        periodic=[boundary == "periodic"] * dimension,
        cutoff=1.9,
        truncation=truncation,
        walls=Walls(1.2, 0.5, 1.1) if boundary == "walls" else None,
    )
    a = evaluated(force, r)[1]
    for k in rng.integers(0, r.size, 12):
        step = np.zeros_like(r)
        step[k] = 1e-5
        u = [potential_energy(force, r + factor * step) for factor in (-2, -1, 1, 2)]
        gradient = (u[0] - 8 * u[1] + 8 * u[2] - u[3]) / (12 * step[k])
        assert a[k] == pytest.approx(-gradient, abs=2e-8 * np.abs(a).max())


def test_energy_and_momentum_are_kept_through_many_list_builds():
    number = 216
    rng = np.random.default_rng(8)
    r = jittered_lattice(rng, number, 3, 1.06)
    v = rng.normal(size=r.size)
    v -= np.tile(v.reshape(-1, 3).mean(axis=0), number)
    side = 6 * 1.06
    force = lennard_jones(
        number=number,
        dimension=3,
        lengths=[side] * 3,
        periodic=[True] * 3,
        cutoff=2.5,
        truncation="force_shifted",
        skin=0.5,
    )
    spread = []
    for steps in (25, 50):
        state, energies = (r, v), [potential_energy(force, r) + kinetic_energy(force, v)]
        for _ in range(30):
            run = integrate("velocity_verlet", force, *state, 0.1 / steps, steps)
            force, state = run.force, (run.r, run.v)
            energies.append(potential_energy(force, run.r) + kinetic_energy(force, run.v))
        spread.append(np.ptp(energies))
        assert np.abs(run.v.reshape(-1, 3).sum(axis=0)).max() < 1e-10
    # Second order in dt; a pair missed at the edge of a list would cost energy at any dt.
    assert 3.5 < spread[0] / spread[1] < 4.5
    assert force.counters[LIST_BUILDS] > 20


def two(distance: float, truncation: str, **options: object) -> tuple[LennardJones, np.ndarray]:
    r = np.array([0.0, 0.0, 0.0, 0.6 * distance, 0.0, 0.8 * distance])
    arguments = {"cutoff": 2.5, "truncation": truncation, **options}
    return lennard_jones(number=2, dimension=3, lengths=None, periodic=[False] * 3, **arguments), r


@pytest.mark.parametrize("truncation", TRUNCATIONS)
def test_a_pair_in_closed_form(truncation):
    cut, slope = pair_energy(2.5, 1.0, 1.0), pair_slope(2.5, 1.0, 1.0)
    for distance in (0.9, MINIMUM, 1.7, 2.4999):
        force, r = two(distance, truncation)
        phi = 4 * (distance**-12 - distance**-6)
        pull = 48 * distance**-13 - 24 * distance**-7
        if truncation != "truncated":
            phi -= cut
        if truncation == "force_shifted":
            phi -= (distance - 2.5) * slope
            pull += slope
        assert potential_energy(force, r) == pytest.approx(phi, rel=1e-13, abs=1e-15)
        assert virial(force, r) == pytest.approx(distance * pull, rel=1e-13, abs=1e-13)
        np.testing.assert_allclose(evaluated(force, r)[1][3:], pull * np.array([0.6, 0, 0.8]), atol=1e-13 * 200)
    force, r = two(2.5001, truncation)
    assert potential_energy(force, r) == virial(force, r) == 0
    assert not evaluated(force, r)[1].any()


def test_what_is_continuous_at_the_cutoff():
    below = 2.5 * (1 - 1e-9)
    jumps = {t: potential_energy(*two(below, t)) for t in TRUNCATIONS}
    pulls = {t: virial(*two(below, t)) / below for t in TRUNCATIONS}
    phi, slope = 4 * (2.5**-12 - 2.5**-6), -(48 * 2.5**-13 - 24 * 2.5**-7)
    assert jumps["truncated"] == pytest.approx(phi, rel=1e-6)
    assert jumps["shifted"] == pytest.approx(0, abs=1e-9)
    assert jumps["force_shifted"] == pytest.approx(0, abs=1e-15)
    assert pulls["truncated"] == pytest.approx(-slope, rel=1e-6)
    assert pulls["shifted"] == pytest.approx(-slope, rel=1e-6)
    assert pulls["force_shifted"] == pytest.approx(0, abs=1e-9)


def test_both_length_forms():
    force, r = two(MINIMUM * 1.3, "truncated", sigma=1.3 * MINIMUM, length_form="r_m", epsilon=0.7)
    assert potential_energy(force, r) == pytest.approx(-0.7, rel=1e-14)
    np.testing.assert_allclose(evaluated(force, r)[1], 0, atol=1e-13)
    assert force.sigma == pytest.approx(1.3)


def test_unlike_pairs_mix_by_lorentz_berthelot():
    force = lennard_jones(
        number=2,
        dimension=2,
        lengths=None,
        periodic=[False, False],
        cutoff=4.0,
        species=np.array([1, 0]),
        epsilon=[1.0, 4.0],
        sigma=[1.0, 1.5],
    )
    r = np.array([0.0, 0.0, 1.4, 0.0])
    assert potential_energy(force, r) == pytest.approx(pair_energy(1.4, 2.0, 1.25), rel=1e-14)


def test_features_that_are_not_used_leave_no_arrays():
    plain = lennard_jones(
        number=3,
        dimension=2,
        lengths=[9.0, 9.0],
        periodic=[True, True],
        cutoff=2.5,
        species=np.zeros(3, dtype=int),
        mass=np.full(3, 1.0),
    )
    assert plain.species is plain.slot_size is plain.mass is plain.masses is plain.walls is None
    assert plain.shift_energy is plain.shift_force is None
    assert plain.neighbours.packed.size % 2 == 0
    assert plain._replace(mass=2.0) == plain._replace(mass=2.0)


@pytest.mark.parametrize("x", [0.3, 0.7, 1.5, 3.0])
def test_wall_force_and_energy_in_closed_form(x):
    walls = Walls(epsilon=1.3, sigma=0.6, cutoff=1.4)
    force = lennard_jones(
        number=1, dimension=2, lengths=[4.0, 9.0], periodic=[False, True], cutoff=2.5, walls=walls, mass=2.0
    )
    pull, energy = 0.0, 0.0
    for s, sign in ((x, 1), (4.0 - x, -1)):
        if s < 1.4:
            pull -= sign * pair_slope(s, 1.3, 0.6)
            energy += pair_energy(s, 1.3, 0.6) - pair_energy(1.4, 1.3, 0.6)
    r = np.array([x, 20.0])
    np.testing.assert_allclose(evaluated(force, r)[1], [pull / 2.0, 0.0], rtol=1e-13)
    assert potential_energy(force, r) == pytest.approx(energy, rel=1e-13, abs=1e-16)
    assert virial(force, r) == 0.0


@pytest.mark.parametrize("x", [0.0, -0.1, 4.0, 4.1, np.nan])
def test_a_particle_outside_the_walls_is_divergence(x):
    force = lennard_jones(
        number=2, dimension=2, lengths=[4.0, 9.0], periodic=[False, True], cutoff=2.5, walls=Walls(1.0, 1.0, 2.5)
    )
    assert np.isnan(accelerate(force, np.array([2.0, 1.0, x, 5.0]), np.zeros(4))).all()
    assert status(force) == DIVERGED


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1e200])
def test_a_lost_particle_is_divergence_and_is_forgiven(melt, bad):
    force, r = melt
    lost = r.copy()
    lost[1234] = bad
    assert np.isnan(accelerate(force, lost, r)).all()
    assert status(force) == DIVERGED
    assert np.isnan(potential_energy(force, lost))
    assert np.isnan(virial(force, lost))
    assert_like_plain(force, r)


def test_clustering_needs_capacity_and_enlarging_mends_it():
    number = 1500
    r = jittered_lattice(np.random.default_rng(7), number, 3, 1.05)
    species = np.arange(number) % 2
    force = lennard_jones(
        number=number,
        dimension=3,
        lengths=[90.0] * 3,
        periodic=[True] * 3,
        cutoff=2.5,
        species=species,
        epsilon=[1.0, 1.2],
        sigma=[1.0, 0.9],
    )
    assert np.isnan(accelerate(force, r, r)).all()
    assert status(force) == NEEDS_CAPACITY
    assert_like_plain(force, r)


def test_counters_are_exact():
    force = lennard_jones(number=2, dimension=2, lengths=None, periodic=[False] * 2, cutoff=2.5, skin=0.4)
    r = np.array([0.0, 0.0, 1.5, 0.0])
    for shift in (0.0, 0.01, 0.02, 1.0, 1.01):
        accelerate(force, r + shift, r)
    potential_energy(force, r + 1.01)
    assert force.counters[LIST_BUILDS] == 2
    assert force.counters[FORCE_EVALUATIONS] == 5
    counts = operations(force)
    # two particles fill one tile of eight, and are not in its list
    assert counts == {
        "evaluations": 5,
        "pair_tests": 5 * 64,
        "list_builds": 2,
        "list_prunings": 2,
        "list_tests": counts["list_tests"],
    }
    # two slots for each of the two lists, from the eight places of the tile
    assert 2 * 2 * 8 <= counts["list_tests"] <= 2 * 8 * 8


@pytest.mark.parametrize("mass", [1.0, 3.0, np.array([1.0, 3.0, 2.0])], ids=["one", "common", "each"])
def test_kinetic_energy_counts_the_masses(mass):
    force = lennard_jones(number=3, dimension=2, lengths=None, periodic=[False] * 2, cutoff=2.5, mass=mass)
    v = np.arange(6.0)
    expected = 0.5 * (np.broadcast_to(mass, 3)[:, None] * v.reshape(3, 2) ** 2).sum()
    assert kinetic_energy(force, v) == pytest.approx(expected, rel=1e-15)


def test_pair_functions():
    assert pair_energy(1.0, 1.0, 1.0) == 0
    assert pair_energy(MINIMUM, 2.0, 1.0) == pytest.approx(-2.0, rel=1e-15)
    assert pair_slope(MINIMUM, 2.0, 1.0) == pytest.approx(0, abs=1e-13)
    r = np.linspace(0.9, 3, 7)
    numeric = (pair_energy(r + 1e-6, 1.1, 0.9) - pair_energy(r - 1e-6, 1.1, 0.9)) / 2e-6
    np.testing.assert_allclose(pair_slope(r, 1.1, 0.9), numeric, rtol=1e-6, atol=1e-8)


GOOD_ARGUMENTS = {
    "number": 4,
    "dimension": 2,
    "lengths": [9.0, 9.0],
    "periodic": [True, True],
    "cutoff": 2.5,
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"dimension": 4}, "dimension must be 2 or 3"),
        ({"number": 0}, "number of particles"),
        ({"truncation": "smooth"}, "truncation must be one of truncated, shifted, force_shifted"),
        ({"length_form": "diameter"}, "length_form"),
        ({"lengths": [9.0, 1e-8]}, "shorten the cutoff"),
        ({"cutoff": np.nan}, "cutoff"),
        ({"cutoff": -1.0}, "cutoff"),
        ({"lengths": [9.0]}, "lengths must hold 2"),
        ({"lengths": [9.0, np.nan]}, "lengths must be positive"),
        ({"lengths": None}, "need lengths"),
        ({"periodic": [True]}, "periodic must hold 2"),
        ({"epsilon": -1.0}, "epsilon must be non-negative"),
        ({"sigma": 0.0}, "sigma must be positive"),
        ({"sigma": [1.0, 2.0]}, "give the species"),
        ({"sigma": [1.0, 2.0], "epsilon": [1.0, 1.0, 1.0]}, "one number per species"),
        ({"sigma": [1.0, 2.0], "species": np.array([0, 1, 2, 0])}, "species must lie in 0 ... 1"),
        ({"sigma": [1.0, 2.0], "species": np.array([0, -1, 1, 0])}, "species must lie in 0 ... 1"),
        ({"sigma": [1.0, 2.0], "species": np.zeros(4)}, "species must hold 4 integers"),
        ({"mass": 0.0}, "mass must be positive"),
        ({"mass": np.ones(3)}, "mass must be one number or 4"),
        ({"mass": np.array([1, 1, 1, np.nan])}, "mass must be positive"),
        ({"walls": Walls(1.0, 1.0, 2.5)}, "all are: leave them out"),
        ({"walls": Walls(1.0, -1.0, 2.5), "periodic": [True, False]}, "wall sigma"),
        ({"skin": -0.1}, "skin"),
        ({"skin": 1e101}, "sides and cutoff"),
    ],
)
def test_bad_arguments_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        lennard_jones(**{**GOOD_ARGUMENTS, **change})


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("mixed", [False, True])
def test_threads_change_no_bit(dimension, mixed):
    """Of coordinates, velocities and energies; nor what is counted. A mixture has walls here, and unlike masses."""
    rng = np.random.default_rng(8)
    r = jittered_lattice(rng, 700, dimension, 1.15).ravel()
    v = rng.normal(size=r.size)
    sides = (r.reshape(-1, dimension).max(axis=0) - r.reshape(-1, dimension).min(axis=0) + 2.0).tolist()
    options = (
        {"mass": 1.0}
        if not mixed
        else {
            "epsilon": (1.0, 0.5),
            "sigma": (1.0, 0.9),
            "species": rng.integers(0, 2, 700),
            "truncation": "shifted",
            "mass": rng.uniform(0.5, 2.0, 700),
            "walls": Walls(1.0, 0.4, 1.0),
        }
    )
    runs = [
        integrate(
            "velocity_verlet",
            lennard_jones(
                number=700,
                dimension=dimension,
                lengths=sides,
                cutoff=2.5,
                threads=threads,
                periodic=[not mixed, *[True] * (dimension - 1)],
                **options,
            ),
            r + 0.5,
            v,
            0.002,
            60,
            every=20,
            thermo=True,
        )
        for threads in (1, 2, 4)
    ]
    assert not runs[0].diverged
    assert runs[0].operations["list_builds"] > 1
    for run in runs[1:]:
        assert np.array_equal(run.r, runs[0].r)
        assert np.array_equal(run.v, runs[0].v)
        assert np.array_equal(run.thermo, runs[0].thermo)
        assert run.operations == runs[0].operations


def test_threads_must_be_one_or_more():
    with pytest.raises(ValueError, match="threads must be at least 1, got 0"):
        lennard_jones(number=3, dimension=2, lengths=None, periodic=[False, False], cutoff=2.0, threads=0)
