"""Chaos: two engines separate as two runs of one engine do, one of them disturbed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.stepping.divergence import melting, separation
from crosscheck.checks.stepping.faults import pair_fault
from crosscheck.checks.stepping.fluids import STEP, TRAJECTORIES
from crosscheck.figure import Figure, Series
from crosscheck.scene import Floats, explicit
from crosscheck.statistics import standard_error
from crosscheck.verdict import Judged, bounded, statistical, worst

STARTS, DISTURBANCE = 12, 1e-13


def _growth_rate(time: Floats, apart: Floats) -> float:
    """Slope of ln(apart) between 1e-12, clear of rounding, and 1e-4, clear of saturation; NaN if it jumps."""
    window = (apart > 1e-12) & (apart < 1e-4)
    return float(np.polyfit(time[window], np.log(apart[window]), 1)[0]) if window.sum() > 3 else np.nan


def _horizon(time: Floats, apart: Floats) -> float:
    """Time at which the separation first exceeds 1e-6."""
    return float(time[np.flatnonzero(apart > 1e-6)[0]])


def _judge(laboratory: Laboratory, other: str) -> Judged:
    """Two engines separate at the rate at which two runs of one engine do, one disturbed by 1e-13, and no sooner."""
    rates, horizons = np.empty((2, STARTS)), np.empty((2, STARTS))
    curves = []
    for number in range(STARTS):
        scene = melting(laboratory.seed(str(number)))
        state = scene.initial_state()
        rng = np.random.default_rng(laboratory.seed(f"{number} disturbance"))
        positions = state.positions + DISTURBANCE * rng.normal(size=state.positions.shape)
        run = laboratory.run(scene, STEP)
        apart = separation(run, laboratory.run(scene, STEP, engine=other))
        twin = separation(run, laboratory.run(scene.changed(initial=explicit(positions, state.velocities)), STEP))
        rates[:, number] = [_growth_rate(run["time"], part) for part in (apart, twin)]
        horizons[:, number] = [_horizon(run["time"], part) for part in (apart, twin)]
        if number == 0:
            shown = slice(1, None, 3)
            for label, values in ((f"{laboratory.engine} and {other}", apart), ("disturbed by 1e-13", twin)):
                curves.append(Series(label, run["time"][shown].tolist(), values[shown].tolist()))
    means, errors = rates.mean(axis=1), standard_error(rates.T)
    rate = statistical(
        f"growth rate of the separation from {other}",
        float(means[0]),
        float(errors[0]),
        float(means[1]),
        float(errors[1]),
        f"standard error over {STARTS} independent starts",
        samples=STARTS,
        needed=1.0,
        figures=(Figure("separation of trajectories", "t", "rms separation", "linear", "log", tuple(curves)),),
    )
    sooner = bounded(
        "mean time until a separation of 1e-6",
        float(horizons[0].mean()),
        float(horizons[1].mean()),
        f"that of a run disturbed by {DISTURBANCE:g}, three decades above the rounding of two right engines",
        at_least=True,
    )
    return worst([rate, sooner], f"{STARTS} starts")


CHECKS = (
    Check(
        name="stepping/lennard-jones-chaos",
        title="Growth of the separation between two engines, against that of one engine disturbed by 1e-13",
        equation="|delta r(t)| ~ |delta r(0)| exp(lambda t)",
        criterion="lambda within the standard errors of 12 starts; separation of 1e-6 reached no sooner",
        citation="Allen & Tildesley (1987), section 3.2; Benettin et al., Meccanica 15, 9 (1980)",
        judge=_judge,
        variants=full(**{"against-lammps": "lammps"}),
        faults=(
            (
                "against-lammps",
                pair_fault(
                    "cutoff-edge",
                    "f = where(r2 < splat(cutoff * cutoff), f, zeros())",
                    "f = where(r2 < splat(0.99999 * cutoff * cutoff), f, zeros())",
                    "pairs at the very edge of the cutoff are missed now and then",
                ),
            ),
        ),
        needs=replace(TRAJECTORIES, promises=("long_runs",)),
        reference="lammps",
    ),
)
