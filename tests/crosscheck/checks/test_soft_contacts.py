"""The logic that the checks of soft contacts bring with them, by independent routes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks import soft_contacts as checks
from crosscheck.checks.soft_contacts import Law, SteppedContact
from crosscheck.engines.base import Run
from crosscheck.references import EPSILON, granular
from crosscheck.references.granular import Body
from crosscheck.references.soft_impact import HookeImpact, SoftContact, damping, stability_limit

# -- what a time step does to a contact --------------------------------------------------------------------------------


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
    bounds = checks.hooke_bounds(alpha, 1 / steps)
    rebound, deepest = _impact(damping(alpha), exact.contact_time / steps, phase)
    assert abs(math.log(rebound / alpha)) <= bounds.restitution
    assert abs(math.log(deepest / exact.largest_overlap)) <= bounds.overlap


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
    assert abs(found - contact.alpha_t) <= checks.sticking_bound(contact, 1 / steps) + 10 * EPSILON


@pytest.mark.parametrize("contact", [SoftContact(0.8, -0.5, 0.3), SoftContact(0.6, 0.3, 0.3, 0.5, "dashpot")])
def test_friction_bounds_are_of_order_one_and_grow_with_the_slip(contact: SoftContact) -> None:
    thetas = np.array([0.1, 1.0, 5.0])
    coarse, fine = (checks.friction_bounds(thetas, contact, resolution) for resolution in (1e-3, 1e-4))
    np.testing.assert_allclose(coarse / fine, 10, rtol=0.05)
    assert (np.diff(fine) > 0).all()


# -- many impacts in one scene -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("central", [False, True])
def test_impacts_are_as_asked(dimension: int, wall: bool, central: bool) -> None:
    thetas, speeds = np.linspace(0, 5, 20), np.linspace(0.5, 2, 20)
    sizes = np.linspace(0.3, 1.5, 40).reshape(20, 2)
    impacts = checks.make_impacts(
        dimension, thetas, 7, speeds=speeds, diameters=sizes, masses=3 * sizes, wall=wall, central=central
    )
    np.testing.assert_allclose(impacts.approach, speeds)
    np.testing.assert_allclose(np.linalg.norm(impacts.slips, axis=1), thetas * speeds, atol=1e-13)
    touching = impacts.touching()
    np.testing.assert_allclose(
        np.linalg.norm(touching[:, 0] - touching[:, 1], axis=1), impacts.radii.sum(axis=1), rtol=1e-12
    )
    assert np.isfinite(impacts.masses).all() != wall
    if central:
        lever = np.cross(impacts.velocities[:, 0] - impacts.velocities[:, 1], impacts.normals)
        np.testing.assert_allclose(lever, 0, atol=1e-15)
    if dimension == 2:
        assert not impacts.velocities[..., 2].any()
        assert not impacts.spins[..., :2].any()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wall", [False, True])
def test_scene_brings_the_grains_to_their_impacts(dimension: int, wall: bool) -> None:
    impacts = checks.make_impacts(dimension, np.linspace(0, 2, 9), 3, wall=wall, diameters=(1.0, 0.6))
    law = Law(0.8, SoftContact(0.8, -0.5, 0.3))
    dt = 1e-3
    # it refuses overlaps
    state = checks.impact_scene(impacts, law, dt, 10).initial_state()
    assert state.diameters is not None
    bodies = 1 if wall else 2
    expected = impacts.touching() - (dt * impacts.phases)[:, None, None] * impacts.velocities
    np.testing.assert_allclose(state.positions, expected[:, :bodies].reshape(-1, 3)[:, :dimension])
    np.testing.assert_allclose(state.diameters, 2 * impacts.radii[:, :bodies].ravel())
    np.testing.assert_array_equal(state.masses, impacts.masses[:, :bodies].ravel())
    assert state.angular_velocities is not None
    assert state.angular_velocities.shape == (9 * bodies, 1 if dimension == 2 else 3)


@pytest.mark.parametrize("wall", [False, True])
def test_rebound_and_hard_errors_against_the_hard_rule(wall: bool) -> None:
    contact = SoftContact(0.7, -0.4, 0.3, 0.5)
    impacts = checks.make_impacts(2, np.linspace(0.1, 5, 12), 5, wall=wall, q=contact.q)
    velocities, spins = np.zeros((2, 12, 2, 3))
    for k in range(12):
        one, two = (
            Body(impacts.masses[k, i], impacts.radii[k, i], impacts.velocities[k, i], impacts.spins[k, i], contact.q)
            for i in (0, 1)
        )
        after = granular.impact(one, two, impacts.normals[k], contact.alpha, contact.alpha_t, contact.mu, contact.mu)
        velocities[k], spins[k] = after.velocities, after.spins
    normal, slip = checks.rebound(impacts, velocities, spins)
    np.testing.assert_allclose(normal, contact.alpha)
    np.testing.assert_allclose(slip, checks.hard_impact(np.linspace(0.1, 5, 12), contact).slip, atol=1e-13)
    assert checks._hard_errors(impacts, contact, velocities, spins) == 0
    # rows of a run are put back in their places
    grains = velocities[:, : 1 if wall else 2].reshape(-1, 3)[:, :2]
    turning = spins[:, : 1 if wall else 2].reshape(-1, 3)[:, 2:]
    run = Run(np.zeros(1), grains, grains, final_angular_velocities=turning)
    for found, expected in zip(checks.after(impacts, run), (velocities, spins), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("wall", [False, True])
def test_overlaps(wall: bool) -> None:
    impacts = checks.make_impacts(2, np.zeros(5), 2, wall=wall, central=True)
    rows = impacts.touching()[:, : 1 if wall else 2, :2]
    # nearer by 0.1 along the normal, then apart by 0.2
    nearer = rows.copy()
    nearer[:, 0] -= 0.1 * impacts.normals[:, :2]
    apart = rows.copy()
    apart[:, 0] += 0.2 * impacts.normals[:, :2]
    frames = np.array([frame.reshape(-1, 2) for frame in (rows, nearer, apart)])
    found = checks.overlaps(impacts, Run(np.zeros(3), frames[-1], frames[-1], positions=frames))
    np.testing.assert_allclose(found, np.outer([0, 0.1, -0.2], np.ones(5)), atol=1e-14)


# -- stability ---------------------------------------------------------------------------------------------------------


@given(limit=st.floats(0.91, 1.09))
def test_bisect(limit: float) -> None:
    assert checks.bisect(lambda x: x > limit, 0.9, 1.1, 1e-6) == pytest.approx(limit, abs=1e-6)


@pytest.mark.parametrize("always", [False, True])
def test_bisect_wants_the_limit_between(always: bool) -> None:
    with pytest.raises(ValueError, match="does not lie between"):
        checks.bisect(lambda x: always, 0.9, 1.1, 1e-6)


@pytest.mark.parametrize("c", [0.0, 1e-3, 0.2, 1.4])
def test_growth_delay_is_where_the_map_explodes(c: float) -> None:
    def explodes(share: float) -> bool:
        h = share * stability_limit(c)
        powers = np.linalg.matrix_power(np.array([[1 - h * h, h * (1 - c * h)], [-h, 1 - c * h]]), checks.STABLE_STEPS)
        return bool(abs(powers @ [0.0, 1.0]).max() > checks.EXPLODED)

    delay = checks.bisect(explodes, 1 - 1e-9, 1.002, 1e-10) - 1
    assert 0 < delay <= checks.growth_delay(c) < 1e-3
    # near a double eigenvalue, at c = 0, the amplitude grows with the number of steps by itself, and needs less
    assert delay > checks.growth_delay(c) / 20
