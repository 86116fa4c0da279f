"""Searches for collisions after each time step: positions and velocities from one sample to the next."""

from __future__ import annotations

import numpy as np

from crosscheck.engines.registry import engine_class
from crosscheck.references import EPSILON
from crosscheck.references.collision_steps import Spheres, after_steps
from crosscheck.simulate.judging.audits.pieces import from_start_and_end, with_output
from crosscheck.simulate.judging.law import none_there
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, round_off, worst

#: Steps between samples, pairs in all steps, samples at most, and roundings of a coordinate from one to the next.
_EVERY, _PAIRS, _MOST, _ROUNDINGS = 8, 2_000_000, 250, 64
_WHY = "64 roundings of a coordinate, and of a normal, over the steps between two samples"


def excuse(trial: Trial) -> str | None:
    """None, or why no step can be audited; trial: a run by a search for collisions."""
    if "impulses_after_steps" not in getattr(engine_class(trial.planned.engine), "promises", ()):
        return "the engine does not promise which impulses its search gives"
    spheres = trial.scene.hard_spheres
    assert spheres is not None
    if spheres.friction or spheres.well or trial.scene.acceleration or spheres.fixed or any(trial.scene.faces):
        return "the auditor of such searches knows smooth spheres alone, without walls and fields"
    return None if _samples(trial) >= 2 else "the run has too few steps"


def _samples(trial: Trial) -> int:
    most = min(_MOST, _PAIRS // (_EVERY * max(trial.scene.number, 2) ** 2))
    return min(most, trial.scene.steps(trial.method.step) // _EVERY)


def _pieces(trial: Trial) -> list[tuple[str, Extra]]:
    found, dt = [], trial.method.step
    duration = _samples(trial) * _EVERY * dt
    for where, scene in from_start_and_end(trial):
        piece = with_output(scene, trial.method, duration, interval=_EVERY * dt, trajectory=True)
        found.append((where, Extra(f"the audit of steps {where}", piece, trial.method, trial.seconds(duration))))
    return found


def extras(trial: Trial) -> list[Extra]:
    """The runs that the audit asks for; trial: the run."""
    return [extra for _, extra in _pieces(trial)]


def judge(trial: Trial) -> Judged:
    """Each sample, from the one before it. trial: the run."""
    scene, dt = trial.scene, trial.method.step
    state, hard = trial.start, scene.hard_spheres
    assert hard is not None
    assert state.diameters is not None
    spheres = Spheres(state.masses.tolist(), state.diameters.tolist(), hard.restitution, scene.periods().tolist())
    far = fast = 0.0
    impulses = judged = crowded = 0
    for _, extra in _pieces(trial):
        run = trial.make(extra)
        x, v = run["positions"], run["velocities"]
        fastest = float(np.linalg.norm(v, axis=2).max())
        for k in range(len(x) - 1):
            moved = after_steps(spheres, x[k], v[k], dt, _EVERY)
            impulses += moved.impulses
            if moved.crowded:
                crowded += 1
                continue
            judged += 1
            place = EPSILON * float(np.abs(x[k : k + 2]).max() + fastest * _EVERY * dt)
            grown = (1 + fastest * _EVERY * dt / moved.closest) ** max(moved.most - 1, 0)
            slips = _ROUNDINGS * fastest * (EPSILON + place / moved.closest) * grown
            far = max(far, float(np.abs(x[k + 1] - moved.positions).max()) / (_ROUNDINGS * place + slips * _EVERY * dt))
            fast = max(fast, float(np.abs(v[k + 1] - moved.velocities).max()) / (slips or EPSILON))
    found = [
        round_off("places, in units of their rounding", far, 1.0, _WHY),
        round_off("velocities, in units of their rounding", fast, 1.0, _WHY),
    ]
    if not impulses or not judged:
        why = "what does not happen is not judged"
        found.append(none_there("impulses that were audited", why, number=float(impulses)))
    note = f"{judged} times {_EVERY} steps, {impulses} impulses"
    return worst(found, note + (f"; {crowded} with three spheres together left out" if crowded else ""))
