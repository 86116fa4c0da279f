"""WHAT the hard particles are: sizes, masses, collision laws, walls. A feature that is absent is `None`.

numba specialises the event loop by these types: without rotation there are no angular velocities; without a field, no
gravity term; with one size, no array of radii. Units: any consistent set, such as particle diameters, masses and
thermal velocities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]

#: Motions of a wall, as `PlaneWalls.motion` holds them.
STEADY, UNIFORM_PHASE, FLUX_PHASE, OSCILLATING, THERMAL = range(5)

#: Columns of `PlaneWalls.numbers`.
RESTITUTION, VELOCITY, AMPLITUDE, FREQUENCY, PHASE, TEMPERATURE, TANGENTIAL, STATIC, SLIDING = range(9)


class Friction(NamedTuple):
    """The tangential law of a contact, of O. R. Walton, in Particulate Two-Phase Flow (ed. M. C. Roco), 884 (1993).

    tangential_restitution: alpha_t in [-1, 1], v'_ct = alpha_t v_ct while sticking: +1 is smooth, -1 perfectly rough
    (the opposite sign of the common beta). static, sliding: coefficients of friction mu_s >= mu_k >= 0: where the
    tangential impulse of sticking exceeds mu_s times the normal one, it is mu_k times the normal one. inertia: q in
    I = q m R^2; None is that of a homogeneous sphere, 2/5, or disk, 1/2; walls have none. All without dimension.
    """

    tangential_restitution: float = 1.0
    static: float = math.inf
    sliding: float = math.inf
    inertia: float | None = None


class Well(NamedTuple):
    """Square well: the energy of a pair is -depth while the centres are closer than `range` contact distances.

    depth: energy; negative for a square shoulder. range: above 1, in contact distances R_i + R_j.
    """

    depth: float
    range: float


class RandomPhase(NamedTuple):
    """Limit of a fast, small oscillation: the wall stays in its place and has velocity speed * cos(phase).

    speed: largest velocity of the wall. law: how the phase is drawn: "uniform", every phase alike; "flux", in
    proportion to the relative speed of approach, as a steady stream of grains would meet it.
    """

    speed: float
    law: Literal["uniform", "flux"]


class Oscillation(NamedTuple):
    """The wall's displacement into the box, amplitude * cos(frequency * t + phase).

    amplitude: length. frequency: angular frequency, radians per time. phase: radians.
    """

    amplitude: float
    frequency: float
    phase: float = 0.0


class Face(NamedTuple):
    """One plane wall. At most one of velocity, random_phase, oscillation and temperature.

    restitution: of the normal velocity, in [0, 1]: it becomes (1 + restitution) V - restitution v_n, with V the wall's
    own velocity into the box. velocity: V is always this (the limit of a sawtooth). random_phase, oscillation: V is
    that of a random phase, or that of the oscillation at the time. temperature: energy; v_n and v_t are drawn anew from
    the flux of a gas at rest at this temperature. friction: the tangential law, for particles with friction.
    """

    restitution: float = 1.0
    velocity: float = 0.0
    random_phase: RandomPhase | None = None
    oscillation: Oscillation | None = None
    temperature: float | None = None
    friction: Friction | None = None


class Cylinder(NamedTuple):
    """A circular wall about the middle of the box, or a cylinder along an axis: a drum or a pipe.

    radius: length. axis: 0, 1 or 2; 2 in two dimensions. angular_velocity: of the wall about the axis, from the lower
    to the higher of the two other axes, radians per time. restitution: of the normal velocity, in [0, 1]. friction: the
    tangential law, for particles with friction.
    """

    radius: float
    axis: int = 2
    angular_velocity: float = 0.0
    restitution: float = 1.0
    friction: Friction | None = None


class Rough(NamedTuple):
    """`Friction` of the particles, checked: tangential_restitution, static, sliding; I = inertia m R^2."""

    tangential_restitution: float
    static: float
    sliding: float
    inertia: float


class PlaneWalls(NamedTuple):
    """Plane walls as arrays over the 2d faces x-, x+, y-, y+, ...

    present: (2d,) whether there is a wall. motion: (2d,) STEADY, UNIFORM_PHASE ... numbers: (2d, 9), columns
    RESTITUTION, VELOCITY ...; phases are those at the time base of the clock.
    """

    present: NDArray[np.bool_]
    motion: NDArray[np.int64]
    numbers: Floats


class CylinderWall(NamedTuple):
    """`Cylinder`, checked: radius, angular_velocity, restitution; its transverse axes `first` and `second`.

    tangential_restitution, static, sliding: of its `Friction`.
    """

    radius: float
    first: int
    second: int
    angular_velocity: float
    restitution: float
    tangential_restitution: float
    static: float
    sliding: float


class HardSpheres(NamedTuple):
    """What the event loop is specialised for; built by `hard_spheres`.

    lengths, periodic: (d,) box sides, and whether each axis is periodic. diameter: the contact distance of the largest
    pair. mass: of every particle, or 1. radii, inverse_masses: (N,), or None where all are alike; 0 for a fixed
    particle. restitution: normal; None is elastic. rough: friction and inertia. acceleration: of a uniform field, (d,).
    well: square well. walls, cylinder: what is there of them. contact_duration: t_c of the TC model. seed: uint64, of
    random walls. Absent features are None.
    """

    lengths: tuple[float, ...]
    periodic: tuple[bool, ...]
    diameter: float
    mass: float
    radii: Floats | None
    inverse_masses: Floats | None
    restitution: float | None
    rough: Rough | None
    acceleration: tuple[float, ...] | None
    well: Well | None
    walls: PlaneWalls | None
    cylinder: CylinderWall | None
    contact_duration: float | None
    seed: np.uint64 | None


def hard_spheres(
    *,
    lengths: Sequence[float],
    periodic: Sequence[bool],
    diameters: ArrayLike = 1.0,
    masses: ArrayLike = 1.0,
    restitution: float = 1.0,
    friction: Friction | None = None,
    acceleration: Sequence[float] | None = None,
    well: Well | None = None,
    faces: Sequence[Face | None] | None = None,
    cylinder: Cylinder | None = None,
    contact_duration: float | None = None,
    seed: int = 0,
) -> HardSpheres:
    """The model of hard disks (two lengths) or spheres (three) in the box [0, L) of each axis.

    lengths, periodic: (d,) box sides, and whether each axis is periodic. diameters, masses: of all, or (N,); an
    infinite mass is a fixed scatterer. restitution: normal, in [0, 1]. friction: with rotation; None: smooth particles.
    acceleration: (d,) of a uniform field. well: square well about every particle. faces: one entry per face x-, x+, y-,
    y+, ...; None is no wall (periodic, or open). cylinder: a circular wall. contact_duration: t_c of the TC model, a
    time (S. Luding and S. McNamara, Granul. Matter 1, 113 (1998)): a grain that has collided less than t_c ago loses
    nothing. seed: of random walls, 0 <= seed < 2^64. Units: any consistent set.

    Raises ValueError that names the argument for a value out of range, a periodic box shorter than two contact ranges,
    walls on a periodic axis, and fixed particles in a field.
    """
    d = len(lengths)
    if d not in (2, 3):
        raise ValueError(f"lengths: hard particles move in 2 or 3 dimensions, got {d}")
    sizes, weights = np.asarray(diameters, dtype=np.float64), np.asarray(masses, dtype=np.float64)
    _refuse("diameters", sizes, ~(np.isfinite(sizes) & (sizes >= 0)), "not negative, and finite")
    _refuse("masses", weights, ~(weights > 0), "positive")
    _within("restitution", restitution, 0, 1)
    rough = None if friction is None else _rough(friction, d)
    largest, radii = _sizes(sizes)
    mass, inverse_masses = _masses(weights)
    field = None if acceleration is None or not any(acceleration) else tuple(map(float, acceleration))
    if field is not None and inverse_masses is not None and not inverse_masses.all():
        raise ValueError("acceleration: fixed particles (of infinite mass) do not fall: leave out one or the other")
    if contact_duration is not None and not contact_duration > 0:
        raise ValueError(f"contact_duration: must be positive, got {contact_duration}")
    walls = _walls(faces, d)
    circular = None if cylinder is None else _cylinder_wall(cylinder, d)
    if well is not None and not (well.range > 1 and math.isfinite(well.depth)):
        raise ValueError(f"well: the range must exceed 1 and the depth be finite, got {well}")
    reach = largest * (1.0 if well is None else well.range)
    for axis, (length, wraps) in enumerate(zip(lengths, periodic, strict=True)):
        if not length > 0:
            raise ValueError(f"lengths[{axis}]: must be positive, got {length}")
        if wraps and length < 2.0001 * reach:
            raise ValueError(
                f"lengths[{axis}] = {length}: a periodic box must be longer than two contact ranges, {2 * reach:g}"
            )
        if wraps and walls is not None and (walls.present[2 * axis] or walls.present[2 * axis + 1]):
            raise ValueError(f"faces: axis {axis} is periodic: it has no walls")
    random = walls is not None and bool((np.isin(walls.motion, (UNIFORM_PHASE, FLUX_PHASE, THERMAL))).any())
    return HardSpheres(
        tuple(map(float, lengths)), tuple(map(bool, periodic)), largest, mass, radii, inverse_masses,
        None if restitution == 1.0 else float(restitution), rough, field, well, walls, circular, contact_duration,
        np.uint64(seed) if random else None,
    )  # fmt: skip


def _sizes(sizes: Floats) -> tuple[float, Floats | None]:
    if sizes.size == 0:
        raise ValueError("diameters: there are no particles")
    same = sizes.ndim == 0 or bool((sizes == sizes.flat[0]).all())
    return float(sizes.max()), None if same else sizes / 2


def _masses(masses: Floats) -> tuple[float, Floats | None]:
    if masses.ndim == 0 or (masses == masses.flat[0]).all():
        return float(masses.flat[0]), None
    return 1.0, np.where(np.isinf(masses), 0.0, 1.0 / masses)


def _rough(friction: Friction, d: int) -> Rough:
    inertia = friction.inertia if friction.inertia is not None else (0.4 if d == 3 else 0.5)
    if not inertia > 0:
        raise ValueError(f"friction.inertia: must be positive, got {inertia}")
    return Rough(*_tangential(friction), float(inertia))


def _tangential(friction: Friction | None) -> tuple[float, float, float]:
    law = friction or Friction()
    _within("friction.tangential_restitution", law.tangential_restitution, -1, 1)
    if not 0 <= law.sliding <= law.static:
        raise ValueError(f"friction: must be 0 <= sliding <= static, got {law.sliding} and {law.static}")
    return float(law.tangential_restitution), float(law.static), float(law.sliding)


def _walls(faces: Sequence[Face | None] | None, d: int) -> PlaneWalls | None:
    if faces is None or all(face is None for face in faces):
        return None
    if len(faces) != 2 * d:
        raise ValueError(f"faces: {2 * d} entries in {d} dimensions, got {len(faces)}")
    present = np.array([face is not None for face in faces])
    motion, numbers = np.zeros(2 * d, np.int64), np.zeros((2 * d, 9))
    for index, face in enumerate(faces):
        if face is None:
            continue
        moves = [face.velocity != 0, face.random_phase is not None, face.oscillation is not None,
                 face.temperature is not None]  # fmt: skip
        if sum(moves) > 1:
            raise ValueError(f"faces[{index}]: one of velocity, random_phase, oscillation and temperature, not several")
        _within(f"faces[{index}].restitution", face.restitution, 0, 1)
        row = numbers[index]
        row[RESTITUTION], row[VELOCITY] = face.restitution, face.velocity
        row[TANGENTIAL], row[STATIC], row[SLIDING] = _tangential(face.friction)
        if face.random_phase is not None:
            motion[index] = UNIFORM_PHASE if face.random_phase.law == "uniform" else FLUX_PHASE
            row[VELOCITY] = face.random_phase.speed
        if face.oscillation is not None:
            motion[index] = OSCILLATING
            row[AMPLITUDE], row[FREQUENCY], row[PHASE] = face.oscillation
        if face.temperature is not None:
            motion[index], row[TEMPERATURE] = THERMAL, face.temperature
    if not np.isfinite(numbers[:, :STATIC]).all() or (numbers[:, [AMPLITUDE, TEMPERATURE]] < 0).any():
        raise ValueError("faces: amplitudes and temperatures must be finite and not negative")
    return PlaneWalls(present, motion, numbers)


def _cylinder_wall(cylinder: Cylinder, d: int) -> CylinderWall:
    if not cylinder.radius > 0:
        raise ValueError(f"cylinder.radius: must be positive, got {cylinder.radius}")
    _within("cylinder.restitution", cylinder.restitution, 0, 1)
    first, second = (0, 1) if d == 2 else tuple(axis for axis in range(3) if axis != cylinder.axis)
    law = _tangential(cylinder.friction)
    return CylinderWall(
        float(cylinder.radius), first, second, float(cylinder.angular_velocity), float(cylinder.restitution), *law
    )


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name}: must be in [{low}, {high}], got {value}")


def _refuse(name: str, values: Floats, wrong: NDArray[np.bool_], demand: str) -> None:
    if wrong.any():
        which = f"[{int(np.flatnonzero(wrong)[0])}]" if values.ndim else ""
        raise ValueError(f"{name}{which}: must be {demand}, got {values.flat[int(np.argmax(wrong))]}")
