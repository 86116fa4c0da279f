"""Collision rules: what they keep, what they lose, and how the random ones are distributed.

Kolmogorov-Smirnov tests demand p > 1e-4: so often would another seed fail a right rule; with these seeds none does.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from event_scenes import full
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy import stats

from refimpl.events.model import (
    FLUX_PHASE,
    OSCILLATING,
    UNIFORM_PHASE,
    Cylinder,
    Face,
    Friction,
    HardSpheres,
    Oscillation,
    RandomPhase,
    hard_spheres,
)
from refimpl.events.rules import (
    apply_impulse,
    hit_cylinder,
    hit_plane,
    normal_restitution,
    pair_impulse,
    random_uniform,
    still_in_contact,
    thermal_velocity,
    wall_velocity,
    well_velocity,
)

EPS = 2.0**-52
RARE = 1e-4
SMOOTH = Friction()
MANY = settings(max_examples=500)

numbers = st.integers(0, 2**32)
unit = st.floats(0, 1)
frictions = st.builds(
    lambda alpha_t, static, share, inertia: Friction(alpha_t, static, share * static, inertia),
    st.floats(-1, 1), st.floats(0, 3), unit, st.floats(0.01, 1),
)  # fmt: skip
ratios = st.floats(-3, 3).map(lambda power: 10**power)


class Impact(NamedTuple):
    """Two particles in contact that approach; n from the first to the second."""

    model: HardSpheres
    rows: np.ndarray
    spins: np.ndarray
    n: np.ndarray
    radii: np.ndarray
    masses: np.ndarray

    def contact_velocity(self) -> tuple[float, np.ndarray]:
        """Of 2 relative to 1 at the contact: v_2 - v_1 - (R_1 w_1 + R_2 w_2) x n, its normal part and the rest."""
        v = self.rows[1, 3:6] - self.rows[0, 3:6] - np.cross(self.radii @ self.spins, self.n)
        return v @ self.n, v - (v @ self.n) * self.n

    def momentum(self) -> np.ndarray:
        return self.masses @ self.rows[:, 3:6]

    def angular_momentum(self, about: np.ndarray) -> np.ndarray:
        inertia = self.model.rough.inertia * self.masses * self.radii**2
        orbital = np.cross(self.rows[:, :3] - about, self.masses[:, None] * self.rows[:, 3:6])
        return orbital.sum(axis=0) + inertia @ self.spins

    def energy(self) -> float:
        inertia = self.model.rough.inertia * self.masses * self.radii**2
        return 0.5 * (self.masses @ (self.rows[:, 3:6] ** 2).sum(axis=1) + inertia @ (self.spins**2).sum(axis=1))

    def scale(self) -> float:
        """Of the momenta."""
        speeds = np.linalg.norm(self.rows[:, 3:6], axis=1) + self.radii * np.linalg.norm(self.spins, axis=1)
        return float((self.masses * speeds).sum())


def impact(d: int, seed: int, size_ratio: float, mass_ratio: float, alpha: float, friction: Friction) -> Impact:
    rng = np.random.default_rng(seed)
    radii, masses = np.array([0.5, 0.5 * size_ratio]), np.array([1.0, mass_ratio])
    sides: dict[str, Any] = {"lengths": (1e4,) * d, "periodic": (True,) * d}
    model = full(2, **sides, diameters=2 * radii, masses=masses, restitution=alpha, friction=friction)
    n, rows, spins = np.zeros(3), np.zeros((2, 8)), np.zeros((2, 3))
    n[:d] = rng.normal(size=d)
    n /= np.linalg.norm(n)
    rows[:, :d] = rng.normal(size=d)
    rows[1, :3] += radii.sum() * n
    rows[:, 3 : 3 + d] = rng.normal(size=(2, d))
    spins[:, 2 if d == 2 else 0 :] = rng.normal(size=(2, 1 if d == 2 else 3)) / radii[:, None]
    if (rows[1, 3:6] - rows[0, 3:6]) @ n > 0:
        rows[:, 3:6] = rows[::-1, 3:6].copy()
    return Impact(model, rows, spins, n, radii, masses)


def collide(event: Impact, recent: bool = False) -> np.ndarray:
    """Applies the rule; the impulse on the second."""
    model, n = event.model, event.n
    gn = (event.rows[1, 3:6] - event.rows[0, 3:6]) @ n
    alpha = normal_restitution(model.restitution, recent)
    p = pair_impulse(model.rough, event.spins, model, event.rows, 0, 1, tuple(n.tolist()), gn, alpha, recent)
    apply_impulse(model, event.rows, 0, 1, p)
    return np.array(p)


impacts = st.builds(impact, st.sampled_from([2, 3]), numbers, ratios.map(abs), ratios, unit, frictions)


@MANY
@given(impacts)
def test_momentum_angular_momentum_and_energy(event: Impact) -> None:
    about = np.array([3.0, -2.0, 1.0 if len(event.model.lengths) == 3 else 0.0])
    p, angular, energy, scale = event.momentum(), event.angular_momentum(about), event.energy(), event.scale()
    arm = np.abs(event.rows[:, :3] - about).max() + event.radii.max()
    collide(event)
    np.testing.assert_allclose(event.momentum(), p, rtol=0, atol=8 * EPS * scale)
    np.testing.assert_allclose(event.angular_momentum(about), angular, rtol=0, atol=32 * EPS * scale * arm)
    assert event.energy() <= energy * (1 + 16 * EPS)
    if len(event.model.lengths) == 2:  # stays in the plane
        assert not event.rows[:, [2, 5]].any()
        assert not event.spins[:, :2].any()


@MANY
@given(impacts)
def test_contact_velocity_coulomb_and_loss(event: Impact) -> None:
    rough, alpha = event.model.rough, event.model.restitution
    normal, slip = event.contact_velocity()
    speed, energy = np.linalg.norm(slip), event.energy()
    reduced, q = event.masses.prod() / event.masses.sum(), rough.inertia
    p = collide(event)
    normal_after, slip_after = event.contact_velocity()
    across = p - (p @ event.n) * event.n
    jn, jt = p @ event.n, np.linalg.norm(across)
    # rounding: of the velocities, the lighter one's change included, and of the spins through the inverse inertia
    rounding = 64 * EPS * (event.scale() / event.masses.min() / min(q, 1))
    assert normal_after == pytest.approx(-alpha * normal, abs=rounding)
    assert jn == pytest.approx(-(1 + alpha) * reduced * normal, rel=16 * EPS, abs=EPS * event.scale())
    sticking = (1 - rough.tangential_restitution) * q / (1 + q) * reduced * speed
    if abs(sticking - rough.static * jn) < 64 * EPS * event.scale():
        return  # rounding decides which it is
    lost = 0.5 * reduced * (1 - alpha**2) * normal**2
    if sticking <= rough.static * jn:
        np.testing.assert_allclose(slip_after, rough.tangential_restitution * slip, rtol=0, atol=rounding)
        lost += 0.5 * reduced * q / (1 + q) * (1 - rough.tangential_restitution**2) * speed**2
    else:
        slid = rough.sliding * jn
        assert jt == pytest.approx(slid, abs=64 * EPS * event.scale())
        assert across @ slip <= 64 * EPS * event.scale() * speed  # against the slip
        lost += slid * speed - 0.5 * slid**2 * (1 + 1 / q) / reduced
    assert energy - event.energy() == pytest.approx(lost, abs=64 * EPS * energy)


@MANY
@given(impacts)
def test_grains_that_have_just_collided_are_smooth_and_elastic(event: Impact) -> None:
    spins, energy, scale = event.spins.copy(), event.energy(), event.scale()
    normal = (event.rows[1, 3:6] - event.rows[0, 3:6]) @ event.n
    collide(event, recent=True)
    np.testing.assert_array_equal(event.spins, spins)
    assert event.energy() == pytest.approx(energy, rel=16 * EPS)
    after = (event.rows[1, 3:6] - event.rows[0, 3:6]) @ event.n
    assert after == pytest.approx(-normal, abs=64 * EPS * scale / event.masses.min())


def test_time_in_contact() -> None:
    assert [normal_restitution(0.5, still_in_contact(0.1, age)) for age in (0.0, 0.09, 0.1, 1.0)] == [
        1.0,
        1.0,
        0.5,
        0.5,
    ]
    assert not still_in_contact(None, 0.0)
    assert normal_restitution(None, False) == 1.0


def test_a_fixed_particle_stays() -> None:
    model = hard_spheres(lengths=(9.0,) * 3, periodic=(True,) * 3, masses=[1.0, math.inf])
    rows = np.zeros((2, 8))
    rows[0, 3:6], rows[1, 0] = [1.0, 0.5, 0.0], 1.0
    p = pair_impulse(None, None, model, rows, 0, 1, (1.0, 0.0, 0.0), -1.0, 1.0, False)
    apply_impulse(model, rows, 0, 1, p)
    np.testing.assert_array_equal(rows[:, 3:6], [[-1.0, 0.5, 0.0], [0.0, 0.0, 0.0]])


# -- walls ----------------------------------------------------------------------------------------


def walled(d: int, face: int, wall: Face, friction: Friction = SMOOTH, mass: float = 2.0, **more: Any) -> HardSpheres:
    faces = [wall if k == face else None for k in range(2 * d)]
    periodic = [k != face >> 1 for k in range(d)]
    return full(1, lengths=(9.0,) * d, periodic=periodic, faces=faces, friction=friction, masses=mass, **more)


def inward(face: int) -> np.ndarray:
    n = np.zeros(3)
    n[face >> 1] = 1 - 2 * (face & 1)
    return n


def hit(model: HardSpheres, rows: np.ndarray, spins: np.ndarray, face: int, now: float = 0.0, count: int = 0) -> None:
    hit_plane(model, model.walls, model.rough, model.seed, rows, spins, 0, count, face, now, False)


@MANY
@given(numbers, st.sampled_from([2, 3]), st.integers(0, 5), unit, st.floats(-1, 3), frictions)
def test_wall_rule(seed: int, d: int, face: int, alpha: float, own: float, friction: Friction) -> None:
    """v_n' = (1 + alpha) V - alpha v_n; the contact's slip as for pairs, with an infinite mass; the other side too."""
    face %= 2 * d
    rng = np.random.default_rng(seed)
    model = walled(d, face, Face(alpha, velocity=own, friction=friction), friction)
    rows, spins, n = np.zeros((1, 8)), np.zeros((1, 3)), inward(face)
    rows[0, 3 : 3 + d] = 3 * rng.normal(size=d)
    spins[0, 2 if d == 2 else 0 :] = rng.normal(size=1 if d == 2 else 3)
    v, w = rows[0, 3:6].copy(), spins[0].copy()
    hit(model, rows, spins, face)
    after, turned = rows[0, 3:6], spins[0]
    if v @ n >= own:  # it does not approach
        np.testing.assert_array_equal(after, v)
        return
    assert after @ n == pytest.approx((1 + alpha) * own - alpha * (v @ n), abs=16 * EPS * (abs(v @ n) + abs(own)))
    mass, radius, q = 2.0, 0.5, friction.inertia or 0.0
    arm = -radius * n  # from the centre to the contact
    slip = v + np.cross(w, arm)
    slip -= (slip @ n) * n
    slip_after = after + np.cross(turned, arm)
    slip_after -= (slip_after @ n) * n
    impulse = mass * (after - v)
    along = impulse - (impulse @ n) * n
    size = np.abs(v).sum() + np.abs(w).sum() + abs(own)
    # angular momentum about the contact: no torque there
    np.testing.assert_allclose(
        mass * np.cross(-arm, after) + q * mass * radius**2 * turned,
        mass * np.cross(-arm, v) + q * mass * radius**2 * w, rtol=0, atol=32 * EPS * mass * size,
    )  # fmt: skip
    jn = mass * (1 + alpha) * (own - v @ n)
    sticking = (1 - friction.tangential_restitution) * q / (1 + q) * mass * np.linalg.norm(slip)
    if abs(sticking - friction.static * jn) < 32 * EPS * mass * size:
        return
    if sticking <= friction.static * jn:
        expected = friction.tangential_restitution * slip
        np.testing.assert_allclose(slip_after, expected, rtol=0, atol=32 * EPS * size / min(q, 1))
    else:
        assert np.linalg.norm(along) == pytest.approx(friction.sliding * jn, abs=32 * EPS * mass * size)
        assert along @ slip <= 32 * EPS * mass * size**2


@MANY
@given(numbers, st.sampled_from([0, 1, 2]), unit, st.floats(-3, 3), frictions)
@example(seed=0, axis=2, alpha=1.0, turning=0.0, friction=Friction(1.0, 0.0, 0.0, 0.4))
def test_drum_rule(seed: int, axis: int, alpha: float, turning: float, friction: Friction) -> None:
    """A wall whose surface moves with Omega x R: normal and tangential rule, and no torque about the contact."""
    rng = np.random.default_rng(seed)
    lengths, radius, size = (9.0, 9.0, 9.0), 4.0, 0.5
    model = hard_spheres(
        lengths=lengths,
        periodic=(False,) * 3,
        friction=friction,
        cylinder=Cylinder(radius, axis, turning, alpha, friction),
    )
    first, second = (k for k in range(3) if k != axis)
    angle = rng.uniform(0, 2 * math.pi)
    out = np.zeros(3)
    out[first], out[second] = math.cos(angle), math.sin(angle)
    # positive from the first transverse axis to the second
    surface = np.zeros(3)
    surface[first], surface[second] = -turning * radius * math.sin(angle), turning * radius * math.cos(angle)
    rows, spins = np.zeros((1, 8)), rng.normal(size=(1, 3))
    rows[0, :3] = 4.5 + (radius - size) * out
    rows[0, axis] = rng.uniform(0, 9)
    rows[0, 3:6] = rng.normal(size=3)
    v, w = rows[0, 3:6].copy(), spins[0].copy()
    hit_cylinder(model, model.cylinder, model.rough, rows, spins, 0, False)
    after, turned = rows[0, 3:6], spins[0]
    gn = v @ out
    if gn <= 0:
        np.testing.assert_array_equal(after, v)
        return
    scale = np.abs(v).sum() + np.abs(w).sum() + abs(turning) * radius
    # the normal is that of rounded positions
    assert after @ out == pytest.approx(-alpha * gn, abs=32 * EPS * scale)
    q, arm = friction.inertia or 0.0, size * out
    slip, slip_after = (a + np.cross(b, arm) - surface for a, b in ((v, w), (after, turned)))
    slip, slip_after = slip - (slip @ out) * out, slip_after - (slip_after @ out) * out
    np.testing.assert_allclose(
        np.cross(-arm, after) + q * size**2 * turned, np.cross(-arm, v) + q * size**2 * w, rtol=0, atol=64 * EPS * scale
    )
    jn, sticking = (1 + alpha) * gn, (1 - friction.tangential_restitution) * q / (1 + q) * np.linalg.norm(slip)
    if abs(sticking - friction.static * jn) < 64 * EPS * scale:
        return
    if sticking <= friction.static * jn:
        expected = friction.tangential_restitution * slip
        np.testing.assert_allclose(slip_after, expected, rtol=0, atol=64 * EPS * scale / min(q, 1))
    else:
        along = after - v - ((after - v) @ out) * out
        assert np.linalg.norm(along) == pytest.approx(friction.sliding * jn, abs=64 * EPS * scale)
        assert along @ slip <= 64 * EPS * scale**2


def test_oscillating_wall_has_the_velocity_of_its_place() -> None:
    model = walled(2, 0, Face(oscillation=Oscillation(0.1, 12.0, 0.3)))
    row, step = model.walls.numbers[0], 1e-4
    for now in np.linspace(0, 1, 20):
        own = wall_velocity(row, OSCILLATING, now, -5.0, 0, 0, 0)
        high, low = (0.1 * math.cos(0.3 + 12 * (now + sign * step)) for sign in (1, -1))
        assert own == pytest.approx((high - low) / (2 * step), abs=0.1 * 12**3 * step**2 / 6 + 1e-11)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("face", [0, 1, 2, 3])
def test_thermal_wall(d: int, face: int) -> None:
    """Flux of a gas at rest: v_n dv_n exp(-m v_n^2/2T), each other component Gaussian of variance T/m."""
    temperature, mass, number = 1.7, 2.0, 20000
    model = walled(d, face, Face(temperature=temperature), mass=mass, seed=11)
    found = np.empty((number, 3))
    for count in range(number):
        rows, spins = np.zeros((1, 8)), np.zeros((1, 3))
        rows[0, 3:5] = -4.0
        hit(model, rows, spins, face, count=count)
        found[count] = rows[0, 3:6]
    width = math.sqrt(temperature / mass)
    assert stats.kstest(found @ inward(face), stats.rayleigh(scale=width).cdf).pvalue > RARE
    across = [k for k in range(d) if k != face >> 1]
    for k in across:
        assert stats.kstest(found[:, k], stats.norm(scale=width).cdf).pvalue > RARE
    independent = np.corrcoef(np.abs(found[:, [face >> 1, *across]]).T) - np.eye(d)
    assert np.abs(independent).max() < 5 / math.sqrt(number)  # 5 standard errors
    if d == 2:
        assert not found[:, 2].any()


@pytest.mark.parametrize("law", [UNIFORM_PHASE, FLUX_PHASE])
@pytest.mark.parametrize("v", [-5.0, -1.2, -0.5, 0.3])
def test_random_phase(law: int, v: float) -> None:
    """V = cos phi; of all V > v, with equal weight of each phi, or V - v as arrivals have: dP ~ (cos phi - v) dphi."""
    top, number = 1.0, 20000
    row = walled(2, 0, Face(random_phase=RandomPhase(top, "uniform")), seed=3).walls.numbers[0]
    own = np.array([wall_velocity(row, law, 0.0, v, 5, 0, count) for count in range(number)])
    assert (own > v).all()
    limit = math.acos(max(v, -1.0))

    def below(phase: np.ndarray) -> np.ndarray:
        return np.sin(phase) - v * phase if law == FLUX_PHASE else phase

    assert stats.kstest(own, lambda speed: 1 - below(np.arccos(np.clip(speed, -1, 1))) / below(limit)).pvalue > RARE


# -- wells ----------------------------------------------------------------------------------------


@MANY
@given(gn=st.floats(-10, 10), inside=st.booleans(), depth=st.floats(-5, 5), mass=st.floats(0.1, 10))
def test_well_keeps_the_energy(gn: float, inside: bool, depth: float, mass: float) -> None:
    new, held = well_velocity(gn, inside, 2 * depth / mass)
    before = 0.5 * mass * gn**2 - depth * inside
    assert 0.5 * mass * new**2 - depth * held == pytest.approx(before, abs=16 * EPS * (0.5 * mass * gn**2 + abs(depth)))
    # it passes if its energy lets it, and else goes back as it came
    passes = 0.5 * mass * gn**2 + (depth if not inside else -depth) >= 0
    if abs(0.5 * mass * gn**2 - abs(depth)) > 16 * EPS * abs(depth):
        assert (held != inside) == passes
    assert new == -gn if held == inside else math.copysign(1, new) == math.copysign(1, gn)


# -- random numbers -------------------------------------------------------------------------------


def drawn(seed: int, particles: Any, counts: Any, draws: Any) -> np.ndarray:
    grid = np.broadcast_arrays(particles, counts, draws)
    return np.array([random_uniform(seed, *map(int, each)) for each in zip(*(g.ravel() for g in grid), strict=True)])


MANY_NUMBERS = np.arange(20000)


@pytest.mark.parametrize("along", [0, 1, 2])
@pytest.mark.parametrize("seed", [0, 1, 2**63])
def test_random_numbers_are_uniform_and_independent_along_each_argument(along: int, seed: int) -> None:
    u = drawn(np.uint64(seed), *(MANY_NUMBERS if k == along else 3 for k in range(3)))
    assert u.min() > 0
    assert u.max() < 1
    assert stats.kstest(u, "uniform").pvalue > RARE
    assert len(np.unique(u)) == len(u)
    for lag in (1, 2, 7):
        pairs = np.histogram2d(u[:-lag], u[lag:], bins=16, range=[[0, 1]] * 2)[0]
        assert stats.chisquare(pairs.ravel()).pvalue > RARE


def test_neighbouring_seeds_are_independent() -> None:
    one, other = (drawn(np.uint64(seed), MANY_NUMBERS, 0, 0) for seed in (7, 8))
    assert abs(np.corrcoef(one, other)[0, 1]) < 5 / math.sqrt(len(one))


def test_random_numbers_know_no_order() -> None:
    order = np.random.default_rng(1).permutation(1000)
    np.testing.assert_array_equal(
        drawn(np.uint64(5), order, 2, 1)[np.argsort(order)], drawn(np.uint64(5), np.arange(1000), 2, 1)
    )


def test_thermal_velocity_scales_with_the_mass() -> None:
    found = np.array([thermal_velocity(1.0, inverse, 3, 1, 1) for inverse in (1.0, 0.25)])
    np.testing.assert_allclose(found[1], found[0] / 2, rtol=2 * EPS)
