"""Two runs of one scene agree: paths until the horizon of chaos, means of stationary series after it.

`agreement` is what the judge calls for each pair of runs, with `excuse` before it and `extras` to say what it takes.

Runs that take the same steps, or go from event to event, claim the same paths to the last digits: `crosscheck.compare`
classes them, with the rate of chaos of a disturbed twin. Others part by what their time steps are off by. How far two
right ones may be apart is then the sum over both: up to twice what halving dt changes (an error is of the order dt^p,
p >= 1; four times, where forces or collisions act up to a step late), and rounding errors, which grow as those of a
twin. Where that sum is no longer small beside the lengths of the scene, paths say nothing any more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck.compare.outcome import status
from crosscheck.compare.trajectories import compare_trajectories
from crosscheck.compare.twin import neighbours_of, rate_of
from crosscheck.engines.protocol import Run
from crosscheck.references.recurrences import MAPS
from crosscheck.scene import Floats, Method, Output, Scene
from crosscheck.simulate import conserved
from crosscheck.simulate.judging import equilibrium
from crosscheck.simulate.judging.ladder import (
    LEAST_SAMPLES,
    MOST_SAMPLES,
    apart,
    first_extras,
    halved,
    ladder,
    looser,
    rounding_growth,
    twin_of,
)
from crosscheck.simulate.judging.law import none_there
from crosscheck.simulate.judging.recording import in_steps, with_observables
from crosscheck.simulate.judging.smoothness import jump
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.simulate.observables import observables
from crosscheck.simulate.summary import length_unit
from crosscheck.statistics import Mean, student_quantile
from crosscheck.status import Status
from crosscheck.trajectories.frames import Source
from crosscheck.trajectories.memory import in_memory
from crosscheck.verdict import DRIFTING, Judgement, bounded, statistical

#: Share of the length of the scene up to which two paths are compared.
_HORIZON = 0.1
#: How often a beginning is made shorter until it is within the horizon.
_TRIES = 4
#: Independent samples at least in the second half of a run, where a series is no better known.
_SHORTEST = 40
#: Models of lattice gases whose collisions draw nothing.
_DETERMINISTIC = ("hpp",)


def excuse(one: Trial, other: Trial) -> str | None:
    """None, or why nothing of the two runs can be compared. one, other: the runs."""
    if one.broken or other.broken:
        return one.broken or other.broken
    if one.scene.lattice_gas is not None:
        return _of_sites(one, other)
    if one.method.contact != other.method.contact:
        return "hard spheres beside soft ones, or other contacts: not compared, they agree in the hard limit alone"
    paths, means = _no_paths(one, other), _no_means(one, other)
    return None if paths is None or means is None else f"{paths}; {means}"


def extras(one: Trial, other: Trial) -> list[tuple[Trial, Extra]]:
    """The extra runs that a comparison will ask for, as far as that is known. one, other: the runs."""
    if one.scene.lattice_gas is not None:
        return []
    found = []
    for trial in (one, other):
        if trial.method.dt is not None and not _same_steps(one, other):
            found += [(trial, extra) for extra in first_extras(trial)]
        if _no_means(one, other) is None and equilibrium.why_none(trial) is None:
            found += [(trial, extra) for extra in equilibrium.extras(trial)]
    return found


def agreement(one: Trial, other: Trial) -> list[Judgement]:
    """How far two runs of a scene are apart, in paths and means. one, other: the runs, for which there is no `excuse`.

    Unsupported, EngineError: as of `Trial.make`.
    """
    if one.scene.lattice_gas is not None:
        here, there = one.run["populations"], other.run["populations"]
        differing = float((here != there).sum())
        why = "the same bits: nothing is drawn, or the same numbers are"
        return [bounded("populations that differ", differing, 0.0, why)]
    found = [_paths(one, other)] if _no_paths(one, other) is None else []
    if _no_means(one, other) is None:
        found += _means(one, other)
    return found or [_unknown("the series are too short for means")]


# -- what can be compared ----------------------------------------------------------------------------------------------


def _of_sites(one: Trial, other: Trial) -> str | None:
    gas = one.scene.lattice_gas
    assert gas is not None
    if "populations" not in one.run or one.run["populations"].shape != other.run["populations"].shape:
        return "populations were not measured by both"
    whole = [bool((trial.run["populations"] == np.round(trial.run["populations"])).all()) for trial in (one, other)]
    if whole[0] != whole[1]:
        return "particles and mean occupations are equal on average alone"
    same = one.planned.engine == other.planned.engine
    drawn = gas.model not in _DETERMINISTIC or gas.force is not None
    drawn = drawn or any(obstacle.rule.startswith("diffusive") for obstacle in gas.obstacles)
    return "each engine draws its own random numbers" if drawn and not same else None


def _no_paths(one: Trial, other: Trial) -> str | None:
    """None, or why single paths cannot be compared."""
    walls = [face for face in one.scene.faces if face is not None]
    drawn = any(face.temperature is not None or face.random_phase is not None for face in walls)
    if drawn and one.planned.engine != other.planned.engine:
        return "walls draw random numbers, each engine its own"
    for trial in (one, other):
        if not trial.measures("positions"):
            return f"{trial.planned.label} records no positions"
        if trial.kind == "stepping" and not first_extras(trial):
            return f"{trial.planned.label} has too few steps"
    return None


def _no_means(one: Trial, other: Trial) -> str | None:
    """None, or why means cannot be compared."""
    if one.scene.number < equilibrium.FEWEST:
        return "few particles have no means"
    if conserved.energy(one.scene, one.method) == "lost":
        return "what only loses energy is never stationary"
    return None


# -- paths -------------------------------------------------------------------------------------------------------------


class _Beginning(NamedTuple):
    """A run until the horizon.

    scene: what was run. run: it. twin: from a disturbed start. rounding: how far its rounding errors may have grown at
    each sample, length.
    """

    scene: Scene
    run: Run
    twin: Run
    rounding: Floats


def _paths(one: Trial, other: Trial) -> Judgement:
    return _of_same_steps(one, other) if _same_steps(one, other) else _of_other_steps(one, other)


def _same_steps(one: Trial, other: Trial) -> bool:
    """Whether both are the same motion but for rounding: from event to event, or one scheme with one form and one dt.

    Two codes may evaluate the dashpots of soft contacts at different velocities: these are not the same steps.
    """
    if one.event_driven and other.event_driven:
        return True
    same = one.method.scheme == other.method.scheme and one.method.dt == other.method.dt
    return same and one.scene.hard_spheres is None and len(MAPS.get(one.method.scheme, ())) == 1


def _of_same_steps(one: Trial, other: Trial) -> Judgement:
    """What `crosscheck.compare` says of both, until rounding errors may have grown to a tenth of the scene's length."""
    trials = (one, other)
    duration = min(trial.end * min(1.0, trial.allowance / max(4 * trial.seconds(trial.end), 1e-9)) for trial in trials)
    found = _until_horizon(trials, duration, MOST_SAMPLES // 2, lambda both: both[0].rounding + both[1].rounding)
    if isinstance(found, str):
        return _unknown(found)
    both, allowed, known = found
    here, there = both
    away = float(apart(here.run, there.run)[0])
    if away > allowed[0]:  # what else may pass for a disturbance
        return bounded("distance of the starts", away, float(allowed[0]), "rounding: both start where the scene says")
    first, second = _source(one, here.run, known), _source(other, there.run, known)
    rates = [rate_of(part.run, part.twin, near=neighbours_of(one.scene)) for part in both]
    # of right runs they are equal; one that is wrong may part faster from its own twin
    rate = min((rate for rate in rates if rate is not None), key=lambda rate: rate.value, default=None)
    # statistics are looked at below, of longer series
    compared = compare_trajectories(first, second, "tolerance", rate=rate)
    parting = None if compared.growth is None else compared.growth.parting
    left = 0 if parting is None else parting.frame
    standing = status(compared.classed, "chaos")
    until = f"until t = {here.run['time'][known - 1]:g} of {one.scene.duration:g}"
    judged = bounded(
        "samples at which the runs are further apart than rounding and chaos explain",
        float(known - left if standing == Status.FAILED else 0),
        0.0,
        "crosscheck compare, at the rate of chaos of a disturbed twin: the steps are the same",
        note=f"{until}: {compared.sentence}",
    )
    return replace(judged, outcome="inconclusive") if standing == Status.INCONCLUSIVE else judged


def _until_horizon(
    trials: tuple[Trial, Trial], duration: float, wanted: int, allowed: Callable[[list[_Beginning]], Floats]
) -> tuple[list[_Beginning], Floats, int] | str:
    """Beginnings of both that are so short that many samples are before the horizon, and the number of those; or why
    there are none.

    duration: at most. wanted: number of samples before it. allowed: how far two such runs may be apart, (samples,).
    """
    steps = [trial.method.step for trial in trials if trial.method.dt is not None]
    length, _ = length_unit(trials[0].scene)
    for _ in range(_TRIES):
        fits = in_steps(duration, steps, MOST_SAMPLES)
        if fits is None:
            return "the time steps have no common multiple within the horizon"
        both = [_beginning(trial, _recorded(trial, *fits)) for trial in trials]
        away = np.maximum.accumulate(allowed(both))
        known = int((away <= _HORIZON * length).sum())
        if known >= min(wanted, len(away)):
            break
        shorter = 1.25 * float(both[0].run["time"][max(known, 1)])
        if shorter >= duration:
            break
        duration = shorter
    return (both, away, known) if known > 1 else "the runs part before the first sample"


def _source(trial: Trial, run: Run, number: int) -> Source:
    """The positions of a run as a trajectory; number: of its first samples."""
    positions = run["positions"][:number]
    steps = None if trial.method.dt is None else np.rint(run["time"][:number] / trial.method.dt).astype(np.int64)
    wide = np.pad(positions, ((0, 0), (0, 0), (0, 3 - positions.shape[2])))
    return in_memory(trial.result.engine, run["time"][:number], wide, steps=steps)


def _of_other_steps(one: Trial, other: Trial) -> Judgement:
    """Positions until the sum of both errors is a tenth of the scene's length."""
    trials = (one, other)
    length, unit = length_unit(one.scene)

    def explained(both: list[_Beginning]) -> Floats:
        parts = [_off(trial, part) for trial, part in zip(trials, both, strict=True)]
        return np.asarray(parts[0] + parts[1])

    found = _until_horizon(trials, min(_horizon(trial) for trial in trials), LEAST_SAMPLES, explained)
    if isinstance(found, str):
        return _unknown(found)
    both, allowed, known = found
    away = apart(both[0].run, both[1].run)[:known]
    share = away[1:] / np.where(allowed[1:known] > 0, allowed[1:known], np.finfo(float).tiny)
    worst = int(np.argmax(share)) + 1
    time = both[0].run["time"]
    note = f"until t = {time[known - 1]:g} of {one.scene.duration:g}: {away.max() / length:.2g} of the {unit}; largest "
    note += f"share at t = {time[worst]:g}, {away[worst] / length:.2g} where {allowed[worst] / length:.2g} is explained"
    why = (
        "twice (late kicks: four times) what halving dt changes, or what ten times the tolerance does, and rounding "
        "errors as they grow in a twin, of both"
    )
    name = "distance of the paths over what dt and rounding explain, largest"
    return bounded(name, float(share.max()), 1.0, why, note=note)


def _horizon(trial: Trial) -> float:
    """Until when the beginning of a run is looked at first."""
    if trial.kind == "stepping":
        found = ladder(trial)
        return trial.scene.duration if found is None else found.until
    share = trial.allowance / max(4 * trial.seconds(trial.end), 1e-9)
    return trial.end * min(1.0, share)


def _recorded(trial: Trial, duration: float, interval: float) -> Scene:
    names = ("kinetic_energy", "collisions", "trajectory")
    output = with_observables(trial.planned.engine, trial.scene, trial.method, Output(interval=interval), names)
    return trial.scene.model_copy(update={"duration": duration, "output": output})


def _beginning(trial: Trial, scene: Scene) -> _Beginning:
    whole = Extra("the beginning", scene, trial.method, trial.seconds(scene.duration))
    run, twin = trial.make(whole), trial.make(twin_of(trial, scene))
    return _Beginning(scene, run, twin, rounding_growth(trial, run, twin))


def _off(trial: Trial, beginning: _Beginning) -> Floats:
    """How far a run may be off at each sample of its beginning, (samples,), length."""
    if trial.kind == "adaptive":  # what ten times the tolerance changes is more than what is left of it
        return np.asarray(
            np.maximum.accumulate(apart(beginning.run, trial.make(looser(trial, beginning.scene)))) + beginning.rounding
        )
    if trial.method.dt is None:
        return beginning.rounding
    run, half = beginning.run, trial.make(halved(trial, beginning.scene))
    late = trial.kind == "collision_search" or jump(trial.scene) is not None
    off = (4.0 if late else 2.0) * np.maximum.accumulate(apart(run, half))
    if trial.kind == "collision_search":
        fastest = float(np.linalg.norm(run["velocities"], axis=2).max())
        collided = run.get("collisions", np.arange(len(off)))
        off = off + np.where(collided > 0, 2 * fastest * trial.method.step, 0.0)
    return np.asarray(off + beginning.rounding)


def _unknown(reason: str) -> Judgement:
    why = "paths until chaos, means of what is stationary"
    return none_there("samples at which the runs can be compared", why, note=reason)


# -- means -------------------------------------------------------------------------------------------------------------


def _means(one: Trial, other: Trial) -> list[Judgement]:
    """Means of what both have measured and what is stationary in both, each with the error of correlated samples."""
    here, there = _series(one), _series(other)
    half = [_half(trial) if one.method != other.method else {} for trial in (one, other)]
    judged = []
    for name in here:
        if name not in there or np.array_equal(here[name], there[name]):
            continue  # of the same numbers there is nothing to be told
        means = [equilibrium.mean_of(series[name]) for series in (here, there)]
        doubt = sum(
            abs(mean.value - float(np.mean(smaller[name])))
            for mean, smaller in zip(means, half, strict=True)
            if name in smaller
        )
        one_judged = (
            statistical(
                f"mean of {name.replace('_', ' ')}", means[0].value, means[0].error, means[1].value, means[1].error,
                "standard errors of correlated series" + ("; what halving dt changes" if doubt else ""),
                samples=means, doubt=doubt,
            )
        )  # fmt: skip
        if one_judged.outcome == "fail" and any(_changes(mean) for mean in means):
            note = f"{one_judged.note}; not stationary: a longer run may tell"
            one_judged = replace(one_judged, outcome="inconclusive", note=note)
        judged.append(one_judged)
    return judged


def _changes(mean: Mean) -> bool:
    trend = mean.trend
    return trend is not None and trend.sigmas > student_quantile(DRIFTING, trend.freedom)


def _series(trial: Trial) -> dict[str, Floats]:
    """Columns of a run from where it has forgotten its start: of the run for means, or of its own second half."""
    if equilibrium.why_none(trial) is None:
        found = equilibrium.equilibrium(trial)
        return _columns(found.scene, trial.method, found.run, found.first)
    return _columns(trial.scene, trial.method, trial.run, len(trial.run["time"]) // 2)


def _half(trial: Trial) -> dict[str, Floats]:
    """The same with half the time step, of a run in equilibrium that takes steps."""
    if trial.method.dt is None or equilibrium.why_none(trial) is not None:
        return {}
    found = equilibrium.equilibrium(trial)
    return _columns(found.scene, trial.method, trial.make(halved(trial, found.scene)), found.first)


def _columns(scene: Scene, method: Method, run: Run, first: int) -> dict[str, Floats]:
    """Energies and pressure of samples, but those that are constant; rates of sums, between samples."""
    if len(run["time"]) - first < _SHORTEST or scene.output.interval is None:
        return {}
    table = observables(scene, run)
    names = ["kinetic_energy", "potential_energy", "rotational_energy"]
    if scene.hard_spheres is not None and not conserved.has_potential(scene, method):
        names.remove("potential_energy")
        if conserved.energy(scene, method) == "kept":
            names.remove("kinetic_energy")
    found = {name: table[name][first:] for name in names if name in table}
    if "virial" in run:
        found["virial"] = run["virial"][first:]
    if scene.hard_spheres is None and "pressure" in table:
        found["pressure"] = table["pressure"][first:]
    lost = ["dissipated_energy"] * conserved.dissipates(scene, method)  # of what dissipates nothing it is rounding
    for name in ("collisions", "collisional_virial", *lost, "wall_torque"):
        if name in run:
            found[f"rate of {name}"] = (np.diff(run[name]) / np.diff(run["time"]))[first:]
    return {name: values for name, values in found.items() if np.isfinite(values).all()}


def pairs(trials: Sequence[Trial]) -> list[tuple[Trial, Trial]]:
    """Each pair of runs, in their order; trials: the runs."""
    return [(one, other) for k, one in enumerate(trials) for other in trials[k + 1 :]]


def name_of(one: Trial, other: Trial) -> str:
    """What a pair of runs is called in the record; one, other: the runs."""
    return f"{one.result.engine} - {other.result.engine}"
