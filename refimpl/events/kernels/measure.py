"""Measurement at events: exact averages, event observables and hydrodynamic fields.

Every function does nothing, and compiles to nothing, where the record that it writes to is `None`.
"""

from typing import Any, NamedTuple

import numpy as np

from refimpl.events.kernels.compiled import inline_internal, kernel
from refimpl.events.model import Vector
from refimpl.events.prediction import contact_distance, field_along, radius_of

#: Entries of `Tallies.sums`.
(
    VIRIAL, DISSIPATED, ENERGY, ENERGY_TIME, FIELD_TIME, SINCE, WELLS, WELLS_TIME, HEIGHT, RISE, PULL, TORQUE, BEFORE,
    OTHER_BEFORE, DEEPEST, SPEED_BEFORE,
) = range(16)  # fmt: skip
#: Number of them: the speed before has three components.
SUMS = 18
#: Columns of `Tallies.walls` behind the three of the impulse.
WALL_ENERGY, WALL_COUNT = 3, 4


class Tallies(NamedTuple):
    """sums: see the names above. walls: (faces, 5) momentum given to the face, energy got from it, collisions.

    rests, wall_rests: what these sums lack by rounding, of the same shapes, so that they lose no digits however many
    events there are (Knuth, The Art of Computer Programming, vol. 2, 4.2.2; A. Neumaier, ZAMM 54, 39 (1974)).

    Between events the energy E = kinetic + rotational + field is constant, and so is that of the wells; the moment of
    the field, S = sum m g.x, is a parabola: dS/dt = RISE, d2S/dt2 = PULL. Hence int K dt = int E dt + int S dt exactly.
    """

    sums: Any
    walls: Any
    rests: Any
    wall_rests: Any


class Fields(NamedTuple):
    """Fields on a grid of `shape` cells, each of `blocks` cells of the event loop along an axis.

    Time integrals per cell: mass (C,), momentum (C, 3), kinetic (C,), rotational (C,). Through the lower face of a cell
    along each axis, positive upwards: flux_mass (3, C), flux_momentum (3, C, 3), flux_energy (3, C). Sums per cell:
    dissipation, collisions (C,), wall_momentum (C, 3) and wall_energy (C,) given by walls. since: (N,).
    """

    shape: Any
    blocks: Any
    sides: Any
    mass: Any
    momentum: Any
    kinetic: Any
    rotational: Any
    flux_mass: Any
    flux_momentum: Any
    flux_energy: Any
    dissipation: Any
    collisions: Any
    wall_momentum: Any
    wall_energy: Any
    since: Any
    ints: Any


@inline_internal
def _mass(mass: float, inverse_masses: Any, i: int) -> float:
    """m_i; 0 for a fixed particle, which has no energy to give."""
    if inverse_masses is None:
        return mass
    return 1.0 / inverse_masses[i] if inverse_masses[i] > 0.0 else 0.0


@inline_internal
def _rotational_energy(rough: Any, spins: Any, model: Any, i: int) -> float:
    """I w^2/2."""
    if rough is None or spins is None:
        return 0.0
    radius = radius_of(model.diameter, model.radii, i)
    inertia = rough.inertia * _mass(model.mass, model.inverse_masses, i) * radius * radius
    x, y, z = spins[i, 0], spins[i, 1], spins[i, 2]
    return 0.5 * inertia * (x * x + y * y + z * z)


@inline_internal
def _translational_energy(model: Any, rows: Any, i: int) -> float:
    """m v^2/2, of the state as it stands in the row."""
    mass = _mass(model.mass, model.inverse_masses, i)
    x, y, z = rows[i, 3], rows[i, 4], rows[i, 5]
    return 0.5 * mass * (x * x + y * y + z * z)


@inline_internal
def _lacking(high: float, more: float, total: float) -> float:
    """What `total`, the rounded high + more, lacks: exact."""
    part = total - high
    return (high - (total - part)) + (more - part)


@inline_internal
def _add(tallies: Any, entry: int, more: float) -> None:
    """Adds to a sum."""
    total = tallies.sums[entry] + more
    tallies.rests[entry] += _lacking(tallies.sums[entry], more, total)
    tallies.sums[entry] = total


@inline_internal
def _add_to_wall(tallies: Any, face: int, column: int, more: float) -> None:
    """Adds to a sum of a face."""
    total = tallies.walls[face, column] + more
    tallies.wall_rests[face, column] += _lacking(tallies.walls[face, column], more, total)
    tallies.walls[face, column] = total


