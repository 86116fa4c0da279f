"""The angular momentum where nothing turns the particles from outside: spins of grains included."""

from __future__ import annotations

import numpy as np

from crosscheck.engines.soft_spheres import inertia_ratio
from crosscheck.references import EPSILON
from crosscheck.scene import AXES, Floats
from crosscheck.simulate.conserved import turns
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.rounding import of_forces
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, round_off, worst

#: Roundings of a product r x m v in an event or a step.
_EACH = 16


def _excuse(trial: Trial) -> str | None:
    scene = trial.scene
    if scene.lattice_gas is not None:
        return "a lattice gas: see the law particles"
    if trial.broken:
        return trial.broken
    if trial.method.contact is not None and scene.spin_dimension:
        return "soft contacts with friction: the arms of their torques are radii, whatever the overlap"
    found = turns(scene, trial.method)
    if isinstance(found, str):
        return f"something turns the particles: {found}" if found != "dimension=1" else "on a line nothing turns"
    if not trial.event_driven and not trial.claims.symplectic:
        return f"scheme {trial.method.scheme} does not claim to be symplectic: it keeps it to its order alone"
    return None


def _judge(trial: Trial) -> Judged:
    """L(t) - L(0) about the point that does not matter, or the middle of the cylinder."""
    found = turns(trial.scene, trial.method)
    assert not isinstance(found, str)
    middle, kept = found
    times, r, v = trial.states
    m = trial.start.masses
    x, p = _wide(r) - middle, m[:, None] * _wide(v)
    total = np.cross(x, p).sum(axis=1) + _spinning(trial, len(times))
    arms = np.linalg.norm(x, axis=2)
    scale = float((arms * np.linalg.norm(p, axis=2)).sum(axis=1).max()) + float(np.abs(total).max())
    largest = float((arms * np.linalg.norm(p, axis=2)).max()) + float(np.abs(total).max()) / len(m)
    rounding = EPSILON * _EACH * (trial.number_of_events * largest + len(m) * scale)
    rounding += trial.end * float((of_forces(trial) * arms.max(axis=0)).sum())
    if trial.method.dt is not None:  # velocities as differences of positions
        rounding += _EACH * EPSILON * float((m * arms.max(axis=0) ** 2).sum()) / trial.method.dt
    why = (
        f"{_EACH} roundings of the largest r x m v for each of {trial.number_of_events} steps or events, of "
        "the forces of all steps, and of the sums, at worst all alike"
    )
    return worst(
        [
            round_off(
                f"change of the angular momentum about {AXES[axis]}, relative to the sum of m r |v|",
                float(np.abs(total[:, axis] - total[0, axis]).max()) / (scale or 1.0),
                rounding / (scale or 1.0) or EPSILON,
                why,
            )
            for axis in np.flatnonzero(kept)
        ],
        f"{len(times)} states",
    )


def _wide(vectors: Floats) -> Floats:
    """(..., d) as (..., 3)."""
    return np.pad(vectors, ((0, 0),) * (vectors.ndim - 1) + ((0, 3 - vectors.shape[-1]),))


def _spinning(trial: Trial, samples: int) -> Floats:
    """Sum of I omega at each state, (S, 3)."""
    start = trial.start.angular_velocities
    if start is None or trial.start.diameters is None:
        return np.zeros((samples, 3))
    spins = trial.run.get("angular_velocities")
    last = trial.run["final_angular_velocities"]
    if spins is None:
        spins = np.array([start, last])
    elif len(spins) < samples:
        spins = np.concatenate([spins, last[None]])
    inertia = inertia_ratio(trial.scene) * trial.start.masses * (trial.start.diameters / 2) ** 2
    turning = np.einsum("i,sij->sj", inertia, spins)
    return np.pad(turning, ((0, 0), (3 - turning.shape[1], 0)))


LAWS = (
    Law(
        "angular-momentum",
        "sum of r x m v + I omega = its value at the start",
        _excuse,
        _judge,
        records=("trajectory",),
    ),
)
