"""In equilibrium each free velocity component has the same share of the kinetic energy."""

from __future__ import annotations

from crosscheck.scene import AXES
from crosscheck.simulate.judging.equilibrium import equilibrium, extras, mean_of, settled, why_none
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, statistical, worst

_WHY = "uniform on a sphere in the space of all scaled velocities; standard error of correlated samples"


def _excuse(trial: Trial) -> str | None:
    return why_none(trial) or (None if trial.measures("velocities") else "the engine records no velocities")


def _judge(trial: Trial) -> Judged:
    """Shares of the kinetic energy, of each axis and of the particles of each mass, over what they should have."""
    found = equilibrium(trial)
    shares, f = found.shares, found.freedoms
    series = {f"along {AXES[axis]}": shares[:, :, axis].mean(axis=1) * f for axis in range(shares.shape[2])}
    if len(found.groups) > 1:
        series |= {group.strip(): shares[:, members].mean(axis=(1, 2)) * f for group, members in found.groups.items()}
    judged = []
    for name, values in series.items():
        mean = mean_of(values)
        quantity = f"kinetic energy of a velocity component {name}, over T/2"
        judged.append(settled(found, statistical(quantity, mean.value, mean.error, 1.0, 0.0, _WHY, samples=mean)))
    return worst(judged, f"{found.samples} samples until t = {found.scene.duration:g}")


LAWS = (Law("equipartition", "<m v_x^2> = <m v_y^2> = ... = T, for each mass", _excuse, _judge, extra=extras),)
