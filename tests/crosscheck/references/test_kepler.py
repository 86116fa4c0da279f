"""The Kepler orbit against Newton's law, its own invariants, quadrature, and an independent integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from crosscheck.references import kepler, oscillator
from crosscheck.scene import Gravity, Kepler, Scene

EPS = kepler.EPSILON
ECCENTRICITIES = (0.0, 1e-9, 0.3, 0.5, 0.9, 0.99, 0.9999, 1 - 1e-9)
MU, AXIS = 1.7, 1.3


def test_minus_sine_against_long_double() -> None:
    x = np.concatenate([np.linspace(-np.pi, np.pi, 1001), np.logspace(-8, 0, 50)])
    long = x.astype(np.longdouble)
    # the series in long double where the difference cancels
    terms = sum(
        (-1) ** k * long ** (2 * k + 3) / np.prod(np.arange(1, 2 * k + 4, dtype=np.longdouble)) for k in range(20)
    )
    assert abs(kepler.minus_sine(x) - terms.astype(float)) == pytest.approx(0.0, abs=4 * EPS)
    assert (abs(kepler.minus_sine(x) - terms) <= 6 * EPS * abs(terms)).all()


@pytest.mark.parametrize("e", ECCENTRICITIES)
def test_keplers_equation_is_solved_to_round_off(e: float) -> None:
    m = np.concatenate([np.linspace(-3.14, 3.14, 2001), np.logspace(-12, 0, 100)])
    x = kepler.eccentric_anomaly(m, e).astype(np.longdouble)
    # the equation in long double, with the same split that avoids the cancellation
    cubes = sum((-1) ** k * x ** (2 * k + 3) / np.prod(np.arange(1, 2 * k + 4, dtype=np.longdouble)) for k in range(20))
    defect = (1 - np.longdouble(e)) * x + np.longdouble(e) * cubes - m
    # the mean anomaly is reduced to (-pi, pi]: an error of eps pi there
    assert (abs(defect) <= 4 * EPS * np.pi).all()
    assert (np.diff(kepler.eccentric_anomaly(np.linspace(-3.1, 3.1, 500), e)) > 0).all()


@pytest.mark.parametrize("e", [0.0, 0.5, 0.9, 0.99])
def test_the_orbit_keeps_energy_momentum_and_apsides(e: float) -> None:
    period = 2 * np.pi * np.sqrt(AXIS**3 / MU)
    t = np.linspace(0, 2 * period, 401)
    r, v = kepler.relative_orbit(t, e, AXIS, MU)
    # energies cancel at pericentre, where both parts are 2/(1 - e) times the total
    assert kepler.energy(r, v, MU) == pytest.approx(-MU / (2 * AXIS), rel=20 * EPS * 2 / (1 - e))
    assert kepler.angular_momentum(r, v) == pytest.approx(np.sqrt(MU * AXIS * (1 - e**2)), rel=20 * EPS)
    assert kepler.eccentricity_vector(r, v, MU) == pytest.approx(np.array([-e, 0]) + 0 * r, abs=20 * EPS / (1 - e))


@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
def test_the_orbit_obeys_newton(e: float) -> None:
    t, h = np.linspace(0.1, 7.0, 50), 1e-5 * (1 - e) ** 1.5
    r, v = kepler.relative_orbit(t, e)
    (r_after, v_after), (r_before, v_before) = (kepler.relative_orbit(t + s * h, e) for s in (1, -1))
    fast = kepler.fastest(e)
    assert (r_after - r_before) / (2 * h) == pytest.approx(v, abs=1e-8 * fast)
    attraction = -r / np.linalg.norm(r, axis=-1)[:, None] ** 3
    assert (v_after - v_before) / (2 * h) == pytest.approx(attraction, abs=1e-8 * fast**2)


def test_the_orbit_against_an_integrator() -> None:
    e = 0.9
    r0, v0 = kepler.relative_orbit(0.0, e, AXIS, MU)

    def right_side(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], -MU * y[:2] / np.linalg.norm(y[:2]) ** 3])

    t = np.linspace(0, 9.0, 30)
    run = solve_ivp(right_side, (0, 9.0), np.concatenate([r0, v0]), "DOP853", t, rtol=1e-12, atol=1e-12)
    assert kepler.relative_orbit(t, e, AXIS, MU)[0] == pytest.approx(run.y[:2].T, abs=1e-8)


def test_it_starts_where_the_scene_does() -> None:
    masses, e = (3.0, 1.0), 0.6
    scene = Scene(
        name="orbit",
        dimension=2,
        duration=1.0,
        masses=masses,
        gravity=Gravity(G=0.5),
        initial=Kepler(kind="kepler", semi_major_axis=AXIS, eccentricity=e),
    )
    state = scene.initial_state()
    r, v = kepler.two_bodies(0.0, masses, e, AXIS, 0.5)
    assert r == pytest.approx(state.positions, rel=4 * EPS, abs=4 * EPS)
    assert v == pytest.approx(state.velocities, rel=4 * EPS, abs=4 * EPS)
    later, moving = kepler.two_bodies(np.array([0.3, 4.0]), masses, e, AXIS, 0.5)
    assert np.einsum("i,tid->td", masses, later) == pytest.approx(0.0, abs=10 * EPS)
    assert np.einsum("i,tid->td", masses, moving) == pytest.approx(0.0, abs=10 * EPS)


def _average(function: kepler.Modified, e: float) -> float:
    """Over the time of one orbit, a = mu = 1."""

    def integrand(anomaly: float) -> float:
        r, v = kepler.relative_orbit(anomaly + e * np.sin(anomaly), e)
        return float(function(r, v, 1.0)) * (1 + e * np.cos(anomaly)) / (2 * np.pi)

    return float(quad(integrand, 0, 2 * np.pi, epsabs=1e-12, epsrel=1e-12)[0])


@pytest.mark.parametrize("modified", [kepler.kick_drift_kick, kepler.drift_kick_drift])
def test_precession_from_the_averaged_hamiltonian(modified: kepler.Modified) -> None:
    e, h = 0.6, 1e-4
    assert _average(modified, e) == pytest.approx((2 + e**2) / 48 * (1 - e**2) ** -2.5, rel=1e-10)
    slope = (_average(modified, e + h) - _average(modified, e - h)) / (2 * h)
    lagrange = -np.sqrt(1 - e**2) / e * slope
    assert kepler.precession(e, 1.0) == pytest.approx(lagrange, rel=1e-6)
    assert _average(kepler.kick_drift, e) == pytest.approx(0.0, abs=1e-10)  # no precession of first order


def test_velocity_verlet_keeps_the_modified_energy() -> None:
    """One step of the map written out here: the error of H + h^2 H_2 falls 8 times faster a step than that of H."""
    r, v = kepler.relative_orbit(2.5, 0.5)
    changes = []
    for h in (0.02, 0.01):
        half = v - 0.5 * h * r / np.linalg.norm(r) ** 3
        r_new = r + h * half
        v_new = half - 0.5 * h * r_new / np.linalg.norm(r_new) ** 3
        modified = [kepler.energy(*s, 1.0) + h**2 * kepler.kick_drift_kick(*s, 1.0) for s in ((r, v), (r_new, v_new))]
        changes.append(abs(float(modified[1] - modified[0])))
    assert np.log2(changes[0] / changes[1]) == pytest.approx(5.0, abs=0.3)


def test_errors_are_carried_as_an_integrator_carries_them() -> None:
    e, start, end = 0.5, 1.3, 2 * np.pi

    def propagate(state: np.ndarray) -> np.ndarray:
        def right_side(t: float, y: np.ndarray) -> np.ndarray:
            return np.concatenate([y[2:], -y[:2] / np.linalg.norm(y[:2]) ** 3])

        return solve_ivp(right_side, (start, end), state, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]

    state = np.concatenate(kepler.relative_orbit(start, e))
    numeric = np.empty((4, 4))
    for k in range(4):
        step = np.zeros(4)
        step[k] = 1e-5
        numeric[:, k] = (propagate(state + step) - propagate(state - step)) / 2e-5
    first, last = kepler._element_derivatives(np.array([start, end]), e)
    assert last @ np.linalg.inv(first) == pytest.approx(numeric, abs=1e-5)


def test_rounding_grows_as_brouwer_says() -> None:
    one, long = kepler.rounding_error(0.5, 1, 1000), kepler.rounding_error(0.5, 100, 100_000)
    assert 700 < long / one < 1300  # periods^(3/2)
    assert kepler.rounding_error(0.5, 1, 4000) == pytest.approx(2 * one)


# -- Gear's start ------------------------------------------------------------------------------------------------------


def test_the_zero_start_is_an_orbit_from_apocentre_that_starts_too_fast() -> None:
    e, dt = 0.5, 1e-2
    t = np.linspace(0.0, 12.0, 40)
    r, v = kepler.zero_start_orbit(t, e, AXIS, MU, dt)
    r0, v0 = kepler.relative_orbit(0.0, e, AXIS, MU)
    # d^3r/dt^3 by differences of the acceleration along the closed form
    h = 1e-4
    after, before = (kepler.relative_orbit(s * h, e, AXIS, MU)[0] for s in (1, -1))
    third = (-MU * after / np.linalg.norm(after) ** 3 + MU * before / np.linalg.norm(before) ** 3) / (2 * h)
    assert r[0] == pytest.approx(r0, abs=4 * EPS)
    assert v[0] - v0 == pytest.approx(-(dt**2) / 12 * third, abs=1e-6 * dt**2)
    assert kepler.energy(r, v, MU) == pytest.approx(float(kepler.energy(r[0], v[0], MU)), rel=1e-13)

    def right_side(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], -MU * y[:2] / np.linalg.norm(y[:2]) ** 3])

    run = solve_ivp(right_side, (0, 12.0), np.concatenate([r[0], v[0]]), "DOP853", t, rtol=1e-12, atol=1e-12)
    assert r == pytest.approx(run.y[:2].T, abs=1e-9)


@pytest.mark.parametrize("scheme", ["gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity"])
def test_a_missing_third_derivative_leaves_the_velocity_off_for_ever(scheme: str) -> None:
    """Nordsieck's step for a force that does not depend on r: an error -R_3 ends as -R_3/2 in R_1, R_4 as nothing."""
    _, advance, _ = oscillator.matrices(scheme, 0.0, 0.0)
    step = advance.astype(float)
    for missing, left in ((3, -0.5), (4, 0.0)):
        if missing < len(step):
            error = np.zeros(len(step))
            error[missing] = -1.0
            assert (np.linalg.matrix_power(step, 200) @ error)[1] == pytest.approx(left, abs=1e-12)


