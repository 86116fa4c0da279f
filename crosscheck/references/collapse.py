"""Inelastic collapse, infinitely many collisions in a finite time: on a line, and of a ball on a floor at rest.

alpha is the coefficient of normal restitution.

Literature: S. McNamara and W. R. Young, Phys. Fluids A 4, 496 (1992); T. Zhou and L. P. Kadanoff, Phys. Rev. E 54,
623 (1996); B. Bernu and R. Mazighi, J. Phys. A 23, 5745 (1990).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Three particles on a line collapse if alpha is below 7 - 4 sqrt 3 (McNamara and Young 1992).
THREE_PARTICLE_COLLAPSE = 7 - 4 * 3**0.5
#: In two and three dimensions that collapse is stable below 9 - 4 sqrt 5 (Zhou and Kadanoff 1996).
STABLE_COLLAPSE = 9 - 4 * 5**0.5


def wall_collapse(number: int) -> float:
    """alpha below which N particles thrown at a wall, all restitutions alike, collapse: tan^2(pi/4 (1 - 1/N)).

    Bernu and Mazighi (1990). The wall has the particles' restitution: it stands for the mirror image of the N, and 2 N
    free particles have the same limit (3, put for 2 N, gives 7 - 4 sqrt 3). One particle never collapses: 0. From
    memory of the literature, checked for N = 2 ... 5 against the eigenvalues of waves of collisions.

    number: N, of particles, 1 or more.
    """
    return float(np.tan(np.pi / 4 * (1 - 1 / number)) ** 2)


class BouncingBall(NamedTuple):
    """A ball dropped from `height` on a floor at rest at time 0, with restitution alpha < 1; a point.

    height: h of its start, a length. alpha: 0 to below 1. gravity: g, length/time^2; any consistent units.
    """

    height: float
    alpha: float
    gravity: float

    @property
    def fall(self) -> float:
        """Time of the first impact, sqrt(2 h/g)."""
        return (2 * self.height / self.gravity) ** 0.5

    @property
    def rest(self) -> float:
        """Time by which infinitely many impacts are over: sqrt(2 h/g) (1 + alpha)/(1 - alpha)."""
        return self.fall * (1 + self.alpha) / (1 - self.alpha)

    @property
    def path(self) -> float:
        """Length of the whole path, h (1 + alpha^2)/(1 - alpha^2)."""
        return self.height * (1 + self.alpha**2) / (1 - self.alpha**2)

    def apex(self, bounce: int) -> float:
        """Height after the given number of impacts, h alpha^(2 k).

        bounce: k, the number of impacts, 0 or more. A length.
        """
        return self.height * self.alpha ** (2 * bounce)

    def impact_time(self, bounce: int) -> float:
        """Time of impact 1, 2, ...: fall (1 + 2 (alpha + ... + alpha^(k-1))).

        bounce: k, from 1. A time from the start of the fall.
        """
        a = self.alpha
        return self.fall * (1 + 2 * a * (1 - a ** (bounce - 1)) / (1 - a))


class LineCollisions(NamedTuple):
    """The collisions of particles on a line, up to the last or to the collapse.

    pairs, wall: numbers of collisions of pairs and with the wall. times: of all of them, (collisions,), in order, in
    the unit of gap over velocity. gaps: the largest gap between neighbours that approach, after each of them,
    (collisions,), length. collapsed: whether they go on for ever.
    """

    pairs: int
    wall: int
    times: Floats
    gaps: Floats
    collapsed: bool


def line_collisions(gaps: ArrayLike, velocities: ArrayLike, alpha: float, wall: bool) -> LineCollisions:
    """Like particles on a line, from gaps and relative velocities alone: no precision is lost as they shrink.

    Momentum and v'_1 - v'_2 = -alpha (v_1 - v_2) (McNamara and Young 1992), from collision to collision, in long
    double. It is a collapse if the velocities have shrunk to 1e-200 and particles still approach.

    gaps: between neighbours, (N - 1,), any unit of length; with `wall`, (N,), first that between the wall at rest, of
    the same restitution, and the first particle. velocities: (N,), positive away from the wall. alpha: of all impacts.

    wall: whether there is one. Times are in units of gap over velocity.
    """
    real = np.longdouble
    gap, half = np.array(gaps, dtype=real), (1 + real(alpha)) / 2
    speed = np.diff(np.array([0.0] * wall + list(np.asarray(velocities)), dtype=real))
    now, hits = real(0), [0, 0]
    times: list[float] = []
    largest: list[float] = []

    def result(collapsed: bool) -> LineCollisions:
        return LineCollisions(hits[0], hits[1], np.array(times), np.array(largest), collapsed)

    while True:
        closing = speed < 0
        if not closing.any():
            return result(False)
        if abs(speed[closing]).max() < 1e-200:
            return result(True)
        spans = np.where(closing, gap / np.where(closing, -speed, 1), np.inf)
        k = int(spans.argmin())
        now, gap = now + spans[k], gap + speed * spans[k]
        gap[k], approach = 0, speed[k]
        speed[k] = -real(alpha) * approach
        at_wall = wall and k == 0
        if k > 0:
            speed[k - 1] += half * approach
        if k + 1 < speed.size:
            speed[k + 1] += (2 * half if at_wall else half) * approach
        hits[at_wall] += 1
        times.append(float(now))
        largest.append(float(gap[speed < 0].max(initial=0)))
