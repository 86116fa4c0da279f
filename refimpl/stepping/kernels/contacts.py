"""Forces of soft grains on each other and on walls: every contact of a pair list, plane walls and a cylinder.

Vectors have three components here; grains in the plane have z = 0 and spin about z. A pair list holds all pairs whose
surfaces were nearer than `skin` when it was made, and is good until a grain has moved by skin/2 (Verlet 1967); cells as
wide as the largest diameter and the skin make it in O(N). A grain is lost as in `refimpl.stepping.kernels.neighbours`,
with the largest diameter and the skin as the list radius.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from refimpl.compilation import compiled
from refimpl.stepping.forces.generic import DIVERGED, GOOD, NEEDS_CAPACITY
from refimpl.stepping.kernels.compiled import internal
from refimpl.stepping.kernels.neighbours import FAR, LOST, ROUNDING, SAFE

#: Places of the numbers in the row of a law.
STIFFNESS, DAMPING, TANGENTIAL_STIFFNESS, TANGENTIAL_DAMPING, FRICTION = range(5)
#: Places of the numbers in the row of a wall; its law follows.
AXIS, SIGN, PLACE, AMPLITUDE, FREQUENCY, PHASE, WALL_LAW = range(7)
#: Places of the numbers in the row of a cylinder; its law follows.
RADIUS, CENTRE_A, CENTRE_B, AXIS_A, AXIS_B, ANGULAR_VELOCITY, CYLINDER_LAW = range(7)
#: Places of the numbers in the bookkeeping of a list: outcome of the last evaluation; 1 when the list is good for the
#: positions `built`; pairs in it; lists made so far; pairs for which there was no room; so far, evaluations of all
#: forces, distances of pairs computed by them, and to make lists.
STATUS, LISTED, PAIRS, BUILDS, NEEDED, EVALUATIONS, PAIR_TESTS, LIST_TESTS = range(8)
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


# -- the law of a contact ----------------------------------------------------------------------------------------------


@internal
def _scale(model: ContactModel, delta: float, radius: float) -> float:
    return np.sqrt(delta * radius) if model.hertz else 1.0


@internal
def _damping(coefficient: float, law: Any, model: ContactModel, mass: float, scale: float) -> float:
    """eta, the force over the velocity."""
    if model.by_mass:
        return coefficient * mass * scale
    return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)


@internal
def _normal_force(law: Any, model: ContactModel, delta: float, approach: float, mass: float, scale: float) -> float:
    """For the overlap delta and the normal velocity `approach`, which is negative when the grains come nearer."""
    return law[STIFFNESS] * scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach


@internal
def _tangential_force(law, model, mass, scale, normal, n, u, stretch, elapsed, f):  # type: ignore[no-untyped-def]
    """Writes the force at the slip u to f, both (3,), after `stretch` (3,) has grown over the time `elapsed`."""
    limit = law[FRICTION] * abs(normal)
    damping = _damping(law[TANGENTIAL_DAMPING], law, model, mass, scale)
    if not model.history:
        slip = _length(u)
        share = min(limit, damping * slip) / slip if slip > 0.0 else 0.0
        for k in range(3):
            f[k] = -share * u[k]
        return
    stiffness = law[TANGENTIAL_STIFFNESS] * scale
    if elapsed != 0.0 and model.granular:
        before, along = _length(stretch), _product(stretch, n)
        slight = _SLIGHT * limit if law[FRICTION] < NO_LIMIT else 0.0
        if abs(along) * stiffness > slight:
            for k in range(3):
                stretch[k] -= along * n[k]
            after = _length(stretch)
            for k in range(3):
                stretch[k] *= before / after if after > 0.0 else 0.0
    for k in range(3):
        stretch[k] += u[k] * elapsed
    stretched = _length(stretch) != 0.0
    if elapsed != 0.0 and not model.granular:
        along = _product(stretch, n)
        for k in range(3):
            stretch[k] -= along * n[k]
    for k in range(3):
        f[k] = -stiffness * stretch[k] - damping * u[k]
    size = _length(f)
    if size > limit:
        for k in range(3):
            f[k] = limit / size * f[k] if stretched else 0.0
            if stretched and stiffness > 0.0:
                stretch[k] = -(f[k] + damping * u[k]) / stiffness


@internal
def _product(x: Any, y: Any) -> float:
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


@internal
def _length(x: Any) -> float:
    return np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])


@internal
def _slip(n, g, approach, w, u):  # type: ignore[no-untyped-def]
    """u = g - (g.n) n - w x n, w the sum of the surfaces' R omega."""
    u[0] = g[0] - approach * n[0] - (w[1] * n[2] - w[2] * n[1])
    u[1] = g[1] - approach * n[1] - (w[2] * n[0] - w[0] * n[2])
    u[2] = g[2] - approach * n[2] - (w[0] * n[1] - w[1] * n[0])


