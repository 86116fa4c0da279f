"""Forces of soft grains on each other and on walls: every contact of the lists, plane walls and a cylinder.

Vectors have three components here, in tuples, which compiled code keeps in registers; grains in the plane have z = 0
and spin about z. Pairs are found first and computed afterwards: which of them touch is a branch that no processor
foretells, and it would keep the contacts from overlapping each other.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from refimpl.compilation import compiled
from refimpl.stepping.kernels.compiled import inline_internal, internal
from refimpl.stepping.kernels.contact_lists import (
    CLOSE_PAIRS,
    CONTACTS,
    EVALUATIONS,
    PAIR_TESTS,
    apart2,
    find_contacts,
    inverses,
    separation,
    update,
)

#: Places of the numbers in the row of a law.
STIFFNESS, DAMPING, TANGENTIAL_STIFFNESS, TANGENTIAL_DAMPING, FRICTION = range(5)
#: Places of the numbers in the row of a wall; its law follows.
AXIS, SIGN, PLACE, AMPLITUDE, FREQUENCY, PHASE, WALL_LAW = range(7)
#: Places of the numbers in the row of a cylinder; its law follows.
RADIUS, CENTRE_A, CENTRE_B, AXIS_A, AXIS_B, ANGULAR_VELOCITY, CYLINDER_LAW = range(7)
#: A stretch whose spring force along the normal is below this share of Coulomb's limit is not rotated, as in LAMMPS.
_SLIGHT = 1e-10
#: Coulomb coefficient that stands for no limit: no force of a contact reaches it.
NO_LIMIT = 1e100


class ContactModel(NamedTuple):
    """Which equations: see `refimpl.stepping.forces.grains`."""

    hertz: bool
    by_mass: bool
    history: bool
    granular: bool


# -- vectors -----------------------------------------------------------------------------------------------------------


@inline_internal
def _vector(dimension, values, i):  # type: ignore[no-untyped-def]
    """That of grain i, from one array of coordinates or velocities."""
    i = dimension * np.int64(i)
    z = 0.0
    if dimension == 3:
        z = values[i + 2]
    return values[i], values[i + 1], z


@inline_internal
def _minus(x: Any, y: Any) -> Any:
    return x[0] - y[0], x[1] - y[1], x[2] - y[2]


@inline_internal
def _less(x: Any, factor: float, y: Any) -> Any:
    """x - factor y."""
    return x[0] - factor * y[0], x[1] - factor * y[1], x[2] - factor * y[2]


@inline_internal
def _times(factor: float, x: Any) -> Any:
    return factor * x[0], factor * x[1], factor * x[2]


@inline_internal
def _product(x: Any, y: Any) -> float:
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


@inline_internal
def _length(x: Any) -> float:
    return np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])


@inline_internal
def _cross(x: Any, y: Any) -> Any:
    return x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]


@inline_internal
def _add(dimension, values, i, factor, x):  # type: ignore[no-untyped-def]
    """values of grain i += factor x."""
    i = dimension * np.int64(i)
    values[i] += factor * x[0]
    values[i + 1] += factor * x[1]
    if dimension == 3:
        values[i + 2] += factor * x[2]


# -- the law of a contact ----------------------------------------------------------------------------------------------


@inline_internal
def _numbers(row):  # type: ignore[no-untyped-def]
    """Those of a law, which no write to an array can change."""
    return row[STIFFNESS], row[DAMPING], row[TANGENTIAL_STIFFNESS], row[TANGENTIAL_DAMPING], row[FRICTION]


@inline_internal
def _scale(model: ContactModel, delta: float, radius: float) -> float:
    return np.sqrt(delta * radius) if model.hertz else 1.0


@inline_internal
def _damping(coefficient: float, law: Any, model: ContactModel, mass: float, scale: float) -> float:
    """eta, the force over the velocity."""
    if model.by_mass:
        return coefficient * mass * scale
    return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)


@inline_internal
def _normal_force(law: Any, model: ContactModel, delta: float, approach: float, mass: float, scale: float) -> float:
    """For the overlap delta and the normal velocity `approach`, which is negative when the grains come nearer."""
    return law[STIFFNESS] * scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach


@internal
def _tangential_force(law, model, mass, scale, normal, n, u, stretch, elapsed):  # type: ignore[no-untyped-def]
    """The force at the slip u, and the stretch after it has grown over the time `elapsed`."""
    limit = law[FRICTION] * abs(normal)
    damping = _damping(law[TANGENTIAL_DAMPING], law, model, mass, scale)
    if not model.history:
        slip = _length(u)
        share = min(limit, damping * slip) / slip if slip > 0.0 else 0.0
        return _times(-share, u), stretch
    stiffness = law[TANGENTIAL_STIFFNESS] * scale
    if elapsed != 0.0 and model.granular:
        before, along = _length(stretch), _product(stretch, n)
        slight = _SLIGHT * limit if law[FRICTION] < NO_LIMIT else 0.0
        if abs(along) * stiffness > slight:
            stretch = _less(stretch, along, n)
            after = _length(stretch)
            stretch = _times(before / after if after > 0.0 else 0.0, stretch)
    stretch = _less(stretch, -elapsed, u)
    stretched = _length(stretch) != 0.0
    if elapsed != 0.0 and not model.granular:
        stretch = _less(stretch, _product(stretch, n), n)
    f = _less(_times(-stiffness, stretch), damping, u)
    size = _length(f)
    if size > limit:
        f = _times(limit / size if stretched else 0.0, f)
        if stretched and stiffness > 0.0:
            stretch = _times(-1.0 / stiffness, _less(f, -damping, u))
    return f, stretch


@inline_internal
def _slip(n, g, approach, w):  # type: ignore[no-untyped-def]
    """u = g - (g.n) n - w x n, w the sum of the surfaces' R omega."""
    return _minus(_less(g, approach, n), _cross(w, n))


