"""Hard spheres never overlap, nor are they beyond a wall: at no sample of the whole run."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.scene import AXES, Floats
from crosscheck.scene.overlaps import wrapped
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, round_off, worst

#: Roundings of a position between two events; and particles in all samples that are looked at.
_ROUNDINGS, _MOST = 64.0, 2_000_000


def _excuse(trial: Trial) -> str | None:
    if trial.scene.hard_spheres is None:
        return "of hard spheres; the scene has none"
    if trial.method.contact is not None:
        return "soft contacts overlap"
    return trial.broken or None


def _judge(trial: Trial) -> Judged:
    """The deepest overlap of a pair, and of a particle with a wall, over what rounding, or a step, makes of it."""
    times, r, v = trial.states
    every = max(1, -(-len(r) * trial.scene.number // _MOST))
    chosen = np.unique(np.append(np.arange(0, len(r), every), len(r) - 1))
    speed = float(np.linalg.norm(v, axis=2).max())
    lengths = trial.scene.lengths()
    extent = float(np.abs(r).max()) + (0.0 if lengths is None else float(lengths.max()))
    tolerance = _ROUNDINGS * EPSILON * (extent + speed * trial.end) or EPSILON
    why = f"{_ROUNDINGS:g} roundings of a position"
    if trial.kind == "collision_search":
        tolerance += 2 * speed * trial.method.step
        why += ", and the way that two go towards each other in a step"
    deepest, pair = max((_deepest(trial, r[k]) for k in chosen), key=lambda found: found[0])
    beyond, which = max((_beyond(trial, r[k]) for k in chosen), key=lambda found: found[0])
    return worst(
        [
            round_off("deepest overlap of two particles", deepest, tolerance, why, note=pair),
            round_off("farthest way beyond a wall at rest", beyond, tolerance, why, note=which),
        ],
        f"{len(chosen)} of {len(times)} states",
    )


def _radii(trial: Trial) -> Floats:
    assert trial.start.diameters is not None
    return np.asarray(trial.start.diameters / 2)


def _deepest(trial: Trial, positions: Floats) -> tuple[float, str]:
    """The largest (s - r) of two particles at these positions, or 0, and which they are."""
    from scipy.spatial import cKDTree

    radii, periods, free = _radii(trial), trial.scene.periods(), trial.free
    tree: Any = cKDTree(wrapped(positions, periods), boxsize=periods)
    pairs: Floats = tree.query_pairs(2 * float(radii.max()), output_type="ndarray")
    i, j = pairs.T
    real = (free[i] | free[j]) & (radii[i] + radii[j] > 0)
    i, j = i[real], j[real]
    if not i.size:
        return 0.0, ""
    gaps = positions[j] - positions[i]
    turns = np.where(periods > 0, np.round(gaps / np.where(periods > 0, periods, 1.0)), 0.0)
    depth = radii[i] + radii[j] - np.linalg.norm(gaps - turns * periods, axis=1)
    k = int(np.argmax(depth))
    return max(float(depth[k]), 0.0), f"particles {i[k]} and {j[k]}" if depth[k] > 0 else ""


def _beyond(trial: Trial, positions: Floats) -> tuple[float, str]:
    """How far a particle is beyond a wall that does not move, or 0, and which."""
    scene, radii = trial.scene, _radii(trial)
    lengths, found = scene.lengths(), (0.0, "")
    if lengths is None:
        return found
    depths: list[tuple[Floats, str]] = []
    for index, face in enumerate(scene.faces):
        if face is not None and face.oscillation is None:
            axis, upper = divmod(index, 2)
            x = positions[:, axis]
            depths.append((radii + (x - lengths[axis] if upper else -x), f"face {AXES[axis]}{'-+'[upper]}"))
    if scene.across and scene.box is not None and scene.box.cylinder is not None:
        away = np.linalg.norm((positions - lengths / 2)[:, list(scene.across)], axis=1)
        depths.append((away + radii - scene.box.cylinder.radius, "the cylinder"))
    for depth, name in depths:
        k = int(np.argmax(np.where(trial.free, depth, -np.inf)))
        if trial.free[k] and depth[k] > found[0]:
            found = float(depth[k]), f"particle {k}, {name}"
    return found


LAWS = (Law("overlap", "|r_i - r_j| >= (s_i + s_j)/2", _excuse, _judge, records=("trajectory",)),)