@internal
def _add_spin(dimension, spins, v, i, radius, w):  # type: ignore[no-untyped-def]
    """Adds R omega of grain i to w (3,)."""
    if dimension == 3:
        for k in range(3):
            w[k] += radius * v[spins + 3 * i + k]
    else:
        w[2] += radius * v[spins + i]


@internal
def _add_torque(dimension, spins, a, i, share, n, f):  # type: ignore[no-untyped-def]
    """Adds -share n x F to the angular acceleration of grain i."""
    z = n[0] * f[1] - n[1] * f[0]
    if dimension == 3:
        a[spins + 3 * i] -= share * (n[1] * f[2] - n[2] * f[1])
        a[spins + 3 * i + 1] -= share * (n[2] * f[0] - n[0] * f[2])
        a[spins + 3 * i + 2] -= share * z
    else:
        a[spins + i] -= share * z


# -- the pair list -----------------------------------------------------------------------------------------------------


@internal
def _list_radius(radii, skin):  # type: ignore[no-untyped-def]
    """The largest diameter and the skin: no pair of a list is further apart."""
    largest = 0.0
    for radius in radii:
        largest = max(largest, radius)
    return 2.0 * largest + skin


@internal
def _has_moved(r, built, dimension, skin):  # type: ignore[no-untyped-def]
    """True if a grain is further than skin/2 from where the list was made, or its place is not a number."""
    limit2 = (0.5 * SAFE * skin) ** 2
    still = True
    for first in range(0, len(built), dimension):
        square = 0.0
        for k in range(dimension):
            square += (r[first + k] - built[first + k]) ** 2
        still &= square <= limit2
    return not still


@internal
def _apart2(sides, r, i, j):  # type: ignore[no-untyped-def]
    """Squared distance of the nearest images."""
    d = len(sides)
    square = 0.0
    for k in range(d):
        x = r[d * i + k] - r[d * j + k]
        if sides[k] > 0.0:
            x -= sides[k] * np.rint(x / sides[k])
        square += x * x
    return square


