"""Walls with a temperature give particles velocities of a gas of that temperature that comes through the wall."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from crosscheck.scene import Floats, Output
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, Judgement, by_chance, statistical, worst

#: Hits of thermal walls that are wanted; and events of all kinds in a run at most, passages of cells included.
_HITS, _EVENTS = 80_000.0, 1_000_000.0


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
    """A run with a trace, from the scene's start; of another attempt, with other random numbers."""
    longer = min(_HITS / max(_hits_of(trial), 1.0), _EVENTS / max(trial.run.cost.events, 1))
    duration = trial.end * min(longer, max(1.0, trial.allowance / max(trial.seconds(trial.end), 1e-9)))
    seed = (trial.seed or 0) + trial.attempt
    changes = {"duration": duration, "seed": seed, "output": Output(interval=duration, trace=True)}
    return Extra(
        "draws of thermal walls", trial.scene.model_copy(update=changes), trial.method, trial.seconds(duration)
    )


def _judge(trial: Trial) -> Judged:
    """Energies with which particles leave each wall, and the distribution of the normal ones."""
    run = trial.make(_extra(trial))
    who, v = run["event_partners"].astype(int), run["event_velocities"][:, 0]
    masses, faces = trial.start.masses, _faces(trial)
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
    from scipy.stats import expon, kstwo

    number, name = len(normal), f"walls of T = {temperature:g}"
    if number < 2:
        return [statistical(f"energy with which particles leave {name}", 1.0, 1.0, 1.0, 0.0, "", samples=number)]
    whole = (normal + along) / ((dimension + 1) / 2)
    values = np.sort(normal)
    seen, expected = np.arange(number + 1) / number, expon.cdf(values)
    distance = float(max((seen[1:] - expected).max(), (expected - seen[:-1]).max()))
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