@inline_internal
def _accumulate(tallies: Any, now: float) -> None:
    sums = tallies.sums
    s = now - sums[SINCE]
    _add(tallies, ENERGY_TIME, sums[ENERGY] * s)
    _add(tallies, WELLS_TIME, sums[WELLS] * s)
    _add(tallies, FIELD_TIME, -s * (sums[HEIGHT] + s * (0.5 * sums[RISE] + s * sums[PULL] / 6.0)))
    _add(tallies, HEIGHT, s * (sums[RISE] + 0.5 * s * sums[PULL]))
    _add(tallies, RISE, s * sums[PULL])
    sums[SINCE] = now


@kernel
def accumulate(tallies: Any, now: float) -> None:
    """Brings the time integrals to the present."""
    _accumulate(tallies, now)


# -- pairs -----------------------------------------------------------------------------------------


@inline_internal
def note_pair_before(tallies: Any, fields: Any, model: Any, rows: Any, spins: Any, i: int, j: int, now: float) -> None:
    """Before the velocities of a pair change; both states are at the present."""
    if tallies is not None:
        _accumulate(tallies, now)
        tallies.sums[BEFORE] = _translational_energy(model, rows, i) + _rotational_energy(model.rough, spins, model, i)
        tallies.sums[OTHER_BEFORE] = _translational_energy(model, rows, j) + _rotational_energy(
            model.rough, spins, model, j
        )
    _add_residence_if_measured(fields, model, rows, spins, i, now)
    _add_residence_if_measured(fields, model, rows, spins, j, now)


@inline_internal
def note_pair_after(
    tallies: Any, fields: Any, model: Any, rows: Any, spins: Any, i: int, j: int, n: Vector, distance: float,
    impulse: Vector,
) -> None:  # fmt: skip
    """After a collision that gave the momentum `impulse` to j; n is the normal."""
    if tallies is not None:
        sums = tallies.sums
        (x, y, z), (px, py, pz) = n, impulse
        lost_i = sums[BEFORE] - _translational_energy(model, rows, i) - _rotational_energy(model.rough, spins, model, i)
        lost_j = (
            sums[OTHER_BEFORE]
            - _translational_energy(model, rows, j)
            - _rotational_energy(model.rough, spins, model, j)
        )
        contact = contact_distance(model.diameter, model.radii, i, j)
        sums[DEEPEST] = max(sums[DEEPEST], (contact - distance) / contact)
        _add(tallies, VIRIAL, distance * (px * x + py * y + pz * z))
        _add(tallies, DISSIPATED, lost_i + lost_j)
        _add(tallies, ENERGY, -(lost_i + lost_j))
        _pair_fields(fields, model, rows, i, j, n, distance, impulse, (lost_i, lost_j), lost_i + lost_j, 1)


@inline_internal
def note_well(
    tallies: Any, fields: Any, model: Any, rows: Any, spins: Any, i: int, j: int, n: Vector, distance: float,
    impulse: float, bound: float,
) -> None:  # fmt: skip
    """After an event at the edge of a well; bound: energy by which the pair is bound more than before."""
    if tallies is not None:
        sums = tallies.sums
        lost_i = sums[BEFORE] - _translational_energy(model, rows, i) - _rotational_energy(model.rough, spins, model, i)
        lost_j = (
            sums[OTHER_BEFORE]
            - _translational_energy(model, rows, j)
            - _rotational_energy(model.rough, spins, model, j)
        )
        _add(tallies, VIRIAL, impulse * distance)
        _add(tallies, ENERGY, -(lost_i + lost_j))
        sums[WELLS] -= bound
        half = 0.5 * bound
        vector = (impulse * n[0], impulse * n[1], impulse * n[2])
        _pair_fields(fields, model, rows, i, j, n, distance, vector, (lost_i + half, lost_j + half), 0.0, 0)


# -- walls -----------------------------------------------------------------------------------------


@inline_internal
def note_wall_before(tallies: Any, fields: Any, model: Any, rows: Any, spins: Any, i: int, now: float) -> None:
    """Before a wall changes a particle's velocity; its state is at the present."""
    if tallies is not None:
        sums = tallies.sums
        _accumulate(tallies, now)
        sums[BEFORE] = _translational_energy(model, rows, i) + _rotational_energy(model.rough, spins, model, i)
        sums[SPEED_BEFORE] = rows[i, 3]
        sums[SPEED_BEFORE + 1] = rows[i, 4]
        sums[SPEED_BEFORE + 2] = rows[i, 5]
    _add_residence_if_measured(fields, model, rows, spins, i, now)