@internal
def _find_pairs(force, r):  # type: ignore[no-untyped-def]
    """Number of pairs i < j with surfaces nearer than skin, and, as far as there is room, the pairs."""
    sides, radii, skin, pairs, reach2 = force.sides, force.radii, force.skin, force.pairs, force.reach2
    d, number = len(sides), len(radii)
    farthest = 0.0
    for k in range(d * number):
        farthest = max(farthest, abs(r[k]))
    reach = _list_radius(radii, skin) / SAFE + ROUNDING * farthest
    low, width, cells = np.zeros(3), np.ones(3), np.ones(3, dtype=np.int64)
    for k in range(d):
        extent = sides[k]
        if extent == 0.0:
            low[k] = high = r[k]
            for i in range(number):
                low[k], high = min(low[k], r[d * i + k]), max(high, r[d * i + k])
            extent = high - low[k]
        # no more cells than grains along an axis: empty ones cost too
        cells[k] = max(1, int(min(number, extent / reach)))
        width[k] = extent / cells[k] if extent > 0.0 else 1.0
    while cells[0] * cells[1] * cells[2] > 8 * number:
        longest = 0
        for k in range(1, d):
            longest = k if cells[k] > cells[longest] else longest
        width[longest] *= cells[longest] / (cells[longest] // 2)
        cells[longest] //= 2
    # grains of a cell as a chain; numbers from 1, 0 ends it
    first = np.zeros(cells[0] * cells[1] * cells[2], dtype=np.int64)
    following, place = np.zeros(number, dtype=np.int64), np.zeros((number, 3), dtype=np.int64)
    for i in range(number):
        for k in range(d):
            x = np.floor((r[d * i + k] - low[k]) / width[k])
            if sides[k] > 0.0:
                x -= cells[k] * np.floor(x / cells[k])
            place[i, k] = int(min(max(x, 0.0), cells[k] - 1.0))
        cell = (place[i, 0] * cells[1] + place[i, 1]) * cells[2] + place[i, 2]
        following[i] = first[cell]
        first[cell] = i + 1
    found, tests = 0, 0
    near, count = np.empty((3, 3), dtype=np.int64), np.zeros(3, dtype=np.int64)
    for i in range(number):
        for k in range(3):
            # every cell once, of a periodic axis too that has fewer than three
            count[k] = 0
            around = k < d and sides[k] > 0.0
            for step in range(-1, 2):
                c = place[i, k] + step
                if around:
                    if (step == -1 and cells[k] < 3) or (step == 1 and cells[k] < 2):
                        continue
                    c %= cells[k]
                elif c < 0 or c >= cells[k]:
                    continue
                near[k, count[k]] = c
                count[k] += 1
        for x in range(count[0]):
            for y in range(count[1]):
                for z in range(count[2]):
                    j = first[(near[0, x] * cells[1] + near[1, y]) * cells[2] + near[2, z]] - 1
                    while j >= 0:
                        touch = radii[i] + radii[j]
                        tests += j > i
                        if j > i and _apart2(sides, r, i, j) < ((touch + skin) / SAFE) ** 2:
                            if found < len(pairs):
                                pairs[found, 0], pairs[found, 1] = i, j
                                reach2[found] = touch * touch
                            found += 1
                        j = following[j] - 1
    force.bookkeeping[LIST_TESTS] += tests
    return found


@internal
def _clear_stretch(force, pair):  # type: ignore[no-untyped-def]
    force.touching[pair] = False
    for k in range(3):
        force.stretches[pair, k] = 0.0


@internal
def _restore_stretch(force, pair, kept, old):  # type: ignore[no-untyped-def]
    force.touching[pair] = True
    for k in range(3):
        force.stretches[pair, k] = kept[old, k]


@internal
def _make_list(force, r):  # type: ignore[no-untyped-def]
    """A new pair list for the positions r; stretches of pairs that touch are carried over."""
    radii, built, pairs, touching, stretches = force.radii, force.built, force.pairs, force.touching, force.stretches
    bookkeeping = force.bookkeeping
    for k in range(len(built)):
        if not -LOST <= r[k] <= LOST:
            return DIVERGED
    # the pairs that touch, as a chain from the first grain of each; numbers from 1, 0 ends it
    remembered = bookkeeping[PAIRS] if len(touching) > 0 else 0
    held = 0
    for pair in range(remembered):
        held += touching[pair]
    head, following = np.zeros(len(radii), dtype=np.int64), np.zeros(held, dtype=np.int64)
    ends, kept = np.zeros((held, 2), dtype=np.int64), np.zeros((held, 3))
    old = 0
    for pair in range(remembered):
        if touching[pair]:
            ends[old, 0], ends[old, 1] = pairs[pair, 0], pairs[pair, 1]
            following[old], head[ends[old, 0]] = head[ends[old, 0]], old + 1
            for k in range(3):
                kept[old, k] = stretches[pair, k]
            old += 1
    found = _find_pairs(force, r)
    if found > len(pairs):
        # the pairs that touch, with their stretches, are kept for the next attempt with larger arrays
        for old in range(held):
            pairs[old, 0], pairs[old, 1] = ends[old, 0], ends[old, 1]
            _restore_stretch(force, old, kept, old)
        bookkeeping[PAIRS], bookkeeping[NEEDED] = held, found
        return NEEDS_CAPACITY
    bookkeeping[PAIRS] = found
    for k in range(len(built)):
        built[k] = r[k]
    for pair in range(found if len(touching) > 0 else 0):
        _clear_stretch(force, pair)
        old = head[pairs[pair, 0]] - 1
        while old >= 0:
            if ends[old, 1] == pairs[pair, 1]:
                _restore_stretch(force, pair, kept, old)
            old = following[old] - 1
    bookkeeping[BUILDS] += 1
    return GOOD


@internal
def _list_is_valid(force, r):  # type: ignore[no-untyped-def]
    """Makes a new pair list if this one may miss a contact at r; False, with the reason in STATUS, if it cannot."""
    bookkeeping = force.bookkeeping
    bookkeeping[STATUS] = GOOD
    listed, d = bookkeeping[LISTED], len(force.sides)
    if listed == 0 or _has_moved(r, force.built, d, force.skin):
        bookkeeping[LISTED] = 0
        if listed == 1 and _has_moved(r, force.built, d, 2.0 * FAR * _list_radius(force.radii, force.skin)):
            bookkeeping[STATUS] = DIVERGED
            return False
        bookkeeping[STATUS] = _make_list(force, r)
        if bookkeeping[STATUS] == GOOD:
            bookkeeping[LISTED] = 1
    return bookkeeping[STATUS] == GOOD


# -- sums over contacts ------------------------------------------------------------------------------------------------


@internal
def _pairs(force, inverse_inertias, elapsed, r, v, a):  # type: ignore[no-untyped-def]
    """Adds the accelerations by all pairs of the list to `a`; returns the number of contacts and sum r_ij . F_ij."""
    sides, radii, inverse_masses, law, model = force.sides, force.radii, force.inverse_masses, force.law, force.model
    pairs, reach2, touching, stretches = force.pairs, force.reach2, force.touching, force.stretches
    d, number = len(sides), len(radii)
    n, g, u, w, f = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    contacts, virial = 0, 0.0
    for pair in range(force.bookkeeping[PAIRS]):
        i, j = pairs[pair, 0], pairs[pair, 1]
        square = _apart2(sides, r, i, j)
        if square >= reach2[pair]:
            if inverse_inertias is not None:  # noqa: SIM102  numba prunes a test for None only if it stands alone
                if touching[pair]:
                    _clear_stretch(force, pair)
            continue
        distance = np.sqrt(square)
        approach = 0.0
        for k in range(d):
            x = r[d * i + k] - r[d * j + k]
            if sides[k] > 0.0:
                x -= sides[k] * np.rint(x / sides[k])
            n[k] = x / distance
            g[k] = v[d * i + k] - v[d * j + k]
            approach += g[k] * n[k]
        delta = radii[i] + radii[j] - distance
        mass = 1.0 / (inverse_masses[i] + inverse_masses[j])
        scale = _scale(model, delta, radii[i] * radii[j] / (radii[i] + radii[j]))
        normal = _normal_force(law, model, delta, approach, mass, scale)
        contacts += 1
        virial += distance * normal
        if inverse_inertias is not None:
            touching[pair] = True
            w[0] = w[1] = w[2] = 0.0
            _add_spin(d, d * number, v, i, radii[i], w)
            _add_spin(d, d * number, v, j, radii[j], w)
            _slip(n, g, approach, w, u)
            _tangential_force(law, model, mass, scale, normal, n, u, stretches[pair], elapsed, f)
            shorter = 0.5 * delta if model.granular else 0.0
            _add_torque(d, d * number, a, i, inverse_inertias[i] * (radii[i] - shorter), n, f)
            _add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[j] - shorter), n, f)
        for k in range(d):
            total = normal * n[k] + f[k]
            a[d * i + k] += inverse_masses[i] * total
            a[d * j + k] -= inverse_masses[j] * total
    return contacts, virial


