"""Total momentum: conserved along each axis along which nothing outside acts, to rounding."""

from __future__ import annotations

import numpy as np

from crosscheck.figure import Figure
from crosscheck.inspect.curves import in_time
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.rounding import bound_of_sum, furthest
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.scene import AXES
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement


class _Momentum(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._momenta: list[Floats] = []
        self._rounding: list[Floats] = []
        self._squares: list[Floats] = []
        self._sizes: list[Floats] = []

    def add(self, view: View) -> None:
        setting = self._setting
        masses, v = setting.moving_masses[:, None], view.velocities
        rounding = setting.source.rounding
        file = bound_of_sum(masses * rounding["velocities"].of(v), rounding["masses"].of(masses) * np.abs(v))
        self._momenta.append(view.momentum)
        self._rounding.append(file)
        self._squares.append(np.sum((masses * v) ** 2, axis=0))
        self._sizes.append(np.abs(masses * v).sum(axis=0))

    def judge(self, once: float) -> Told:
        setting = self._setting
        momenta, sizes = np.array(self._momenta), np.max(self._sizes, axis=0)
        judged: list[Judgement] = []
        said: list[str] = []
        for column, axis in enumerate(setting.axes):
            name, size = AXES[axis], float(sizes[column]) or 1.0
            change = momenta[:, column] - momenta[0, column]
            reason = setting.conserved.momentum[axis]
            if reason:
                far = float(np.abs(change).max()) / size
                said.append(
                    f"momentum along {name} changes by {far:.2e} of the sum of m |v_{name}| at most, which is not "
                    f"judged: {reason}."
                )
                continue
            judged.append(self._judged(name, change, size, column))
        figure = Figure(
            "Change of the momentum",
            setting.clock.name,
            "over the sum of m |v| along the axis",
            series=tuple(
                in_time(f"along {AXES[axis]}", setting, (momenta[:, column] - momenta[0, column]) / sizes[column])
                for column, axis in enumerate(setting.axes)
                if sizes[column] > 0
            ),
        )
        return Told(tuple(judged), tuple(said), (figure,) if figure.series else ())

    def _judged(self, name: str, change: Floats, size: float, column: int) -> Judgement:
        """The frame whose momentum is furthest from that of the first, as a share of what rounding allows."""
        setting = self._setting
        file = np.array([one[column] for one in self._rounding])
        squares = np.array([one[column] for one in self._squares]).max()
        steps = np.array([setting.steps_to(index) for index in range(len(change))])
        allowed = np.hypot(file, file[0]) + setting.epsilon * bound_of_sum(np.sqrt(steps * squares)[None])
        why = (
            "rounding of the file's velocities and masses, and one of each particle's momentum a step, independent of "
            "each other: what their sum exceeds with the probability 1e-9 (Hoeffding)"
        )
        quantity = f"change of the momentum along {name}, over the sum of m |v_{name}|"
        return furthest(quantity, change, allowed, size, why)


def _begin(setting: Setting) -> Collector | str:
    return setting.no_velocities() or _Momentum(setting)


PROPERTY = Property("momentum", "conservation", _begin)
