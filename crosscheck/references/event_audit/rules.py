"""What a contact does to velocities and spins: the laws of the scene language, for one event.

Vectors have three components; in the plane the third is 0, and of a spin the first two are. Arguments that are the same
throughout: matter: particles and walls. i, j: numbers of particles. n: unit vector from i to j, or towards the wall.
speed: the largest one of the run, of whose rounding that of a slip is. At a contact with the
normal n from i to j, the surfaces slide past each other with the tangential part of

    c = (v_i + omega_i x R_i n) - (v_j - omega_j x R_j n),

and the impulse J on i (-J on j) acts at the point of contact: dv = J/m, domega = R n x J/I, of both. With
1/mu = 1/m_i + 1/m_j and I = q m R^2, a tangential impulse changes c_t by J_t (1 + 1/q)/mu.

Literature: J. T. Jenkins and M. W. Richman, Phys. Fluids 28, 3485 (1985); O. R. Walton, in Particulate Two-Phase Flow
(ed. M. C. Roco), 884 (1993); B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31, 459 (1959) (wells).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.references.event_audit.matter import Matter, law_of
from crosscheck.scene import Floats
from crosscheck.scene.parts import Friction

#: Two sides of a decision (stick or slide, through the edge of a well or back) that are nearer than this share of
#: either are both right: the numbers that decide are rounded.
UNDECIDED = 1e-10


class Motion(NamedTuple):
    """State of one particle: its velocity (3,), length/time, and spin (3,), 1/time."""

    velocity: Floats
    spin: Floats


class Outcome(NamedTuple):
    """States that a rule allows after an event.

    first, second: of both partners; second None for a wall. amplified: by how much rounding of what came in is larger
    in what comes out, at least 1. inside: whether a pair is in its well then.
    """

    first: Motion
    second: Motion | None
    amplified: float
    inside: bool = False


def cross(a: Floats, b: Floats) -> Floats:
    """a x b of two vectors of three components."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def size(a: Floats) -> float:
    """|a|."""
    return math.sqrt(a @ a)


def tangential_impulses(
    slip: Floats, normal: float, inverse: float, shape: float, friction: Friction | None, speed: float
) -> list[tuple[Floats, float]]:
    """The tangential impulses that a contact may give against the slip, and the amplification of rounding in each.

    slip: c_t, (3,), length/time. normal: normal impulse. inverse: 1/mu. shape: q. friction: its law, None: smooth.
    speed: a typical one, of whose rounding that of the slip is. Two where rounding decides between them.
    """
    restitution, static, sliding = law_of(friction)
    sticking = -(1 - restitution) * slip / (inverse * (1 + 1 / shape))
    if math.isinf(static):
        return [(sticking, 1.0)]
    needed, most, c = size(sticking), static * normal, size(slip)
    slides = (-sliding * normal / c * slip if c > 0 else 0 * slip, 1 + speed / c if c > 0 else 1.0)
    if abs(needed - most) <= UNDECIDED * max(needed, most):
        return [(sticking, 1.0), slides]
    return [slides] if needed > most else [(sticking, 1.0)]


def pair_collision(
    matter: Matter, i: int, j: int, n: Floats, one: Motion, other: Motion, elastic: bool, speed: float
) -> list[Outcome]:
    """What may follow the collision of i and j.

    matter, n, speed: see the module. one, other: motions of i and j before. elastic: the TC model lets it lose nothing.
    """
    spheres, inverse = matter.spheres, matter.inverse[i] + matter.inverse[j]
    ri, rj = matter.radii[i], matter.radii[j]
    c = one.velocity - other.velocity + cross(ri * one.spin + rj * other.spin, n)
    approach = c @ n
    restitution = 1.0 if elastic else spheres.restitution
    normal = (1 + restitution) * approach / inverse
    options = [(np.zeros(3), 1.0)]
    if spheres.friction is not None and not elastic:
        options = tangential_impulses(c - approach * n, normal, inverse, matter.shape, spheres.friction, speed)
    return [
        Outcome(
            pushed(matter, i, one, n, -normal * n + tangent),
            pushed(matter, j, other, -n, normal * n - tangent),
            amplified,
        )
        for tangent, amplified in options
    ]


def pushed(matter: Matter, i: int, motion: Motion, n: Floats, impulse: Floats) -> Motion:
    """The motion of i after an impulse at the point of its surface in the direction n from its centre.

    matter: see the module. motion: before. impulse: (3,), momentum.
    """
    if matter.fixed[i]:
        return motion
    turn = np.zeros(3)
    if matter.spheres.friction is not None:
        turn = matter.radii[i] / matter.moments[i] * cross(n, impulse)
    return Motion(motion.velocity + matter.inverse[i] * impulse, motion.spin + turn)


def well_edge(matter: Matter, i: int, j: int, n: Floats, one: Motion, other: Motion, inside: bool) -> list[Outcome]:
    """What may follow when i and j meet the edge of their well: its depth, in the energy of the normal motion.

    matter, n: see the module. one, other: motions of i and j before. inside: whether they are in it.
    """
    inverse = float(matter.inverse[i] + matter.inverse[j])
    apart = float((other.velocity - one.velocity) @ n)
    kinetic = apart**2 / (2 * inverse)
    left = kinetic - matter.depth if inside else kinetic + matter.depth
    through = math.copysign(math.sqrt(2 * inverse * max(left, 0.0)), apart)
    options: list[tuple[float, bool]] = []
    near = UNDECIDED * (kinetic + abs(matter.depth))
    if left >= -near:
        options.append((through, not inside))
    if left <= near:
        options.append((-apart, inside))
    found = []
    for after, inside_after in options:
        impulse = (after - apart) / inverse
        # a root of a small difference: its rounding is that of the two energies
        amplified = 1 + (abs(apart) / abs(after) if after else 1 / math.sqrt(UNDECIDED))
        found.append(
            Outcome(
                Motion(one.velocity - matter.inverse[i] * impulse * n, one.spin),
                Motion(other.velocity + matter.inverse[j] * impulse * n, other.spin),
                amplified,
                inside_after,
            )
        )
    return found


def wall_collision(
    matter: Matter,
    i: int,
    n: Floats,
    motion: Motion,
    law: tuple[float, Friction | None],
    surface: Floats,
    speed: float,
) -> list[Outcome]:
    """What may follow when particle i hits a wall.

    matter, n, speed: see the module. motion: before. law: restitution and friction. surface: velocity of the wall
    there, (3,), length/time.
    """
    restitution, friction = law
    c = motion.velocity - surface + cross(matter.radii[i] * motion.spin, n)
    approach = c @ n
    normal = (1 + restitution) * approach * matter.masses[i]
    options = [(np.zeros(3), 1.0)]
    if friction is not None and matter.spheres.friction is not None:
        options = tangential_impulses(c - approach * n, normal, matter.inverse[i], matter.shape, friction, speed)
    return [
        Outcome(pushed(matter, i, motion, n, -normal * n + tangent), None, amplified) for tangent, amplified in options
    ]
