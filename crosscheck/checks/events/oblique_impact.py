"""Oblique impacts of rough grains: from sticking to sliding."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references import granular as reference
from crosscheck.references.granular import Body
from crosscheck.scene import Floats, GrainFriction, HardSpheres, Scene, explicit
from crosscheck.verdict import Judged, round_off, worst

#: Pairs, one angle of impact each; distance between pairs, and times of contact and of the end.
PAIRS, APART, CONTACT, END = 60, 8.0, 0.5, 1.0
_ALPHA, _ALPHA_T, _STATIC, _SLIDING = 0.8, -0.5, 0.5, 0.3
_DIAMETERS = (1.0, 0.6)


class Pair(NamedTuple):
    """Two bodies that touch at the time `CONTACT`.

    bodies: with their velocities and spins before. species: index of each in the scene. normal: unit vector from the
    second to the first, (3,). touching: their centres at that time, (2, 3).
    """

    bodies: tuple[Body, Body]
    species: tuple[int, int]
    normal: Floats
    touching: Floats


def pairs_at_all_angles(dimension: int, seed: int) -> list[Pair]:
    """Pairs whose contact velocity, of size 1, comes at angles from 0 to 90 degrees to the normal.

    dimension: 2 or 3. seed: of the directions and spins.
    """
    rng = np.random.default_rng(seed)
    plane = np.array([1.0, 1.0, float(dimension == 3)])
    q, made = 0.4 if dimension == 3 else 0.5, []
    side = int(np.ceil(PAIRS ** (1 / dimension)))
    for k in range(PAIRS):
        angle = (k + 0.5) / PAIRS * np.pi / 2
        normal, other = (rng.normal(size=(2, 3))) * plane
        normal /= np.linalg.norm(normal)
        tangent = other - (other @ normal) * normal
        tangent /= np.linalg.norm(tangent)
        species = (k % 2, k // 2 % 2)
        radii = [_DIAMETERS[one] / 2 for one in species]
        spins = rng.normal(size=(2, 3)) * (1 - plane if dimension == 2 else 1)
        masses = rng.uniform(0.5, 2.0, 2)
        slow = 0.1 * rng.normal(size=3) * plane
        fast = slow + np.sin(angle) * tangent - np.cos(angle) * normal
        fast += np.cross(radii[0] * spins[0] + radii[1] * spins[1], normal)
        place = APART * np.array([k % side, k // side % side, k // side**2]) * plane
        bodies = tuple(
            Body(float(mass), radius, velocity, spin, q)
            for mass, radius, velocity, spin in zip(masses, radii, (fast, slow), spins, strict=True)
        )
        touching = np.array([place + sum(radii) * normal, place])
        made.append(Pair((bodies[0], bodies[1]), species, normal, touching))
    return made


def _impacts(pairs: list[Pair], dimension: int) -> Scene:
    bodies = [body for pair in pairs for body in pair.bodies]
    velocities = np.array([body.velocity for body in bodies])
    places = np.concatenate([pair.touching for pair in pairs]) - CONTACT * velocities
    spins = np.array([body.spin for body in bodies])
    return Scene(
        name="oblique-impacts",
        dimension=dimension,  # type: ignore[arg-type]
        duration=END,
        masses=tuple(body.mass for body in bodies),
        species=tuple(one for pair in pairs for one in pair.species),
        hard_spheres=HardSpheres(
            diameter=_DIAMETERS,
            restitution=_ALPHA,
            friction=GrainFriction(tangential_restitution=_ALPHA_T, static=_STATIC, sliding=_SLIDING),
        ),
        initial=explicit(places[:, :dimension], velocities[:, :dimension], spins[:, 2:] if dimension == 2 else spins),
    )


def _spatial(rows: Floats, spin: bool = False) -> Floats:
    """(N, 1 | 2 | 3) as (N, 3); the one component of a spin is the third."""
    missing = 3 - rows.shape[1]
    return np.pad(rows, ((0, 0), (missing, 0) if spin else (0, missing)))


def _judge_oblique(laboratory: Laboratory, dimension: int) -> Judged:
    """Velocities and spins after each impact against the rule of impact, and each pair's conserved quantities."""
    pairs = pairs_at_all_angles(dimension, laboratory.seed())
    run = laboratory.run(_impacts(pairs, dimension), EVENT_DRIVEN)
    places, velocities = _spatial(run["final_positions"]), _spatial(run["final_velocities"])
    spins = _spatial(run["final_angular_velocities"], spin=True)
    errors, lost, sliding, points = [], [], 0, []
    for k, pair in enumerate(pairs):
        one, two = pair.bodies
        found = slice(2 * k, 2 * k + 2)
        expected = reference.impact(one, two, pair.normal, _ALPHA, _ALPHA_T, _STATIC, _SLIDING)
        sliding += expected.sliding
        after = [
            body._replace(velocity=v, spin=w)
            for body, v, w in zip(pair.bodies, velocities[found], spins[found], strict=True)
        ]
        radii = np.array([one.radius, two.radius])[:, None]
        # near grazing, a rounding of the place along the path is one of the normal times 1/cos
        graze = abs(reference.contact_velocity(one, two, pair.normal) @ pair.normal)
        errors += [graze * (velocities[found] - expected.velocities), graze * radii * (spins[found] - expected.spins)]
        before = pair.touching - CONTACT * np.array([one.velocity, two.velocity])
        lost.append(_moments(after, places[found]) - _moments([one, two], before))
        points.append(_impact_point(pair, after))
    size = float(np.ptp([pair.touching for pair in pairs]))
    # a rounding of the coordinates turns the normal of the smallest grains by so much
    turn = EPSILON * size / min(_DIAMETERS)
    scale = max(float(np.linalg.norm(body.velocity)) for pair in pairs for body in pair.bodies)
    like = round_off(
        "largest error of velocities and of R w, times the cosine of the angle of impact",
        float(abs(np.array(errors)).max()),
        16 * turn * scale,
        "rounding of the places at contact: it turns the normal, by which every component changes",
        figures=(_impact_figure(np.array(points).T, dimension),),
    )
    kept = round_off(
        "largest change of a pair's momentum or angular momentum",
        float(abs(np.array(lost)).max()),
        16 * EPSILON * (scale * size + scale),
        "rounding of m r x v, with r from the corner of the arrangement",
    )
    return worst([like, kept], f"{PAIRS} impacts, {sliding} of which slide")


