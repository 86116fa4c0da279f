"""Angular momentum in open space: conserved about the origin to rounding, by central forces and symplectic schemes."""

from __future__ import annotations

import numpy as np

from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.rounding import bound_of_sum, furthest
from crosscheck.inspect.schemes import not_symplectic
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import Floats


class _AngularMomentum(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._momenta: list[Floats] = []
        self._rounding: list[float] = []
        self._squares: list[float] = []
        self._sizes: list[float] = []

    def add(self, view: View) -> None:
        setting, frame = self._setting, view.frame
        assert frame.velocities is not None
        masses, moving, rounding = setting.moving_masses, setting.moving, setting.source.rounding
        r, v = frame.positions[moving], frame.velocities[moving]
        far, fast = np.linalg.norm(r, axis=1), np.linalg.norm(v, axis=1)
        off = [np.linalg.norm(rounding[name].of(one), axis=1) for name, one in (("positions", r), ("velocities", v))]
        self._momenta.append(masses @ np.cross(r, v))
        self._rounding.append(
            float(
                bound_of_sum(masses * far * off[1], masses * fast * off[0], rounding["masses"].of(masses) * far * fast)
            )
        )
        self._squares.append(float(np.sum((masses * far * fast) ** 2)))
        self._sizes.append(float(np.sum(masses * far * fast)))

    def judge(self, once: float) -> Told:
        setting = self._setting
        momenta, size = np.array(self._momenta), max(self._sizes) or 1.0
        change = np.linalg.norm(momenta - momenta[0], axis=1)
        reason = setting.conserved.angular_momentum or not_symplectic(setting.scene)
        if reason:
            far = float(change.max()) / size
            return Told((), (f"it changes by {far:.2e} of the sum of m r v at most, which is not judged: {reason}.",))
        file = np.array(self._rounding)
        steps = np.array([setting.steps_to(index) for index in range(len(change))])
        # positions and velocities both round once a step
        walk = setting.epsilon * bound_of_sum(np.sqrt(2 * steps * max(self._squares))[None])
        allowed = np.hypot(file, file[0]) + walk
        why = (
            "rounding of the file, and of each particle's position and velocity a step, independent of each other: "
            "what their sum exceeds with the probability 1e-9 (Hoeffding)"
        )
        return Told((furthest("change of the angular momentum, over the sum of m r v", change, allowed, size, why),))


def _begin(setting: Setting) -> Collector | str:
    reason = setting.no_velocities()
    if reason:
        return reason
    if len(setting.axes) == 1:
        return "on a line it is 0"
    return _AngularMomentum(setting) if setting.open_space else "it is conserved in open space, and there is a box"


PROPERTY = Property("angular momentum", "conservation", _begin)
