"""The state of hard particles, what is refused at the start, and the energies: of both algorithms alike.

Arguments that are the same throughout: model: `HardSpheres`. number: N, of the particles. spins: (N, 3) angular
velocities, or None of smooth particles. bonds: (N, 1 + slots), a row being the number of partners inside the well, then
the partners. Units: any consistent set.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.events.model import AMPLITUDE, FREQUENCY, TEMPERATURE, VELOCITY, Floats, HardSpheres, Well

#: |r^2 - s^2|/s^2 of a pair whose distance r was made equal to s: a generous bound in boxes of up to 1e4 diameters.
NEAR = 1e-9
#: The same where the rounding of positions is larger: so many sides of the box, over the diameter.
NEAR_IN_BOX = 2.0**-44
#: A few particles in a box of a few diameters would renew their clock, with all predictions, every few hundred events.
#: Contacts to 2e-13 diameters are enough there: with fewer particles than FEW, a box counts as larger in proportion, up
#: to so many diameters.
FEW, SMALL_BOX = 128, 64.0
#: Two events are at one time if they are nearer than this, in times to cross the box: clocks are rounded to an eighth.
SIMULTANEOUS = 2.0**-46
#: Overlap of two particles at the start, in diameters, that passes as rounding of the input.
TOLERANCE = 1e-9


class Simultaneous(NamedTuple):
    """Events that rounding cannot tell apart in time, and that share a particle: the order of particles decides.

    number: of events in which a particle takes part that has had another event, with another partner, at the same time
    (within `SIMULTANEOUS` times `time_to_cross`). first: time of the first of these; NaN for none.
    """

    number: int
    first: float


class State(NamedTuple):
    """The state of N particles in d dimensions at one time.

    time: since the start. positions: (N, d), not wrapped into the box. velocities: (N, d). angular_velocities: (N, 1)
    in two dimensions, (N, 3) in three, or None of smooth particles.
    """

    time: float
    positions: Floats
    velocities: Floats
    angular_velocities: Floats | None


# -- sizes, masses, energies -----------------------------------------------------------------------


def radii_of(model: HardSpheres, number: int) -> Floats:
    """(N,) radii."""
    return np.full(number, model.diameter / 2) if model.radii is None else model.radii


def masses_of(model: HardSpheres, number: int) -> Floats:
    """(N,) masses; 0 for fixed particles: they have no kinetic energy."""
    inverse = model.inverse_masses
    if inverse is None:
        return np.full(number, model.mass)
    return np.where(inverse > 0, 1.0 / np.where(inverse > 0, inverse, 1.0), 0.0)


def rotational_energies(model: HardSpheres, spins: Floats | None, number: int) -> Floats:
    """(N,) I w^2/2, I = q m R^2."""
    if spins is None or model.rough is None:
        return np.zeros(number)
    inertia = model.rough.inertia * masses_of(model, number) * radii_of(model, number) ** 2
    energies: Floats = 0.5 * inertia * np.sum(spins**2, axis=1)
    return energies


def kinetic_energies(model: HardSpheres, state: State) -> Floats:
    """(N,) translational and rotational energy in a state."""
    number = len(state.velocities)
    translation: Floats = 0.5 * masses_of(model, number) * np.sum(state.velocities**2, axis=1)
    return translation + rotational_energies(model, state.angular_velocities, number)


def field_energy(model: HardSpheres, positions: Floats) -> float:
    """-sum m g.x, positions (N, d) not wrapped into the box."""
    if model.acceleration is None:
        return 0.0
    return -float(masses_of(model, len(positions)) @ positions @ np.array(model.acceleration))


def well_energy(model: HardSpheres, bonds: NDArray[np.int32] | None) -> float:
    """-depth for each pair inside its well."""
    return 0.0 if model.well is None or bonds is None else -0.5 * model.well.depth * float(bonds[:, 0].sum())


# -- rounding --------------------------------------------------------------------------------------


def nearness(model: HardSpheres) -> float:
    """|r^2 - s^2|/s^2 below which rounding may hide whether a pair at the distance r is at its contact, or edge, s."""
    return NEAR + NEAR_IN_BOX * max(model.lengths) / model.diameter if model.diameter > 0 else NEAR


def time_to_cross(model: HardSpheres, velocities: Floats) -> float:
    """Longest side of the box over a typical speed: over so long a time, rounding of time and of positions are alike.

    A small box with few particles counts as a larger one, see `SMALL_BOX`.
    The speed is the root mean square of the velocities (N, d or more components) of mobile particles, of those of the
    walls, and of what fields, wells and warm walls can give. Infinite where nothing moves.
    """
    squares = np.sum(velocities**2, axis=1)
    if model.inverse_masses is not None and model.inverse_masses.any():
        squares = squares[model.inverse_masses > 0]
    square = float(np.mean(squares))
    length = max(model.lengths)
    if model.acceleration is not None:
        square += 2.0 * length * math.hypot(*model.acceleration)
    square += _square_given(model)
    counted = max(length, min(SMALL_BOX * model.diameter, length * FEW / len(velocities)))
    return counted / math.sqrt(square) if square > 0 else math.inf


def _square_given(model: HardSpheres) -> float:
    """Square of the speed that wells, moving walls and warm walls give."""
    lightest = 1.0 / model.mass if model.inverse_masses is None else float(model.inverse_masses.max())
    square = 0.0 if model.well is None else 4.0 * abs(model.well.depth) * lightest
    if model.walls is not None:
        numbers = model.walls.numbers
        square += float(
            np.max(
                numbers[:, VELOCITY] ** 2
                + (numbers[:, AMPLITUDE] * numbers[:, FREQUENCY]) ** 2
                + numbers[:, TEMPERATURE] * lightest
            )
        )
    return square


def shortest_time(model: HardSpheres, velocities: Floats, crossing: float) -> float:
    """Two collisions of a particle that are nearer in time than this are one instant.

    velocities: (N, d or more components). crossing: their `time_to_cross`. Particles that creep may soon be as
    fast as walls and wells make them, before this is asked again.
    """
    speed = math.sqrt(rms_speed(velocities) ** 2 + _square_given(model))
    size = model.diameter or max(model.lengths)
    times = [size / speed] if speed > 0 else []
    if model.acceleration is not None and any(model.acceleration):
        times.append(math.sqrt(size / math.hypot(*model.acceleration)))
    # not below the rounding of the clock, in boxes of more than 1e5 diameters
    return max(2.0**-33 * min(times, default=0.0), SIMULTANEOUS * crossing if crossing < math.inf else 0.0)


def rms_speed(velocities: Floats) -> float:
    """Root mean square; velocities: (N, d or more components)."""
    return float(np.sqrt(np.mean(np.sum(velocities**2, axis=1))))


def collapse(one: int, other: int, time: float) -> str:
    """What a run says that an inelastic collapse ended.

    one, other: the particles, or a negative number for a wall. time: of the last collision.
    """
    who = f"particles {one} and {other}" if other >= 0 else f"particle {one} with a wall"
    return f"inelastic collapse of {who} at t = {float(time)!r}"


def two_sum(high: float, low: float, more: float) -> tuple[float, float]:
    """(high + low) + more as a sum of two: the first is rounded, the second what it lacks.

    D. E. Knuth, The Art of Computer Programming, vol. 2, 4.2.2. high, low, more: in any unit.
    """
    more += low
    total = high + more
    part = total - high
    return total, (high - (total - part)) + (more - part)


# -- the start -------------------------------------------------------------------------------------


def check_state(model: HardSpheres, x: Floats, v: Floats) -> int:
    """Number of particles at the positions x, (N, d), with velocities v, (N, d).

    Raises ValueError that names the first particle that is not finite, of infinite mass and not at rest, or outside a
    wall, and for arrays of the wrong shape.
    """
    n, d = len(x), len(model.lengths)
    if n == 0:
        raise ValueError("there are no particles")
    for name, values in (("positions", x), ("velocities", v)):
        if values.shape != (n, d):
            raise ValueError(f"{name}: shape {values.shape} for {n} particles in {d} dimensions")
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}] is not finite: {values[bad[0]]}")
    for name, given in (("diameters", model.radii), ("masses", model.inverse_masses)):
        if given is not None and len(given) != n:
            raise ValueError(f"{name}: {len(given)} values for {n} particles")
    if model.inverse_masses is not None:
        moving = np.flatnonzero((model.inverse_masses == 0) & (v != 0).any(axis=1))
        if moving.size:
            raise ValueError(f"velocities[{moving[0]}]: a particle of infinite mass stays at rest")
    radii = radii_of(model, n)
    slack = TOLERANCE * (model.diameter or 1.0)
    if model.walls is not None:
        for face in np.flatnonzero(model.walls.present):
            axis, far = divmod(int(face), 2)
            room = (model.lengths[axis] - x[:, axis] if far else x[:, axis]) - radii
            _, _, amplitude, _, phase, *_ = model.walls.numbers[face]
            outside = np.flatnonzero(room - amplitude * math.cos(phase) < -slack)
            if outside.size:
                raise ValueError(f"particle {outside[0]} at {x[outside[0]]} is beyond the wall of face {face}")
    if model.cylinder is not None:
        middle = np.array([model.lengths[model.cylinder.first], model.lengths[model.cylinder.second]]) / 2
        away = np.linalg.norm(x[:, [model.cylinder.first, model.cylinder.second]] - middle, axis=1)
        outside = np.flatnonzero(away + radii > model.cylinder.radius + slack)
        if outside.size:
            raise ValueError(f"particle {outside[0]} at {x[outside[0]]} is beyond the cylinder")
    return n


def spins_of(given: ArrayLike | None, n: int, d: int) -> Floats:
    """Angular velocities (N, 3) from those given: (n, 1) in d = 2, (n, 3) in d = 3; zeros for None.

    Raises ValueError for another shape, and for what is not finite.
    """
    spins = np.zeros((n, 3))
    if given is not None:
        values = np.array(given, dtype=np.float64)
        if values.shape != (n, 1 if d == 2 else 3) or not np.isfinite(values).all():
            raise ValueError(f"angular_velocities: finite, of shape ({n}, {1 if d == 2 else 3}); got {values.shape}")
        spins[:, 2 if d == 2 else 0 :] = values
    return spins


def bonds_of(model: HardSpheres, well: Well, positions: Floats) -> NDArray[np.int32]:
    """(N, N + 1) partners inside each particle's well, from all pairs of the positions (N, d)."""
    n, d = positions.shape
    bonds = np.zeros((n, n + 1), np.int32)
    radii = radii_of(model, n)
    for i in range(n):
        gaps = positions - positions[i]
        for k in range(d):
            if model.periodic[k]:
                gaps[:, k] -= model.lengths[k] * np.round(gaps[:, k] / model.lengths[k])
        inside = np.sum(gaps**2, axis=1) < (well.range * (radii + radii[i])) ** 2
        inside[i] = False
        partners = np.flatnonzero(inside)
        bonds[i, 0], bonds[i, 1 : 1 + partners.size] = partners.size, partners
    return bonds
