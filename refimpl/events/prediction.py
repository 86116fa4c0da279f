"""When the next event is: closed forms and safe searches, shared by the naive algorithm and the fast one.

Every time is counted from the present; `NEVER` is no event. Pairs: with r and v the relative position and velocity,
b = r.v, w = v.v, c = r.r - s^2, contact at distance s is at the root of w t^2 + 2 b t + c = 0 (B. J. Alder and T. E.
Wainwright, J. Chem. Phys. 31, 459 (1959)). A common acceleration cancels.

Errors are of the order of the rounding of the distances in a formula, not of their squares: from afar, b^2 - w c is
the difference of two numbers of the order of r^2 w, of which s^2 w may be a small part. There it is formed as
s^2 w - |r x v|^2, whose rounding changes the impact parameter |r x v|/|v| by that of r.

Arguments that are the same throughout: model: `HardSpheres`. rows: (N, 7 or 8), a particle's position 0-2, velocity 3-5
and the time of that state 6. i, j: numbers of particles. diameter: contact distance of the largest pair. radii: (N,),
or None where all are alike. radius: of a particle. acceleration: (d,) of the field, or None. axis: 0 ... d - 1. walls,
cylinder, well: records of `refimpl.events.model`, or None. face: 2 axis + (0 for the lower, 1 for the upper wall).
bonds: (N, 1 + slots) int32 of a gas with wells, a row being the number of partners inside the well, then the partners.
b, c, w: of the pair, as above. s2: squared contact distance. moment2: |r x v|^2 of the pair. near: |r^2 - s^2|/s^2
below which rounding may hide whether a pair is at its contact, or at the edge of its well, see `state.nearness`. now:
the time, on the clock of the walls' phases. horizon: the search for a contact ends there. Units: any consistent set.
"""

from __future__ import annotations

import math
from typing import Any

from refimpl.events.kernels.compiled import inline, kernel
from refimpl.events.model import (
    AMPLITUDE,
    FREQUENCY,
    OSCILLATING,
    PHASE,
    CylinderWall,
    Floats,
    HardSpheres,
    PlaneWalls,
    Well,
)

#: The time of an event that does not happen: large, yet finite, so that sums and comparisons need no special case.
NEVER = 1e300
#: (r^2 - s^2)/s^2 above which a discriminant is formed from |r x v|^2. Nearer, b^2 - w c is at hand, and changes the
#: impact parameter by r^2/(2 s) roundings of it: 32 of s at most, less than the clock does.
FAR = 64.0
#: Rounding of a relative velocity, squared, over the sum of the two velocities squared: slower counts as at rest.
AT_REST = (2.0**-49) ** 2
#: Rounding of positions that a wall search may stop at, in units of the position.
TOUCH = 2.0**-50


@inline
def squared_moment(x: float, y: float, z: float, u: float, v: float, w: float) -> float:
    """|r x v|^2 of a relative position (x, y, z) and velocity (u, v, w)."""
    a, b, c = y * w - z * v, z * u - x * w, x * v - y * u
    return a * a + b * b + c * c


@inline
def discriminant(b: float, c: float, w: float, s2: float, moment2: float) -> float:
    """b^2 - w c = s^2 w - |r x v|^2: the form with the smaller rounding; moment2 is read for c > FAR s2 only."""
    if c > FAR * s2:
        return s2 * w - moment2
    return b * b - w * c


@inline
def approach(b: float, c: float, discriminant: float) -> float:
    """First root for b < 0: c/(sqrt(discriminant) - b), without cancellation; 0 where rounding made the pair overlap.

    discriminant: b^2 - w c, positive.
    """
    return max(c / (math.sqrt(discriminant) - b), 0.0)


@inline
def separation(b: float, c: float, w: float, discriminant: float) -> float:
    """The root at which a pair inside a distance (c <= 0) leaves it; discriminant: b^2 - w c, rounded up to 0."""
    root = math.sqrt(max(discriminant, 0.0))
    if b > 0.0:
        return max(-c / (b + root), 0.0)
    return (root - b) / w


