"""Initial states: lattices, random velocities, Kepler orbits, configuration files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_files import FLUID, SPRING, TURNING, assert_one_message, changed, load
from scipy.spatial import cKDTree

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Cylinder,
    Face,
    Gravity,
    HardSpheres,
    Kepler,
    Lattice,
    LennardJones,
    Oscillation,
    Scene,
    Spring,
    explicit,
)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (SPRING, "initial.positions", [[1.0], [2.0, 3.0]], "initial.positions[1] has 2 components in dimension 1"),
        (SPRING, "initial.velocities", [[1.0]], "initial.velocities has 1 rows for 2 particles"),
        (SPRING, "initial.positions", [], "initial.positions is empty: give at least one particle"),
        (TURNING, "initial.angular_velocities", [[1.0, 0.0], [1.0, 0.0]],
         "initial.angular_velocities[0] has 2 components in dimension 2"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_with_its_path(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    assert_one_message(tmp_path, changed(table, path, value), message)


# -- lattices and velocities ----------------------------------------------------------------------------


def fluid(structure: str, number: int, **more: Any) -> Scene:
    dimension = 2 if structure in ("square", "triangular") else 3
    options = {"temperature": 1.5, "seed": 1, "density": 0.8} | more
    return Scene(
        name="fluid",
        dimension=dimension,
        duration=1.0,
        lennard_jones=LennardJones(cutoff=2.5),
        box=Box(density=options.pop("density")),
        initial=Lattice(kind="lattice", structure=structure, number=number, **options),
    )


def nearest(scene: Scene) -> float:
    state = scene.initial_state()
    distances, _ = cKDTree(state.positions, boxsize=state.lengths).query(state.positions, k=2)
    return float(distances[:, 1].min())


@pytest.mark.parametrize(
    ("structure", "number", "distance"),
    [
        ("fcc", 256, 2**0.5 / 2 * (4 / 0.8) ** (1 / 3)),
        ("sc", 216, 0.8 ** (-1 / 3)),
        ("square", 144, 0.8**-0.5),
        ("triangular", 360, None),
    ],
)
def test_lattices_are_the_ones_named(structure: str, number: int, distance: float | None) -> None:
    scene = fluid(structure, number)
    state = scene.initial_state()
    assert state.positions.shape == (number, scene.dimension)
    assert (state.positions >= 0).all()
    assert (state.positions < state.lengths).all()
    assert scene.volume() == pytest.approx(number / 0.8)
    if distance is not None:
        assert nearest(scene) == pytest.approx(distance)
    else:
        # nearly triangular in a square: within some per cent of the ideal distance
        assert nearest(scene) == pytest.approx((2 / 3**0.5 / 0.8) ** 0.5, rel=0.06)


@given(structure=st.sampled_from(["fcc", "sc", "square", "triangular"]), number=st.integers(1, 300))
def test_any_number_of_sites_keeps_apart(structure: str, number: int) -> None:
    scene = fluid(structure, number)
    state = scene.initial_state()
    assert state.positions.shape == (number, scene.dimension)
    if number > 1:
        assert nearest(scene) > 0.4 * (number / 0.8 / number) ** (1 / scene.dimension)


@given(number=st.integers(2, 200), seed=st.integers(0, 2**32), temperature=st.floats(1e-3, 10))
def test_velocities_are_maxwell_s_without_total_momentum(number: int, seed: int, temperature: float) -> None:
    masses = tuple(1.0 + i % 3 for i in range(number))
    scene = fluid("fcc", number, seed=seed, temperature=temperature).changed(masses=masses)
    state = scene.initial_state()
    m, v = state.masses[:, None], state.velocities
    np.testing.assert_allclose((m * v).sum(axis=0), 0, atol=1e-12 * abs(m * v).sum())
    assert 0.5 * (m * v**2).sum() == pytest.approx(1.5 * (number - 1) * temperature, rel=1e-12)
    again = scene.initial_state()
    np.testing.assert_array_equal(again.velocities, v)
    np.testing.assert_array_equal(again.positions, state.positions)


def test_velocities_follow_maxwell_s_distribution() -> None:
    from scipy.stats import kstest

    scene = fluid("fcc", 4000, temperature=2.0).changed(masses=4.0)
    assert kstest(scene.initial_state().velocities.ravel() / 0.5**0.5, "norm").pvalue > 1e-3


def test_seeds_differ_and_no_temperature_is_rest() -> None:
    one, two = (fluid("fcc", 32, seed=seed).initial_state().velocities for seed in (1, 2))
    assert not (one == two).any()
    assert not fluid("fcc", 32, temperature=0.0).initial_state().velocities.any()
    assert not fluid("fcc", 1).initial_state().velocities.any()


def test_a_lattice_of_another_dimension() -> None:
    scene = fluid("fcc", 32)
    wrong = scene.changed(initial=scene.initial.model_copy(update={"structure": "square"}))
    with pytest.raises(UsageError, match="'square' fills 2 dimensions, the scene has 3: take another structure"):
        wrong.initial_state()


# -- between hard walls ---------------------------------------------------------------------------------


@given(number=st.integers(1, 60), stroke=st.floats(0.01, 0.5), edge=st.floats(10, 20))
def test_a_lattice_between_hard_walls_keeps_surfaces_inside(number: int, stroke: float, edge: float) -> None:
    floor = Face(oscillation=Oscillation(amplitude=stroke, frequency=1.0))
    scene = Scene(
        name="box",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(edge, edge), boundaries=("hard", "hard"), faces={"y-": floor}),
        initial=Lattice(kind="lattice", structure="square", number=number, speed=2.0, seed=1),
    )
    state = scene.initial_state()
    assert (state.positions >= 0.5 - 1e-12).all()
    assert (state.positions <= edge - 0.5 + 1e-12).all()
    assert (state.positions[:, 1] >= 0.5 + stroke - 1e-12).all()
    np.testing.assert_allclose(np.linalg.norm(state.velocities, axis=1), 2.0, rtol=1e-14)


def test_the_densest_square_lattice_fits_between_walls() -> None:
    scene = Scene(
        name="box",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(10.0, 10.0), boundaries=("hard", "hard")),
        initial=Lattice(kind="lattice", structure="square", number=100, speed=1.0, seed=1),
    )
    x = np.unique(scene.initial_state().positions.round(12))
    np.testing.assert_allclose(x, np.arange(10) + 0.5, rtol=1e-12)


@pytest.mark.parametrize(("dimension", "structure"), [(2, "triangular"), (3, "fcc")])
def test_a_lattice_in_a_cylinder(dimension: int, structure: str) -> None:
    scene = Scene(
        name="drum",
        dimension=dimension,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(12.0,) * dimension,
            boundaries=("open", "open", "hard")[:dimension],
            cylinder=Cylinder(radius=5.5, axis="z" if dimension == 3 else None),
        ),
        initial=Lattice(kind="lattice", structure=structure, number=50, temperature=1.0, seed=1),
    )
    state = scene.initial_state()
    assert len(state.positions) == 50
    assert np.linalg.norm(state.positions[:, :2] - 6.0, axis=1).max() <= 5.0


def test_lattice_velocities_beside_fixed_particles() -> None:
    scene = Scene(
        name="mixture",
        dimension=2,
        duration=1.0,
        masses=2.0,
        species=(0, 1) * 50,
        hard_spheres=HardSpheres(diameter=0.5, fixed=(1,)),
        box=Box(lengths=(20.0, 20.0)),
        initial=Lattice(kind="lattice", structure="square", number=100, temperature=1.5, seed=1),
    )
    v = scene.initial_state().velocities
    assert not v[1::2].any()
    assert (v[::2] ** 2).sum() == pytest.approx(2 * 50 * 1.5 / 2.0)


# -- orbits, and states that cannot be ------------------------------------------------------------------


@given(
    e=st.floats(0, 0.99),
    a=st.floats(0.1, 10),
    G=st.floats(0.1, 10),
    masses=st.tuples(st.floats(0, 5), st.floats(0.1, 5)),
    dimension=st.sampled_from([2, 3]),
)
def test_kepler_start_has_the_energy_and_angular_momentum_of_its_orbit(
    e: float, a: float, G: float, masses: tuple[float, float], dimension: int
) -> None:
    scene = Scene(
        name="orbit",
        dimension=dimension,
        duration=1.0,
        masses=masses,
        gravity=Gravity(G=G),
        initial=Kepler(kind="kepler", semi_major_axis=a, eccentricity=e),
    )
    state = scene.initial_state()
    r, v = state.positions[1] - state.positions[0], state.velocities[1] - state.velocities[0]
    total = G * sum(masses)
    assert 0.5 * v @ v - total / np.linalg.norm(r) == pytest.approx(-total / (2 * a), rel=1e-11)
    assert r[0] * v[1] - r[1] * v[0] == pytest.approx((total * a * (1 - e**2)) ** 0.5, rel=1e-12)
    assert np.linalg.norm(r) == pytest.approx(a * (1 + e))
    for vectors in (state.positions, state.velocities):
        np.testing.assert_allclose(state.masses @ vectors, 0, atol=1e-13 * abs(vectors).max() * sum(masses))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gravity": None, "spring": Spring(k=1.0)}, r"'kepler' needs \[gravity\] and dimension 2 or 3"),
        ({"dimension": 1}, r"'kepler' needs \[gravity\] and dimension 2 or 3"),
        ({"masses": (0.0, 0.0)}, "one of the two bodies of initial.kind = 'kepler' needs a mass"),
        ({"masses": (1.0, 1.0, 1.0)}, "masses: 3 values for 2 particles; give one, or one per particle"),
        ({"species": (0,)}, "species: 1 values for 2 particles; give one per particle"),
    ],
)
def test_states_that_cannot_be(change: dict[str, Any], message: str) -> None:
    scene = Scene(
        name="orbit", dimension=2, duration=1.0, gravity=Gravity(), initial=Kepler(kind="kepler", eccentricity=0.1)
    )
    with pytest.raises(UsageError, match=message):
        scene.changed(**change).initial_state()


@pytest.mark.parametrize(
    ("positions", "lengths", "pair"),
    [
        ([[1.0, 1.0], [2.0, 2.0], [1.0, 1.0]], [5.0, 5.0], "0 and 2"),
        ([[1.0, 1.0], [2.0, 2.0], [2.0, 7.0]], [5.0, 5.0], "1 and 2"),
        ([[1.0, 0.0], [2.0, 2.0], [1.0, 5.0]], [5.0, 5.0], "0 and 2"),
        ([[-0.0, 1.0], [0.0, 1.0]], None, "0 and 1"),
    ],
)
def test_coincident_particles_are_named(positions: list[list[float]], lengths: list[float] | None, pair: str) -> None:
    scene = Scene(
        name="pair",
        dimension=2,
        duration=0.0,
        lennard_jones=LennardJones(cutoff=2.5),
        box=None if lengths is None else Box(lengths=tuple(lengths)),
        initial=explicit(np.array(positions), np.zeros((len(positions), 2))),
    )
    with pytest.raises(UsageError, match=f"particles {pair} are at the same place: move one of them"):
        scene.initial_state()


# -- configuration files --------------------------------------------------------------------------------


POSITIONS = np.array([[0.1, 0.2, 0.3], [1.5, 1.6, 1.7]])
VELOCITIES = np.array([[1.0, 0.0, -0.25], [0.0, 2.0, 0.5]])


def from_file(tmp_path: Path, name: str, dimension: int = 3) -> Scene:
    table = changed(FLUID, "initial", {"kind": "file", "path": name})
    if dimension == 2:
        table = changed(changed(table, "dimension", 2), "box.lengths", [5.0, 5.0])
    return load(tmp_path, table)


@pytest.mark.parametrize("dimension", [2, 3])
def test_npz_configurations(tmp_path: Path, dimension: int) -> None:
    inside = np.arange(3) < dimension  # a plane takes files in space if nothing is or moves along z
    np.savez(tmp_path / "start.npz", positions=POSITIONS * inside, velocities=VELOCITIES * inside)
    state = from_file(tmp_path, "start.npz", dimension).initial_state()
    np.testing.assert_array_equal(state.positions, POSITIONS[:, :dimension])
    np.testing.assert_array_equal(state.velocities, VELOCITIES[:, :dimension])
    np.savez(tmp_path / "rest.npz", positions=POSITIONS)
    assert not from_file(tmp_path, "rest.npz").initial_state().velocities.any()


def test_xyz_configurations(tmp_path: Path) -> None:
    rows = "".join(f"X {x!r} {y!r} {z!r}\n" for x, y, z in POSITIONS.tolist())
    (tmp_path / "start.xyz").write_text(f"2\nProperties=species:S:1:pos:R:3\n{rows}")
    state = from_file(tmp_path, "start.xyz").initial_state()
    np.testing.assert_array_equal(state.positions, POSITIONS)
    assert not state.velocities.any()


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        (None, r"initial.path = .*start.npz: cannot be read as a configuration"),
        ({"velocities": POSITIONS}, r"cannot be read as a configuration .*positions"),
        ({"positions": np.full((2, 3), np.nan)}, "holds values that are not finite"),
        ({"positions": POSITIONS[:, :2]}, r"initial.positions\[0\] has 2 components in dimension 3"),
        ({"positions": POSITIONS[0]}, r"cannot be read as a configuration"),
        ({"positions": POSITIONS, "velocities": VELOCITIES[:1]}, "initial.velocities has 1 rows for 2 particles"),
    ],
)
def test_configurations_that_cannot_be_used(tmp_path: Path, arrays: dict[str, Any] | None, message: str) -> None:
    if arrays is not None:
        np.savez(tmp_path / "start.npz", **arrays)
    with pytest.raises(UsageError, match=message):
        from_file(tmp_path, "start.npz")


def test_files_may_hold_angular_velocities(tmp_path: Path) -> None:
    table = changed(TURNING, "initial", {"kind": "file", "path": "start.npz"})
    places = np.array([[1.0, 1.0], [3.0, 3.0]])
    np.savez(tmp_path / "start.npz", positions=places, angular_velocities=[[1.0], [2.0]])
    np.testing.assert_array_equal(load(tmp_path, table).initial_state().angular_velocities, [[1.0], [2.0]])
    for spins, message in (
        ([[math.nan], [2.0]], "angular_velocities holds values that are not finite"),
        ([1.0, 2.0], "angular_velocities needs two dimensions, found 1"),
        ([[1.0]], "initial.angular_velocities has 1 rows for 2 particles"),
    ):
        np.savez(tmp_path / "start.npz", positions=places, angular_velocities=spins)
        with pytest.raises(UsageError, match=message):
            load(tmp_path, table)
