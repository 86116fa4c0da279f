"""The energy: conserved to rounding from event to event, to the order of the scheme by steps; or accounted for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from crosscheck.convergence import ORDER_TOLERANCE
from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
from crosscheck.scene import Method
from crosscheck.simulate import conserved
from crosscheck.simulate.judging.ladder import (
    continuous_energy,
    energy_of,
    first_extras,
    is_cut,
    ladder,
    looser,
    recorded,
)
from crosscheck.simulate.judging.law import Law, none_there
from crosscheck.simulate.judging.recording import in_steps
from crosscheck.simulate.judging.rounding import of_forces
from crosscheck.simulate.judging.smoothness import claimed_order, jump, late_kicks
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, Judgement, bounded, round_off

#: Roundings of an energy in an event or a step.
_EACH = 16
#: Of so many particles the energy fluctuates alike with any step; of fewer, single encounters count.
MANY = 50
#: Halvings of dt in a run of many.
_HALVINGS = 2
#: A fluctuation that grows by more when dt becomes smaller is none of a fluid in equilibrium.
_GROWN = 3.0
#: How far below its order a change may fall.
_HALF = 0.5
#: What halving dt changes adds up to no more than so many times the first change, if it falls at least as dt^0.1.
_SLOWLY = 16.0
#: Standard deviations of what late kicks do: beyond it is the probability 6e-7.
_SIGMAS = 5.0


def _tallied(trial: Trial) -> bool:
    """Whether the energy is not conserved, and all that collisions and walls do to it was counted."""
    if conserved.energy(trial.scene, trial.method) == "kept":
        return False
    walls = any(face is not None for face in trial.scene.faces) or bool(trial.scene.across)
    known = "dissipated_energy" in trial.run and ("wall_energy" in trial.run or not walls)
    return trial.event_driven and known


def _excuse(trial: Trial) -> str | None:
    scene, run = trial.scene, trial.run
    if scene.lattice_gas is not None:
        return "a lattice gas: see the law particles"
    if trial.broken:
        return trial.broken
    if "kinetic_energy" not in run:
        return "the engine does not measure it"
    if "potential_energy" not in run and conserved.has_potential(scene, trial.method):
        return "the engine does not measure the potential energy"
    if _tallied(trial):
        return None
    reasons = conserved.changes_energy(scene, trial.method)
    if conserved.energy(scene, trial.method) == "changed":
        return f"it changes, and by how much was not counted: {', '.join(reasons)}"
    if trial.kind == "stepping" and not first_extras(trial):
        return "the run has too few steps"
    return None


def _judge(trial: Trial) -> Judged:
    if trial.kind == "adaptive":
        return _by_tolerance(trial)
    if trial.kind != "stepping":
        return _by_rounding(trial)
    if conserved.energy(trial.scene, trial.method) == "lost":
        return _only_lost(trial)
    return _of_many(trial) if trial.scene.number >= MANY else _of_few(trial)


# -- without time steps ------------------------------------------------------------------------------------------------


def _by_rounding(trial: Trial) -> Judged:
    """E(t) - E(0), with what was dissipated and what walls gave; or that it does not grow."""
    run, tallied = trial.run, _tallied(trial)
    energy = energy_of(run)
    change, scale = energy - energy[0], float(np.abs(run["kinetic_energy"]).max())
    scale += float(np.abs(run.get("potential_energy", np.zeros(1))).max())
    if tallied:
        given = run["wall_energy"].sum(axis=1) if "wall_energy" in run else 0.0
        change = change + run["dissipated_energy"] - given
        scale += float(np.abs(run["dissipated_energy"]).max() + np.abs(given).max())
    if trial.scene.acceleration is not None:  # heights of either sign
        heights = np.abs(trial.states[1] @ np.array(trial.scene.acceleration)) @ trial.start.masses
        scale += float(heights.max())
    number = trial.number_of_events
    scale = scale or 1.0
    rounding = EPSILON * _EACH * (number + trial.scene.number)
    why = f"{_EACH} roundings for each of {number} steps or events and for each particle, at worst all alike"
    if tallied or conserved.energy(trial.scene, trial.method) == "kept":
        name = "change of the energy" + ", less what was dissipated and what walls gave" * tallied
        return round_off(f"{name}, relative", float(np.abs(change).max()) / scale, rounding, why)
    grown = float((energy - np.minimum.accumulate(energy)).max())
    return round_off("growth of an energy that can only be lost, relative", grown / scale, rounding, why)


# -- with a tolerance --------------------------------------------------------------------------------------------------


def _by_tolerance(trial: Trial) -> Judged:
    """The error of the energy, beside that with ten times the tolerance: it falls as its power 3/4 at least."""
    kept = conserved.energy(trial.scene, trial.method) == "kept"

    def off(run: Run) -> float:
        energy = energy_of(run)
        return float((np.abs(energy - energy[0]) if kept else energy - np.minimum.accumulate(energy)).max())

    loose = trial.make(looser(trial, trial.scene))
    if loose.diverged or loose.stopped:
        return _unknown("the run with ten times the tolerance ended before its time")
    rounding = _rounding(trial, trial.run, trial.end)
    name = "error of the energy" if kept else "growth of an energy that can only be lost"
    return bounded(
        f"{name}, over what ten times the tolerance and rounding leave of it",
        off(trial.run),
        off(loose) / 2 + rounding,
        "a tenth of the tolerance leaves a sixth of an error that follows it, and all of one that does not: half is "
        "between them",
        note=f"tolerance {trial.method.allowed:g}",
    )


# -- with time steps ---------------------------------------------------------------------------------------------------


def _rounding(trial: Trial, run: Run, duration: float) -> float:
    """What rounding may make of the energy within this duration."""
    kinetic, steps = float(np.abs(run["kinetic_energy"]).max()), max(run.cost.steps, 1)
    potential = float(np.abs(run.get("potential_energy", np.zeros(1))).max())
    speed = float(np.linalg.norm(trial.states[2], axis=2).max())
    return (
        EPSILON * _EACH * ((steps + trial.scene.number) * kinetic + trial.scene.number * potential)
        + duration * speed * float(of_forces(trial).sum())
        + float(of_forces(trial).sum()) * float(np.abs(trial.states[1]).max())
    )


def _of_few(trial: Trial) -> Judged:
    """Until the horizon: what the energy changes by with the smallest dt is what remains after the last halving."""
    found = ladder(trial)
    if found is None or not found.energies:
        return _unknown("the beginning of the run cannot be compared with smaller steps")
    series = [continuous_energy(found.scene, run)[: found.horizon] for run in found.runs]
    scale = max(float(np.abs(found.runs[-1][name]).max()) for name in ("kinetic_energy", "potential_energy")) or 1.0
    off, coarse = (float(np.abs(energy - series[0][0]).max()) for energy in (series[-1], series[0]))
    claimed, jumps = claimed_order(trial), jump(trial.scene)
    order = 1 if claimed is None or jumps else claimed
    changes = [float(np.abs(b - a).max()) for a, b in pairwise(series)]
    change = changes[-1]
    if jumps:  # errors of first order and random size: as large as any of the halvings tells
        change = max(one / 2**k for k, one in enumerate(reversed(changes)))
    remains = change / (2 ** (order - ORDER_TOLERANCE) - 1)
    limit = (remains + _rounding(trial, found.runs[-1], found.until)) / scale
    why = f"an error of the order {order}, to a quarter, is 1/(2^p - 1) of what halving dt has changed; and rounding"
    note = f"dt = {found.steps[-1]:g}, until t = {found.until:g} of {trial.scene.duration:g}; "
    note += f"{coarse / scale:.2g} with dt = {found.steps[0]:g}"
    judged = bounded("change of the energy with the smallest dt, relative", off / scale, limit, why, note=note)
    if judged.outcome == "fail" and claimed is None:
        return replace(judged, outcome="inconclusive", note=f"{note}; the scheme claims no order")
    return judged if _falls(changes, order) or off > _SLOWLY * max(changes) else _not_yet(judged)


def _long(trial: Trial) -> list[Extra]:
    """Runs as long as the allowance makes possible, with dt, dt/2 and dt/4, and all energies."""
    method, whole = trial.method, trial.scene.duration
    share = trial.allowance / max((2 ** (_HALVINGS + 1) - 1) * trial.seconds(whole), 1e-9)
    fits = in_steps(max(whole * min(1.0, share), method.step), [method.step], 50 if is_cut(trial.scene) else 400)
    if fits is None or round(fits[0] / fits[1]) < 8:
        return []
    scene = recorded(trial, *fits, trajectory=is_cut(trial.scene))
    extras = []
    for k in range(_HALVINGS + 1):
        smaller = Method.model_validate({**method.model_dump(), "dt": method.step / 2**k})
        changed = scene.model_copy(update={"method": smaller})
        extras.append(Extra(f"the energy with dt/{2**k}", changed, smaller, trial.seconds(fits[0], 2.0**k)))
    return extras


def _of_many(trial: Trial) -> Judged:
    """The fluctuation of the energy falls as dt^p, but for what late kicks at a cutoff add up to."""
    extras, order = _long(trial), claimed_order(trial)
    if not extras or order is None:
        return _unknown("the run has too few steps" if order is not None else "the scheme claims no order")
    series = [continuous_energy(extra.scene, trial.make(extra)) for extra in extras]
    runs = [trial.make(extra) for extra in extras]
    parts = (runs[0]["kinetic_energy"], runs[0]["potential_energy"])
    scale = max(float(np.abs(part).max()) for part in parts) or 1.0
    off = [float(np.mean((energy - energy[0]) ** 2)) ** 0.5 for energy in series]
    duration = extras[0].scene.duration
    late = 0.0
    if trial.scene.lennard_jones is not None:
        kinetic = float(runs[0]["kinetic_energy"].max())
        late = _SIGMAS * late_kicks(trial, extras[-1].method.step, duration, kinetic)
    falls = off[0] / 2 ** (_HALVINGS * (order - ORDER_TOLERANCE))
    limit = falls + late + _rounding(trial, runs[-1], duration)
    shown = ", ".join(f"{one / scale:.3g}" for one in off)
    note = f"{shown} with dt, dt/2, dt/4 until t = {duration:g} of {trial.scene.duration:g}"
    why = f"it falls as dt^{order}, to a quarter of the order"
    if late:
        why += f"; and {_SIGMAS:g} standard deviations of kicks that come up to a step late ({jump(trial.scene)})"
    name = "change of the energy with dt/4, root of its mean square, relative"
    judged = bounded(name, off[-1] / scale, limit / scale, why, note=note)
    last = off[-2] / 2 ** (order - ORDER_TOLERANCE)
    return _not_yet(judged) if off[-1] <= last + late or off[-1] > _GROWN * off[0] else judged


def _only_lost(trial: Trial) -> Judged:
    """Until the horizon, no growth but what the steps make."""
    found = ladder(trial)
    if found is None or not found.energies:
        return _unknown("the beginning of the run cannot be compared with smaller steps")
    series = [energy_of(run)[: found.horizon] for run in found.runs]
    fine, finer = series[-2:]
    scale = max(float(np.abs(finer).max()), float(np.abs(found.runs[-1]["kinetic_energy"]).max())) or 1.0
    grown = float((finer - np.minimum.accumulate(finer)).max())
    limit = 2 * float(np.abs(finer - fine).max()) + _rounding(trial, found.runs[-1], found.until)
    why = "twice what the last halving of dt has changed, of two samples; and roundings of all steps"
    note = f"dt = {found.steps[-1]:g}, until t = {found.until:g} of {trial.scene.duration:g}"
    name = "growth of an energy that can only be lost, relative"
    judged = bounded(name, grown / scale, limit / scale, why, note=note)
    changes = [float(np.abs(b - a).max()) for a, b in pairwise(series)]
    return judged if _falls(changes, 1) or grown > _SLOWLY * max(changes) else _not_yet(judged)


def _falls(changes: Sequence[float], order: int) -> bool:
    """Whether what halving dt changes falls, to half an order: where it does not, dt is no small number yet."""
    return len(changes) > 1 and changes[-1] * 2 ** (order - _HALF) <= changes[-2]


def _not_yet(judged: Judgement) -> Judgement:
    """The judgement, not red."""
    if judged.outcome != "fail":
        return judged
    note = f"{judged.note}; it does not yet fall as it should for small steps: take a smaller dt"
    return replace(judged, outcome="inconclusive", note=note)


def _unknown(reason: str) -> Judged:
    return none_there("runs whose energy could be judged", "the law holds for the scene", note=reason)


def _extra(trial: Trial) -> Iterable[Extra]:
    if trial.kind == "adaptive":
        return [looser(trial, trial.scene)]
    if trial.kind != "stepping":
        return []
    many = conserved.energy(trial.scene, trial.method) == "kept" and trial.scene.number >= MANY
    return _long(trial) if many else first_extras(trial)


LAWS = (
    Law(
        "energy",
        "K + U + dissipated - given by walls = its value at the start",
        _excuse,
        _judge,
        records=(
            "kinetic_energy", "potential_energy", "rotational_energy", "dissipated_energy", "wall_energy", "events",
        ),
        extra=_extra,
    ),
)  # fmt: skip
