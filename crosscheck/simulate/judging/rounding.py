"""Bounds on what rounding does to a run, as far as its scene tells them."""

from __future__ import annotations

import numpy as np

from crosscheck.references import EPSILON
from crosscheck.references.lennard_jones import pair_sum
from crosscheck.references.smooth_forces import smooth
from crosscheck.scene import Floats, explicit
from crosscheck.simulate.judging.trial import Trial

#: Up to so many particles, all pairs are looked at.
ALL_PAIRS = 1000
#: Between start and end forces may be larger; of gravity, near an encounter, by far: see `of_forces`.
_LARGER = 4.0


def of_forces(trial: Trial) -> Floats:
    """How far the force on each particle may be off by the rounding of coordinates and sums, (N,), in units of force.

    trial: the run.

    From the larger of the forces at the start and at the end, and at the samples of few particles; 0 of hard spheres
    that go from event to event.
    """
    scene = trial.scene
    if scene.hard_spheres is not None:
        return _of_contacts(trial)
    _, r, _ = trial.states
    if scene.number > ALL_PAIRS:
        if scene.lennard_jones is None:
            return np.full(scene.number, _of_many(trial))
        found = [pair_sum(scene), pair_sum(scene.changed(initial=explicit(r[-1], np.zeros_like(r[-1]))))]
        return _LARGER * np.max([one.force_scale * (one.sensitivity + 64 * EPSILON) for one in found], axis=0)
    few = scene.number <= 30
    chosen = r if few else r[[0, len(r) // 2, -1]]
    return np.asarray(_LARGER * np.max([smooth(scene, x).forces_error for x in chosen], axis=0), dtype=np.float64)


def _of_many(trial: Trial) -> float:
    """Of gravity among many: the largest force that the energies allow, times the roundings of as many terms."""
    masses, (_, r, _) = trial.start.masses, trial.states
    nearest = float(np.linalg.norm(np.ptp(r[-1], axis=0))) / len(masses) ** (1 / trial.scene.dimension)
    assert trial.scene.gravity is not None
    force = trial.scene.gravity.G * float(masses.max()) * float(masses.sum()) / max(nearest, 1e-300) ** 2
    return force * len(masses) * EPSILON


def _of_contacts(trial: Trial) -> Floats:
    """Of soft contacts: the stiffest spring times the rounding of a coordinate, for each neighbour that may touch."""
    from crosscheck.engines.soft_spheres import contact_stiffness

    scene, contact = trial.scene, trial.method.contact
    if contact is None:
        return np.zeros(scene.number)
    _, r, _ = trial.states
    diameters = scene.diameters()
    assert diameters is not None
    stiffness = contact_stiffness(scene, contact)
    if contact.law == "hertz":
        stiffness *= 1.5 * float(diameters.max()) / 2
    touching = 6.0 if scene.dimension == 2 else 12.0
    size = float(np.abs(r).max()) + float(diameters.max())
    return np.full(scene.number, 16 * EPSILON * touching * stiffness * size)