@inline
def falling_time(height: float, v: float, a: float) -> float:
    """First s >= 0 with height + v s + a s^2/2 <= 0 on its way down; a start below 0 counts as 0.

    height: of the surface above the wall. v, a: velocity and acceleration, positive away from the wall.
    """
    if a == 0.0:
        return max(-height / v, 0.0) if v < 0.0 else NEVER
    height = max(height, 0.0)
    square = v * v - 2.0 * a * height
    if a < 0.0:
        root = math.sqrt(square)
        return (v + root) / -a if v > 0.0 else 2.0 * height / (root - v) if root > v else 0.0
    if v >= 0.0 or square < 0.0:
        return NEVER
    return 2.0 * height / (math.sqrt(square) - v)


@kernel
def oscillating_time(
    height: float, v: float, a: float, amplitude: float, frequency: float, angle: float, horizon: float, scale: float
) -> float:
    """First contact with a wall at amplitude * cos(angle + frequency s), before `horizon`; else `NEVER`.

    height, v, a: of the particle's surface above the wall's middle position. amplitude, frequency: of the wall, angular
    frequency. angle: phase of the wall now. scale: of the coordinates, whose rounding ends the search.

    The gap h(s) has |h''| <= M, M = |a| + A omega^2, hence none of its roots lies before that of h + h' s - M s^2/2:
    steps to it never pass one, and converge quadratically.
    """
    touch = TOUCH * (scale + amplitude)
    steepest = abs(a) + amplitude * frequency * frequency
    s = 0.0
    while s < horizon:
        above = height + s * (v + 0.5 * a * s) - amplitude
        if above > 0.0:  # no contact is possible above the highest place of the wall
            s += falling_time(above, v + a * s, a)
            if s >= horizon:
                break
        phase = angle + frequency * s
        gap = height + s * (v + 0.5 * a * s) - amplitude * math.cos(phase)
        speed = v + a * s + amplitude * frequency * math.sin(phase)
        if gap <= touch:
            if speed < 0.0:
                return s
            curvature = a + amplitude * frequency * frequency * math.cos(phase)
            if speed == 0.0 and curvature < 0.0:
                return s
        room = max(gap, 0.0)
        root = math.sqrt(speed * speed + 2.0 * steepest * room)
        # without cancellation: a slow wall has a small M
        step = (speed + root) / steepest if speed > 0.0 else 2.0 * room / (root - speed) if root > speed else 0.0
        # near the root, and for a particle at rest on the wall, a step must still change the time
        s += max(step, math.sqrt(0.25 * touch / steepest) if gap <= touch else 0.0, 2.0**-52 * s)
    return NEVER


@kernel
def _value(a0: float, a1: float, a2: float, a3: float, a4: float, s: float) -> float:
    return a0 + s * (a1 + s * (a2 + s * (a3 + s * a4)))


@kernel
def _root_between(a0: float, a1: float, a2: float, a3: float, a4: float, low: float, high: float) -> float:
    """The root of a polynomial that is monotonic on [low, high] and changes sign there; the side where it is <= 0."""
    rising = _value(a0, a1, a2, a3, a4, high) > 0.0
    middle = 0.5 * (low + high)
    while low < middle < high:
        if (_value(a0, a1, a2, a3, a4, middle) > 0.0) == rising:
            high = middle
        else:
            low = middle
        middle = 0.5 * (low + high)
    return low if rising else high


@kernel
def _cubic_turns(a1: float, a2: float, a3: float, a4: float, end: float) -> tuple[float, float, float]:
    """Zeros in (0, end) of f' = a1 + 2 a2 s + 3 a3 s^2 + 4 a4 s^3, in order; `end` in place of those that are not."""
    b0, b1, b2, b3 = a1, 2.0 * a2, 3.0 * a3, 4.0 * a4
    first, second = end, end  # where f' turns: zeros of b1 + 2 b2 s + 3 b3 s^2
    square = b2 * b2 - 3.0 * b3 * b1
    if square > 0.0:
        q = -(b2 + math.copysign(math.sqrt(square), b2))
        one, two = q / (3.0 * b3), b1 / q
        low, high = min(one, two), max(one, two)
        first = low if 0.0 < low < end else end
        second = high if 0.0 < high < end else end
        first, second = min(first, second), max(first, second)
    found0, found1, found2 = end, end, end
    low = 0.0
    for piece in range(3):
        high = first if piece == 0 else (second if piece == 1 else end)
        if high > low:
            at_low, at_high = _value(b0, b1, b2, b3, 0.0, low), _value(b0, b1, b2, b3, 0.0, high)
            if (at_low > 0.0) != (at_high > 0.0):
                zero = _root_between(b0, b1, b2, b3, 0.0, low, high)
                if found0 == end:
                    found0 = zero
                elif found1 == end:
                    found1 = zero
                else:
                    found2 = zero
            low = high
    return found0, found1, found2


