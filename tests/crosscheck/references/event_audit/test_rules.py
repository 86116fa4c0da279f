"""The auditor's laws of collisions: conservation, the energy that is lost, and what sticks or slides."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references.event_audit.matter import matter_of
from crosscheck.references.event_audit.rules import Motion, cross, pair_collision, wall_collision, well_edge
from crosscheck.scene import Box, Explicit, Friction, GrainFriction, HardSpheres, Scene, Well

SEEDS = st.integers(0, 10**6)


def pair(seed, friction=None, well=None, restitution=0.7):
    """Two unlike spheres in contact that approach: matter, normal and motions."""
    rng = np.random.default_rng(seed)
    scene = Scene(
        name="pair",
        dimension=3,
        duration=1.0,
        hard_spheres=HardSpheres(diameter=(1.2, 0.7), restitution=restitution, friction=friction, well=well),
        masses=(1.3, 2.9),
        species=(0, 1),
        box=Box(lengths=(9.0, 9.0, 9.0)),
        initial=Explicit(positions=((1.0, 1.0, 1.0), (4.0, 4.0, 4.0))),
    )
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    one, other = (Motion(rng.normal(size=3), rng.normal(size=3)) for _ in range(2))
    if (other.velocity - one.velocity) @ n > 0:
        one, other = other, one
    return matter_of(scene), n, one, other


def slip(matter, n, one, other):
    """Velocity of the surface of the first past that of the second, at their contact."""
    return (
        one.velocity + cross(one.spin, matter.radii[0] * n) - other.velocity - cross(other.spin, -matter.radii[1] * n)
    )


def energy(matter, motions):
    return sum(
        0.5 * matter.masses[k] * (m.velocity @ m.velocity) + 0.5 * matter.moments[k] * (m.spin @ m.spin)
        for k, m in enumerate(motions)
    )


def spun(matter, n, motions):
    """Angular momentum about the first centre."""
    arms = (np.zeros(3), (matter.radii[0] + matter.radii[1]) * n)
    return sum(
        matter.moments[k] * m.spin + matter.masses[k] * cross(arms[k], m.velocity) for k, m in enumerate(motions)
    )


@given(SEEDS, st.sampled_from([None, 0.1, 5.0]), st.floats(-1, 1))
def test_a_pair_keeps_momenta_and_loses_what_its_law_says(seed, limit, alpha_t):
    friction = GrainFriction(tangential_restitution=alpha_t, static=limit, sliding=limit)
    matter, n, one, other = pair(seed, friction)
    (outcome,) = pair_collision(matter, 0, 1, n, one, other, False, 1.0)
    before, after = (one, other), (outcome.first, outcome.second)
    masses = matter.masses
    assert masses @ [m.velocity for m in after] == pytest.approx(masses @ [m.velocity for m in before], abs=1e-13)
    assert spun(matter, n, after) == pytest.approx(spun(matter, n, before), abs=1e-13)
    old, new = slip(matter, n, *before), slip(matter, n, *after)
    assert new @ n == pytest.approx(-0.7 * (old @ n), abs=1e-13)
    mu = 1 / (1 / masses[0] + 1 / masses[1])
    tangent, left = old - (old @ n) * n, new - (new @ n) * n
    normal = 1.7 * mu * (old @ n)
    impulse = (tangent - left) * mu / (1 + 1 / matter.shape)
    if limit is not None and np.linalg.norm(impulse) == pytest.approx(limit * normal):
        assert cross(impulse, tangent) == pytest.approx(np.zeros(3), abs=1e-12)
        assert impulse @ tangent >= 0
    else:
        assert left == pytest.approx(alpha_t * tangent, abs=1e-13)
        assert limit is None or np.linalg.norm(impulse) <= limit * normal
    lost = 0.5 * mu * ((old @ n) ** 2 - (new @ n) ** 2)
    lost += 0.5 * mu / (1 + 1 / matter.shape) * (tangent @ tangent - left @ left)
    assert energy(matter, before) - energy(matter, after) == pytest.approx(lost, abs=1e-12)


@given(SEEDS, st.sampled_from([-3.0, -0.2, 0.2, 3.0]), st.booleans())
def test_the_edge_of_a_well_changes_the_energy_by_its_depth_or_turns_the_pair_back(seed, depth, inside):
    matter, n, one, other = pair(seed, well=Well(depth=depth, range=1.5))
    if inside:
        one, other = other, one
    for outcome in well_edge(matter, 0, 1, n, one, other, inside):
        gained = energy(matter, (outcome.first, outcome.second)) - energy(matter, (one, other))
        entered = float(outcome.inside) - float(inside)
        assert gained == pytest.approx(depth * entered, abs=1e-11)
        apart = (outcome.second.velocity - outcome.first.velocity) @ n
        before = (other.velocity - one.velocity) @ n
        assert apart * before > 0 if entered else apart == pytest.approx(-before)
        momentum = matter.masses[0] * outcome.first.velocity + matter.masses[1] * outcome.second.velocity
        assert momentum == pytest.approx(matter.masses[0] * one.velocity + matter.masses[1] * other.velocity)


@given(SEEDS, st.floats(-1, 1))
def test_a_moving_rough_wall_reverses_the_motion_relative_to_its_surface(seed, alpha_t):
    matter, n, one, _ = pair(seed, GrainFriction(tangential_restitution=0.1))
    surface = np.random.default_rng(seed + 1).normal(size=3)
    if (one.velocity - surface) @ n < 0:
        n = -n
    law = (0.6, Friction(tangential_restitution=alpha_t))
    (outcome,) = wall_collision(matter, 0, n, one, law, surface, 1.0)

    def relative(motion):
        return motion.velocity + cross(motion.spin, matter.radii[0] * n) - surface

    old, new = relative(one), relative(outcome.first)
    assert new @ n == pytest.approx(-0.6 * (old @ n), abs=1e-13)
    assert new - (new @ n) * n == pytest.approx(alpha_t * (old - (old @ n) * n), abs=1e-13)
    push = matter.masses[0] * (outcome.first.velocity - one.velocity)
    turned = matter.moments[0] * (outcome.first.spin - one.spin)
    assert turned == pytest.approx(matter.radii[0] * cross(n, push), abs=1e-13)


def test_where_rounding_decides_both_outcomes_are_allowed():
    matter, n, one, other = pair(3)
    c = slip(matter, n, one, other)
    c = c - (c @ n) * n
    mu = 1 / (1 / matter.masses[0] + 1 / matter.masses[1])
    normal = 1.7 * mu * float((one.velocity - other.velocity) @ n)
    stick = 0.7 * math.sqrt(c @ c) * mu / (1 + 1 / 0.4)
    limit = stick / normal
    friction = GrainFriction(tangential_restitution=0.3, static=limit, sliding=limit / 2)
    rough, *_ = pair(3, friction)
    assert len(pair_collision(rough, 0, 1, n, one, other, False, 1.0)) == 2