@inline_internal
def _surface(dimension, spins, v, i, radius):  # type: ignore[no-untyped-def]
    """R omega of grain i."""
    if dimension == 3:
        i = spins + 3 * np.int64(i)
        return radius * v[i], radius * v[i + 1], radius * v[i + 2]
    return 0.0, 0.0, radius * v[spins + np.int64(i)]


@inline_internal
def _add_torque(dimension, spins, a, i, share, twist):  # type: ignore[no-untyped-def]
    """Adds -share times the twist n x F to the angular acceleration of grain i."""
    if dimension == 3:
        i = spins + 3 * np.int64(i)
        a[i] -= share * twist[0]
        a[i + 1] -= share * twist[1]
        a[i + 2] -= share * twist[2]
    else:
        a[spins + np.int64(i)] -= share * twist[2]


# -- sums over contacts ------------------------------------------------------------------------------------------------


@inline_internal
def _keep(stretches, place, stretch):  # type: ignore[no-untyped-def]
    stretches[place, 0], stretches[place, 1], stretches[place, 2] = stretch


@internal
def _pairs(force, inverse_inertias, elapsed, r, v, a):  # type: ignore[no-untyped-def]
    """Adds the accelerations by all pairs that touch to `a`; returns their number and sum r_ij . F_ij."""
    lists, radii, inverse_masses, model = force.lists, force.radii, force.inverse_masses, force.model
    sides, close, law, bookkeeping = lists.sides, lists.close, _numbers(force.law), lists.bookkeeping
    d, spins, per_side = len(sides), len(sides) * len(radii), inverses(sides)
    before, now = (bookkeeping[EVALUATIONS] + 1) % 2, bookkeeping[EVALUATIONS] % 2
    old_places, old_stretches, places = lists.places[before], lists.stretches[before], lists.places[now]
    ends, stretches = lists.ends[now], lists.stretches[now]
    old, old_contacts = 0, bookkeeping[CONTACTS]
    contacts, virial = find_contacts(lists, r, places), 0.0
    for contact in range(contacts):
        i, j = close[places[contact], 0], close[places[contact], 1]
        apart = separation(sides, per_side, r, i, j)
        distance = _length(apart)
        n = _times(1.0 / distance, apart)
        g = _minus(_vector(d, v, i), _vector(d, v, j))
        approach = _product(g, n)
        delta = radii[i] + radii[j] - distance
        mass = 1.0 / (inverse_masses[i] + inverse_masses[j])
        scale = _scale(model, delta, radii[i] * radii[j] / (radii[i] + radii[j]))
        normal = _normal_force(law, model, delta, approach, mass, scale)
        virial += distance * normal
        total = _times(normal, n)
        if inverse_inertias is not None:
            while old < old_contacts and old_places[old] < places[contact]:
                old += 1
            stretch = (0.0, 0.0, 0.0)
            if old < old_contacts and old_places[old] == places[contact]:
                stretch = old_stretches[old, 0], old_stretches[old, 1], old_stretches[old, 2]
            w = _less(_surface(d, spins, v, i, radii[i]), -1.0, _surface(d, spins, v, j, radii[j]))
            u = _slip(n, g, approach, w)
            f, stretch = _tangential_force(law, model, mass, scale, normal, n, u, stretch, elapsed)
            ends[contact, 0], ends[contact, 1] = i, j
            _keep(stretches, contact, stretch)
            twist = _cross(n, f)
            shorter = 0.5 * delta if model.granular else 0.0
            _add_torque(d, spins, a, i, inverse_inertias[i] * (radii[i] - shorter), twist)
            _add_torque(d, spins, a, j, inverse_inertias[j] * (radii[j] - shorter), twist)
            total = _less(total, -1.0, f)
        _add(d, a, i, inverse_masses[i], total)
        _add(d, a, j, -inverse_masses[j], total)
    bookkeeping[CONTACTS] = contacts
    return contacts, virial


