"""How many independent samples of its velocities a file holds: where particles keep them to its end, it is one.

A series that is shorter than its correlation time hardly scatters, and what it seems to say of its own error is worth
nothing. Whether velocities last to the end of the file is told by the particles themselves: by how far velocities, and
their squares, are correlated with those of the first frame that counts.
"""

from __future__ import annotations

import numpy as np

from crosscheck.inspect.view import View
from crosscheck.statistics import Mean, correlated_mean
from crosscheck.trajectories.frames import Floats

#: Correlation at the end of the file, in the mean of its last quarter, above which it holds one sample.
_KEPT = 0.5
#: Degrees of freedom of an error that follows from one sample: so few that the verdict is inconclusive.
_ONE = 3.0
#: Distance of independent frames, in those of independent values with the same error.
_APART = 2.0


class Samples:
    """The correlation of velocities, and of their squares, with those of the first frame that is shown."""

    def __init__(self) -> None:
        self._first: tuple[Floats, Floats] | None = None
        self._kept: list[float] = []

    def add(self, view: View) -> None:
        """Takes the correlations of a frame. view: of it."""
        velocities = view.relative * view.setting.moving_masses[:, None] ** 0.5
        squares = np.sum(velocities**2, axis=1)
        now = (velocities / (np.linalg.norm(velocities) or 1.0), _unit(squares - squares.mean()))
        if self._first is None:
            self._first = now
        self._kept.append(max(float(np.sum(one * other)) for one, other in zip(self._first, now, strict=True)))

    @property
    def one(self) -> bool:
        """Whether the file holds one sample of the velocities."""
        last = self._kept[-max(1, len(self._kept) // 4) :]
        return float(np.mean(last)) > _KEPT

    def mean(self, values: Floats, variance: float) -> Mean:
        """The mean of a series of the frames that were shown, (F,); of one sample, with the error that this has.

        values: in time. variance: of one value, if all is right.
        """
        found = correlated_mean(values)
        return Mean(found.value, variance**0.5, 1.0, _ONE) if self.one else found

    def independent(self, values: Floats) -> float:
        """The number of independent values of a series of the frames that were shown, (F,). values: in time."""
        return 1.0 if self.one else min(correlated_mean(values).independent, float(len(values)))


def apart(number: int, independent: float) -> int:
    """How far apart frames are that are independent one by one: every n-th, 1 + 2 (F/N - 1) rounded up.

    number: F, of frames. independent: N, of independent values with the same error, which are half as far apart: a
    correlation exp(-k/tau) is 0.14 there, and 0.02 at twice the distance.
    """
    return min(max(int(np.ceil(1 + _APART * (number / independent - 1))), 1), number)


def _unit(values: Floats) -> Floats:
    return np.asarray(values / (float(np.linalg.norm(values)) or 1.0))
