"""Impact rules by conservation laws, cooling by exact quadrature of the collision integrals, floors by simulation."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from crosscheck.references import granular as gr

#: Standard errors allowed to a seeded Monte Carlo mean: fixed by the seed, once in 10^5 by chance otherwise.
SIGMAS = 4.5
both = pytest.mark.parametrize("dimension", [2, 3])


def mean_within(samples: np.ndarray, expected: float) -> None:
    error = samples.std(ddof=1) / samples.size**0.5
    assert abs(samples.mean() - expected) < SIGMAS * error


# -- impact ---------------------------------------------------------------------------------------------

seeds = st.integers(0, 10**6)
coefficients = st.tuples(st.floats(0, 1), st.floats(-1, 1), st.floats(0, 2), st.floats(0, 1))


def random_impact(seed: int, planar: bool, like: bool) -> tuple[gr.Body, gr.Body, np.ndarray, np.random.Generator]:
    rng = np.random.default_rng(seed)
    normal = rng.standard_normal(3)
    if planar:
        normal[2] = 0
    normal /= np.linalg.norm(normal)
    bodies = []
    for _ in range(2):
        v, w = rng.standard_normal((2, 3))
        if planar:
            v[2], w[:2] = 0, 0
        mass, radius = (1.0, 0.5) if like else rng.uniform(0.5, 2, 2)
        bodies.append(gr.Body(mass, radius, v, w, 0.5 if planar else 0.4))
    return bodies[0], bodies[1], normal, rng


def after(body: gr.Body, done: gr.Impact, k: int) -> gr.Body:
    return body._replace(velocity=done.velocities[k], spin=done.spins[k])


@given(seed=seeds, planar=st.booleans(), c=coefficients)
def test_impact_keeps_momentum_and_angular_momentum(
    seed: int, planar: bool, c: tuple[float, float, float, float]
) -> None:
    one, two, normal, rng = random_impact(seed, planar, like=False)
    assume(gr.contact_velocity(one, two, normal) @ normal < 0)
    alpha, alpha_t, static, share = c
    done = gr.impact(one, two, normal, alpha, alpha_t, static, static * share)
    new = [after(one, done, 0), after(two, done, 1)]
    centre = rng.standard_normal(3)
    places = [centre + one.radius * normal, centre - two.radius * normal]

    def momentum(bodies: list[gr.Body]) -> np.ndarray:
        return sum(b.mass * b.velocity for b in bodies)

    def angular(bodies: list[gr.Body]) -> np.ndarray:
        return sum(b.mass * np.cross(x, b.velocity) + b.inertia * b.spin for b, x in zip(bodies, places, strict=True))

    def energy(bodies: list[gr.Body]) -> float:
        return sum(0.5 * b.mass * b.velocity @ b.velocity + 0.5 * b.inertia * b.spin @ b.spin for b in bodies)

    np.testing.assert_allclose(momentum(new), momentum([one, two]), atol=1e-13)
    np.testing.assert_allclose(angular(new), angular([one, two]), atol=1e-12)
    assert energy(new) <= energy([one, two]) * (1 + 1e-13)
    if planar:
        assert new[0].velocity[2] == 0
        assert not new[0].spin[:2].any()
    # the contact: normal restitution always, tangential if it sticks, Coulomb's law on the impulse
    before, then = gr.contact_velocity(one, two, normal), gr.contact_velocity(*new, normal)
    assert then @ normal == pytest.approx(-alpha * (before @ normal), abs=1e-12)
    slip, left = before - (before @ normal) * normal, then - (then @ normal) * normal
    push = done.impulse @ normal
    rub = done.impulse - push * normal
    if done.sliding:
        assert np.linalg.norm(rub) == pytest.approx(static * share * push, abs=1e-14)
        assert rub @ slip <= 1e-14
        # it does not reverse the slip further than sticking would
        assert left @ slip >= min(alpha_t, 1.0) * (slip @ slip) - 1e-12
    else:
        np.testing.assert_allclose(left, alpha_t * slip, atol=1e-12)
        assert np.linalg.norm(rub) <= static * push + 1e-14


@given(seed=seeds, planar=st.booleans(), alpha=st.floats(0, 1), alpha_t=st.floats(-1, 1))
def test_energy_lost_by_like_bodies(seed: int, planar: bool, alpha: float, alpha_t: float) -> None:
    one, two, normal, _ = random_impact(seed, planar, like=True)
    g = gr.contact_velocity(one, two, normal)
    assume(g @ normal < 0)
    done = gr.impact(one, two, normal, alpha, alpha_t)
    energies = [
        sum(0.5 * b.velocity @ b.velocity + 0.5 * b.inertia * b.spin @ b.spin for b in bodies)
        for bodies in ([one, two], [after(one, done, 0), after(two, done, 1)])
    ]
    n = float(g @ normal)
    lost = gr.dissipated_energy(n, float(np.linalg.norm(g - n * normal)), alpha, alpha_t, one.q)
    assert energies[0] - energies[1] == pytest.approx(float(lost), abs=1e-12)


@pytest.mark.parametrize("factor", [0.999, 1.001])
def test_sliding_sets_in_at_the_limit(factor: float) -> None:
    q, alpha, alpha_t, mu = 0.4, 0.9, -0.3, 0.2
    slip = gr.sliding_limit(alpha, alpha_t, mu, q) * factor
    one = gr.Body(1.0, 0.5, np.array([slip, 0.0, -1.0]), np.zeros(3), q)
    two = gr.Body(1.0, 0.5, np.zeros(3), np.zeros(3), q)
    done = gr.impact(one, two, np.array([0.0, 0.0, 1.0]), alpha, alpha_t, mu, mu)
    assert done.sliding == (factor > 1)


def test_smooth_impact_exchanges_normal_components_and_leaves_spins() -> None:
    one, two, normal, _ = random_impact(3, planar=False, like=True)
    if gr.contact_velocity(one, two, normal) @ normal > 0:
        normal = -normal
    done = gr.impact(one, two, normal, 1.0)
    assert done.velocities[0] @ normal == pytest.approx(two.velocity @ normal)
    np.testing.assert_allclose(done.spins[0], one.spin)
    with pytest.raises(ValueError, match="do not approach"):
        gr.impact(after(one, done, 0), after(two, done, 1), normal, 1.0)


def test_moving_wall() -> None:
    """v'_n = (1 + e) V - e v_n; a rough ball that rolls on it takes up spin."""
    wall = gr.Body(math.inf, 0.0, np.array([0.0, 0.0, 0.7]), np.zeros(3))
    ball = gr.Body(2.0, 0.5, np.array([1.0, 0.0, -1.3]), np.zeros(3))
    done = gr.impact(ball, wall, np.array([0.0, 0.0, 1.0]), 0.8, 0.0)
    assert done.velocities[0][2] == pytest.approx(float(gr.rebound(1.3, 0.7, 0.8)))
    np.testing.assert_array_equal(done.velocities[1], wall.velocity)
    np.testing.assert_array_equal(done.spins[1], 0)
    # sticking from no spin: 1/(1 + q) of the speed is kept, as when a ball comes to roll
    assert done.velocities[0][0] == pytest.approx(1 / 1.4)
    assert done.spins[0][1] == pytest.approx(1 / 1.4 / 0.5)


