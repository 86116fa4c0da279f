"""Walls with a temperature give particles velocities of a gas of that temperature that comes through the wall."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import Floats, Output, Scene, explicit
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, Judgement, by_chance, statistical, worst

#: Hits of thermal walls that are wanted; events of all kinds in a run at most, passages of cells included; particles.
_HITS, _EVENTS, _SOME = 80_000.0, 1_000_000.0, 20
#: How often a run is made longer, and by what factor at least.
_TRIES, _LONGER = 2, 1.5


def _excuse(trial: Trial) -> str | None:
    if not _faces(trial):
        return "no walls with a temperature"
    if trial.broken:
        return trial.broken
    if not trial.event_driven or not trial.able(_extra(trial).scene):
        return "the engine keeps no trace of its events"
    return None if _hits_of(trial) > 0 else "no particle has hit them"


def _faces(trial: Trial) -> dict[int, float]:
    """Temperatures of the thermal walls, by their numbers."""
    faces = enumerate(trial.scene.faces)
    return {k: face.temperature for k, face in faces if face is not None and face.temperature is not None}


def _hits_of(trial: Trial) -> float:
    """How often the thermal walls were hit in the run, or an estimate that is too low where that is not known."""
    counted = trial.run.get("wall_collisions")
    return float(trial.run.cost.events) / 100 if counted is None else float(counted[-1, list(_faces(trial))].sum())


def _extra(trial: Trial) -> Extra:
    """A run of some of the particles with a trace; of another attempt, with other random numbers.

    What a wall draws depends on nothing but the mass: among few particles most events are hits of walls.
    """
    scene = _of_some(trial)
    share = scene.number / trial.scene.number
    longer = min(_HITS / max(_hits_of(trial) * share, 1.0), _EVENTS / max(trial.run.cost.events * share, 1))
    affordable = trial.allowance / max(trial.seconds(trial.end) * share, 1e-9)
    duration = trial.end * min(longer, max(1.0, affordable))
    scene = scene.model_copy(update={"seed": (trial.seed or 0) + trial.attempt})
    return _lasting(duration, Extra("draws of thermal walls", scene, trial.method, trial.seconds(duration) * share))


def _lasting(duration: float, extra: Extra) -> Extra:
    changes = {"duration": duration, "output": Output(interval=duration, trace=True)}
    return replace(extra, scene=extra.scene.model_copy(update=changes))


def _with_many(trial: Trial) -> Run:
    """A run with as many hits as are wanted and can be had: few particles hit walls less often than a crowd."""
    extra = _extra(trial)
    run = trial.make(extra)
    for _ in range(_TRIES):
        hits = float(np.isin(run["event_partners"][:, 1], [-1 - face for face in _faces(trial)]).sum())
        longer = min(
            _HITS / max(hits, 1.0), _EVENTS / max(run.cost.events, 1), trial.allowance / max(run.cost.cpu, 1e-9)
        )
        if longer < _LONGER:
            break
        extra = _lasting(longer * extra.scene.duration, extra)
        run = trial.make(extra)
    return run


def _of_some(trial: Trial) -> Scene:
    """The scene with so many of its particles as are enough, of those that move."""
    scene, start = trial.scene, trial.start
    free = np.flatnonzero(trial.free)
    if free.size <= _SOME:
        return scene
    chosen = free[np.linspace(0, free.size - 1, _SOME).astype(int)]
    spins = None if start.angular_velocities is None else start.angular_velocities[chosen]
    changes: dict[str, Any] = {"initial": explicit(start.positions[chosen], start.velocities[chosen], spins)}
    for name in ("masses", "species"):
        each = getattr(scene, name)
        if isinstance(each, tuple):
            changes[name] = tuple(each[k] for k in chosen)
    return scene.model_copy(update=changes)


def _judge(trial: Trial) -> Judged:
    """Energies with which particles leave each wall, and the distribution of the normal ones."""
    run = _with_many(trial)
    who, v = run["event_partners"].astype(int), run["event_velocities"][:, 0]
    masses, faces = _of_some(trial).own_start().masses, _faces(trial)
    judged: list[Judgement] = []
    for temperature in sorted(set(faces.values())):
        normal, along = [], []
        for face in (face for face, one in faces.items() if one == temperature):
            hit = who[:, 1] == -1 - face
            energies = 0.5 * masses[who[hit, 0]][:, None] * v[hit] ** 2 / temperature
            normal.append(energies[:, face // 2])
            along.append(np.delete(energies, face // 2, axis=1).sum(axis=1))
        judged += _of_walls(np.concatenate(normal), np.concatenate(along), trial.scene.dimension, temperature)
    return worst(judged, f"{len(who)} events, of which {int((who[:, 1] < 0).sum())} at walls")


def _of_walls(normal: Floats, along: Floats, dimension: int, temperature: float) -> list[Judgement]:
    """normal: m v_n^2/2T of each draw, (draws,). along: the same of the components along the wall, summed."""
    from scipy.stats import expon, kstest, kstwo

    number, name = len(normal), f"walls of T = {temperature:g}"
    if number < 2:
        return [statistical(f"energy with which particles leave {name}", 1.0, 1.0, 1.0, 0.0, "", samples=number)]
    whole = (normal + along) / ((dimension + 1) / 2)
    distance = float(kstest(normal, expon.cdf, method="asymp").statistic)
    return [
        statistical(
            f"energy with which particles leave {name}, over T (d + 1)/2", float(whole.mean()),
            float(whole.std(ddof=1)) / number**0.5, 1.0, 0.0,
            "m v_n^2/2T is exponential, of mean 1, and each component along the wall has 1/2; draws are independent",
            samples=number,
        ),
        by_chance(
            f"distance of m v_n^2/2T from an exponential (Kolmogorov-Smirnov), {name}", distance, kstwo(number),
            f"Kolmogorov's distribution for {number} draws",
        ),
    ]  # fmt: skip


def _extras(trial: Trial) -> Iterable[Extra]:
    return [_extra(trial)]


LAWS = (
    Law(
        "thermal-walls",
        "p(v) ~ v_n exp(-m v^2/2T) of particles that leave a wall of temperature T",
        _excuse,
        _judge,
        records=("wall_collisions",),
        extra=_extras,
    ),
)
