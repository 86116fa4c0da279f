"""Vibrating floor of small amplitude and high frequency: mean energy gained in a visit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.over_floor import (
    FLOOR_OBSERVABLES,
    FLOOR_WORDS,
    GRAVITY,
    over_floor,
    plate_figures,
    vertical,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import floors
from crosscheck.scene import Face, Floats, Oscillation
from crosscheck.verdict import Judged, within

#: Amplitudes in units of V0^2/g, velocities of the grains in units of V0.
AMPLITUDES = (0.1, 0.03, 0.01, 0.003)
SPEEDS = (1.0, 2.0, 3.0)
#: Grains, one per phase; samples a period, and periods after the last grain has reached the floor.
PHASES, PER_PERIOD, PERIODS = 2000, 6, 12


class _Visits(NamedTuple):
    """Of every grain: energy gained in its visit to the floor, velocity on leaving; and the share still there."""

    gains: Floats
    velocities: Floats
    unfinished: float


def _visit_floor(laboratory: Laboratory, u: float, amplitude: float) -> _Visits:
    """One grain per phase comes down onto the floor A cos(t/A), V0 = 1: at z = 0 it would have velocity -u.

    A visit is over when the grain rises above the floor's highest place.
    """
    period = 2 * np.pi * amplitude
    # times at which the grains would pass z = 0: equally spaced over one period, from above the floor
    passing = 1.5 * amplitude / u + period * (np.arange(PHASES) + 0.5) / PHASES
    heights = u * passing - GRAVITY * passing**2 / 2
    interval = period / PER_PERIOD
    floor = Face(oscillation=Oscillation(amplitude=amplitude, frequency=1 / amplitude))
    duration = interval * int(PER_PERIOD * PERIODS)
    run = laboratory.run(over_floor(floor, heights, -u + GRAVITY * passing, duration, interval), EVENT_DRIVEN)
    z, v = vertical(run)
    gone = (z > amplitude) & (v > 0)
    finished = gone.any(axis=0)
    sample = np.where(finished, gone.argmax(axis=0), z.shape[0] - 1)
    grain_numbers = np.arange(PHASES)
    energies = 0.5 * v[sample, grain_numbers] ** 2 + GRAVITY * z[sample, grain_numbers]
    return _Visits(energies - 0.5 * u * u, np.sqrt(2 * np.maximum(energies, 0.0)), 1 - float(finished.mean()))


def _judge_limit(laboratory: Laboratory, u: float) -> Judged:
    """Means over the phases at falling amplitudes, the last of them against the limit."""
    visits = [_visit_floor(laboratory, u, amplitude) for amplitude in AMPLITUDES]
    means = np.array([float(visit.gains.mean()) for visit in visits])
    # the gain jumps as a function of the phase, as in `floors.visit_gain`
    grain = 8 * (1 + u) / PHASES
    limit = floors.visit_gain(u)
    remains = float(abs(means[-1] - means[0])) * AMPLITUDES[-1] / AMPLITUDES[0] + grain
    flux, uniform = floors.flux_phase_gain(u, 1.0), floors.uniform_phase_gain(u, 1.0)
    gain_figure = Figure(
        "mean gain in a visit to a vibrating floor", "A g/V0^2", "energy/V0^2", "log", "linear",
        (
            Series(f"u = {u:g}", list(AMPLITUDES), means.tolist(), [grain] * means.size),
            Series(f"u = {u:g}, limit of a visit", [AMPLITUDES[-1], AMPLITUDES[0]], [limit.value] * 2, theory=True),
            Series("flux law", [AMPLITUDES[-1], AMPLITUDES[0]], [flux] * 2, theory=True),
            Series("uniform law", [AMPLITUDES[-1], AMPLITUDES[0]], [uniform] * 2, theory=True),
        ),
    )  # fmt: skip
    plates = (visits[-1].velocities - u) / 2
    histogram = plate_figures(plates, u, f"floor, A = {AMPLITUDES[-1]:g}") if u >= 3 else ()
    table = ", ".join(f"A {a:g}: {mean:.4f}" for a, mean in zip(AMPLITUDES[:-1], means[:-1], strict=True))
    return within(
        "order",
        f"mean energy gained in a visit at A = {AMPLITUDES[-1]:g}",
        float(means[-1]),
        limit.value,
        remains + limit.doubt,
        "finite amplitude, of first order from the largest one, and the jumps between neighbouring phases",
        note=f"at larger amplitudes {table}; flux law {flux:.4f}, uniform law {uniform:g}; grains still on the floor "
        f"at the end: {max(visit.unfinished for visit in visits):.2%}",
        figures=(gain_figure, *histogram),
    )


CHECKS = (
    Check(
        name="events/small-amplitude",
        title="Vibrating floor of small amplitude and high frequency: mean energy gained in a visit",
        equation="<dE>(A -> 0, A omega = V0) = that of a visit in the limit: 2 V0^2, the flux law's, for u >= 3 V0",
        criterion=f"mean over {PHASES} equally spaced phases at A = {', '.join(f'{a:g}' for a in AMPLITUDES)}",
        citation="McNamara & Barrat, Phys. Rev. E 55, 7767 (1997)",
        judge=_judge_limit,
        variants=full(**{f"u{u:g}": u for u in SPEEDS}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=FLOOR_WORDS | {"acceleration", "box.faces.oscillation"},
            observables=FLOOR_OBSERVABLES,
        ),
        faults=(
            (
                "u2",
                Fault(
                    "floor-half-as-fast",
                    "events/rules.py",
                    "return -numbers[AMPLITUDE] * frequency * math.sin(numbers[PHASE] + frequency * now)",
                    "return -0.5 * numbers[AMPLITUDE] * frequency * math.sin(numbers[PHASE] + frequency * now)",
                    "the floor's velocity is half of what its place says",
                ),
            ),
        ),
    ),
)
