"""What a time step does to a contact, against contacts that are stepped one by one, and against the map of a step."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import (
    HertzImpact,
    HookeImpact,
    SoftContact,
    damping,
    soft_impact,
    stability_limit,
)
from crosscheck.references.stepped_contact import (
    SteppedContact,
    elastic_energy_bound,
    friction_bounds,
    growth_delay,
    hard_rule_bounds,
    hooke_bounds,
    impact_bounds,
    sticking_bound,
)

# -- normal impact -----------------------------------------------------------------------------------------------------


@given(c=st.floats(0.0, 1.8), share=st.floats(0.01, 0.5))
@settings(deadline=None)
def test_stepped_contact_is_the_map_of_half_steps(c: float, share: float) -> None:
    h = share * stability_limit(c)
    contact = SteppedContact(c, h)
    # x and v/omega_0 of the half step before: the force, its velocity of then, and the drift
    eigenvalues = np.linalg.eigvals([[1 - h * h, h * (1 - c * h)], [-h, 1 - c * h]])
    if not np.iscomplex(eigenvalues).all():
        # it creeps to rest
        with pytest.raises(ValueError, match="creep to rest"):
            _ = contact.angle
        return
    angle = float(abs(np.angle(eigenvalues[0])))
    # d angle = d(cos angle)/sin(angle)
    rounding = 100 * EPSILON / math.sin(angle) ** 2
    assert contact.angle == pytest.approx(angle, rel=rounding)
    assert contact.restitution == pytest.approx(abs(eigenvalues[0]) ** (math.pi / angle), rel=10 * rounding / angle)
    assert contact.duration == pytest.approx(math.pi / angle * h, rel=10 * rounding)


@pytest.mark.parametrize("alpha", [0.9, 0.5, 0.05])
def test_stepped_contact_converges_to_the_closed_form(alpha: float) -> None:
    exact, steps = HookeImpact(1.0, 1.0, 1.0, alpha), np.array([1e-2, 1e-3])
    contacts = [SteppedContact(damping(alpha), float(h)) for h in steps]
    off = np.array([[math.log(one.restitution / alpha), one.duration / exact.contact_time - 1] for one in contacts])
    # of order 1, for the dashpot lags: the error falls by ten, but for the next order, h over the swing that is left
    np.testing.assert_allclose(off[0] / off[1], 10, rtol=10 * steps[0] / (1 - damping(alpha) / 2))


def _impact(c: float, h: float, phase: float) -> tuple[float, float]:
    """v'/v and largest overlap at a step, of velocity Verlet that finds the first overlap after `phase` steps."""
    x, v, deepest = phase * h, 1.0, 0.0
    while x > 0:
        deepest = max(deepest, x)
        v -= h * (x + c * v)
        x += h * v
    return -v, deepest


@given(alpha=st.floats(0.05, 1.0), steps=st.floats(40, 400), phase=st.floats(0.001, 1.0))
@settings(deadline=None, max_examples=60)
def test_bounds_hold_at_every_phase(alpha: float, steps: float, phase: float) -> None:
    exact = HookeImpact(1.0, 1.0, 1.0, alpha)
    bounds = hooke_bounds(alpha, 1 / steps)
    slower, deepest = _impact(damping(alpha), exact.contact_time / steps, phase)
    assert abs(math.log(slower / alpha)) <= bounds.restitution
    assert abs(math.log(deepest / exact.largest_overlap)) <= bounds.overlap


@given(alpha=st.floats(0.05, 1.0), steps=st.floats(40, 400), phase=st.floats(0.001, 1.0), speed=st.floats(0.3, 3.0))
@settings(deadline=None, max_examples=60)
def test_bounds_of_hertz_hold_at_every_phase(alpha: float, steps: float, phase: float, speed: float) -> None:
    impact = HertzImpact(0.7, 1.3, 0.25, speed, alpha)
    dt = impact.contact_time / steps
    c, k, root = damping(alpha, "hertz"), impact.stiffness, math.sqrt(impact.radius)
    x, v, deepest = phase * dt * speed, speed, 0.0
    while x > 0:
        deepest = max(deepest, x)
        dashpot = c * math.sqrt(impact.mass * k) * math.sqrt(root * math.sqrt(x))
        v -= dt * (k * root * x**1.5 + dashpot * v) / impact.mass
        x += dt * v
    bounds = impact_bounds(impact, dt)
    assert abs(math.log(-v / speed / alpha)) <= bounds.restitution
    assert abs(math.log(deepest / impact.largest_overlap)) <= bounds.overlap


def test_impact_bounds_of_hooke_are_those_of_its_restitution() -> None:
    impact = HookeImpact(0.7, 1.3, 2.0, 0.6)
    assert impact_bounds(impact, impact.contact_time / 80) == pytest.approx(hooke_bounds(0.6, 1 / 80), rel=1e-12)


@given(steps=st.floats(20, 400), phase=st.floats(0.001, 1.0))
@settings(deadline=None)
def test_elastic_energy_bound_holds_at_every_phase(steps: float, phase: float) -> None:
    slower, _ = _impact(0.0, math.pi / steps, phase)
    # the next order of h
    assert abs(slower**2 - 1) <= elastic_energy_bound(1 / steps) * (1 + (math.pi / steps) ** 2)


def _where(explodes: Callable[[float], bool], low: float, high: float) -> float:
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if explodes(middle) else (middle, high)
    return 0.5 * (low + high)


