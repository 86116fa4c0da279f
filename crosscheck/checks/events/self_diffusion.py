"""Self-diffusion of dense spheres from the mean-square displacement; sigma = m = T = 1."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.gases import TALLIES, event_driven, gas
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import transport as reference
from crosscheck.scene import Floats, Output
from crosscheck.statistics import mean_of_stretches
from crosscheck.verdict import Judged, statistical

#: Number of spheres; samples to the start of the window, which ends at twice that time; the longest lag shown.
DIFFUSING, WINDOW, SHOWN = 1728, 10, 40
#: The origins, in stretches that last one and a half times as long as a displacement does.
STRETCHES = 40
ORIGINS = STRETCHES * 3 * WINDOW


def _window_start(density: float) -> float:
    """Five times the slower decay: that of the velocity, or of the longest shear wave of the box.

    After that the box has no long-time tail left, and the mean-square displacement is straight to exp(-5).
    """
    return float(5 * max(reference.velocity_decay_time(density), reference.shear_decay_time(density, DIFFUSING)))


def _squares(positions: Floats, lag: int, origins: int) -> Floats:
    """Mean-square displacement of all particles over `lag` samples, for each origin."""
    return np.asarray(((positions[lag : lag + origins] - positions[:origins]) ** 2).sum(axis=2).mean(axis=1))


def _judge(laboratory: Laboratory, density: float) -> Judged:
    """Slope of the mean-square displacement between the ends of the window."""
    step = _window_start(density) / WINDOW
    samples = ORIGINS + 2 * SHOWN
    output = Output(interval=step, observables=TALLIES, trajectory=True)
    run = laboratory.run(gas(3, DIFFUSING, density, laboratory.seed(), output, samples * step), EVENT_DRIVEN)
    positions = run["positions"][SHOWN:]  # settled
    slope = (_squares(positions, 2 * WINDOW, ORIGINS) - _squares(positions, WINDOW, ORIGINS)) / (6 * WINDOW * step)
    mean = mean_of_stretches(slope.reshape(STRETCHES, -1).mean(axis=1))
    known = reference.sphere_diffusion(density, DIFFUSING)
    lags = np.arange(0, SHOWN + 1, 4)
    growth = np.diff([_squares(positions, lag, ORIGINS).mean() for lag in lags.tolist()]) / (6 * 4 * step)
    middle = (0.5 * (lags[1:] + lags[:-1]) / WINDOW).tolist()
    figure = Figure(
        "growth of the mean-square displacement", "t/t1, window from 1 to 2", "d<r^2>/dt / 6D expected", "linear",
        "linear", (
            Series(f"n = {density:g}", middle, (growth / known.value).tolist()),
            Series("expected", [0.0, SHOWN / WINDOW], [1.0, 1.0], theory=True),
        ),
    )  # fmt: skip
    infinite = reference.sphere_diffusion(density)
    return statistical(
        "D of spheres",
        mean.value,
        mean.error,
        known.value,
        known.uncertainty,
        f"standard error of {STRETCHES} stretches of {ORIGINS} origins, and of the reference; its shift for this N",
        samples=mean,
        doubt=known.doubt,
        needed=0.05,
        note=f"N = {DIFFUSING}, window from t1 = {WINDOW * step:.4g} to 2 t1; infinite N: {infinite.value:.5g}",
        figures=(figure,),
    )


CHECKS = (
    Check(
        name="events/self-diffusion",
        title="Self-diffusion of dense spheres from the mean-square displacement",
        equation="D = d<|r(t) - r(0)|^2>/dt/6; D_N = D - 2.837297 T/(6 pi viscosity L)",
        criterion="within the errors of correlated origins and of the reference, corrected for finite N",
        citation="NIST Standard Reference Simulation Website; Yeh & Hummer, J. Phys. Chem. B 108, 15873 (2004)",
        judge=_judge,
        variants=full(**{f"n{n:g}": n for n in (0.1, 0.3, 0.5, 0.7)}),
        needs=event_driven("dimension=3 box.boundaries=periodic", f"positions velocities {' '.join(TALLIES)}"),
        faults=(
            (
                "n0.5",
                Fault(
                    "forgotten-images",
                    "events/kernels/loop.py",
                    "images[i, k] += turn",
                    "images[i, k] = turn",
                    "a particle that leaves the box again and again is put back by one box only",
                ),
            ),
        ),
    ),
)
