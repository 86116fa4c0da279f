"""The total momentum along each axis: what walls and a uniform field do not change stays as it is."""

from __future__ import annotations

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.scene import AXES, Floats
from crosscheck.simulate.conserved import changes_momentum
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.rounding import of_forces
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, round_off, worst

#: Roundings of a momentum in an event or a step: of the impulse, its components and both sums.
_EACH = 8


def _walls_known(trial: Trial) -> bool:
    """Whether the momentum given to walls is counted, impulse by impulse, until the end."""
    counted = trial.event_driven and "wall_impulse" in trial.run
    return counted and float(trial.run["time"][-1]) >= trial.end * (1 - 1e-9)


def _reasons(trial: Trial) -> list[str | None]:
    known = _walls_known(trial)
    return [
        changes_momentum(trial.scene, trial.method, axis, walls_known=known) for axis in range(trial.scene.dimension)
    ]


def _excuse(trial: Trial) -> str | None:
    if trial.scene.lattice_gas is not None:
        return "a lattice gas: see the law particles"
    if trial.broken:
        return trial.broken
    if trial.kind == "adaptive":  # of implicit schemes, whose equations are solved to the tolerance
        return f"scheme {trial.method.scheme} need not keep it better than its tolerance: see the law energy"
    reasons = _reasons(trial)
    if None not in reasons:
        return f"momentum goes elsewhere: {', '.join(dict.fromkeys(filter(None, reasons)))}"
    return None


def _judge(trial: Trial) -> Judged:
    """P(t) - P(0) - M g t, and what walls were given, by axis."""
    times, r, v = trial.states
    free, masses = trial.free, trial.start.masses
    m = masses[free]
    total = np.einsum("i,sij->sj", m, v[:, free])
    given = _given(trial, times)
    field = np.zeros(trial.scene.dimension)
    if trial.scene.acceleration is not None:
        field = np.array(trial.scene.acceleration)
    change = total - total[0] + given - m.sum() * times[:, None] * field
    scale = float(np.abs(m[:, None] * v[:, free]).sum(axis=(1, 2)).max()) + float(np.abs(given).max(initial=0.0))
    scale += float(m.sum() * np.abs(field).max(initial=0.0) * trial.end)
    rounding = EPSILON * _EACH * (trial.number_of_events * _largest(m, v[:, free]) + len(m) * scale)
    rounding += EPSILON * trial.number_of_events * float(np.abs(given).max(initial=0.0))
    rounding += trial.end * float(of_forces(trial).sum())
    if trial.method.dt is not None:  # velocities as differences of positions
        rounding += _EACH * EPSILON * float(m.sum() * np.abs(r).max()) / trial.method.dt
    why = (
        f"{_EACH} roundings of the largest momentum for each of {trial.number_of_events} steps or events, of "
        "the forces of all steps, and of the sums, at worst all alike"
    )
    judged = []
    for axis, reason in enumerate(_reasons(trial)):
        if reason is None:
            error = float(np.abs(change[:, axis]).max())
            name = f"change of the momentum along {AXES[axis]}, relative to the sum of m |v|"
            judged.append(round_off(name, error / (scale or 1.0), rounding / (scale or 1.0) or EPSILON, why))
    left = [f"{AXES[axis]}: {reason}" for axis, reason in enumerate(_reasons(trial)) if reason is not None]
    return worst(judged, "; ".join([f"{len(times)} states", *left]))


def _largest(masses: Floats, velocities: Floats) -> float:
    return float(np.abs(masses[:, None] * velocities).max(initial=0.0))


def _given(trial: Trial, times: Floats) -> Floats:
    """Momentum given to all walls until each time, (S, d); 0 where it was not measured."""
    if not _walls_known(trial):
        return np.zeros((times.size, trial.scene.dimension))
    impulses = trial.run["wall_impulse"].sum(axis=1)
    if len(impulses) < times.size:  # the end is a state of its own
        return np.concatenate([impulses, impulses[-1:]])
    return np.asarray(impulses if len(impulses) == times.size else impulses[[0, -1]])


LAWS = (
    Law(
        "momentum",
        "sum of m v + momentum given to walls - M g t = its value at the start",
        _excuse,
        _judge,
        records=("trajectory", "wall_impulse"),
    ),
)