def _moments(bodies: list[Body], places: Floats) -> Floats:
    """Momentum and angular momentum of two bodies, (6,)."""
    momenta = np.array([body.mass * body.velocity for body in bodies])
    turning = np.cross(places, momenta) + [body.inertia * body.spin for body in bodies]
    return np.concatenate([momenta.sum(axis=0), turning.sum(axis=0)])


def _impact_point(pair: Pair, after: list[Body]) -> tuple[float, float]:
    """Tangential over normal contact velocity: before, and along the same direction after."""
    before = reference.contact_velocity(*pair.bodies, pair.normal)
    normal = float(before @ pair.normal)
    slip = before - normal * pair.normal
    size = float(np.linalg.norm(slip))
    rebound = reference.contact_velocity(after[0], after[1], pair.normal)
    return size / -normal, float(rebound @ slip) / size / -normal


def _impact_figure(points: Floats, dimension: int) -> Figure:
    """Foerster's plot: sticking is a line through the origin, sliding one of slope 1."""
    q = 0.4 if dimension == 3 else 0.5
    limit = reference.sliding_limit(_ALPHA, _ALPHA_T, _STATIC, q)
    shown = points[:, points[0] < 4 * limit]
    slid = np.array([limit, 4 * limit])
    theory = (
        Series(f"{dimension}D, sticking", [0.0, limit], [0.0, _ALPHA_T * limit], theory=True),
        Series(
            f"{dimension}D, sliding", slid.tolist(), reference.sliding_slip(slid, _ALPHA, _SLIDING, q).tolist(),
            theory=True,
        ),
    )  # fmt: skip
    return Figure(
        "oblique impacts", "tangential / normal contact velocity before", "the same after", "linear", "linear",
        (Series(f"{dimension}D", shown[0].tolist(), shown[1].tolist()), *theory),
    )  # fmt: skip


CHECKS = (
    Check(
        name="events/oblique-impact",
        title="Oblique impacts of rough grains: from sticking to sliding",
        equation="J_n = (1 + alpha) mu |g_n|; |J_t| = (1 - alpha_t) q/(1 + q) mu |g_t|, or mu_k J_n if above mu_s J_n",
        criterion="each velocity and spin of 60 pairs of unlike sizes and masses, to rounding",
        citation="Walton, in Particulate Two-Phase Flow (1993); Foerster et al., Phys. Fluids 6, 1108 (1994)",
        judge=_judge_oblique,
        variants=full(**{"2d": 2, "3d": 3}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "hard_spheres.diameter[]",
                    "hard_spheres.friction",
                    "hard_spheres.friction.sliding",
                    "hard_spheres.friction.static",
                    "hard_spheres.restitution",
                    "masses[]",
                }
            ),
            observables=frozenset(),
        ),
        faults=(
            (
                "2d",
                Fault(
                    "coulomb-on-velocities",
                    "events/rules.py",
                    "if stick * slip > static * normal:",
                    "if (1.0 - alpha_t) * mass * slip > static * normal:",
                    "Coulomb's law compares the changes of the contact velocity, not the impulses",
                ),
            ),
        ),
    ),
)
