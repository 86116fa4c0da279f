"""Flow and sound between two parallel walls at which the fluid does not slip.

Literature: L. D. Landau and E. M. Lifshitz, Fluid Mechanics, secs. 17 and 24; G. Kirchhoff, Ann. Phys. 210, 177 (1868).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def forced_profile(force: ArrayLike, spacing: float) -> tuple[NDArray[np.float64], float]:
    """G with G'' = -F, G = 0 at the first place and at its periodic image: a steady flow has nu j = G.

    force: F (places,), per volume, at places `spacing` apart, of which the first is a wall. Returns G (places,), and
    the sum of F over the channel, F H of a uniform force, of which each wall takes half. The second differences of G
    are -F: exact for a uniform force, G = F y (H - y)/2, else to O(spacing^2).

    spacing: length. Any consistent units.
    """
    given = np.asarray(force, dtype=np.float64)
    y = np.arange(given.size) * spacing
    height = given.size * spacing
    stress = np.cumsum(given * spacing)
    profile = -np.cumsum(np.concatenate([[0.0], stress[:-1]])) * spacing
    profile += y / height * -(profile[-1] - stress[-1] * spacing)
    return profile, float(stress[-1])


def channel_sound(speed: float, viscosity: complex, wavenumber: float, height: float, slip: float = 0.0) -> complex:
    """Complex rate s of sound, exp(s t), along a channel, per unit of time.

    speed: c of free sound. viscosity: nu; complex where the stress lags behind the shear at this frequency (see
    `lagging_viscosity`). wavenumber: k along the channel. height: H between the walls. slip: b, at a wall the fluid
    slips by b times its gradient there. All in one set of units, the boundary layers (2 nu/(c k))^(1/2) thin beside H.

    s^2/(1 - tanh(q)/(q + (2 b/H) q^2 tanh(q))) + nu k^2 s + c^2 k^2 = 0, q = (H/2)(s/nu)^(1/2): the momentum along
    the channel averaged over its height, with the boundary layers of an incompressible flow on both walls (G.
    Kirchhoff, Ann. Phys. 210, 177 (1868)). Im s is the frequency, -Re s the damping.
    """
    s = complex(0.0, speed * wavenumber)
    for _ in range(200):
        q = height / 2 * np.sqrt(s / viscosity)
        layers = 1 - np.tanh(q) / (q * (1 + 2 * slip / height * q * np.tanh(q)))
        new = complex(np.sqrt(-layers * (viscosity * wavenumber**2 * s + speed**2 * wavenumber**2)))
        new = new if new.imag > 0 else -new
        if abs(new - s) < 1e-15:
            break
        s = (new + s) / 2
    return s


def lagging_viscosity(short: float, long: float) -> complex:
    """Viscosity at the frequency omega in two dimensions, where stresses have a long-time tail: nu - i pi A/2.

    The stress correlation falls as A/t, so the integral of it times exp(-i omega t) is nu - A ln(omega t_0) - i pi A/2,
    and the viscosity of shear waves grows by A ln 4 when they are made twice as long and decay four times slower (L. P.
    Kadanoff, G. R. McNamara and G. Zanetti, Phys. Rev. A 40, 4527 (1989)). short: nu of shear waves that decay with the
    rate omega. long: of waves twice as long.
    """
    return complex(short, -np.pi / 2 * (long - short) / np.log(4))
