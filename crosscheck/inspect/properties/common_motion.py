"""Motion of all particles together: of the centre of mass, and in open space a rigid rotation (the flying ice cube).

Thermostats that scale velocities may feed the energy of the particles' motion into that of all of them together, until
they move as one. In equilibrium each of these few degrees of freedom has k_B T/2, as any other.

Literature: S. C. Harvey, R. K.-Z. Tan and T. E. Cheatham, J. Comput. Chem. 19, 726 (1998).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.setting import Setting
from crosscheck.inspect.view import View
from crosscheck.trajectories.frames import Floats
from crosscheck.verdict import Judgement, bounded


class _CommonMotion(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        # energies over that of a degree of freedom, k_B T/2, of each frame
        self._centre: list[float] = []
        self._rotation: list[float] = []
        self._rotations = 0

    def add(self, view: View) -> None:
        setting = self._setting
        total = float(view.kinetic.sum())
        if not total > 0:
            return
        unit = total / setting.freedoms
        self._centre.append(float(np.sum(view.momentum**2)) / setting.moving_masses.sum() / unit)
        if setting.open_space and len(setting.axes) > 1:
            energy, self._rotations = _rotation(view)
            self._rotation.append(energy / unit)

    def judge(self, once: float) -> Told:
        if not self._centre:
            return Told((), ("nothing moves about the centre of mass.",))
        setting = self._setting
        judged, said = [], []
        rows = [("the motion of the centre of mass", np.array(self._centre), len(setting.axes))]
        if self._rotation:
            rows.append(("rigid rotation", np.array(self._rotation), self._rotations))
        meant = setting.scene is not None and not any(setting.conserved.momentum[axis] for axis in setting.axes)
        for what, energies, number in rows:
            if setting.ensemble == "none" or meant:
                first, last = (value / (value + setting.freedoms) for value in (energies[0], energies[-1]))
                reason = "the scene's start states it" if meant else "it is not taken to be in equilibrium"
                said.append(
                    f"share of the kinetic energy in {what}: from {first:.3g} to {last:.3g}; not judged: {reason}."
                )
            else:
                judged.append(self._judged(what, energies, number, once))
        return Told(tuple(judged), tuple(said))

    def _judged(self, what: str, energies: Floats, number: int, once: float) -> Judgement:
        """The mean share of all frames, or of the last quarter, which shows growth."""
        from scipy.stats import f

        freedoms = self._setting.freedoms
        last = energies[-max(1, len(energies) // 4) :]
        value = max(float(energies.mean()), float(last.mean()))
        limit = number * float(f.isf(once / 2, number, freedoms))
        why = (
            f"{number} degrees of freedom of k_B T/2 in equilibrium, also if it is one constant sample: Fisher's F; "
            f"false-alarm rate {once:.2g}; the larger of the means of all frames and of their last quarter"
        )
        first, final = (one / (one + freedoms) for one in (energies[0], energies[-1]))
        judged = bounded(
            f"share of the kinetic energy in {what}",
            value / (value + freedoms),
            limit / (limit + freedoms),
            why,
            note=f"{first:.2e} in the first frame, {final:.2e} in the last",
        )
        return replace(judged, false_alarm=once)


def _rotation(view: View) -> tuple[float, int]:
    """Twice the kinetic energy of rigid rotation, and its number of degrees of freedom: L I^-1 L about the centre."""
    setting, frame = view.setting, view.frame
    assert frame.velocities is not None
    masses, moving = setting.moving_masses, setting.moving
    r, v = (one[moving] - masses @ one[moving] / masses.sum() for one in (frame.positions, frame.velocities))
    momentum = masses @ np.cross(r, v)
    square = np.sum(r**2, axis=1)
    inertia = (masses * square).sum() * np.eye(3) - (masses[:, None] * r).T @ r
    if len(setting.axes) == 2:  # about the axis across the plane alone
        axis = ({0, 1, 2} - set(setting.axes)).pop()
        return float(momentum[axis] ** 2 / inertia[axis, axis]) if inertia[axis, axis] > 0 else 0.0, 1
    rank = int(np.linalg.matrix_rank(inertia, hermitian=True))
    return float(momentum @ np.linalg.pinv(inertia, hermitian=True) @ momentum), rank


def _begin(setting: Setting) -> Collector | str:
    reason = setting.no_velocities()
    if reason:
        return reason
    return _CommonMotion(setting) if setting.freedoms > 0 else "nothing moves about the centre of mass"


PROPERTY = Property("common motion", "velocities", _begin)