@inline_internal
def _on_wall(  # type: ignore[no-untyped-def]
    force, inverse_inertias, law, stretches, elapsed, i, delta, n, g, v, a, on_wall
):
    """Adds the acceleration of grain i by a wall to `a` and the force on the wall to `on_wall`; returns friction.

    law: the wall's row of numbers. stretches: (N, 3) of this wall. n: towards the grain. g: velocity of the grain from
    the wall.
    """
    radii, inverse_masses, model = force.radii, force.inverse_masses, force.model
    d = len(force.lists.sides)
    spins = d * len(radii)
    mass, approach = 1.0 / inverse_masses[i], _product(g, n)
    scale = _scale(model, delta, radii[i])
    normal = _normal_force(law, model, delta, approach, mass, scale)
    total, f = _times(normal, n), (0.0, 0.0, 0.0)
    if inverse_inertias is not None:
        u = _slip(n, g, approach, _surface(d, spins, v, i, radii[i]))
        before = stretches[i, 0], stretches[i, 1], stretches[i, 2]
        f, stretch = _tangential_force(law, model, mass, scale, normal, n, u, before, elapsed)
        _keep(stretches, i, stretch)
        _add_torque(d, spins, a, i, inverse_inertias[i] * radii[i], _cross(n, f))
        total = _less(total, -1.0, f)
    _add(d, a, i, inverse_masses[i], total)
    _add(d, on_wall, 0, -1.0, total)
    return f


@internal
def _motion(wall: Any, time: float) -> tuple[float, float]:
    """Place and velocity of a plane wall."""
    swing, angle = wall[SIGN] * wall[AMPLITUDE], wall[FREQUENCY] * time + wall[PHASE]
    return wall[PLACE] + swing * np.cos(angle), -swing * wall[FREQUENCY] * np.sin(angle)


@inline_internal
def _along(axis: int, x: float, other: int, y: float) -> Any:
    """The vector with the component x along one axis, and y along another one."""
    return (
        x * (axis == 0) + y * (other == 0),
        x * (axis == 1) + y * (other == 1),
        x * (axis == 2) + y * (other == 2),
    )


@internal
def _planes(force, inverse_inertias, elapsed, time, r, v, a, on_walls):  # type: ignore[no-untyped-def]
    """Adds the accelerations by all plane walls to `a`, and the forces on the walls to `on_walls`, (walls + 1, d)."""
    radii, walls, stretches = force.radii, force.walls, force.wall_stretches
    d = len(force.lists.sides)
    for wall in range(len(walls)):
        axis, sign, law = int(walls[wall, AXIS]), walls[wall, SIGN], _numbers(walls[wall, WALL_LAW:])
        place, speed = _motion(walls[wall], time)
        n, velocity = _along(axis, sign, axis, 0.0), _along(axis, speed, axis, 0.0)
        for i in range(len(radii)):
            delta = radii[i] - sign * (r[d * i + axis] - place)
            if delta <= 0.0:
                if inverse_inertias is not None:
                    _keep(stretches[wall], i, (0.0, 0.0, 0.0))
                continue
            g = _minus(_vector(d, v, i), velocity)
            _on_wall(force, inverse_inertias, law, stretches[wall], elapsed, i, delta, n, g, v, a, on_walls[wall])


@internal
def _cylinder(force, inverse_inertias, elapsed, r, v, a, on_wall):  # type: ignore[no-untyped-def]
    """Adds the accelerations by the inside of a turning cylinder; returns its torque on the grains about its axis."""
    radii, cylinder, stretches = force.radii, force.cylinder, force.wall_stretches[len(force.walls)]
    d, law = len(force.lists.sides), _numbers(cylinder[CYLINDER_LAW:])
    torque = 0.0
    first, second, inside = int(cylinder[AXIS_A]), int(cylinder[AXIS_B]), cylinder[RADIUS]
    surface = cylinder[ANGULAR_VELOCITY] * inside
    for i in range(len(radii)):
        x, y = r[d * i + first] - cylinder[CENTRE_A], r[d * i + second] - cylinder[CENTRE_B]
        distance = np.sqrt(x * x + y * y)
        delta = radii[i] - (inside - distance)
        if delta <= 0.0:
            if inverse_inertias is not None:
                _keep(stretches, i, (0.0, 0.0, 0.0))
            continue
        along, across = -x / distance, -y / distance
        n = _along(first, along, second, across)
        g = _minus(_vector(d, v, i), _along(first, surface * across, second, -surface * along))
        f = _on_wall(force, inverse_inertias, law, stretches, elapsed, i, delta, n, g, v, a, on_wall)
        # the arm of a grain ends delta beyond the wall
        torque += (distance + radii[i]) * (f[first] * across - f[second] * along)
    return torque


