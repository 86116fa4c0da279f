"""A column of soft beads on a line that falls on a floor, by an adaptive Runge-Kutta method.

Literature: S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994) and 50, 4113
(1994).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crosscheck.references.soft_impact import damping, stiffness

Floats = NDArray[np.float64]


def soft_chain(
    number: int, restitution: float, t_c: float, gap: float, speed: float, duration: float
) -> tuple[Floats, Floats]:
    """Soft beads on a line, `duration` after the lowest, at `speed`, has met the floor, in a field of 1.

    y_i'' = -1 + F_i - F_(i+1), F = k delta - c sqrt(m k) v_n where beads overlap, m = 1/2 between beads and 1 at the
    floor, k = (pi^2 + ln^2 alpha)/(2 t_c^2), c = 2 |ln alpha|/sqrt(pi^2 + ln^2 alpha); by an adaptive Runge-Kutta
    method, relative error 1e-8 a step, steps up to t_c/5 so that no contact is missed. Beads have diameter and mass 1.

    number: of beads; restitution: alpha between beads and at the floor, above 0; t_c: duration of a contact of two
    beads alone (time); gap: between the surfaces of neighbours at the start (length). Returns two arrays (number,),
    from the lowest bead upwards: heights of the centres above the floor, and velocities, positive upwards.

    speed: of the lowest bead at the first contact (length/time). duration: (time). The field is 1 length/time^2.
    """
    from scipy.integrate import solve_ivp

    k = stiffness(restitution, 0.5, t_c)
    dashpots = damping(restitution) * np.sqrt(k * np.array([1.0] + [0.5] * (number - 1)))

    def rates(t: float, state: Floats) -> Floats:
        y, v = state[:number], state[number:]
        # the floor's surface is where a bead below it would have its centre
        overlap = 1 - np.diff(y, prepend=-0.5)
        force = np.where(overlap > 0, k * overlap - dashpots * np.diff(v, prepend=0.0), 0.0)
        return np.concatenate([v, force - np.append(force[1:], 0.0) - 1])

    start = np.concatenate([0.5 + np.arange(number) * (1 + gap), np.full(number, -speed)])
    done = solve_ivp(rates, (0.0, duration), start, rtol=1e-8, atol=1e-10 * speed * t_c, max_step=t_c / 5)
    return done.y[:number, -1], done.y[number:, -1]
