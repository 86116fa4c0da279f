"""Between plane walls the impulses on the walls follow exactly from the collisions and the kinetic energy."""

from __future__ import annotations

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, round_off

_NEEDED = ("wall_impulse", "collisional_virial", "kinetic_energy_integral")
#: Roundings of an impulse times a length.
_EACH = 16


def _excuse(trial: Trial) -> str | None:
    scene, spheres = trial.scene, trial.scene.hard_spheres
    if spheres is None or not trial.event_driven:
        return "of hard spheres from event to event"
    if trial.broken:
        return trial.broken
    if "periodic" in scene.boundaries or scene.across or not any(scene.faces):
        return "of boxes with plane walls, and without periodic axes or cylinders"
    if scene.acceleration is not None or spheres.friction is not None or spheres.fixed:
        return "fields, friction and fixed particles exert forces that are not summed as a virial"
    for face in scene.faces:
        if face is not None and (face.oscillation is not None or face.temperature is not None):
            return "walls that move, or draw tangential velocities, are not counted by their impulse alone"
    diameters = trial.start.diameters
    assert diameters is not None
    if np.unique(diameters).size > 1:
        return "particles of several sizes stop at several distances from a wall"
    missing = [name for name in _NEEDED if name not in trial.run]
    return f"the engine does not measure {missing[0]}" if missing else None


def _judge(trial: Trial) -> Judged:
    """sum m r.v, from the middle, at start and end: its change is 2 int K dt + W - sum over faces of (L/2 - R) I."""
    run, d = trial.run, trial.scene.dimension
    lengths, diameters = trial.scene.lengths(), trial.start.diameters
    assert lengths is not None
    assert diameters is not None
    times, r, v = trial.states
    m = trial.start.masses
    moment = (m[:, None] * (r - lengths / 2) * v).sum(axis=(1, 2))
    reach = np.repeat(lengths / 2 - diameters[0] / 2, 2)
    outwards = run["wall_impulse"][-1, np.arange(2 * d), np.repeat(np.arange(d), 2)] * np.tile([-1.0, 1.0], d)
    right = 2 * run["kinetic_energy_integral"][-1] + run["collisional_virial"][-1] - (reach * outwards).sum()
    scale = 2 * run["kinetic_energy_integral"][-1] + abs(run["collisional_virial"][-1]) + np.abs(moment).max()
    error = float(abs(moment[-1] - moment[0] - right) / (scale or 1.0))
    number = trial.number_of_events
    return round_off(
        "residual of the virial theorem, relative",
        error,
        EPSILON * _EACH * (number + len(m)),
        f"{_EACH} roundings of a sum for each of {number} events and for each particle, at worst all alike",
        note=f"until t = {times[-1]:g}",
    )


LAWS = (
    Law(
        "virial-theorem",
        "[sum m r.v] = 2 int K dt + sum r_ij.dp_ij - sum over walls of (L/2 - R) times the impulse",
        _excuse,
        _judge,
        records=("trajectory", *_NEEDED),
    ),
)
