"""Closed forms of soft impacts by quadrature and by solving the equations of motion; friction by explicit stepping."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from crosscheck.references import EPSILON, granular
from crosscheck.references import soft_impact as si

#: Relative tolerance asked of solve_ivp; errors of its steps, about a hundred, may add up.
RTOL = 1e-12
SOLVED = 100 * RTOL
#: quad's own bound on its relative error.
QUADRATURE = 1e-10
#: Closed forms against each other: a few dozen operations.
ROUNDING = 100 * EPSILON

restitutions = st.floats(0.01, 1)
laws = st.sampled_from(["history", "dashpot"])
scaled = st.floats(0, 8)


@st.composite
def contacts(draw: st.DrawFn) -> si.SoftContact:
    friction = draw(laws)
    low = -1.0 if friction == "history" else 0.01
    alpha_t = draw(st.floats(low, 0.99))
    return si.SoftContact(draw(restitutions), alpha_t, draw(st.floats(0.05, 2)), draw(st.floats(0.1, 1)), friction)


# -- normal impact ------------------------------------------------------------------------------------------------


@given(alpha=st.floats(0, 1), law=st.sampled_from(["hooke", "hertz"]))
def test_damping_and_restitution_are_inverse(alpha: float, law: Literal["hooke", "hertz"]) -> None:
    c = si.damping(alpha, law)
    log = -math.log(alpha) if alpha > 0 else math.inf
    if alpha > 0:
        assert c == pytest.approx({"hooke": 2, "hertz": 5**0.5}[law] * log / math.hypot(math.pi, log), rel=ROUNDING)
    # d ln alpha = -pi d zeta/(1 - zeta^2)^(3/2), and zeta is rounded; sqrt(1 - zeta^2) = pi/hypot(pi, ln alpha)
    spread = EPSILON * (1 + math.pi * (math.hypot(math.pi, log) / math.pi) ** 3)
    assert si.restitution(c, law) == pytest.approx(alpha, rel=min(1.0, 4 * spread), abs=1e-300)


def test_limits_of_restitution() -> None:
    assert si.damping(1.0) == pytest.approx(0, abs=EPSILON)
    assert (si.damping(0.0), si.restitution(2.0), si.restitution(0.0)) == (2.0, 0.0, 1.0)
    # small zeta = cot chi = epsilon: alpha^(chi/pi) = 1 - pi epsilon/2
    gentle = si.HookeImpact(1.0, 1.0, 1.0, math.exp(-math.pi * 1e-6))
    assert gentle.largest_overlap == pytest.approx(1 - math.pi / 2 * 1e-6, abs=10e-12)
    # alpha -> 0: chi = pi/|ln alpha|, and chi cot chi = 1 - chi^2/3 to the next even order
    hard = si.HookeImpact(1.0, 1.0, 1.0, 1e-300)
    chi = math.atan(math.pi / -math.log(1e-300))
    assert hard.largest_overlap == pytest.approx(math.exp(-1 + chi**2 / 3), abs=chi**4)
    assert hard.time_of_largest_overlap == pytest.approx(1 + chi**2 / 6, abs=chi**4)


@pytest.mark.parametrize("alpha", [1.0, 0.9, 0.3, 0.05])
def test_hooke_solves_its_equation_of_motion(alpha: float) -> None:
    mass, stiffness, speed = 0.7, 3.0, 1.3
    impact = si.HookeImpact(mass, stiffness, speed, alpha)
    eta = si.damping(alpha) * math.sqrt(mass * stiffness)

    def rates(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -(stiffness * state[0] + eta * state[1]) / mass]

    def apart(_: float, state: np.ndarray) -> float:
        return state[0]

    def turning(_: float, state: np.ndarray) -> float:
        return state[1]

    def attraction(_: float, state: np.ndarray) -> float:
        return stiffness * state[0] + eta * state[1]

    apart.direction = turning.direction = attraction.direction = -1  # type: ignore[attr-defined]
    times = np.linspace(0, impact.contact_time, 40)
    done = solve_ivp(
        rates,
        (0, 1.01 * impact.contact_time),
        [0, speed],
        "DOP853",
        dense_output=True,
        events=(apart, turning, attraction),
        rtol=RTOL,
        atol=RTOL,
        # so that the interpolant, of order 7, is as good as the steps
        max_step=impact.contact_time / 100,
    )
    delta, velocity = done.sol(times)
    np.testing.assert_allclose(impact.overlap(times), delta, atol=SOLVED)
    np.testing.assert_allclose(impact.velocity(times), velocity, atol=SOLVED)
    np.testing.assert_allclose(impact.force(times), stiffness * delta + eta * velocity, atol=10 * SOLVED)
    assert done.t_events[0][-1] == pytest.approx(impact.contact_time, rel=SOLVED)
    assert done.y_events[0][-1][1] == pytest.approx(-alpha * speed, abs=SOLVED)
    assert done.t_events[1][0] == pytest.approx(impact.time_of_largest_overlap, rel=SOLVED)
    assert done.y_events[1][0][0] == pytest.approx(impact.largest_overlap, rel=SOLVED)
    assert done.t_events[2][0] == pytest.approx(impact.time_of_attraction, rel=SOLVED)
    assert impact.force(0.0) == pytest.approx(impact.first_force, abs=ROUNDING)
    assert impact.force(impact.contact_time) == pytest.approx(impact.last_force, abs=ROUNDING * impact.contact_time)
    assert not impact.force([-0.1, 1.1 * impact.contact_time]).any()
    assert not impact.overlap([-0.1, 1.1 * impact.contact_time]).any()


@given(alpha=st.floats(0.01, 0.999))
def test_largest_overlap_in_its_other_form(alpha: float) -> None:
    zeta = si.damping(alpha) / 2
    root = math.sqrt(1 - zeta**2)
    expected = 1.3 / math.sqrt(3 / 0.7) * math.exp(-zeta / root * math.atan(root / zeta))
    assert si.HookeImpact(0.7, 3.0, 1.3, alpha).largest_overlap == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize("alpha", [1.0, 0.9, 0.3])
def test_impulse_and_energy_of_hooke(alpha: float) -> None:
    mass, stiffness, speed = 0.7, 3.0, 1.3
    impact = si.HookeImpact(mass, stiffness, speed, alpha)
    turn, end = min(impact.time_of_attraction, impact.contact_time), impact.contact_time
    push, pull = (quad(impact.force, *span, epsrel=QUADRATURE)[0] for span in ((0, turn), (turn, end)))
    assert push + pull == pytest.approx((1 + alpha) * mass * speed, rel=QUADRATURE)
    assert push - pull == pytest.approx(si.force_impulse(alpha) * mass * speed, rel=QUADRATURE)
    assert pull <= 0
    eta = si.damping(alpha) * math.sqrt(mass * stiffness)
    lost = quad(lambda t: eta * float(impact.velocity(t)) ** 2, 0, end, epsrel=QUADRATURE)[0]
    assert lost == pytest.approx((1 - alpha**2) * mass * speed**2 / 2, rel=QUADRATURE, abs=QUADRATURE)


def hertz_motion(impact: si.HertzImpact, rtol: float) -> np.ndarray:
    """Contact time, restitution, largest overlap and integral of |F_n|/(m v), by solving the equation of motion."""
    root = math.sqrt(impact.stiffness * impact.mass)
    eta = si.damping(impact.alpha, "hertz") * root

    def force(state: np.ndarray) -> float:
        delta = max(state[0], 0.0)
        spring = impact.stiffness * math.sqrt(impact.radius) * delta**1.5
        return spring + eta * (impact.radius * delta) ** 0.25 * state[1]

    def rates(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -force(state) / impact.mass, abs(force(state))]

    def apart(_: float, state: np.ndarray) -> float:
        return state[0]

    def turning(_: float, state: np.ndarray) -> float:
        return state[1]

    apart.terminal, apart.direction = True, -1  # type: ignore[attr-defined]
    done = solve_ivp(
        rates, (0, 100.0), [0, impact.speed, 0], "DOP853", events=(apart, turning), rtol=rtol, atol=rtol * 1e-3
    )
    (time,), ((_, after, push),) = done.t_events[0], done.y_events[0]
    momentum = impact.mass * impact.speed
    return np.array([time, -after / impact.speed, done.y_events[1][0][0], push / momentum])


@pytest.mark.parametrize("alpha", [1.0, 0.9, 0.3])
def test_hertz_solves_its_equation_of_motion(alpha: float) -> None:
    impact = si.HertzImpact(0.7, 3.0, 0.4, 1.3, alpha)
    closed = np.array([impact.contact_time, alpha, impact.largest_overlap, si.force_impulse(alpha)])
    # the force begins as delta^(1/4) and spoils the solver's order: take the error of the looser run from the tighter
    loose, tight = hertz_motion(impact, 1e-7), hertz_motion(impact, 1e-12)
    assert (abs(tight - loose) < 1e-4).all()
    assert (abs(tight - closed) <= np.maximum(abs(tight - loose), SOLVED)).all()


def test_hertz_without_damping() -> None:
    impact = si.HertzImpact(0.7, 3.0, 0.4, 1.3)
    top = impact.largest_overlap
    stored = quad(lambda d: 3.0 * math.sqrt(0.4) * d**1.5, 0, top, epsrel=QUADRATURE)[0]
    assert stored == pytest.approx(0.7 * 1.3**2 / 2, rel=QUADRATURE)
    # t_c = 2 integral d delta/(v sqrt(1 - (delta/delta_max)^(5/2))), with 1 - s^2 for delta/delta_max
    half = quad(lambda s: 2 * s / math.sqrt(-math.expm1(2.5 * math.log1p(-s * s))), 0, 1, epsrel=QUADRATURE)[0]
    assert pytest.approx(2 * half, rel=QUADRATURE) == si.HERTZ_TIME
    assert pytest.approx(2.94, abs=0.005) == si.HERTZ_TIME
    assert impact.contact_time == pytest.approx(si.HERTZ_TIME * top / 1.3, rel=ROUNDING)
    faster = impact._replace(speed=2.6)
    assert faster.contact_time / impact.contact_time == pytest.approx(2**-0.2, rel=ROUNDING)


# -- the time step ------------------------------------------------------------------------------------------------


def verlet(c: float, h: float) -> np.ndarray:
    """The matrix of a step on (x, v, a), omega_0 = 1."""

    def step(x: float, v: float, a: float) -> tuple[float, float, float]:
        half = v + a * h / 2
        x = x + h * half
        a = -x - c * half
        return x, half + a * h / 2, a

    return np.array([step(*unit) for unit in np.eye(3)]).T


@given(c=st.floats(0, 1.99))
def test_verlet_is_stable_up_to_the_limit(c: float) -> None:
    limit = si.stability_limit(c)
    assert limit**2 + 2 * c * limit == pytest.approx(4, rel=ROUNDING)
    below, above = (abs(np.linalg.eigvals(verlet(c, f * limit))).max() for f in (0.999, 1.001))
    assert below <= 1 + 1e3 * EPSILON
    assert above > 1.001
    duration = si.HookeImpact(1.0, 1.0, 1.0, si.restitution(c)).contact_time
    # the restitution of c, and c of it, are rounded: see the test of their inverse
    assert si.stable_resolution(c) == pytest.approx(limit / duration, rel=ROUNDING / (1 - c / 2))


def test_limit_of_an_undamped_contact() -> None:
    assert si.stability_limit(0.0) == 2
    assert si.stable_resolution(0.0) == pytest.approx(2 / math.pi)


# -- friction -----------------------------------------------------------------------------------------------------


def stepped(theta: np.ndarray, contact: si.SoftContact, steps: int) -> np.ndarray:
    """u'/v by explicit steps of the laws with their dimensions, as codes take them.

    Order 2, because the turn of F_n, where the stretch is 0, is put between two steps; a code that does not knows it to
    a step only, and has order 1.
    """
    mass, stiffness, speed = 2.0, 5.0, 1.3
    normal = si.HookeImpact(mass, stiffness, speed, contact.alpha)
    share, log = contact.q / (1 + contact.q), math.log(contact.alpha)
    k_t = stiffness * share * math.acos(contact.alpha_t) ** 2 / (math.pi**2 + log**2)
    turn = min(normal.time_of_attraction, normal.contact_time)
    u, stretch = theta * speed, np.zeros_like(theta)
    for start, end in ((0.0, turn), (turn, normal.contact_time)):
        dt = (end - start) / steps
        for force in normal.force(start + dt * (np.arange(steps) + 0.5)):
            limit = contact.mu * abs(force)
            if contact.friction == "history":
                stretch = np.clip(stretch + u * dt / 2, -limit / k_t, limit / k_t)
                u = u - dt * k_t * stretch / (mass * share)
                stretch = stretch + u * dt / 2
            else:
                rate = -math.log(contact.alpha_t) / normal.contact_time * dt
                stuck = u * (1 - rate / 2) / (1 + rate / 2)
                u = np.where(u - stuck <= limit * dt / (mass * share), stuck, u - limit * dt / (mass * share))
        stretch = np.zeros_like(theta)
    return u / speed


@pytest.mark.parametrize(
    "contact",
    [
        si.SoftContact(0.9, -0.5, 0.3),
        si.SoftContact(1.0, 0.3, 0.4, 0.5),
        si.SoftContact(0.6, 0.2, 0.5),
        si.SoftContact(0.1, -0.9, 0.7, 0.8),
        si.SoftContact(0.9, 0.5, 0.3, 0.4, "dashpot"),
        si.SoftContact(0.6, 0.2, 0.5, 0.4, "dashpot"),
        si.SoftContact(1.0, 0.1, 0.3, 0.4, "dashpot"),
        si.SoftContact(0.2, 0.2, 0.5, 0.5, "dashpot"),
    ],
)
def test_explicit_steps_converge_to_the_outcome(contact: si.SoftContact) -> None:
    theta = np.linspace(0.02, 8, 60)
    outcome = si.soft_impact(theta, contact)
    coarse, fine = (abs(stepped(theta, contact, n) - outcome.slip).max() for n in (250, 1000))
    # order 2: a 16th; order 1: a quarter
    assert fine < coarse / 8
    assert fine < (math.pi / 1000) ** 2


def test_no_limit_and_no_friction() -> None:
    theta = np.array([[-2.0, 0.0, 0.3], [1.0, 5.0, 40.0]])
    for friction in ("history", "dashpot"):
        free = si.SoftContact(0.8, 0.3, math.inf, 0.4, friction)
        np.testing.assert_allclose(si.soft_impact(theta, free).slip, 0.3 * theta, rtol=ROUNDING)
        np.testing.assert_allclose(si.hard_impact(theta, free).slip, 0.3 * theta, rtol=ROUNDING)
        assert si.sliding_onset(free) == si.gross_sliding(free) == math.inf
        assert si.weak_slip_restitution(free) == 0.3
        for smooth in (free._replace(mu=0.0), free._replace(mu=0.5, alpha_t=1.0)):
            for outcome in (si.soft_impact(theta, smooth), si.hard_impact(theta, smooth)):
                assert (outcome.slip == theta).all()
                assert not outcome.impulse.any()
            assert si.weak_slip_restitution(smooth) == 1
            assert si.residual(smooth) == (0, 0)
        assert si.residual(free) == (0, 0)
        assert si.gross_sliding(free._replace(mu=0.0)) == 0


@given(contact=contacts(), x=scaled)
def test_friction_takes_energy_and_keeps_to_its_limits(contact: si.SoftContact, x: float) -> None:
    theta = x * contact.scale
    outcome = si.soft_impact([theta, -theta], contact)
    assert outcome.slip[0] == -outcome.slip[1]
    assert abs(outcome.slip[0]) <= theta + ROUNDING * contact.scale * (1 + x)
    assert 0 <= outcome.impulse[0] <= contact.mu * si.force_impulse(contact.alpha) * (1 + ROUNDING)
    if contact.friction == "dashpot":
        # the limit only ever weakens it
        assert outcome.slip[0] >= contact.alpha_t * theta - ROUNDING * contact.scale * (1 + x)


@given(contact=contacts(), x=scaled, mu=st.floats(0.05, 2), q=st.floats(0.1, 1))
def test_mu_and_q_only_scale(contact: si.SoftContact, x: float, mu: float, q: float) -> None:
    other = contact._replace(mu=mu, q=q)
    one, two = (float(si.soft_impact(x * c.scale, c).slip) / c.scale for c in (contact, other))
    assert one == pytest.approx(two, abs=ROUNDING * (1 + x))


@given(theta=st.floats(-10, 10), mu=st.floats(0.05, 2), q=st.floats(0.1, 1))
def test_elastic_perfectly_rough_contact_is_the_hard_rule(theta: float, mu: float, q: float) -> None:
    contact = si.SoftContact(1.0, -1.0, mu, q)
    soft, hard = si.soft_impact(theta, contact), si.hard_impact(theta, contact)
    np.testing.assert_allclose(soft, hard, atol=ROUNDING * (abs(theta) + contact.scale))
    assert si.sliding_onset(contact) == pytest.approx(granular.sliding_limit(1.0, -1.0, mu, q), rel=ROUNDING)
    assert si.gross_sliding(contact) == pytest.approx(si.sliding_onset(contact), rel=ROUNDING)


@given(contact=contacts(), x=scaled, wall=st.booleans(), mass=st.floats(0.3, 3), radius=st.floats(0.2, 2))
def test_hard_rule_is_that_of_granular_for_unlike_grains_and_walls(
    contact: si.SoftContact, x: float, wall: bool, mass: float, radius: float
) -> None:
    theta, speed = x * contact.scale, 1.7
    normal, along = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    one = granular.Body(1.0, 0.5, speed * (theta * along - normal), np.zeros(3), contact.q)
    two = granular.Body(math.inf if wall else mass, 0.0 if wall else radius, np.zeros(3), np.zeros(3), contact.q)
    reduced = 1 / (1 + 1 / two.mass)
    done = granular.impact(one, two, normal, contact.alpha, contact.alpha_t, contact.mu, contact.mu)
    after = one._replace(velocity=done.velocities[0], spin=done.spins[0])
    rest = two._replace(velocity=done.velocities[1], spin=done.spins[1])
    slip = granular.contact_velocity(after, rest, normal) @ along / speed
    outcome = si.hard_impact(theta, contact)
    assert outcome.slip == pytest.approx(slip, abs=ROUNDING * (1 + theta + contact.scale))
    assert outcome.impulse == pytest.approx(-done.impulse @ along / (reduced * speed), abs=ROUNDING * (1 + theta))


@pytest.mark.parametrize(("alpha", "alpha_t"), [(1.0, 0.3), (0.9, 0.5), (0.6, 0.2), (0.9, 0.05), (0.1, 0.01)])
def test_gross_sliding_of_the_dashpot(alpha: float, alpha_t: float) -> None:
    contact = si.SoftContact(alpha, alpha_t, 0.3, 0.5, "dashpot")
    limit, most = si.gross_sliding(contact), 0.3 * si.force_impulse(alpha)
    above = si.soft_impact(limit * np.array([1 + 1e-9, 1.5, 10]), contact)
    np.testing.assert_allclose(above.impulse, most, rtol=ROUNDING)
    assert si.soft_impact(0.99 * limit, contact).impulse < most * (1 - 1e-7)
    if alpha == 1:
        rate = -math.log(alpha_t) / math.pi
        assert limit == pytest.approx(contact.scale * (1 + math.hypot(1, 1 / rate)), rel=ROUNDING)
    # the largest need, on a fine grid: parabolic at the top
    rate = -math.log(alpha_t) / math.pi
    impact = si.HookeImpact(1.0, 1.0, 1.0, alpha)
    times = np.linspace(0, impact.contact_time, 20001)
    force, velocity = impact.force(times), impact.velocity(times)
    turned = 1 + alpha ** (impact.time_of_attraction / impact.contact_time)
    pushed = np.where(times < impact.time_of_attraction, 1 - velocity, 2 * turned - 1 + velocity)
    needs = abs(force) * impact.contact_time / (math.pi * rate) + pushed
    assert limit == pytest.approx(contact.scale * needs.max(), rel=(math.pi / 20000) ** 2 * 10)


@pytest.mark.parametrize("alpha_t", [-0.9, 0.0, 0.8])
def test_gross_sliding_of_the_elastic_spring(alpha_t: float) -> None:
    contact = si.SoftContact(1.0, alpha_t, 0.3)
    limit = si.gross_sliding(contact)
    above = si.soft_impact(limit * np.array([1 + 1e-9, 1.5, 10]), contact)
    np.testing.assert_allclose(above.impulse, 0.6, rtol=ROUNDING)
    assert si.soft_impact(0.9 * limit, contact).impulse < 0.6 * (1 - 1e-7)


def test_the_damped_spring_always_sticks_first() -> None:
    contact = si.SoftContact(0.6, 0.2, 0.5)
    assert si.gross_sliding(contact) == math.inf
    theta = np.array([1e3, 2e3])
    short = 0.5 * si.force_impulse(0.6) - si.soft_impact(theta, contact).impulse
    cot, nu = -math.log(0.6) / math.pi, math.acos(0.2) / math.pi
    leading = 2 * (0.5 * cot / nu) ** 2 * 3.5 / theta
    # the next order in 1/Theta halves
    off = abs(short / leading - 1)
    assert off[0] < 0.01
    assert off[1] == pytest.approx(off[0] / 2, rel=0.05)


@given(contact=contacts())
def test_weak_slip(contact: si.SoftContact) -> None:
    expected = si.weak_slip_restitution(contact)
    x = np.array([1e-4, 1e-5])
    ratio = si.soft_impact(x * contact.scale, contact).slip / (x * contact.scale)
    off = abs(ratio - expected)
    # sliding lasts a time of order x; the smaller x leaves a tenth, or the rounding of w
    assert off[1] <= 0.2 * off[0] + 100 * EPSILON / x[1]


def test_the_turn_of_the_force_takes_the_stretch() -> None:
    contact = si.SoftContact(0.9, -0.5, 0.3)
    assert si.weak_slip_restitution(contact) == pytest.approx(-0.4603, abs=5e-5)
    # however large mu is, unless it is infinite
    many = [float(si.soft_impact(1.0, contact._replace(mu=mu)).slip) for mu in (1e3, 1e6, math.inf)]
    np.testing.assert_allclose(many, [-0.4603, -0.4603, -0.5], atol=5e-4)
    assert si.sliding_onset(contact) == 0
    assert si.weak_slip_restitution(contact._replace(alpha=1.0)) == pytest.approx(-0.5, rel=ROUNDING)


def test_sliding_sets_in_at_once_but_for_the_elastic_rough_contact() -> None:
    for contact in (si.SoftContact(1.0, 0.3, 0.4), si.SoftContact(0.9, 0.5, 0.3, 0.4, "dashpot")):
        theta = 0.01 * contact.scale
        assert si.sliding_onset(contact) == 0
        assert si.soft_impact(theta, contact).slip > contact.alpha_t * theta * (1 + 1e-6)


# -- the distance to the hard rule --------------------------------------------------------------------------------

#: From the module itself; `test_explicit_steps_converge_to_the_outcome` has the same contacts.
RESIDUALS = {
    si.SoftContact(0.9, -0.5, 0.3): 0.46949,
    si.SoftContact(1.0, -1.0, 0.3): 0.0,
    si.SoftContact(0.6, 0.2, 0.5): 1.15677,
    si.SoftContact(0.6, 0.2, 0.5, 0.4, "dashpot"): 0.31101,
}


@pytest.mark.parametrize(("contact", "expected"), RESIDUALS.items())
def test_residuals(contact: si.SoftContact, expected: float) -> None:
    found = si.residual(contact)
    assert found.size == pytest.approx(expected, abs=6e-6)
    # where hard grains begin to slide, soft ones have slid for some time
    corner = granular.sliding_limit(contact.alpha, contact.alpha_t, contact.mu, contact.q)
    assert found.theta == pytest.approx(corner, rel=ROUNDING)
    there = si.soft_impact(corner, contact).slip - si.hard_impact(corner, contact).slip
    assert found.size == pytest.approx(abs(there), abs=ROUNDING * contact.scale)


@settings(max_examples=5)
@given(contact=contacts(), seed=st.integers(0, 10**6))
def test_residual_is_the_largest(contact: si.SoftContact, seed: int) -> None:
    found = si.residual(contact, 60)
    theta = np.tan(np.random.default_rng(seed).uniform(0, math.pi / 2, 100)) * contact.scale
    apart = abs(si.soft_impact(theta, contact).slip - si.hard_impact(theta, contact).slip)
    assert (apart <= found.size + ROUNDING * (theta + contact.scale)).all()
    scaled_up = si.residual(contact._replace(mu=2 * contact.mu), 60)
    assert scaled_up == pytest.approx((2 * found.size, 2 * found.theta), rel=1e-6)


def test_residual_at_large_angles_is_the_force_that_attracts() -> None:
    # so much damping that the attraction at the end counts more than the late sliding at the corner
    contact = si.SoftContact(0.1, 0.3, 0.7, 0.4, "dashpot")
    found = si.residual(contact)
    assert found.theta == si.gross_sliding(contact)
    assert found.size == pytest.approx(contact.scale * (si.force_impulse(0.1) - 1.1), rel=ROUNDING)


def test_refusals() -> None:
    for alpha in (-0.1, 1.1):
        with pytest.raises(ValueError, match="restitution"):
            si.damping(alpha)
    for c in (-0.1, 2.1):
        with pytest.raises(ValueError, match="damping"):
            si.restitution(c)
    with pytest.raises(ValueError, match="restitution"):
        _ = si.HookeImpact(1.0, 1.0, 1.0, 0.0).contact_time
    with pytest.raises(ValueError, match="at least 0"):
        si.stability_limit(-0.1)
    with pytest.raises(ValueError, match="below 2"):
        si.stable_resolution(2.0)
    good = si.SoftContact(0.9, 0.5, 0.3)
    with pytest.raises(ValueError, match="finite"):
        si.soft_impact([0.1, math.inf], good)
    for bad, words in {
        good._replace(alpha=0.0): "restitution",
        good._replace(alpha_t=-1.1): "tangential",
        good._replace(alpha_t=-0.5, friction="dashpot"): "dashpot",
        good._replace(mu=-0.1): "mu",
        good._replace(q=0.0): "q above 0",
    }.items():
        for ask in (si.weak_slip_restitution, si.sliding_onset, si.gross_sliding, si.residual):
            with pytest.raises(ValueError, match=words):
                ask(bad)
        for rule in (si.soft_impact, si.hard_impact):
            with pytest.raises(ValueError, match=words):
                rule(1.0, bad)


def test_frequency_is_that_of_the_elastic_contact() -> None:
    """Without damping the contact is half a turn of the oscillator."""
    impact = si.HookeImpact(mass=0.3, stiffness=7.0, speed=1.1, alpha=1.0)
    assert impact.frequency * impact.contact_time == pytest.approx(math.pi)
    t = 0.1 * impact.contact_time
    assert impact.frequency**2 == pytest.approx(impact.force(t) / (impact.mass * impact.overlap(t)))
