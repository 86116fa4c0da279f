"""Impacts in one scene, and the bounds of a time step, by independent routes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.granular.impacts import Law, SteppedContact, hooke_bounds, impact_scene, make_impacts, overlaps
from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
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
    bounds = hooke_bounds(alpha, 1 / steps)
    slower, deepest = _impact(damping(alpha), exact.contact_time / steps, phase)
    assert abs(math.log(slower / alpha)) <= bounds.restitution
    assert abs(math.log(deepest / exact.largest_overlap)) <= bounds.overlap


# -- many impacts in one scene -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("central", [False, True])
def test_impacts_are_as_asked(dimension: int, wall: bool, central: bool) -> None:
    thetas, speeds = np.linspace(0, 5, 20), np.linspace(0.5, 2, 20)
    sizes = np.linspace(0.3, 1.5, 40).reshape(20, 2)
    impacts = make_impacts(
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
    impacts = make_impacts(dimension, np.linspace(0, 2, 9), 3, wall=wall, diameters=(1.0, 0.6))
    law = Law(0.8, SoftContact(0.8, -0.5, 0.3))
    dt = 1e-3
    # it refuses overlaps
    state = impact_scene(impacts, law, dt, 10).initial_state()
    assert state.diameters is not None
    bodies = 1 if wall else 2
    expected = impacts.touching() - (dt * impacts.phases)[:, None, None] * impacts.velocities
    np.testing.assert_allclose(state.positions, expected[:, :bodies].reshape(-1, 3)[:, :dimension])
    np.testing.assert_allclose(state.diameters, 2 * impacts.radii[:, :bodies].ravel())
    np.testing.assert_array_equal(state.masses, impacts.masses[:, :bodies].ravel())
    assert state.angular_velocities is not None
    assert state.angular_velocities.shape == (9 * bodies, 1 if dimension == 2 else 3)


@pytest.mark.parametrize("wall", [False, True])
def test_overlaps(wall: bool) -> None:
    impacts = make_impacts(2, np.zeros(5), 2, wall=wall, central=True)
    rows = impacts.touching()[:, : 1 if wall else 2, :2]
    # nearer by 0.1 along the normal, then apart by 0.2
    nearer = rows.copy()
    nearer[:, 0] -= 0.1 * impacts.normals[:, :2]
    apart = rows.copy()
    apart[:, 0] += 0.2 * impacts.normals[:, :2]
    frames = np.array([frame.reshape(-1, 2) for frame in (rows, nearer, apart)])
    found = overlaps(impacts, Run(np.zeros(3), frames[-1], frames[-1], positions=frames))
    np.testing.assert_allclose(found, np.outer([0, 0.1, -0.2], np.ones(5)), atol=1e-14)
