"""Lattice gases: particles are neither made nor lost, and without walls their momentum is that of the start."""

from __future__ import annotations

import numpy as np

from crosscheck.errors import UsageError
from crosscheck.references import EPSILON
from crosscheck.references.lattice_models import VELOCITIES, momenta
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, round_off, worst

#: Roundings of a mean occupation in a step: of the factors of a product, of their sum, and of a force.
_EACH = 16


def _excuse(trial: Trial) -> str | None:
    if trial.scene.lattice_gas is None:
        return "of lattice gases; the scene has none"
    if trial.broken:
        return trial.broken
    return None if "populations" in trial.run else "the engine does not measure populations"


def _judge(trial: Trial) -> Judged:
    """Sums over all channels and blocks: whole numbers, where particles are moved and not their means."""
    gas, run = trial.scene.lattice_gas, trial.run
    assert gas is not None
    whole = run["populations"].sum(axis=(1, 2))
    exact = bool((whole == np.round(whole)).all())
    mass, momentum = whole.sum(axis=1), momenta(gas.model, whole)
    steps, sites = trial.number_of_events, gas.rows * gas.columns
    rounding = 0.5
    why = "whole numbers are equal, or they are not"
    if not exact:
        rounding = EPSILON * _EACH * float(mass.max()) * (1 + steps)
        why = f"{_EACH} roundings of each sum, and of a mean occupation in each step, at worst all alike"
    judged = [
        round_off("particles made or lost", float(np.abs(mass - mass[0]).max()), rounding, why),
        round_off("particles at the start, less those of the scene", _missing(trial, float(mass[0])), rounding, why),
    ]
    note = "walls take momentum: it is not judged" if gas.obstacles else ""
    if not gas.obstacles:
        known = ["force_impulse"] if gas.force is not None else []
        given = np.zeros_like(momentum)
        if known and "force_impulse" in run:
            given[:, 0] = run["force_impulse"].sum(axis=1) / VELOCITIES[gas.model].unit[0]
        for axis, name in enumerate("xy"):
            if axis == 0 and known and "force_impulse" not in run:
                note = "what the force gives along x is not measured"
                continue
            change = np.abs(momentum[:, axis] - momentum[0, axis] - given[:, axis]).max()
            judged.append(round_off(f"change of the momentum along {name}, in its unit", float(change), rounding, why))
    if gas.reversals:
        return worst(judged[:1], "velocities are reversed: momentum is not judged")
    return worst(judged, "; ".join(filter(None, (f"{len(mass)} samples, {sites} sites", note))))


def _missing(trial: Trial, number: float) -> float:
    """How many particles a start has more than the scene says, of particles or of their means, whichever it is."""
    sites = float(np.unpackbits(trial.scene.initial_sites().reshape(-1, 1), axis=1).sum())
    try:
        means = float(trial.scene.initial_occupations().sum())
    except UsageError:  # a density of 0 or 1 has no equilibrium of means
        means = sites
    return min(number - sites, number - means, key=abs)


LAWS = (
    Law(
        "particles",
        "sum of n_i, and sum of n_i c_i less what the force gave, = their values at the start",
        _excuse,
        _judge,
        records=("populations", "force_impulse"),
    ),
)
