"""Grains at rest in their contact with a floor, pushed or spun: they slide, then roll.

Literature: R. Garg, J. Galvin, T. Li and S. Pannala, Powder Technol. 220, 122 (2012).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.checks.base import Check, Laboratory, Variant, soft
from crosscheck.checks.granular.soft_grains import CONTACTS, contact_needs, soft_needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.hertz_mindlin import Material, Pressed, overlap_under
from crosscheck.references.rolling import SlideToRoll
from crosscheck.scene import Box, Contact, Face, Friction, GrainFriction, HardSpheres, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, round_off, worst

Floats = NDArray[np.float64]

#: Velocities v_0 and R omega_0 along the direction of motion: without spin, spun only, with backspin, with topspin.
STARTS = ((1.0, 0.0), (0.0, -0.8), (0.7, -0.3), (0.5, 1.1))
#: Coefficient of friction, and the field; masses are 1, radii 1/2.
_MU, _G, _RADIUS = 0.4, 1.0, 0.5
#: Stiffness of a linear contact: the floor yields by 1e-5.
_STIFFNESS = 1e5
_DT, _STEPS, _EVERY = 2e-4, 6000, 25
#: Distance of the grains, and side of the box.
_APART, _SIDE = 5.0, 25.0
#: A floor of glass-like hardness in these units, for Hertz and Mindlin: the grain sinks by 3e-5.
_MATERIAL = Material(1e7, 0.3)


class _Floor(NamedTuple):
    """A kind of contact in `dimension` dimensions; name: of the variant.

    contact: entries of `scene.Contact`. stiffness, damping: k_t/m and gamma_t of the resting contact. overlap: at rest,
    length. mapped: the contact follows from restitution and friction of the scene, else it has coefficients of its own.
    """

    name: str
    dimension: int
    contact: dict[str, Any]
    stiffness: float
    damping: float
    overlap: float
    mapped: bool = False


def _own(name: str, dimension: int) -> _Floor:
    k_t, damping = 2 / 7 * _STIFFNESS, 50.0
    own = {"k_n": _STIFFNESS, "k_t": k_t, "gamma_n": 30.0, "gamma_t": damping, "mu": _MU}
    return _Floor(name, dimension, own, k_t, damping, _G / _STIFFNESS)


def _mapped(name: str, dimension: int, q: float) -> _Floor:
    # the tangential spring of alpha_t = 0, alpha = 1/2: a quarter of its period lasts half a contact
    k_t = _STIFFNESS * q / (1 + q) * (math.pi / 2) ** 2 / (math.pi**2 + math.log(0.5) ** 2)
    return _Floor(name, dimension, {"stiffness": _STIFFNESS}, k_t, 0.0, _G / _STIFFNESS, mapped=True)


def _material(name: str) -> _Floor:
    pressed = Pressed(_MATERIAL, _RADIUS, overlap_under(_G, _MATERIAL, _RADIUS))
    rate = 1e4
    contact = {
        "law": "hertz",
        "E": _MATERIAL.young,
        "nu": _MATERIAL.poisson,
        "gamma_n": rate,
        "gamma_t": rate,
        "mu": _MU,
    }
    return _Floor(name, 3, contact, pressed.tangential_stiffness, rate * pressed.circle, pressed.overlap)


FLOORS = (_own("2d", 2), _own("3d", 3), _mapped("3d-restitution", 3, 0.4), _material("3d-hertz-mindlin"))


class _Grains(NamedTuple):
    """Grains on one face: the scene, their directions of motion (N, 3), the normal (3,), and what each shall do."""

    scene: Scene
    directions: Floats
    normal: Floats
    expected: tuple[SlideToRoll, ...]


def _on_face(floor: _Floor, axis: int, upper: int) -> _Grains:
    """Grains on the lower or upper face of an axis, pressed against it, with motions of both signs along each axis."""
    d, q = floor.dimension, 0.5 if floor.dimension == 2 else 0.4
    normal = np.zeros(3)
    normal[axis] = -1.0 if upper else 1.0
    along = [np.eye(3)[k] for k in range(d) if k != axis]
    kinds = [(sign * vector, start) for vector in along for sign in (1.0, -1.0) for start in STARTS]
    if d == 3:
        kinds.append(((along[0] - 2 * along[1]) / math.sqrt(5), STARTS[0]))
    directions = np.array([direction for direction, _ in kinds])
    # in lines along the first axis of the face; in the plane, those that run towards another one are far enough
    places = np.full((len(kinds), 3), _SIDE / 2)
    lines = [k for k in range(d) if k != axis]
    for n in range(len(kinds)):
        places[n, lines[0]] = _APART * (n % 5 if d == 3 else n)
        if d == 3:
            places[n, lines[1]] = _APART * (n // 5)
    height = _RADIUS - floor.overlap
    places[:, axis] = _SIDE - height if upper else height
    speeds = np.array([start for _, start in kinds])
    spins = np.cross(normal, directions) * (speeds[:, 1] / _RADIUS)[:, None]
    limit = _MU if floor.mapped else None
    alpha, alpha_t = (0.5, 0.0) if floor.mapped else (1.0, -1.0)
    friction = Friction(tangential_restitution=alpha_t, static=limit, sliding=limit)
    face, other = f"{'xyz'[axis]}{'-+'[upper]}", f"{'xyz'[axis]}{'-+'[1 - upper]}"
    scene = Scene(
        name="slide-to-roll",
        dimension=d,  # type: ignore[arg-type]
        duration=_DT * _STEPS,
        acceleration=tuple((-_G * normal[:d]).tolist()),
        hard_spheres=HardSpheres(
            restitution=alpha, friction=GrainFriction(tangential_restitution=alpha_t, static=limit, sliding=limit)
        ),
        box=Box(
            lengths=(_SIDE,) * d,
            boundaries=tuple("hard" if k == axis else "open" for k in range(d)),
            faces={face: Face(restitution=alpha, friction=friction), other: Face(open=True)},
        ),
        initial=explicit(
            places[:, :d], (speeds[:, :1] * directions)[:, :d], spins[:, 2:] if d == 2 else spins
        ),
        output=Output(interval=_DT * _EVERY, trajectory=True, observables=("rotational_energy",)),
    )  # fmt: skip
    expected = tuple(
        SlideToRoll(v, s, _MU, _G, q, floor.stiffness, floor.damping) for _, (v, s) in kinds
    )  # fmt: skip
    return _Grains(scene, directions, normal, expected)


class _Errors(NamedTuple):
    """Largest errors of a run: of velocities and R omega, and of the energy of a grain; and what left its height."""

    motion: float
    energy: float
    strays: float


def _errors(grains: _Grains, floor: _Floor, run: Run) -> _Errors:
    d, times = floor.dimension, run["time"]
    moved = np.zeros((2, times.size, len(grains.expected), 3))
    moved[0, :, :, :d] = run["velocities"]
    moved[1, :, :, 2 if d == 2 else 0 :] = _RADIUS * run["angular_velocities"]
    wanted = np.zeros_like(moved)
    rolling = np.cross(grains.normal, grains.directions)
    for n, one in enumerate(grains.expected):
        v, s = one.motion(times)
        wanted[0, :, n], wanted[1, :, n] = v[:, None] * grains.directions[n], s[:, None] * rolling[n]
    q = grains.expected[0].inertia
    energies = 0.5 * (wanted[0] ** 2).sum(axis=(1, 2)) + 0.5 * q * (wanted[1] ** 2).sum(axis=(1, 2))
    found = 0.5 * (run["velocities"] ** 2).sum(axis=(1, 2)) + run["rotational_energy"]
    kept = abs(run["positions"] @ grains.normal[:d] - run["positions"][0] @ grains.normal[:d])
    return _Errors(
        float(abs(moved - wanted).max()),
        float(abs(found - energies).max()) / len(grains.expected),
        float(kept.max()),
    )


def _tolerance(one: SlideToRoll) -> float:
    """Of velocities: the time step, and the start, at which the spring is not yet stretched to the limit."""
    w = math.sqrt((1 + 1 / one.inertia) * one.stiffness)
    swung = max(_DT * _STEPS - one.time, 0.0)
    fading = 0.5 * (1 + 1 / one.inertia) * one.damping
    # the phase of the swing lags by (w dt)^2/24 of itself; with damping it has faded after some 1/fading
    phase = w * (min(swung, 1 / fading) if fading > 0 else swung)
    lag = (w * _DT) ** 2 / 24 * phase + fading * _DT
    stretched = one.friction * one.weight / (one.stiffness * abs(one.velocity - one.rolling))
    return one.slowing * (2 * _DT + stretched + lag / w)


def _judge(laboratory: Laboratory, floor: _Floor) -> Judged:
    method = soft(**floor.contact).model_copy(update={"dt": _DT})
    errors: list[_Errors] = []
    curves: list[Series] = []
    tolerance, dissipation = 0.0, 0.0
    for axis in range(floor.dimension):
        for upper in (0, 1):
            grains = _on_face(floor, axis, upper)
            run = laboratory.run(grains.scene, method)
            errors.append(_errors(grains, floor, run))
            tolerance = max(_tolerance(one) for one in grains.expected)
            dissipation = float(np.mean([one.dissipated for one in grains.expected]))
            if not curves:
                curves = _curves(grains, floor, run)
    largest = _Errors(*(max(column) for column in zip(*errors, strict=True)))
    fastest = max(abs(v) + abs(s) for v, s in STARTS)
    judgements = [
        bounded(
            "largest error of v and R omega", largest.motion, tolerance,
            "two steps of slowing (start and end of sliding), the stretching of the spring at the start, and the phase "
            "of its swing",
        ),
        bounded(
            "largest error of the energy of a grain, with rotation", largest.energy, 2 * fastest * tolerance,
            "m v dv of velocities within their tolerance",
        ),
        round_off(
            "grains that rest in their contact: largest change of height", largest.strays,
            4 * math.sqrt(_STEPS) * EPSILON * _SIDE,
            "a coordinate is rounded at every step, a random walk",
        ),
    ]  # fmt: skip
    first = SlideToRoll(*STARTS[0], _MU, _G, 0.5 if floor.dimension == 2 else 0.4)
    note = (
        f"{2 * floor.dimension} faces, {len(grains.expected)} grains on each; from v_0 = 1 without spin to "
        f"{first.end:.4f} at t = {first.time:.4f}; {dissipation:.4f} of energy a grain dissipated in the mean"
    )
    figure = Figure("sliding, then rolling", "time", "velocity along the floor", series=tuple(curves))
    return worst(judgements, note, (figure,))


def _curves(grains: _Grains, floor: _Floor, run: Run) -> list[Series]:
    """v and R omega of the first grain, and what is expected of them."""
    times, thin = run["time"], slice(None, None, 4)
    v, s = grains.expected[0].motion(times)
    rolling = np.cross(grains.normal, grains.directions[0])
    spin = _RADIUS * run["angular_velocities"][:, 0] @ rolling[2 if floor.dimension == 2 else 0 :]
    moved = run["velocities"][:, 0] @ grains.directions[0][: floor.dimension]
    x = times[thin].tolist()
    return [
        Series(f"{floor.name}, v", x, moved[thin].tolist()),
        Series(f"{floor.name}, R omega", x, spin[thin].tolist()),
        Series(f"{floor.name}, v, closed form", x, v[thin].tolist(), theory=True),
        Series(f"{floor.name}, R omega, closed form", x, s[thin].tolist(), theory=True),
    ]


CHECKS = (
    Check(
        name="granular/slide-to-roll",
        title="A grain at rest in its contact slides along the floor, then rolls",
        equation="v = v_0 - mu g t, R omega = (mu g/q) t; rolling at v_0/(1 + q) after t = v_0 q/((1 + q) mu g)",
        criterion="v, R omega and the energy on every face, in every direction, against the closed form",
        citation="Coriolis, Theorie mathematique des effets du jeu de billard (1835); "
        "Garg et al., Powder Technol. 220, 122 (2012)",
        judge=_judge,
        variants=tuple(  # rough disks of the quick tier are those of the audit, which compiles nothing
            Variant(
                floor.name,
                floor,
                "full" if floor.dimension == 2 else "quick",
                contact_needs(Contact(**floor.contact)),
            )
            for floor in FLOORS
        ),
        needs=soft_needs(
            "hard_spheres.friction box.faces box.faces.friction box.faces.open box.boundaries=hard "
            "box.boundaries=open acceleration",
            "positions velocities angular_velocities rotational_energy",
        ),
        faults=(
            (
                "2d",
                Fault(
                    "short-arm-at-walls",
                    CONTACTS,
                    "_add_torque(d, spins, a, i, inverse_inertias[i] * radii[i], _cross(n, f))",
                    "_add_torque(d, spins, a, i, 0.99 * inverse_inertias[i] * radii[i], _cross(n, f))",
                    "the torque of friction at a wall has an arm of 99 % of the radius",
                ),
            ),
            (
                "3d",
                Fault(
                    "spin-about-y-turned-round",
                    CONTACTS,
                    "a[i + 1] -= share * twist[1]",
                    "a[i + 1] += share * twist[1]",
                    "the torque about the axis y has the wrong sign",
                ),
            ),
        ),
    ),
)