@kernel
def leaving_time(r2: float, ru: float, u2: float, ra: float, ua: float, a2: float, radius: float) -> float:
    """First time at which a particle inside a circle reaches it: |r + u s + a s^2/2| = radius, outwards.

    r2 = r.r, ru = r.u, u2 = u.u, ra = r.a, ua = u.a, a2 = a.a: of the transverse position, velocity and acceleration.
    radius: of the circle. Without acceleration a quadratic; with it a quartic, whose stationary points cut the time
    into monotonic pieces: no root is missed.
    """
    c = r2 - radius * radius
    if a2 == 0.0:
        if u2 == 0.0:
            return NEVER
        return separation(ru, min(c, 0.0), u2, ru * ru - u2 * c)
    if c >= 0.0 and ru > 0.0:
        return 0.0
    c = min(c, 0.0)
    c1, c2, c3, c4 = 2.0 * ru, u2 + ra, ua, 0.25 * a2
    # beyond `end` the acceleration has carried it out
    end = (2.0 * math.sqrt(u2) + 2.0 * math.sqrt(u2 + math.sqrt(a2) * (math.sqrt(r2) + radius))) / math.sqrt(a2)
    turns = _cubic_turns(c1, c2, c3, c4, end)
    low = 0.0
    for piece in range(4):
        high = turns[piece] if piece < 3 else end
        if high > low:
            if _value(c, c1, c2, c3, c4, low) <= 0.0 < _value(c, c1, c2, c3, c4, high):
                return _root_between(c, c1, c2, c3, c4, low, high)
            low = high
    return NEVER


@inline
def drift(x: float, v: float, acceleration: tuple[float, ...] | None, axis: int, s: float) -> float:
    """x + v s + g s^2/2: one coordinate x with velocity v, the time s later."""
    if acceleration is None:
        return x + v * s
    return x + s * (v + 0.5 * acceleration[axis] * s)


@inline
def speed_after(v: float, acceleration: tuple[float, ...] | None, axis: int, s: float) -> float:
    """v + g s: one velocity v, the time s later."""
    if acceleration is None:
        return v
    return v + acceleration[axis] * s


@inline
def field_along(acceleration: tuple[float, ...] | None, axis: int) -> float:
    """g along one axis, 0 without a field."""
    if acceleration is None:
        return 0.0
    return acceleration[axis]


@inline
def contact_distance(diameter: float, radii: Floats | None, i: int, j: int) -> float:
    """R_i + R_j."""
    if radii is None:
        return diameter
    return radii[i] + radii[j]


@inline
def radius_of(diameter: float, radii: Floats | None, i: int) -> float:
    """R_i."""
    if radii is None:
        return 0.5 * diameter
    return radii[i]


@inline
def bonded(bonds: Any, i: int, j: int) -> bool:
    """Whether the pair is inside its well, by the bonds."""
    for slot in range(1, bonds[i, 0] + 1):
        if bonds[i, slot] == j:
            return True
    return False


@inline
def pair_time(
    well: Well | None,
    bonds: Any,
    i: int,
    j: int,
    b: float,
    c: float,
    w: float,
    s2: float,
    moment2: float,
    near: float,
) -> float:
    """Time to the next event of a pair, at the core or at the edge of the well; NEVER if there is none.

    moment2 is read for c > FAR s2 only.
    """
    disc = discriminant(b, c, w, s2, moment2)
    if well is None:
        return approach(b, c, disc) if b < 0.0 and disc > 0.0 else NEVER
    edge2 = s2 * (well.range * well.range)
    outer = c + (s2 - edge2)
    disc_outer = discriminant(b, outer, w, edge2, moment2)
    inside = outer < 0.0
    if abs(outer) < near * s2:  # rounding cannot tell
        inside = bonded(bonds, i, j)
    if not inside:
        return approach(b, outer, disc_outer) if b < 0.0 and disc_outer > 0.0 else NEVER
    if b < 0.0 and disc > 0.0:
        return approach(b, c, disc)
    return separation(b, min(outer, 0.0), w, disc_outer) if w > 0.0 else NEVER