@internal
def _on_wall(  # type: ignore[no-untyped-def]
    force, inverse_inertias, law, stretches, elapsed, i, delta, vectors, v, a, on_wall
):
    """Adds the acceleration of grain i by a wall to `a` and the force on the wall to `on_wall`.

    law: the wall's row of numbers. stretches: (N, 3) of this wall. vectors: n towards the grain and g set, u, w, f for
    results.
    """
    radii, inverse_masses, model = force.radii, force.inverse_masses, force.model
    n, g, u, w, f = vectors
    d = len(force.sides)
    spins = d * len(radii)
    mass, approach = 1.0 / inverse_masses[i], _product(g, n)
    scale = _scale(model, delta, radii[i])
    normal = _normal_force(law, model, delta, approach, mass, scale)
    if inverse_inertias is not None:
        w[0] = w[1] = w[2] = 0.0
        _add_spin(d, spins, v, i, radii[i], w)
        _slip(n, g, approach, w, u)
        _tangential_force(law, model, mass, scale, normal, n, u, stretches[i], elapsed, f)
        _add_torque(d, spins, a, i, inverse_inertias[i] * radii[i], n, f)
    for k in range(d):
        total = normal * n[k] + f[k]
        a[d * i + k] += inverse_masses[i] * total
        on_wall[k] -= total


@internal
def _motion(wall: Any, time: float) -> tuple[float, float]:
    """Place and velocity of a plane wall."""
    swing, angle = wall[SIGN] * wall[AMPLITUDE], wall[FREQUENCY] * time + wall[PHASE]
    return wall[PLACE] + swing * np.cos(angle), -swing * wall[FREQUENCY] * np.sin(angle)