@compiled(cache=True)
def grain_accelerations(force, r, v, a):  # type: ignore[no-untyped-def]
    """Accelerations, angular accelerations, and rates of the tallies, to `a`; NaN where the list cannot be made.

    force: `Grains`. r, v, a: coordinates, velocities and accelerations of the same shape, see `forces.grains`.
    """
    gravity, walls, clock, auxiliary = force.gravity, force.walls, force.clock, force.auxiliary
    d, number = len(force.lists.sides), len(force.radii)
    if not update(force.lists, r):
        for k in range(len(a)):
            a[k] = np.nan
        return
    force.lists.bookkeeping[EVALUATIONS] += 1
    force.lists.bookkeeping[PAIR_TESTS] += force.lists.bookkeeping[CLOSE_PAIRS]
    ends = len(r) - auxiliary
    time = r[ends]
    # an evaluation at the time of the last one is a repeated one, or the first
    elapsed = 0.0 if np.isnan(clock[0]) else time - clock[0]
    clock[0] = time
    for k in range(len(a)):
        a[k] = 0.0
    for k in range(d):
        if gravity[k] != 0.0:
            for i in range(k, d * number, d):
                a[i] = gravity[k]
    # handed on as an argument: numba leaves the branches for rough grains out where it is None
    inverse_inertias = force.inverse_inertias
    contacts, virial = _pairs(force, inverse_inertias, elapsed, r, v, a)
    on_walls = np.zeros((len(walls) + 1, d))
    torque = 0.0
    if len(walls) > 0:
        _planes(force, inverse_inertias, elapsed, time, r, v, a, on_walls)
    if len(force.cylinder) > 0:
        torque = _cylinder(force, inverse_inertias, elapsed, r, v, a, on_walls[len(walls)])
    if auxiliary > 1:
        a[ends + 1], a[ends + 2] = contacts, virial
        for wall in range(len(walls) + 1):
            for k in range(d):
                a[ends + 3 + d * wall + k] = on_walls[wall, k]
        a[len(a) - 1] = torque


@internal
def _spring_energy(law: Any, model: ContactModel, delta: float, radius: float) -> float:
    """k delta^2/2, or 2 k sqrt(R_eff) delta^(5/2)/5."""
    return law[STIFFNESS] * delta * delta * (0.4 * np.sqrt(delta * radius) if model.hertz else 0.5)


@compiled(cache=True)
def elastic_energy(force, r):  # type: ignore[no-untyped-def]
    """Energy of the normal springs of all contacts; NaN without a list.

    force: `Grains`. r: coordinates, see `forces.grains`.
    """
    lists, radii, law, model, walls, cylinder = (
        force.lists, force.radii, force.law, force.model, force.walls, force.cylinder,
    )  # fmt: skip
    d, time = len(lists.sides), r[r.size - force.auxiliary]
    energy = 0.0
    if not update(lists, r):
        return np.nan
    places = np.empty(len(lists.close), dtype=np.uint32)
    for contact in range(find_contacts(lists, r, places)):
        i, j = lists.close[places[contact], 0], lists.close[places[contact], 1]
        delta = radii[i] + radii[j] - np.sqrt(apart2(lists.sides, inverses(lists.sides), r, i, j))
        radius = radii[i] * radii[j] / (radii[i] + radii[j])
        energy += _spring_energy(law, model, delta, radius)
    for wall in range(len(walls)):
        axis, sign = int(walls[wall, AXIS]), walls[wall, SIGN]
        place, _ = _motion(walls[wall], time)
        for i in range(len(radii)):
            delta = radii[i] - sign * (r[d * i + axis] - place)
            if delta > 0.0:
                energy += _spring_energy(walls[wall, WALL_LAW:], model, delta, radii[i])
    if len(cylinder) > 0:
        first, second = int(cylinder[AXIS_A]), int(cylinder[AXIS_B])
        for i in range(len(radii)):
            x, y = r[d * i + first] - cylinder[CENTRE_A], r[d * i + second] - cylinder[CENTRE_B]
            delta = radii[i] - (cylinder[RADIUS] - np.sqrt(x * x + y * y))
            if delta > 0.0:
                energy += _spring_energy(cylinder[CYLINDER_LAW:], model, delta, radii[i])
    return energy
