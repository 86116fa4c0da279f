"""Bodies on circles: the exact solution of Verlet's difference equation, after any number of steps.

Where every body circles about one axis at one angular velocity w, its acceleration is -w^2 r, r from the centre. Then
r_n+1 - 2 r_n + r_n-1 = dt^2 a(r_n) has the solution r_n = r_0 turned by n theta, with 2 sin(theta/2) = w dt: positions
stay on their circles, turn too fast by a relative w^2 dt^2/24, and (r_n+1 - r_n-1)/2dt is the velocity. It is exact for
every step: what is left of an engine's error is rounding.

Literature: J. L. Lagrange, Essai sur le probleme des trois corps (1772), of the triangle; E. J. Routh, Proc. London
Math. Soc. 6, 86 (1875), that it is stable if one mass is large; L. Verlet, Phys. Rev. 159, 98 (1967), of the equation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosscheck.references import EPSILON

Floats = NDArray[np.float64]

#: An orthogonal frame that is aligned with no axis; the bodies circle about its third vector.
_FRAME = np.linalg.qr(np.array([[0.6, -0.3, 0.5], [0.2, 0.9, 0.4], [-0.7, 0.1, 0.8]]))[0]


@dataclass(frozen=True)
class Circles:
    """Bodies that circle about the origin under their gravity, each at its own angular velocity.

    masses: (N,). radii, phases: of the circles, and of the bodies on them at time 0, (N,). rates: angular velocities,
    (N,), radians per unit of time.
    """

    masses: Floats
    radii: Floats
    phases: Floats
    rates: Floats

    def angle(self, dt: float) -> Floats:
        """What each body turns by in a step of length dt, (N,), radians: 2 arcsin(w dt/2)."""
        return 2 * np.arcsin(self.rates * dt / 2)

    def positions(self, dt: float, steps: int) -> Floats:
        """Where the bodies are after `steps` steps of length dt, (N, 3)."""
        return self._place(self.phases + np.remainder(steps * self.angle(dt), 2 * np.pi), self.radii)

    def velocities(self, dt: float, steps: int) -> Floats:
        """(r_n+1 - r_n-1)/2dt, the velocities after `steps` steps of length dt, (N, 3)."""
        angle = self.angle(dt)
        ahead = self.phases + np.remainder(steps * angle, 2 * np.pi) + np.pi / 2
        return self._place(ahead, self.radii * np.sin(angle) / dt)

    def rounding_error(self, dt: float, steps: int) -> float:
        """Bound on the standard deviation of a body's place, over its radius, if each of so many steps rounds r and v.

        dt, steps: the length of a step, and their number. A relative error e of the distance or of the speed at time t
        changes the mean distance by up to 2 e, the rate by 3 e w, and the place at the end by 3 e w (T - t): with
        e = eps/sqrt(12) for each of the two, in every step, the sum is 3 eps w T (2 steps/36)^(1/2) (Brouwer, Astron.
        J. 46, 149 (1937)). Softening lessens it.
        """
        return float(3 * EPSILON * steps * self.angle(dt).max() * np.sqrt(steps / 18))

    def _place(self, angles: Floats, lengths: Floats) -> Floats:
        plane = np.stack([lengths * np.cos(angles), lengths * np.sin(angles), 0 * lengths], axis=-1)
        return plane @ _FRAME.T


def triangle(masses: tuple[float, float, float], side: float, G: float, softening: float) -> Circles:
    """Three bodies at the corners of an equilateral triangle: w^2 = G M/(side^2 + softening^2)^(3/2).

    masses: any; M is their sum. side, softening: lengths. G: length^3/(mass time^2).
    """
    mass = np.array(masses)
    corners = side / np.sqrt(3) * np.exp(2j * np.pi * np.arange(3) / 3)
    from_centre = corners - (mass * corners).sum() / mass.sum()
    phases: Floats = np.arctan2(from_centre.imag, from_centre.real)
    rate = np.sqrt(G * mass.sum() / (side**2 + softening**2) ** 1.5)
    return Circles(mass, np.abs(from_centre), phases, np.full(3, rate))


def satellites(number: int, centre: int, mass: float, G: float, softening: float) -> Circles:
    """Bodies without mass, each on a circle of its own about a body that has mass and rests.

    number: of all bodies. centre: which of them has the `mass`. G, softening: as for `triangle`. The radii are 1 ... 2.
    """
    radii = np.linspace(1.0, 2.0, number)
    rates = np.sqrt(G * mass / (radii**2 + softening**2) ** 1.5)
    at_rest = np.arange(number) == centre
    return Circles(
        np.where(at_rest, mass, 0.0),
        np.where(at_rest, 0.0, radii),
        np.array([2.4 * body for body in range(number)]),
        np.where(at_rest, 0, rates),
    )