# -- smooth particles -----------------------------------------------------------------------------------


@cache
def collision_moments(alpha: float, dimension: int, nodes: int = 8) -> np.ndarray:
    """Rows: collision rate, -d<v^2>/dt, -d<v^4>/dt over a Maxwellian's rate, columns: order 0 and 1 in a_2; T = m = 1.

    f = M (1 + a_2 S(v^2/2)), S(x) = x^2/2 - (d+2) x/2 + d (d+2)/8. In the frame of the normal everything is a
    polynomial times |u_n| and Gaussians: with Laguerre nodes for u_n^2 the quadrature is exact.
    """
    y, wy = np.polynomial.laguerre.laggauss(nodes)
    h, wh = np.polynomial.hermite_e.hermegauss(nodes)
    wh = wh / wh.sum()
    tangents = dimension - 1
    axes = [(y, wy)] + [(h, wh)] * (1 + 2 * tangents)
    grid = np.meshgrid(*(a for a, _ in axes), indexing="ij", sparse=True)
    weight = 1.0
    for w in np.meshgrid(*(b for _, b in axes), indexing="ij", sparse=True):
        weight = weight * w
    # relative velocity sqrt(2) r, centre of mass c/sqrt(2): both of unit variance in r, c
    un, c, rest = 2 * grid[0] ** 0.5, grid[1] / 2**0.5, grid[2:]
    tangential = sum((r / 2**0.5) ** 2 for r in rest)
    sign = sum(rest[k] * rest[tangents + k] for k in range(tangents))  # 2 u_t.c_t / 2

    def squares(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (c + normal / 2) ** 2 + tangential + sign, (c - normal / 2) ** 2 + tangential - sign

    def sonine(v2: np.ndarray) -> np.ndarray:
        x, d = v2 / 2, dimension
        return x * x / 2 - (d + 2) * x / 2 + d * (d + 2) / 8

    one, two = squares(un)
    new_one, new_two = squares(-alpha * un)
    first = sonine(one) + sonine(two)
    # a particle's own rate is 1: a pair's change counts half for each
    return np.array(
        [
            [(weight * x).sum(), (weight * x * first).sum()]
            for x in (1.0, (one + two - new_one - new_two) / 2, (one**2 + two**2 - new_one**2 - new_two**2) / 2)
        ]
    )


@both
@pytest.mark.parametrize("alpha", [0.95, 0.8, 0.7, 0.5, 0.3])
def test_fourth_cumulant_and_rates_by_quadrature(alpha: float, dimension: int) -> None:
    """Linear in a_2: dln<v^4>/dt = 2 dln<v^2>/dt, with <v^4> = d (d + 2) (1 + a_2)."""
    rate, second, fourth = collision_moments(alpha, dimension)
    d = dimension
    # fourth = 2 second (d + 2) (1 + a_2): order 0 and 1
    a2 = (2 * (d + 2) * second[0] - fourth[0]) / (fourth[1] - 2 * (d + 2) * (second[1] + second[0]))
    assert gr.fourth_cumulant(alpha, d) == pytest.approx(a2, rel=1e-9)
    assert rate[1] / rate[0] == pytest.approx(-1 / 16, rel=1e-9)
    assert second[0] / d == pytest.approx(gr.cooling_rate(alpha, d, 1.0), rel=1e-9)
    assert second[1] / second[0] == pytest.approx(3 / 16, rel=1e-9)


def test_fourth_cumulants_of_the_simulations() -> None:
    """The linear theory is high by at most 0.03, and its sign is right outside the zero near 1/sqrt 2."""
    for (dimension, alpha), simulated in gr.FOURTH_CUMULANTS.items():
        theory = gr.fourth_cumulant(alpha, dimension)
        assert -3 * simulated.uncertainty < theory - simulated.value < 0.03
        if alpha != 0.7:
            assert theory * simulated.value > 0
    assert gr.fourth_cumulant(0.5**0.5, 2) == pytest.approx(0, abs=1e-15)
    assert gr.fourth_cumulant(1.0, 3) == 0
    assert gr.moment_ratio(0.1, 2) == pytest.approx(2.2)


@both
@given(alpha=st.floats(0.1, 0.99), rate=st.floats(0.1, 10))
def test_haff_solves_the_cooling_equation(dimension: int, alpha: float, rate: float) -> None:
    a2 = gr.fourth_cumulant(alpha, dimension)
    zeta = gr.cooling_rate(alpha, dimension, rate, a2)
    done = solve_ivp(
        lambda _, y: [-zeta * y[0] ** 1.5, rate * gr.rate_factor(a2) * y[0] ** 0.5],
        (0, 3 / zeta),
        [1.0, 0.0],
        rtol=1e-10,
        atol=1e-12,
    )
    time, temperature, collisions = done.t[-1], *done.y[:, -1]
    assert gr.haff(time, 1.0, zeta) == pytest.approx(temperature, rel=1e-7)
    assert gr.haff_collisions(time, zeta, rate * gr.rate_factor(a2)) == pytest.approx(collisions, rel=1e-7)
    assert gr.temperature_after(collisions, alpha, dimension, a2) == pytest.approx(temperature, rel=1e-6)


# -- rough particles ------------------------------------------------------------------------------------


@both
@pytest.mark.parametrize(("alpha", "alpha_t", "ratio"), [(0.9, 0.0, 0.6), (0.7, -0.8, 1.7), (0.8, 0.5, 0.1)])
def test_rough_rates_by_monte_carlo(dimension: int, alpha: float, alpha_t: float, ratio: float) -> None:
    """Impacts of Maxwellian particles, flux-weighted, through the impact rule written out for many at once."""
    rng, count, radius = np.random.default_rng(11), 400000, 0.5
    q = 0.5 if dimension == 2 else 0.4
    inertia = q * radius**2
    v, w = rng.standard_normal((2, 2, count, 3))
    w *= (ratio / inertia) ** 0.5
    normal = np.array([1.0, 0.0, 0.0])
    if dimension == 2:
        v[..., 2], w[..., :2] = 0, 0
    # flux-weighted approach: |u_n| = 2 sqrt(T E) with E exponential, the centre of mass as it is
    centre, un = (v[0, :, 0] + v[1, :, 0]) / 2, -2 * rng.exponential(size=count) ** 0.5
    v[0, :, 0], v[1, :, 0] = centre + un / 2, centre - un / 2
    g = v[0] - v[1] - np.cross(radius * (w[0] + w[1]), normal)
    slip = g - g[:, :1] * normal
    impulse = -(1 + alpha) / 2 * g[:, :1] * normal + (alpha_t - 1) / (2 * (1 + 1 / q)) * slip
    turn = -radius / inertia * np.cross(normal, impulse)
    translational = sum(((v[k] + s * impulse) ** 2 - v[k] ** 2).sum(axis=1) for k, s in ((0, 1), (1, -1))) / 2
    rotational = inertia * sum(((w[k] + turn) ** 2 - w[k] ** 2).sum(axis=1) for k in (0, 1)) / 2
    # half the pair's change per own collision: d/2 dT = change/2
    expected = gr.rough_rates(1.0, ratio, alpha, alpha_t, q, dimension)
    mean_within(translational / dimension, expected[0])
    mean_within(rotational / gr.rotational_freedoms(dimension), expected[1])


@both
@given(alpha=st.floats(0.1, 1), alpha_t=st.floats(-1, 0.95), q=st.floats(0.1, 1))
def test_rough_ratio_balances_the_rates(dimension: int, alpha: float, alpha_t: float, q: float) -> None:
    x = gr.rough_ratio(alpha, alpha_t, q, dimension)
    translational, rotational = gr.rough_rates(1.0, x, alpha, alpha_t, q, dimension)
    assert translational == pytest.approx(rotational / x, rel=1e-6, abs=1e-9)
    if dimension == 3:
        beta = -alpha_t
        h = (1 + q) ** 2 / (2 * q * (1 + beta) ** 2) * (1 - alpha**2 - (1 - q) / (1 + q) * (1 - beta**2))
        closed = h + (1 + h * h) ** 0.5 if h > 0 else 1 / ((1 + h * h) ** 0.5 - h)
        assert x == pytest.approx(closed, rel=1e-6)


def test_rough_ratios_of_the_simulations() -> None:
    """The Maxwellian theory is up to 8 % high."""
    for (dimension, q, alpha, alpha_t), simulated in gr.ROUGH_RATIOS.items():
        excess = gr.rough_ratio(alpha, alpha_t, q, dimension) / simulated.value - 1
        assert -2 * simulated.uncertainty / simulated.value < excess < 0.08
    assert gr.rough_ratio(0.9, 0.0, 0.4, 3) == pytest.approx(0.5738, abs=5e-5)
    assert gr.rough_ratio(0.9, -0.5, 0.5, 2) == pytest.approx(0.7904, abs=5e-5)


def test_elastic_rough_particles_share_the_energy() -> None:
    assert gr.rough_ratio(1.0, -1.0, 0.4, 3) == pytest.approx(1)
    assert gr.rough_rates(1.0, 1.0, 1.0, -1.0, 0.4, 3) == pytest.approx((0, 0), abs=1e-15)
    assert gr.rough_rates(1.0, 0.3, 0.9, 1.0, 0.4, 3) == pytest.approx((gr.cooling_rate(0.9, 3, 1.0) * -1, 0))
    with pytest.raises(ValueError, match="smooth"):
        gr.rough_ratio(0.9, 1.0, 0.4, 3)


# -- collapse and the ball ------------------------------------------------------------------------------


def pair(size: int, k: int, r: float) -> np.ndarray:
    """Velocities of a line of particles after particles k and k + 1 collide."""
    matrix = np.eye(size)
    matrix[k : k + 2, k : k + 2] = [[(1 - r) / 2, (1 + r) / 2], [(1 + r) / 2, (1 - r) / 2]]
    return matrix


def collapses(sequence: np.ndarray) -> bool:
    """A sequence of collisions repeats for ever only if all velocities shrink alike: a real eigenvalue in (0, 1)."""
    values = np.linalg.eigvals(sequence)
    return bool(((abs(values.imag) < 1e-9) & (values.real > 0) & (values.real < 1 - 1e-9)).any())


@pytest.mark.parametrize("shift", [-1e-4, 1e-4])
def test_three_particles_collapse_below_the_threshold(shift: float) -> None:
    r = gr.THREE_PARTICLE_COLLAPSE + shift
    assert collapses(pair(3, 0, r) @ pair(3, 1, r)) == (shift < 0)
    assert gr.STABLE_COLLAPSE < gr.THREE_PARTICLE_COLLAPSE


@pytest.mark.parametrize("number", [2, 3, 4, 5])
@pytest.mark.parametrize("shift", [-1e-3, 1e-3])
def test_collapse_on_a_wall_of_the_same_restitution(number: int, shift: float) -> None:
    """Waves of collisions: all pairs of one parity and then of the other, in a line of N particles and their images."""
    r = gr.wall_collapse(number) + shift
    even, odd = np.eye(2 * number), np.eye(2 * number)
    for k in range(0, 2 * number - 1, 2):
        even = even @ pair(2 * number, k, r)
    for k in range(1, 2 * number - 1, 2):
        odd = odd @ pair(2 * number, k, r)
    # the motion that mirrors itself: v_k = -v_(2N-1-k)
    mirror = np.vstack([np.eye(number), -np.eye(number)[::-1]])
    step = (even @ odd @ mirror)[:number]
    assert collapses(step) == (shift < 0)


def test_collapse_limits() -> None:
    assert gr.wall_collapse(1) == 0
    assert gr.wall_collapse(2) == pytest.approx(3 - 8**0.5)
    assert gr.wall_collapse(3) == pytest.approx(1 / 3)
    # N (1 - alpha) -> pi
    assert 1e5 * (1 - gr.wall_collapse(10**5)) == pytest.approx(math.pi, rel=1e-4)


@given(alpha=st.floats(0.05, 0.95), height=st.floats(0.1, 10), gravity=st.floats(0.1, 10))
def test_bouncing_ball_is_the_sum_of_its_bounces(alpha: float, height: float, gravity: float) -> None:
    ball = gr.BouncingBall(height, alpha, gravity)
    speed, time, path = (2 * gravity * height) ** 0.5, (2 * height / gravity) ** 0.5, height
    for bounce in range(1, 800):
        assert ball.impact_time(bounce) == pytest.approx(time, rel=1e-11)
        speed *= alpha
        assert ball.apex(bounce) == pytest.approx(speed**2 / (2 * gravity), rel=1e-11)
        time, path = time + 2 * speed / gravity, path + speed**2 / gravity
        if speed < 1e-18:
            break
    assert ball.rest == pytest.approx(time, rel=1e-11)
    assert ball.path == pytest.approx(path, rel=1e-11)


def test_bouncing_ball_at_a_known_point() -> None:
    assert gr.BouncingBall(1.0, 0.8, 9.81).rest == pytest.approx(4.063713, abs=5e-7)


# -- floors ---------------------------------------------------------------------------------------------


@given(u=st.floats(0.05, 4), e=st.floats(0, 1))
def test_floor_laws_by_quadrature(u: float, e: float) -> None:
    """Over the phase: V = V0 cos, so that the density's poles are gone."""
    v0 = 1.3

    def mean(law: str, what: str) -> float:
        # p(V) dV = p(V) pi sqrt(V0^2 - V^2) dphase/pi; uniform: 1
        def integrand(phase: float) -> float:
            plate = v0 * math.cos(phase)
            weight = 1.0 if law == "uniform" else max(u + plate, 0) / gr.flux_mean_approach(u, v0)
            gain = 0.5 * (float(gr.rebound(u, plate, e)) ** 2 - u * u)
            return weight * {"one": 1.0, "gain": gain, "plate": plate}[what]

        edge = [math.acos(-u / v0)] if u < v0 else None
        return quad(integrand, 0, math.pi, points=edge, epsabs=1e-12, epsrel=1e-10)[0] / math.pi

    assert mean("flux", "one") == pytest.approx(1, rel=1e-9)
    assert mean("uniform", "gain") == pytest.approx(gr.uniform_phase_gain(u, v0, e), abs=1e-9)
    assert mean("flux", "gain") == pytest.approx(gr.flux_phase_gain(u, v0, e), abs=1e-9)
    if u >= v0:
        assert mean("flux", "plate") == pytest.approx(v0**2 / (2 * u), rel=1e-9)


@given(u=st.floats(0.05, 4), plate=st.floats(-1.2, 1.2))
def test_floor_densities(u: float, plate: float) -> None:
    v0 = 1.3
    uniform = 1 / (math.pi * (v0**2 - plate**2) ** 0.5)
    assert gr.uniform_phase_density(plate, v0) == pytest.approx(uniform, rel=1e-12)
    expected = uniform * max(u + plate, 0) / gr.flux_mean_approach(u, v0)
    assert gr.flux_phase_density(plate, u, v0) == pytest.approx(expected, rel=1e-12)
    assert gr.uniform_phase_density(1.4, v0) == 0


def test_elastic_gains() -> None:
    assert gr.uniform_phase_gain(0.3, 1.3) == pytest.approx(1.3**2)
    assert gr.flux_phase_gain(1.5, 1.3) == pytest.approx(2 * 1.3**2)
    assert gr.flux_phase_gain(1.3 - 1e-9, 1.3) == pytest.approx(gr.flux_phase_gain(1.3, 1.3), rel=1e-6)
    assert gr.sawtooth_gain(0.5, 1.3) == pytest.approx(2 * 1.3 * 1.8)


@given(
    height=st.floats(1.0, 5.0),
    velocity=st.floats(-5, 5),
    time=st.floats(0, 10),
    omega=st.floats(0.3, 8),
    gravity=st.floats(0.5, 3),
)
def test_plate_impact_is_the_first_crossing(
    height: float, velocity: float, time: float, omega: float, gravity: float
) -> None:
    found = gr.plate_impact_time(height, velocity, time, 0.9, omega, gravity)
    s = np.linspace(0, found - time, 4000)

    def gap(x: np.ndarray) -> np.ndarray:
        return height + velocity * x - gravity * x * x / 2 - 0.9 * np.cos(omega * (time + x))

    scale = height + abs(velocity) * s[-1] + gravity * s[-1] ** 2
    steepness = abs(velocity) + gravity * s[-1] + 0.9 * omega
    rounding = 8 * np.finfo(float).eps * (scale + steepness * (found + 1))
    assert gap(s)[:-1].min() > -rounding
    assert abs(gap(s)[-1]) < rounding


def test_plate_impact_finds_a_graze_and_the_hit_beside_it() -> None:
    """A straight path that touches the crest, raised and lowered by 1e-10."""
    # z = h - u s touches z = cos t where sin t = u: h = cos t + u t
    u = 0.4
    crest = math.asin(u)
    height, start = math.cos(crest) + u * crest, -3.0
    above, below = (gr.plate_impact_time(height + shift - u * start, -u, start, 1.0, 1.0) for shift in (1e-10, -1e-10))
    assert below == pytest.approx(crest, abs=2e-5)
    assert above > 2


def test_plate_impact_after_leaving() -> None:
    """A particle that leaves the plate finds its next impact, not the one it comes from."""
    start = 0.3
    nxt = gr.plate_impact_time(math.cos(start), 2.0, start, 1.0, 1.0, gravity=1.0)
    assert nxt > start + 1
    assert gr.plate_impact_time(math.cos(start), 2.0, start, 1.0, 1.0, horizon=50.0) == math.inf
    for height, velocity in ((0.5, 1.0), (1.0, -1.0)):
        with pytest.raises(ValueError, match="must start above the plate"):
            gr.plate_impact_time(height, velocity, 0.0, 1.0, 1.0, gravity=1.0)


@pytest.mark.parametrize("u", [1.0, 1.5, 3.5])
def test_first_impacts_follow_the_flux_law(u: float) -> None:
    """u >= V0: <V> = V0^2/2u, the cumulative distribution, and for fast particles one impact a visit."""
    phases = 2 * np.pi * (np.arange(800) + 0.5) / 800
    visits = [gr.plate_visit(u, phase) for phase in phases]
    plates = np.sort([visit.plate for visit in visits])
    # equally spaced phases of a smooth function of the phase; at u = V0 it has a square-root kink
    assert plates.mean() == pytest.approx(1 / (2 * u), abs=1e-12 if u > 1 else 1e-4)
    cumulative = 0.5 + (np.arcsin(plates) - (1 - plates**2) ** 0.5 / u) / np.pi
    np.testing.assert_allclose(cumulative, (np.arange(800) + 0.5) / 800, atol=2 / 800)
    if u > 3:
        assert max(visit.impacts for visit in visits) == 1
        gain = gr.visit_gain(u, phases=400)
        assert gain.value == pytest.approx(gr.flux_phase_gain(u, 1.0), abs=1e-9)


def test_visits_gain_more_than_single_impacts() -> None:
    for u, expected in ((0.25, 1.667), (0.5, 2.060), (1.5, 2.140)):
        gain = gr.visit_gain(u, phases=800)
        assert abs(gain.value - expected) < gain.uncertainty
        assert gain.value > gr.flux_phase_gain(u, 1.0) + 0.05
        assert gain.value > gr.uniform_phase_gain(u, 1.0) + 0.5


def test_a_particle_may_settle_on_the_plate() -> None:
    """Without rebound it leaves when the plate slows down, and is back at once."""
    with pytest.raises(RuntimeError, match="50 impacts in one visit"):
        gr.plate_visit(0.5, 1.0, restitution=0.0, most=50)