@inline_internal
def note_wall_after(tallies: Any, fields: Any, model: Any, rows: Any, spins: Any, i: int, face: int) -> None:
    """After a wall has changed a particle's velocity."""
    if tallies is not None:
        sums = tallies.sums
        mass = _mass(model.mass, model.inverse_masses, i)
        gained = _translational_energy(model, rows, i) + _rotational_energy(model.rough, spins, model, i) - sums[BEFORE]
        px = mass * (rows[i, 3] - sums[SPEED_BEFORE])
        py = mass * (rows[i, 4] - sums[SPEED_BEFORE + 1])
        pz = mass * (rows[i, 5] - sums[SPEED_BEFORE + 2])
        _add_to_wall(tallies, face, 0, -px)
        _add_to_wall(tallies, face, 1, -py)
        _add_to_wall(tallies, face, 2, -pz)
        _add_to_wall(tallies, face, WALL_ENERGY, gained)
        tallies.walls[face, WALL_COUNT] += 1.0
        _add(tallies, ENERGY, gained)
        _add(tallies, RISE, _along(model.acceleration, px, py, pz))
        _wall_fields(fields, i, px, py, pz, gained)


@inline_internal
def _along(acceleration: Any, px: float, py: float, pz: float) -> float:
    """g.p"""
    if acceleration is None:
        return 0.0
    total = acceleration[0] * px + acceleration[1] * py
    return total + acceleration[len(acceleration) - 1] * pz if len(acceleration) == 3 else total


@inline_internal
def note_cylinder(tallies: Any, model: Any, rows: Any, i: int, face: int) -> None:
    """Angular momentum about the axis that the drum gave to a particle, spin included: R x p is at the surface."""
    if tallies is not None:
        _torque(tallies, model.cylinder, model, rows, i, face)


@inline_internal
def _torque(tallies: Any, cylinder: Any, model: Any, rows: Any, i: int, face: int) -> None:
    if cylinder is not None:
        if face == 2 * len(model.lengths):
            sums = tallies.sums
            mass = _mass(model.mass, model.inverse_masses, i)
            first, second = cylinder.first, cylinder.second
            x, y = rows[i, first] - 0.5 * model.lengths[first], rows[i, second] - 0.5 * model.lengths[second]
            stretch = cylinder.radius / np.sqrt(x * x + y * y)
            px = mass * (rows[i, 3 + first] - sums[SPEED_BEFORE + first])
            py = mass * (rows[i, 3 + second] - sums[SPEED_BEFORE + second])
            _add(tallies, TORQUE, stretch * (x * py - y * px))


# -- fields ----------------------------------------------------------------------------------------


@inline_internal
def _block(fields: Any, i: int, axis: int) -> int:
    return fields.ints[i, 3 + axis] // fields.blocks[axis]


@inline_internal
def _place(fields: Any, i: int) -> int:
    """Index of the field cell that a particle is in."""
    shape = fields.shape
    return (_block(fields, i, 2) * shape[1] + _block(fields, i, 1)) * shape[0] + _block(fields, i, 0)


@inline_internal
def _add_residence(fields: Any, model: Any, rows: Any, spins: Any, i: int, now: float) -> None:
    """Adds the integrals of mass, momentum and energy of a particle over the time since this was last done."""
    mass = _mass(model.mass, model.inverse_masses, i)
    a, b = fields.since[i] - rows[i, 6], now - rows[i, 6]
    place = _place(fields, i)
    kinetic = 0.0
    for k in range(len(model.lengths)):
        v = rows[i, 3 + k]
        g = field_along(model.acceleration, k)
        fields.momentum[place, k] += mass * (v * (b - a) + 0.5 * g * (b * b - a * a))
        kinetic += v * v * (b - a) + v * g * (b * b - a * a) + g * g * (b * (b * b) - a * (a * a)) / 3.0
    fields.mass[place] += mass * (b - a)
    fields.kinetic[place] += 0.5 * mass * kinetic
    fields.rotational[place] += _rotational_energy(model.rough, spins, model, i) * (b - a)
    fields.since[i] = now


@inline_internal
def _add_residence_if_measured(fields: Any, model: Any, rows: Any, spins: Any, i: int, now: float) -> None:
    if fields is not None:
        _add_residence(fields, model, rows, spins, i, now)


@inline_internal
def note_crossing(fields: Any, model: Any, rows: Any, spins: Any, bonds: Any, i: int, face: int, now: float) -> None:
    """Before a particle passes a face of its cell: if it is a field's too, mass, momentum and energy go through it."""
    if fields is not None:
        axis, up = face >> 1, face & 1
        cell = fields.ints[i, 3 + axis]
        block = fields.blocks[axis]
        at_edge = (cell + 1) % block == 0 if up else cell % block == 0
        if at_edge:
            _add_residence(fields, model, rows, spins, i, now)
            sign = 1.0 if up else -1.0
            mass = _mass(model.mass, model.inverse_masses, i)
            s = now - rows[i, 6]
            energy = _rotational_energy(model.rough, spins, model, i) + _half_bond_energy(model.well, bonds, i)
            place = _face(fields, _place(fields, i), axis, up)
            fields.flux_mass[axis, place] += sign * mass
            for k in range(len(model.lengths)):
                v = rows[i, 3 + k] + field_along(model.acceleration, k) * s
                energy += 0.5 * mass * v * v
                fields.flux_momentum[axis, place, k] += sign * mass * v
            fields.flux_energy[axis, place] += sign * energy


