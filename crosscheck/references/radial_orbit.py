"""Two bodies that fall straight into each other from rest, under Newton's gravity.

With the distance r_0 at the start and mu = G (m_0 + m_1), r = r_0 cos^2 x and t = (r_0^3/(2 mu))^(1/2) (x + sin x
cos x): the limit e = 1 of Kepler's orbit from apocentre, a = r_0/2.

Literature: J. M. A. Danby, Fundamentals of Celestial Mechanics, 2nd ed., Willmann-Bell (1988), section 6.8, rectilinear
motion.
"""

from __future__ import annotations

import math


def collision_time(start: float, mu: float) -> float:
    """Time of the collision, pi/2 (r_0^3/(2 mu))^(1/2).

    start: r_0, length. mu: length^3/time^2. Danby (1988).
    """
    return 0.5 * math.pi * math.sqrt(start**3 / (2 * mu))


def separation(time: float, start: float, mu: float) -> float:
    """Distance at a time before the collision, length.

    time: from rest, 0 to `collision_time`. start: r_0, length. mu: length^3/time^2. By bisection on x, to rounding; see
    the module. ValueError for a time outside the fall.
    """
    if not 0 <= time <= collision_time(start, mu):
        raise ValueError(f"time {time} is not within the fall of {collision_time(start, mu)}")
    target = time / math.sqrt(start**3 / (2 * mu))
    low, high = 0.0, 0.5 * math.pi
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return start * math.cos(middle) ** 2
        low, high = (middle, high) if middle + math.sin(middle) * math.cos(middle) < target else (low, middle)