@inline
def rests(rows: Floats, i: int, j: int, b: float, s2: float) -> bool:
    """Whether a pair in contact approaches more slowly than its velocities are rounded."""
    scale = 0.0
    for k in range(3):
        scale += rows[i, 3 + k] * rows[i, 3 + k] + rows[j, 3 + k] * rows[j, 3 + k]
    return b * b <= AT_REST * s2 * scale


@inline
def wall_time(
    model: HardSpheres,
    walls: PlaneWalls | None,
    face: int,
    x: float,
    v: float,
    radius: float,
    now: float,
    horizon: float,
) -> float:
    """Time until a particle at x, with velocity v along the face's axis, meets the wall; NEVER without a wall."""
    if walls is None:
        return NEVER
    if not walls.present[face]:
        return NEVER
    axis, near = face >> 1, face & 1 == 0
    height = x - radius if near else model.lengths[axis] - x - radius
    v = v if near else -v
    a = field_along(model.acceleration, axis)
    a = a if near else -a
    if walls.motion[face] == OSCILLATING:
        frequency = walls.numbers[face, FREQUENCY]
        angle = walls.numbers[face, PHASE] + frequency * now
        return oscillating_time(
            height, v, a, walls.numbers[face, AMPLITUDE], frequency, angle, horizon, model.lengths[axis]
        )
    return falling_time(height, v, a)


@inline
def resting_flight(walls: PlaneWalls | None, model: HardSpheres, face: int) -> float:
    """A particle that hits an oscillating wall twice within this time rests on it; 0 for other walls.

    The search of `oscillating_time` does not resolve heights below s = TOUCH times the scale of the coordinates: a
    flight of time t rises by less where M t^2/2 < s, that is for t of the order of sqrt(s/M), M as there. A particle
    that comes to rest on the wall would go on in such flights, which mean nothing, forever.
    """
    if walls is None:
        return 0.0
    if walls.motion[face] != OSCILLATING:
        return 0.0
    amplitude, frequency = walls.numbers[face, AMPLITUDE], walls.numbers[face, FREQUENCY]
    steepest = abs(field_along(model.acceleration, face >> 1)) + amplitude * frequency * frequency
    return 4.0 * math.sqrt(TOUCH * (model.lengths[face >> 1] + amplitude) / steepest)


@inline
def cylinder_time(
    model: HardSpheres, cylinder: CylinderWall | None, rows: Floats, i: int, s: float, radius: float
) -> float:
    """Time until the particle, whose state is older than the present by s, reaches the cylinder; NEVER without one."""
    if cylinder is None:
        return NEVER
    first_axis, second_axis = cylinder.first, cylinder.second
    x = drift(rows[i, first_axis], rows[i, 3 + first_axis], model.acceleration, first_axis, s)
    y = drift(rows[i, second_axis], rows[i, 3 + second_axis], model.acceleration, second_axis, s)
    x, y = x - 0.5 * model.lengths[first_axis], y - 0.5 * model.lengths[second_axis]
    u = speed_after(rows[i, 3 + first_axis], model.acceleration, first_axis, s)
    v = speed_after(rows[i, 3 + second_axis], model.acceleration, second_axis, s)
    a, b = field_along(model.acceleration, first_axis), field_along(model.acceleration, second_axis)
    return leaving_time(
        x * x + y * y,
        x * u + y * v,
        u * u + v * v,
        x * a + y * b,
        u * a + v * b,
        a * a + b * b,
        cylinder.radius - radius,
    )


@inline
def nearest(model: HardSpheres, rows: Floats, i: int, j: int) -> tuple[float, float, float]:
    """r_j - r_i of the nearest image, from two states of one time."""
    x, y, z = rows[j, 0] - rows[i, 0], rows[j, 1] - rows[i, 1], rows[j, 2] - rows[i, 2]
    x = wrapped(x, model.lengths[0], model.periodic[0])
    y = wrapped(y, model.lengths[1], model.periodic[1])
    if len(model.lengths) == 3:
        z = wrapped(z, model.lengths[len(model.lengths) - 1], model.periodic[len(model.lengths) - 1])
    return x, y, z


@inline
def wrapped(x: float, length: float, wraps: bool) -> float:
    """A component x of a distance, of the nearest image; length: of the box side; wraps: whether it is periodic."""
    if wraps:
        if x > 0.5 * length:
            return x - length
        if x < -0.5 * length:
            return x + length
    return x