@internal
def _planes(force, inverse_inertias, elapsed, time, r, v, a, on_walls):  # type: ignore[no-untyped-def]
    """Adds the accelerations by all plane walls to `a`, and the forces on the walls to `on_walls`, (walls + 1, d)."""
    radii, walls, stretches = force.radii, force.walls, force.wall_stretches
    d = len(force.sides)
    vectors = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    n, g, _, _, _ = vectors
    for wall in range(len(walls)):
        axis, sign = int(walls[wall, AXIS]), walls[wall, SIGN]
        place, speed = _motion(walls[wall], time)
        n[0] = n[1] = n[2] = 0.0
        n[axis] = sign
        for i in range(len(radii)):
            delta = radii[i] - sign * (r[d * i + axis] - place)
            if delta <= 0.0:
                if inverse_inertias is not None:
                    for k in range(3):
                        stretches[wall, i, k] = 0.0
                continue
            for k in range(d):
                g[k] = v[d * i + k]
            g[axis] -= speed
            law = walls[wall, WALL_LAW:]
            _on_wall(force, inverse_inertias, law, stretches[wall], elapsed, i, delta, vectors, v, a, on_walls[wall])


@internal
def _cylinder(force, inverse_inertias, elapsed, r, v, a, on_wall):  # type: ignore[no-untyped-def]
    """Adds the accelerations by the inside of a turning cylinder; returns its torque on the grains about its axis."""
    radii, cylinder, stretches = force.radii, force.cylinder, force.wall_stretches[len(force.walls)]
    d = len(force.sides)
    vectors = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    n, g, _, _, f = vectors
    torque = 0.0
    first, second, inside = int(cylinder[AXIS_A]), int(cylinder[AXIS_B]), cylinder[RADIUS]
    surface = cylinder[ANGULAR_VELOCITY] * inside
    for i in range(len(radii)):
        x, y = r[d * i + first] - cylinder[CENTRE_A], r[d * i + second] - cylinder[CENTRE_B]
        distance = np.sqrt(x * x + y * y)
        delta = radii[i] - (inside - distance)
        if delta <= 0.0:
            if inverse_inertias is not None:
                for k in range(3):
                    stretches[i, k] = 0.0
            continue
        n[0] = n[1] = n[2] = 0.0
        n[first], n[second] = -x / distance, -y / distance
        for k in range(d):
            g[k] = v[d * i + k]
        g[first] -= surface * n[second]
        g[second] += surface * n[first]
        law = cylinder[CYLINDER_LAW:]
        _on_wall(force, inverse_inertias, law, stretches, elapsed, i, delta, vectors, v, a, on_wall)
        # the arm of a grain ends delta beyond the wall
        torque += (distance + radii[i]) * (f[first] * n[second] - f[second] * n[first])
    return torque


@compiled(cache=True)
def grain_accelerations(force, r, v, a):  # type: ignore[no-untyped-def]
    """Accelerations, angular accelerations, and rates of the tallies, to `a`; NaN where the list cannot be made.

    force: `Grains`. r, v, a: coordinates, velocities and accelerations of the same shape, see `forces.grains`.
    """
    gravity, walls, clock, auxiliary = force.gravity, force.walls, force.clock, force.auxiliary
    d, number = len(force.sides), len(force.radii)
    if not _list_is_valid(force, r):
        for k in range(len(a)):
            a[k] = np.nan
        return
    force.bookkeeping[EVALUATIONS] += 1
    force.bookkeeping[PAIR_TESTS] += force.bookkeeping[PAIRS]
    ends = len(r) - auxiliary
    time = r[ends]
    # an evaluation at the time of the last one is a repeated one, or the first
    elapsed = 0.0 if np.isnan(clock[0]) else time - clock[0]
    clock[0] = time
    for i in range(number):
        for k in range(d):
            a[d * i + k] = gravity[k]
    for k in range(d * number, len(a)):
        a[k] = 0.0
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
    sides, radii, law, model = force.sides, force.radii, force.law, force.model
    walls, cylinder, pairs, reach2 = force.walls, force.cylinder, force.pairs, force.reach2
    d, time = len(sides), r[r.size - force.auxiliary]
    energy = 0.0
    if not _list_is_valid(force, r):
        return np.nan
    for pair in range(force.bookkeeping[PAIRS]):
        i, j = pairs[pair, 0], pairs[pair, 1]
        square = _apart2(sides, r, i, j)
        if square < reach2[pair]:
            delta = radii[i] + radii[j] - np.sqrt(square)
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
