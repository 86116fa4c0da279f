"""How many independent samples of its velocities a file holds: where particles keep them to its end, it is one.

And whether particles stay in their places: waves of a crystal may keep their energies for longer than any file lasts,
so that the time average of a temperature along an axis is one sample of theirs, although velocities change signs.

A series that is shorter than its correlation time hardly scatters, and what it seems to say of its own error is worth
nothing. Whether velocities last to the end of the file is told by the particles themselves: by how far velocities, and
their squares, are correlated with those of the first frame that counts.

Literature: E. Fermi, J. Pasta and S. Ulam, Los Alamos report LA-1940 (1955); F. A. Lindemann, Phys. Z. 11, 609 (1910),
for how far particles of a crystal go.
"""

from __future__ import annotations

import math

import numpy as np

from crosscheck.compare.differences import nearest_image
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.statistics import Mean, correlated_mean, student_quantile
from crosscheck.trajectories.frames import Floats

#: Correlation at the end of the file, in the mean of its last quarter, above which it holds one sample.
_KEPT = 0.5
#: Root mean square displacement, in distances of neighbours, from which on particles do not stay in place: crystals
#: melt at about 0.15 from a site, which is 0.2 from one frame to a later one.
_BOUND = 0.4
#: Degrees of freedom of an error that follows from one sample: so few that the verdict is inconclusive.
_ONE = 3.0
#: Distance of independent frames, in those of independent values with the same error.
_APART = 2.0


class Samples:
    """The correlation of velocities, and of their squares, with those of the first frame that is shown.

    setting: what is known of the trajectory.
    """

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._first: tuple[Floats, Floats] | None = None
        self._places: Floats | None = None
        self._kept: list[float] = []
        self._moved: list[float] = []

    def add(self, view: View) -> None:
        """Takes the correlations of a frame. view: of it."""
        setting = self._setting
        velocities = view.relative * setting.moving_masses[:, None] ** 0.5
        squares = np.sum(velocities**2, axis=1)
        now = (velocities / (np.linalg.norm(velocities) or 1.0), _unit(squares - squares.mean()))
        if self._first is None:
            self._first = now
        self._kept.append(max(float(np.sum(one * other)) for one, other in zip(self._first, now, strict=True)))
        places = view.frame.positions[setting.moving]
        if self._places is None:
            self._places = places
        moved = places - self._places
        if view.frame.box is not None:
            moved = nearest_image(moved, view.frame.box)
        self._moved.append(float(np.mean(np.sum(moved**2, axis=1))) ** 0.5 / setting.spacing)

    @property
    def one(self) -> bool:
        """Whether the file holds one sample of the velocities."""
        return _at_the_end(self._kept) > _KEPT

    @property
    def waves(self) -> bool:
        """Whether waves may keep their energies: particles are still about their places, without a bath."""
        return self._setting.ensemble != "nvt" and _at_the_end(self._moved) < _BOUND

    def doubt(self, variance: float, once: float) -> tuple[float, str]:
        """What waves that keep their energies may add to a mean over all frames, and the end of a sentence on it.

        As far as one frame scatters. variance: of one frame, if all is right. once: probability of a false alarm.
        """
        if self.one or not self.waves:
            return 0.0, ""
        why = "; the doubt is what one frame scatters: particles stay in place, and waves may keep their energies"
        return student_quantile(once, math.inf) * variance**0.5, why

    def mean(self, values: Floats, variance: float) -> Mean:
        """The mean of a series of the frames that were shown, (F,); of one sample, with the error that this has.

        values: in time. variance: of one value, if all is right.
        """
        found = correlated_mean(values)
        return Mean(found.value, variance**0.5, 1.0, _ONE) if self.one else found

    def independent(self, values: Floats) -> float:
        """The number of independent values of a series of the frames that were shown, (F,). values: in time."""
        return 1.0 if self.one or self.waves else min(correlated_mean(values).independent, float(len(values)))


def apart(number: int, independent: float) -> int:
    """How far apart frames are that are independent one by one: every n-th, 1 + 2 (F/N - 1) rounded up.

    number: F, of frames. independent: N, of independent values with the same error, which are half as far apart: a
    correlation exp(-k/tau) is 0.14 there, and 0.02 at twice the distance.
    """
    return min(max(int(np.ceil(1 + _APART * (number / independent - 1))), 1), number)


def _at_the_end(values: list[float]) -> float:
    """The mean of the last quarter."""
    return float(np.mean(values[-max(1, len(values) // 4) :]))


def _unit(values: Floats) -> Floats:
    return np.asarray(values / (float(np.linalg.norm(values)) or 1.0))