# -- rounding ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
def test_rounding_of_energy_and_angular_momentum_by_trial(e: float) -> None:
    """Random roundings of r and v at every step of a period, to first order: below the bounds, and of their size."""
    steps, trials = 2000, 400
    r, v = kepler.relative_orbit(np.arange(steps) * 2 * np.pi / steps, e)
    rng = np.random.default_rng(3)
    shift_r, shift_v = EPS * rng.uniform(-0.5, 0.5, size=(2, trials, steps, 2)) * np.array([r, v])[:, None]
    slope = r / np.linalg.norm(r, axis=-1)[:, None] ** 3
    energy = ((shift_r * slope).sum(-1) + (shift_v * v).sum(-1)).sum(1) * 2
    momentum = (kepler.angular_momentum(shift_r, v) + kepler.angular_momentum(r, shift_v)).sum(1) / np.sqrt(1 - e**2)
    assert 0.05 < energy.std() / kepler.energy_rounding(e, 1, steps) < 1
    assert 0.2 < momentum.std() / kepler.momentum_rounding(e, 1, steps) < 1
    assert kepler.energy_rounding(e, 4, steps) == pytest.approx(2 * kepler.energy_rounding(e, 1, steps))
    assert kepler.momentum_rounding(e, 4, steps) == pytest.approx(2 * kepler.momentum_rounding(e, 1, steps))


