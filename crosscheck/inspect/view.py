"""A frame as the properties look at it: what several of them need is computed once, and only if it is asked for."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from crosscheck.compare.differences import nearest_image
from crosscheck.inspect.setting import Setting
from crosscheck.trajectories.frames import Floats, Frame, Integers


class View:
    """A frame and the one before.

    setting: what is known of the trajectory. index: number of the frame. frame: it. before: the view of the frame
    before; None: it is the first.
    """

    def __init__(self, setting: Setting, index: int, frame: Frame, before: View | None) -> None:
        self.setting, self.index, self.frame, self.before = setting, index, frame, before

    # -- velocities of the particles that move, along the axes along which they do -------------------------------

    @cached_property
    def velocities(self) -> Floats:
        """Velocities of the particles that move, (n, d), length/time."""
        assert self.frame.velocities is not None
        return self.frame.velocities[self.setting.moving][:, list(self.setting.axes)]

    @cached_property
    def momentum(self) -> Floats:
        """Total momentum of the particles that move, (d,)."""
        return np.asarray(self.setting.moving_masses @ self.velocities)

    @cached_property
    def peculiar(self) -> Floats:
        """m v^2 of each particle about the centre of mass, along each axis, (n, d): energies."""
        masses = self.setting.moving_masses
        return np.asarray(masses[:, None] * self.relative**2)

    @cached_property
    def relative(self) -> Floats:
        """Velocities about that of the centre of mass, (n, d)."""
        return self.velocities - self.momentum / self.setting.moving_masses.sum()

    @cached_property
    def kinetic(self) -> Floats:
        """Twice the kinetic energy about the centre of mass along each axis, (d,)."""
        return np.asarray(self.peculiar.sum(axis=0))

    # -- displacements from the frame before ----------------------------------------------------------------------

    @cached_property
    def displacements(self) -> Floats:
        """Differences of positions to the frame before, (n, 3), of the particles that move."""
        assert self.before is not None
        moving = self.setting.moving
        return self.frame.positions[moving] - self.before.frame.positions[moving]

    @cached_property
    def nearest(self) -> Floats:
        """The displacements to the nearest image, (n, 3)."""
        box = self.frame.box
        return self.displacements if box is None else nearest_image(self.displacements, box)

    @cached_property
    def interval(self) -> float:
        """Time from the frame before, of the clock of the setting."""
        values = self.setting.clock.values
        return float(values[self.index] - values[self.index - 1])

    @cached_property
    def travelled(self) -> Floats | None:
        """Mean of the velocities of both frames times the interval, (n, 3), length; None: not known in that unit."""
        if self.before is None or not self.setting.clock.same_unit:
            return None
        here, there = self.frame.velocities, self.before.frame.velocities
        if here is None or there is None:
            return None
        return np.asarray((here + there)[self.setting.moving] / 2 * self.interval)

    @property
    def ids(self) -> Integers:
        """Ids of the particles that move, (n,)."""
        return self.frame.ids[self.setting.moving]
