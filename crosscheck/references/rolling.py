"""A ball or disk that slides along a floor until it rolls, on a rigid floor and on one of springs.

A grain of mass m and radius R, with I = q m R^2, rests on a floor that presses it with m g and rubs with mu m g at
most. Along the floor it has the velocity v, and s = R omega, positive where it rolls along v; u = v - s is the slip. A
force F at the floor changes v by F/m and s by -F/(q m), so that v + q s = C never changes and

    v = (C + q u)/(1 + q),        s = (C - u)/(1 + q),        u' = (1 + 1/q) F/m.

On a rigid floor F = -mu m g until u = 0: u falls by a = (1 + 1/q) mu g in unit time, for the time t_1 = |u_0|/a, and
the grain rolls from there on, with v = s = C/(1 + q): 5/7 of v_0 for a ball that starts without spin, for which
t_1 = 2 v_0/(7 mu g), and 2/3 for a disk, t_1 = v_0/(3 mu g). The work of friction is m u_0^2 q/(2 (1 + q)), 2/7 and 1/3
of m v_0^2/2.

On a soft floor F = -k_t xi - gamma_t m u below the limit, xi' = u: it is the law of Cundall and Strack. On the limit
the spring keeps |F| = mu m g, and it sticks as soon as k_t xi + gamma_t m u would fall, at u_1 = gamma_t m a/k_t, that
is at t_1 = (u_0 - u_1)/a. From there on

    u'' + b u' + w^2 u = 0,    b = (1 + 1/q) gamma_t,    w^2 = (1 + 1/q) k_t/m,    with u = u_1 and u' = -a at t_1:

the grain rolls and swings about rolling. It swings by a/w at most, and by less each time: without gamma_t the limit is
reached and not exceeded. What the spring takes to be stretched to the limit at the start, mu m g/(k_t u_0) at most, is
left out.

Literature: G.-G. Coriolis, Theorie mathematique des effets du jeu de billard (Paris, 1835); R. Garg, J. Galvin, T. Li
and S. Pannala, Powder Technol. 220, 122 (2012); P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


class SlideToRoll(NamedTuple):
    """A grain that starts with the velocity v_0 along the floor and s_0 = R omega_0; any consistent units.

    velocity: v_0, length/time. rolling: s_0, length/time. friction: mu. weight: g, the force on the floor over the
    mass, length/time^2. inertia: q. stiffness: k_t/m, 1/time^2; infinity: a rigid floor. damping: gamma_t, 1/time.
    """

    velocity: float
    rolling: float
    friction: float
    weight: float
    inertia: float
    stiffness: float = math.inf
    damping: float = 0.0

    @property
    def slowing(self) -> float:
        """a = (1 + 1/q) mu g, by which the slip falls in unit time; length/time^2."""
        return (1 + 1 / self.inertia) * self.friction * self.weight

    @property
    def time(self) -> float:
        """Duration of the sliding, t_1, time; 0 if the slip at the start does not exceed u_1."""
        return max(0.0, abs(self.velocity - self.rolling) - self._last_slip) / self.slowing

    @property
    def end(self) -> float:
        """Velocity of the rolling grain, C/(1 + q), length/time."""
        return (self.velocity + self.inertia * self.rolling) / (1 + self.inertia)

    @property
    def dissipated(self) -> float:
        """Energy that friction and damping take in all, over the mass, u_0^2 q/(2 (1 + q)); on a floor with damping.

        Without damping, a/w of the slip is left in the swing.
        """
        return 0.5 * self.inertia / (1 + self.inertia) * (self.velocity - self.rolling) ** 2

    @property
    def _last_slip(self) -> float:
        """u_1, of a positive slip."""
        return 0.0 if math.isinf(self.stiffness) else self.damping * self.slowing / self.stiffness

    def slip(self, time: ArrayLike) -> Floats:
        """u(t), length/time.

        time: t >= 0, any shape. ValueError if the swing does not swing, b >= 2 w.
        """
        times, start = np.asarray(time, dtype=np.float64), self.velocity - self.rolling
        side, swung = math.copysign(1.0, start), np.maximum(times - self.time, 0.0)
        sliding = abs(start) - self.slowing * np.minimum(times, self.time)
        if math.isinf(self.stiffness):
            return np.asarray(side * np.where(times < self.time, sliding, 0.0))
        share = 1 + 1 / self.inertia
        half, square = 0.5 * share * self.damping, share * self.stiffness
        if half**2 >= square:
            raise ValueError("the tangential spring is damped so strongly that nothing swings")
        turn = math.sqrt(square - half**2)
        last = min(self._last_slip, abs(start))
        wave = last * np.cos(turn * swung) + (half * last - self.slowing) / turn * np.sin(turn * swung)
        return np.asarray(side * np.where(times < self.time, sliding, np.exp(-half * swung) * wave))

    def motion(self, time: ArrayLike) -> tuple[Floats, Floats]:
        """v(t) and s(t) = R omega(t), length/time.

        time: t >= 0, any shape. ValueError as `slip`.
        """
        slip, constant = self.slip(time), self.velocity + self.inertia * self.rolling
        q = self.inertia
        return np.asarray((constant + q * slip) / (1 + q)), np.asarray((constant - slip) / (1 + q))
