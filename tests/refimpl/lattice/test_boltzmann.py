"""The lattice Boltzmann iteration: propagation, conservation, and the modes it must have; walls and drive."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from lattice_gases import DENSITIES, every_model, every_set, mass_and_momentum

from crosscheck.references.lattice_models import modes
from refimpl.lattice.boltzmann import BoltzmannLattice
from refimpl.lattice.equilibrium import fermi_dirac
from refimpl.lattice.models import MODELS, Model, build
from refimpl.lattice.velocities import VelocitySet


class Push(NamedTuple):
    """A drive."""

    channel: int
    probability: float


def positions(velocities: VelocitySet, rows: int, columns: int) -> np.ndarray:
    """(rows, columns, 2)."""
    y, x = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    return np.stack([x + 0.5 * (y % 2) * velocities.half_rows, y * velocities.row_height], axis=-1)


def total(lattice: BoltzmannLattice) -> np.ndarray:
    return mass_and_momentum(lattice.model.velocities, lattice.f).sum(axis=(0, 1))


@every_set
def test_particles_move_by_their_velocity(velocities: VelocitySet) -> None:
    model = build("free", velocities, lambda velocities, state: state)
    rows, columns = 4, 3
    place = positions(velocities, rows, columns)
    box = np.array([columns, rows * velocities.row_height])
    for row, column, i in np.ndindex(rows, columns, velocities.channels):
        f = np.zeros((rows, columns, velocities.channels))
        f[row, column, i] = 1
        lattice = BoltzmannLattice(model, f)
        lattice.advance(1)
        ((y, x, j),) = np.argwhere(lattice.f)
        moved = place[y, x] - place[row, column] - velocities.cartesian[i]
        assert j == i
        np.testing.assert_allclose(moved / box, np.round(moved / box), atol=1e-12)
        lattice.advance(2 * rows * columns - 1)
        assert lattice.time == 2 * rows * columns
        np.testing.assert_array_equal(lattice.f, f)


@every_model
@given(data=st.data())
def test_conservation_and_the_h_theorem(model: Model, data: st.DataObject) -> None:
    f = data.draw(arrays(np.float64, (4, 3, model.channels), elements=st.floats(0, 1)))
    lattice = BoltzmannLattice(model, f)
    before, h = total(lattice), lattice.h_function
    for _ in range(5):
        lattice.advance(1)
        assert lattice.h_function <= h + 1e-12
        h = lattice.h_function
    np.testing.assert_allclose(total(lattice), before, rtol=0, atol=1e-13)


@every_model
def test_uniform_equilibrium_is_stationary(model: Model) -> None:
    f = np.tile(fermi_dirac(model.velocities, 0.3, (0.1, 0.07)), (4, 3, 1))
    lattice = BoltzmannLattice(model, f)
    lattice.advance(100)
    np.testing.assert_allclose(lattice.f, f, rtol=0, atol=1e-15)


def collided_by_sums(model: Model, f: np.ndarray) -> np.ndarray:
    """f + Delta(f), (b,), by the sum over all states and their outcomes."""
    states = np.array([[s >> i & 1 for i in range(model.channels)] for s in range(model.velocities.states)])
    after = np.array([states[list(found)].mean(axis=0) for found in model.outcomes])
    return np.asarray(f + np.prod(np.where(states, f, 1 - f), axis=1) @ (after - states))


def collided(model: Model, f: np.ndarray) -> np.ndarray:
    """f (..., b) after one step of lattices whose sites are all alike."""
    found = []
    for one in f.reshape(-1, model.channels):
        lattice = BoltzmannLattice(model, np.tile(one, (2, 1, 1)))
        lattice.advance(1)
        np.testing.assert_array_equal(lattice.f[0], lattice.f[1])
        found.append(lattice.f[0, 0])
    return np.array(found).reshape(f.shape)


@every_model
@given(data=st.data())
def test_collisions_against_the_sum_over_all_states(model: Model, data: st.DataObject) -> None:
    f = data.draw(arrays(np.float64, (2, model.channels), elements=st.floats(0, 1)))
    found = collided(model, f)
    for site in range(2):
        np.testing.assert_allclose(found[site], collided_by_sums(model, f[site]), rtol=0, atol=1e-15)
    change = mass_and_momentum(model.velocities, found - f)
    np.testing.assert_allclose(change, 0, atol=1e-14)
    assert ((found > -1e-15) & (found < 1 + 1e-15)).all()


@every_model
def test_collisions_leave_equilibrium_alone(model: Model) -> None:
    u = np.array([(0.0, 0.0), (0.2, 0.0), (-0.05, 0.3)])
    for d in DENSITIES:
        f = fermi_dirac(model.velocities, d, u)
        np.testing.assert_allclose(collided(model, f), f, rtol=0, atol=3e-16)


def test_h_of_some_occupations() -> None:
    """0 ln 0 = 0; occupations that rounding has carried past 0 or 1 count as these."""
    fhp = MODELS["fhp1"]
    empty_and_full = np.zeros((2, 3, 6))
    empty_and_full[0] = 1.0
    lattice = BoltzmannLattice(fhp, empty_and_full)
    assert lattice.h_function == 0
    lattice.f[0], lattice.f[1] = 1 + 2.0**-52, -(2.0**-60)
    assert lattice.h_function == pytest.approx(0, abs=1e-14)
    assert BoltzmannLattice(fhp, np.full((2, 3, 6), 0.5)).h_function == pytest.approx(-36 * math.log(2), rel=1e-14)
    f = np.array([0.2, 0.9, 0.2, 0.9, 0.2, 0.9])
    one = 0.2 * math.log(0.2) + 0.8 * math.log(0.8) + 0.9 * math.log(0.9) + 0.1 * math.log(0.1)
    assert BoltzmannLattice(fhp, np.tile(f, (2, 3, 1))).h_function == pytest.approx(18 * one, rel=1e-14)


def wave(lattice: BoltzmannLattice, k: np.ndarray) -> np.ndarray:
    """Fourier components of mass and momentum, (3,)."""
    place = positions(lattice.model.velocities, *lattice.f.shape[:2])
    phases = np.exp(-1j * (place @ k))[..., None]
    return (phases * mass_and_momentum(lattice.model.velocities, lattice.f)).mean(axis=(0, 1))


def perturbed(model: Model, rows: int, columns: int, k: np.ndarray, d: float, u: np.ndarray) -> BoltzmannLattice:
    """Equilibrium with d (1 + 0.3 eps sin), and the velocity u + eps (1, 1) sin, eps = 1e-5, of k.r."""
    small = 1e-5 * np.sin(positions(model.velocities, rows, columns) @ k)
    return BoltzmannLattice(model, fermi_dirac(model.velocities, d * (1 + 0.3 * small), u + small[..., None]))


@pytest.mark.parametrize("name", [name for name in MODELS if name != "hpp"])
@pytest.mark.parametrize("along_x", [True, False])
@pytest.mark.parametrize("u", [(0.0, 0.0), (0.1, 0.05)])
def test_small_waves_evolve_as_the_modes_say(name: str, along_x: bool, u: tuple[float, float]) -> None:
    """Mass and momentum of one wave at three times, after the fast modes died, are a 3 x 3 map to the next times."""
    model = MODELS[name]
    rows, columns = (2, 40) if along_x else (40, 2)
    size = columns if along_x else rows * model.velocities.row_height
    k = 2 * math.pi / size * np.array([along_x, not along_x], dtype=float)
    d, apart = 0.3, 12
    lattice = perturbed(model, rows, columns, k, d, np.array(u))
    lattice.advance(120)
    seen = []
    for _ in range(4):
        seen.append(wave(lattice, k))
        lattice.advance(apart)
    step = np.stack(seen[1:], axis=1) @ np.linalg.inv(np.stack(seen[:3], axis=1))
    found = np.linalg.eigvals(step)
    forth, back = (modes(name, d, sign * k, u) for sign in (1, -1))
    expected = np.array(
        [
            -forth.shear_decay - 1j * forth.shear_frequency,
            -forth.sound_damping - 1j * forth.sound_frequency,
            -back.sound_damping + 1j * back.sound_frequency,
        ]
    )
    for value in np.exp(apart * expected):
        assert np.abs(found - value).min() < 1e-7
    assert len({int(np.abs(found - value).argmin()) for value in np.exp(apart * expected)}) == 3


def test_hpp_keeps_the_momentum_of_each_line() -> None:
    """Spurious invariants, none of them local: along x in each row, along y in each column."""
    rng = np.random.default_rng(3)
    f = rng.random((5, 7, 4))
    lattice = BoltzmannLattice(MODELS["hpp"], f)
    lattice.advance(50)
    assert np.abs(lattice.f - f).max() > 0.1
    for axis in (0, 1):
        lines = [(x[..., axis] - x[..., axis + 2]).sum(axis=1 - axis) for x in (f, lattice.f)]
        np.testing.assert_allclose(lines[1], lines[0], rtol=0, atol=1e-13)


def test_sound_in_hpp_decays_as_its_mode() -> None:
    columns, d, eps = 48, 0.5, 1e-5
    k = 2 * math.pi / columns
    f = np.tile(d * (1 + eps * np.cos(k * np.arange(columns)))[None, :, None], (1, 1, 4))
    lattice = BoltzmannLattice(MODELS["hpp"], f)
    lattice.advance(40)
    seen = []
    for _ in range(3):
        seen.append(wave(lattice, np.array([k, 0]))[:2])
        lattice.advance(8)
    step = np.stack(seen[1:], axis=1) @ np.linalg.inv(np.stack(seen[:2], axis=1))
    found = modes("hpp", d, (k, 0))
    assert found.sound_damping == pytest.approx(k**2 / 8, rel=0.01)
    expected = np.exp(-8 * (found.sound_damping + 1j * found.sound_frequency))
    for value in (expected, expected.conjugate()):
        assert np.abs(np.linalg.eigvals(step) - value).min() < 1e-6


# -- walls and drive ---------------------------------------------------------------------------------------------------

every_lattice = pytest.mark.parametrize("name", ["hpp", "fhp1", "fhp3"])


def random_lattice(name: str, walls: np.ndarray | None, forcing: Push | None = None) -> BoltzmannLattice:
    f = np.random.default_rng(4).random((8, 6, MODELS[name].channels))
    return BoltzmannLattice(MODELS[name], f, walls, forcing)


@every_lattice
def test_walls_of_any_kind_keep_mass_and_lower_h(name: str) -> None:
    walls = np.random.default_rng(5).integers(0, 16, (8, 6)).astype(np.uint8)
    lattice = random_lattice(name, walls)
    mass = total(lattice)[0]
    h = lattice.h_function
    for _ in range(20):
        lattice.advance(1)
        assert total(lattice)[0] == pytest.approx(mass, rel=1e-14)
        assert lattice.h_function < h + 1e-12
        h = lattice.h_function


@every_lattice
@pytest.mark.parametrize(("code", "kept"), [(1, 2), (2, 1)])
def test_specular_walls_keep_the_tangential_momentum(name: str, code: int, kept: int) -> None:
    walls = np.zeros((8, 6), dtype=np.uint8)
    walls[(0, slice(None)) if code == 2 else (slice(None), 0)] = code
    lattice = random_lattice(name, walls)
    before = total(lattice)
    lattice.advance(20)
    after = total(lattice)
    assert after[kept] == pytest.approx(before[kept], abs=1e-12)
    assert abs(after[3 - kept] - before[3 - kept]) > 0.1


@every_lattice
def test_what_leaves_a_wall(name: str) -> None:
    """Of the occupations that arrive: bounced back, mirrored, or half of each pair of images."""
    walls = np.zeros((8, 6), dtype=np.uint8)
    walls[3] = (3, 2, 1, 6, 9, 12)
    lattice = random_lattice(name, walls)
    free = BoltzmannLattice(build("free", lattice.model.velocities, lambda velocities, state: state), lattice.f)
    lattice.advance(1)
    free.advance(1)
    image = lattice.model.velocities.image
    arrived, left = free.f[3], lattice.f[3]
    signs: list[list[tuple[int, int]]] = [
        [(-1, -1)],
        [(1, -1)],
        [(-1, 1)],
        [(1, -1), (-1, -1)],
        [(-1, 1), (-1, -1)],
        [(1, 1), (-1, -1)],
    ]
    for column, images in enumerate(signs):
        expected = np.mean([arrived[column, list(image(*each))] for each in images], axis=0)
        np.testing.assert_allclose(left[column], expected, rtol=1e-14)
    # diffusive walls take up the tangential momentum
    momentum = left @ lattice.model.velocities.cartesian
    np.testing.assert_allclose([momentum[3, 0], momentum[4, 1], *momentum[5]], 0, atol=1e-15)


@every_lattice
def test_a_gas_at_rest_stays_at_rest_between_walls(name: str) -> None:
    walls = np.zeros((8, 6), dtype=np.uint8)
    walls[0], walls[4] = 3, 6
    lattice = BoltzmannLattice(MODELS[name], np.full((8, 6, MODELS[name].channels), 0.3), walls)
    lattice.advance(10)
    np.testing.assert_allclose(lattice.f, 0.3, rtol=1e-14)


@every_lattice
def test_the_drive_moves_particles_at_fluid_sites(name: str) -> None:
    """Each turned particle changes the momentum by 2 c_i; from rest, p d (1 - d) of them at a site."""
    b, d, p = MODELS[name].channels, 0.3, 0.2
    walls = np.zeros((8, 6), dtype=np.uint8)
    walls[0] = 3
    lattice = BoltzmannLattice(MODELS[name], np.full((8, 6, b), d), walls, Push(1, p))
    lattice.advance(1)
    c = lattice.model.velocities.cartesian[1]
    expected = [48 * b * d, *(42 * 2 * p * d * (1 - d) * c)]
    np.testing.assert_allclose(total(lattice), expected, rtol=1e-13)
    opposite = lattice.model.velocities.image(-1, -1)[1]
    driven = np.full(b, d)
    driven[[1, opposite]] += p * d * (1 - d) * np.array([1, -1])
    collided = collided_by_sums(lattice.model, driven)
    np.testing.assert_allclose(lattice.f[1:], np.broadcast_to(collided, (7, 6, b)), rtol=1e-14)
    np.testing.assert_allclose(lattice.f[0], d, rtol=1e-14)
    lattice.advance(50)
    assert total(lattice)[0] == pytest.approx(48 * b * d, rel=1e-13)
    assert ((lattice.f >= 0) & (lattice.f <= 1)).all()


def test_lattices_that_there_are_not() -> None:
    hpp, fhp = MODELS["hpp"], MODELS["fhp3"]
    f = np.full((4, 3, 7), 0.5)
    with pytest.raises(ValueError, match=r"shape \(rows, columns, 4\)"):
        BoltzmannLattice(hpp, f)
    with pytest.raises(ValueError, match=r"shape \(rows, columns, 7\)"):
        BoltzmannLattice(fhp, f[0])
    with pytest.raises(ValueError, match="even number of rows, got 3"):
        BoltzmannLattice(fhp, f[:3])
    BoltzmannLattice(hpp, np.zeros((3, 3, 4)))
    for value in (-1e-9, 1.5, math.nan):
        with pytest.raises(ValueError, match=f"between 0 and 1, got {value}"):
            BoltzmannLattice(fhp, np.where(np.arange(7) == 2, value, f))
    with pytest.raises(ValueError, match=r"walls must have the shape \(4, 3\)"):
        BoltzmannLattice(fhp, f, np.zeros((3, 4), dtype=np.uint8))
    with pytest.raises(ValueError, match="numbered 0 to 15, got 16"):
        BoltzmannLattice(fhp, f, np.full((4, 3), 16, dtype=np.uint8))
    for channel in (-1, 6, 7):
        with pytest.raises(ValueError, match=f"channel that moves, got {channel}"):
            BoltzmannLattice(fhp, f, forcing=Push(channel, 0.1))
    with pytest.raises(ValueError, match=r"probability of a drive must be between 0 and 1, got 1.1"):
        BoltzmannLattice(fhp, f, forcing=Push(0, 1.1))


def test_the_array_given_is_left_alone() -> None:
    f = np.random.default_rng(6).random((4, 3, 6))
    copy = f.copy()
    lattice = BoltzmannLattice(MODELS["fhp1"], f)
    lattice.advance(3)
    np.testing.assert_array_equal(f, copy)
    assert lattice.time == 3
