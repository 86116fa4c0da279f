"""Lattice gases: every site after each of a few steps, against what the arrived particles may become."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.recording import recorded
from crosscheck.engines.registry import engine_class
from crosscheck.references import EPSILON
from crosscheck.references.lattice_audit import mean_step
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, round_off

#: Sites at most, and steps.
MOST, STEPS = 150_000, 3
_WHY = "coordinates say where each particle arrives, the definition of the model what it may become"


def excuse(trial: Trial) -> str | None:
    """None, or why no site can be audited; trial: of a lattice gas."""
    gas = trial.scene.lattice_gas
    assert gas is not None
    sites = gas.rows * gas.columns
    return f"{gas.columns} x {gas.rows} sites: the auditor follows up to {MOST}" if sites > MOST else None


def extras(trial: Trial) -> list[Extra]:
    """None that can be named: the run of a few steps takes no time. trial: the run."""
    return []


def judge(trial: Trial) -> Judged:
    """Sites in a state that the arrived one cannot become; or mean occupations after each step. trial: the run."""
    one, steps = trial.planned, min(STEPS, max(1, round(trial.scene.duration)))
    laboratory = Laboratory(one.engine, engine_class(one.engine).schemes, trial.bench.pool, "simulate")
    gas = trial.scene.lattice_gas
    assert gas is not None
    before = None if gas.reversals is None else tuple(step for step in gas.reversals if step <= steps)
    short = trial.scene.model_copy(
        update={"duration": float(steps), "lattice_gas": gas.model_copy(update={"reversals": before})}
    )
    found = recorded(laboratory, short, trial.method)
    trial.cost.add(laboratory.cost)
    sites = f"{gas.columns} x {gas.rows} sites, {steps} steps from the start"
    if found.whole:
        wrong = found.forbidden
        note = f"{sites}{'; ' if wrong.first else ''}{wrong.first}"
        return round_off(
            "sites that leave a step in a state that the arrived one cannot become", wrong.number, 0.5, _WHY, note=note
        )
    f = found.trajectory
    channels = f.shape[-1]
    expected = np.array([mean_step(found.lattice, found.walls, found.force, one) for one in f[:-1]])
    error = float(np.abs(expected - f[1:]).max()) / (channels * 2**channels * EPSILON)
    why = "a rounding for each of the 2^b states that are summed over, and each of the b factors"
    return round_off("mean occupations after a step, in roundings", error, 1.0, why, note=sites)