@pytest.mark.parametrize("c", [0.0, 1e-3, 0.2, 1.4])
def test_growth_delay_is_where_the_map_explodes(c: float) -> None:
    steps, growth = 4000, 40000.0

    def explodes(share: float) -> bool:
        h = share * stability_limit(c)
        powers = np.linalg.matrix_power(np.array([[1 - h * h, h * (1 - c * h)], [-h, 1 - c * h]]), steps)
        return bool(abs(powers @ [0.0, 1.0]).max() > growth)

    delay = _where(explodes, 1 - 1e-9, 1.002) - 1
    assert 0 < delay <= growth_delay(c, growth, steps) < 1e-3
    # near a double eigenvalue, at c = 0, the amplitude grows with the number of steps by itself, and needs less
    assert delay > growth_delay(c, growth, steps) / 20


# -- friction ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("contact", [SoftContact(0.8, -0.5, 0.3), SoftContact(0.6, 0.3, 0.3, 0.5, "dashpot")])
def test_friction_bounds_are_of_order_one_and_grow_with_the_slip(contact: SoftContact) -> None:
    thetas = np.array([0.1, 1.0, 5.0])
    coarse, fine = (friction_bounds(thetas, contact, resolution) for resolution in (1e-3, 1e-4))
    np.testing.assert_allclose(coarse / fine, 10, rtol=0.05)
    assert (np.diff(fine) > 0).all()


def _slide(theta: float, contact: SoftContact, resolution: float, phase: float) -> float:
    """u'/v of a contact with Coulomb's limit, step by step; m = k = v = 1."""
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    c, h = damping(contact.alpha), resolution * exact.contact_time
    mass = contact.q / (1 + contact.q)
    x, v, u, stretch = phase * h, 1.0, theta, 0.0
    while x > 0:
        normal = x + c * v
        limit = contact.mu * abs(normal)
        if contact.friction == "history":
            spring = mass * (math.acos(contact.alpha_t) / exact.contact_time) ** 2
            stretch = float(np.clip(stretch + h * u, -limit / spring, limit / spring))
            force = spring * stretch
        else:
            force = float(np.clip(-math.log(contact.alpha_t) * mass / exact.contact_time * u, -limit, limit))
        v -= h * normal
        u -= h * force / mass
        x += h * v
    return u


@given(
    alpha=st.floats(0.3, 1.0),
    alpha_t=st.floats(-0.95, 0.95),
    mu=st.floats(0.1, 1.0),
    q=st.floats(0.3, 0.6),
    history=st.booleans(),
    angle=st.floats(0.01, 2.5),
    steps=st.floats(100, 1000),
    phase=st.floats(0.001, 1.0),
)
@settings(deadline=None, max_examples=100)
def test_friction_bounds_hold_at_every_phase(
    alpha: float, alpha_t: float, mu: float, q: float, history: bool, angle: float, steps: float, phase: float
) -> None:
    law = "history" if history else "dashpot"
    contact = SoftContact(alpha, alpha_t if history else max(abs(alpha_t), 0.05), mu, q, law)  # type: ignore[arg-type]
    # in units of the hard rule's limit of sticking
    theta = angle * contact.scale * (1 + alpha) / (1 - contact.alpha_t)
    found = _slide(theta, contact, 1 / steps, phase)
    assert abs(found - float(soft_impact(theta, contact).slip)) <= friction_bounds(theta, contact, 1 / steps)


@given(theta=st.floats(0.0, 3.0), mu=st.floats(0.1, 1.0), steps=st.floats(10, 300), phase=st.floats(0.001, 1.0))
@settings(deadline=None, max_examples=100)
def test_hard_rule_bounds_hold_at_every_phase(theta: float, mu: float, steps: float, phase: float) -> None:
    contact = SoftContact(1.0, -1.0, mu, 0.5, "history")
    found = _slide(theta, contact, 1 / steps, phase)
    bound = hard_rule_bounds(theta, contact, 1 / steps)
    assert abs(found - float(soft_impact(theta, contact).slip)) <= bound + 10 * EPSILON


def _stick(contact: SoftContact, resolution: float, phase: float) -> float:
    """u'/u of a contact that sticks, step by step."""
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    c, h = damping(contact.alpha), resolution * exact.contact_time
    x, v, u, stretch = phase * h, 1.0, 1.0, 0.0
    while x > 0:
        v -= h * (x + c * v)
        x += h * v
        if contact.friction == "history":
            stretch += resolution * u
            u -= resolution * math.acos(contact.alpha_t) ** 2 * stretch
        else:
            u += resolution * math.log(contact.alpha_t) * u
    return u


@given(
    alpha=st.floats(0.1, 1.0),
    alpha_t=st.floats(-1.0, 1.0),
    history=st.booleans(),
    steps=st.floats(20, 300),
    phase=st.floats(0.001, 1.0),
)
@settings(deadline=None, max_examples=60)
def test_sticking_bound_holds_at_every_phase(
    alpha: float, alpha_t: float, history: bool, steps: float, phase: float
) -> None:
    law = "history" if history else "dashpot"
    contact = SoftContact(alpha, alpha_t if history else max(abs(alpha_t), 0.05), math.inf, 0.4, law)  # type: ignore[arg-type]
    found = _stick(contact, 1 / steps, phase)
    assert abs(found - contact.alpha_t) <= sticking_bound(contact, 1 / steps) + 10 * EPSILON


@pytest.mark.parametrize("c", [0.0, 0.1, 1.0])
def test_ends_bound_the_half_steps_of_both_ends(c: float) -> None:
    """Half a step of damping at either end, (1 - c h)^(1/2) each, and cos of half a step's turn, 1 - h^2/8, twice."""
    step = 1e-3
    ends = math.log((1 - c * step) ** 0.5 * math.cos(step / 2)) * 2
    assert SteppedContact(c, step).ends == pytest.approx(-ends, rel=1e-5)