@pytest.mark.parametrize("shadow", [kepler.KICK_DRIFT_KICK, kepler.DRIFT_KICK_DRIFT, kepler.KICK_DRIFT])
def test_a_shadow_is_kept_to_the_order_that_it_claims(shadow: kepler.Shadow) -> None:
    """One period of the map written out here: the departure of H + h^power correction falls as h^(power + gain)."""

    def kick(r: np.ndarray, h: float) -> np.ndarray:
        return np.asarray(-h * r / np.linalg.norm(r) ** 3)

    departures = []
    for steps in (800, 1600):
        h = 2 * np.pi / steps
        r, v = (np.array(part) for part in kepler.relative_orbit(0.0, 0.3))
        modified = []
        for _ in range(steps + 1):
            modified.append(float(kepler.energy(r, v, 1.0) + h**shadow.power * shadow.correction(r, v, 1.0)))
            if shadow is kepler.DRIFT_KICK_DRIFT:
                r = r + 0.5 * h * v
                v = v + kick(r, h)
                r = r + 0.5 * h * v
            elif shadow is kepler.KICK_DRIFT:
                v = v + kick(r, h)
                r = r + h * v
            else:
                half = v + kick(r, 0.5 * h)
                r = r + h * half
                v = half + kick(r, 0.5 * h)
        departures.append(np.ptp(modified))
    assert np.log2(departures[0] / departures[1]) == pytest.approx(shadow.power + shadow.gain, abs=0.1)


def test_relative_is_the_difference_of_the_two_bodies() -> None:
    for a, state in zip(
        kepler.relative_orbit(0.7, 0.3, 2.0, 1.5 * 4.0),
        kepler.two_bodies(0.7, [1.0, 3.0], 0.3, 2.0, 1.5),
        strict=True,
    ):
        assert kepler.relative(state) == pytest.approx(a, rel=1e-12)