@inline_internal
def _half_bond_energy(well: Any, bonds: Any, i: int) -> float:
    """A particle's half of the energy of its wells."""
    if well is None:
        return 0.0
    return -0.5 * well.depth * bonds[i, 0]


@inline_internal
def _face(fields: Any, place: int, axis: int, up: int) -> int:
    """The cell whose lower face is the upper (lower) face of the cell `place`."""
    if not up:
        return place
    shape = fields.shape
    stride = 1 if axis == 0 else (shape[0] if axis == 1 else shape[0] * shape[1])
    here = (place // stride) % shape[axis]
    return place + stride if here + 1 < shape[axis] else place - here * stride


@inline_internal
def _next(fields: Any, place: int, axis: int, up: int) -> int:
    """The next cell up (down) along an axis."""
    if up:
        return _face(fields, place, axis, 1)
    shape = fields.shape
    stride = 1 if axis == 0 else (shape[0] if axis == 1 else shape[0] * shape[1])
    here = (place // stride) % shape[axis]
    return place - stride if here > 0 else place + (shape[axis] - 1) * stride


@inline_internal
def _pair_fields(
    fields: Any, model: Any, rows: Any, i: int, j: int, n: Vector, distance: float, impulse: Vector,
    losses: tuple[float, float], lost: float, collision: int,
) -> None:  # fmt: skip
    """Momentum and energy go from i to j along the line of centres, through the faces that it crosses.

    Irving and Kirkwood, J. Chem. Phys. 18, 817 (1950). Each partner's cell bears half of what is dissipated.
    """
    if fields is not None:
        (x, y, z), (px, py, pz), (lost_i, lost_j) = n, impulse, losses
        here, there = _place(fields, i), _place(fields, j)
        fields.dissipation[here] += 0.5 * lost
        fields.dissipation[there] += 0.5 * lost
        fields.collisions[here] += 0.5 * collision
        fields.collisions[there] += 0.5 * collision
        energy = 0.5 * (lost_i - lost_j)
        place = here
        done = 0
        for _ in range(3):
            # of the axes along which the cells still differ, the face that the line meets first
            best, axis, up = 1e300, -1, 0
            for k in range(len(model.lengths)):
                if not (done >> k) & 1:
                    shape = fields.shape[k]
                    step = _block(fields, j, k) - _block(fields, i, k)
                    if step > 1 or (step == 1 and shape == 2 and _component_along(x, y, z, k) < 0.0):
                        step = -1
                    elif step < -1 or (step == -1 and shape == 2 and _component_along(x, y, z, k) > 0.0):
                        step = 1
                    if shape == 1 and model.periodic[k]:  # the next cell is an image of this one
                        end = rows[i, k] + distance * _component_along(x, y, z, k)
                        step = 1 if end >= fields.sides[k] else (-1 if end < 0.0 else 0)
                    if step != 0:
                        edge = (_block(fields, i, k) + (1 if step > 0 else 0)) * fields.sides[k]
                        along = (edge - rows[i, k]) / (distance * _component_along(x, y, z, k))
                        if along < best:
                            best, axis, up = along, k, 1 if step > 0 else 0
            if axis < 0:
                break
            done |= 1 << axis
            sign = 1.0 if up else -1.0
            through = _face(fields, place, axis, up)
            fields.flux_momentum[axis, through, 0] += sign * px
            fields.flux_momentum[axis, through, 1] += sign * py
            fields.flux_momentum[axis, through, 2] += sign * pz
            fields.flux_energy[axis, through] += sign * energy
            place = _next(fields, place, axis, up)


@inline_internal
def _component_along(x: float, y: float, z: float, axis: int) -> float:
    return x if axis == 0 else (y if axis == 1 else z)


@inline_internal
def _wall_fields(fields: Any, i: int, px: float, py: float, pz: float, gained: float) -> None:
    if fields is not None:
        place = _place(fields, i)
        fields.wall_momentum[place, 0] += px
        fields.wall_momentum[place, 1] += py
        fields.wall_momentum[place, 2] += pz
        fields.wall_energy[place] += gained


@kernel
def settle_fields(fields: Any, model: Any, rows: Any, spins: Any, now: float) -> None:
    """Brings the time integrals of every particle to the present."""
    for i in range(rows.shape[0]):
        _add_residence(fields, model, rows, spins, i, now)
