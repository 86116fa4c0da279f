"""Liquid of square wells: energy and pressure against Monte Carlo; diameter, mass and depth are 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.gases import event_driven
from crosscheck.checks.events.square_wells import OBSERVABLES, WORDS, constant_energy, fluid, temperatures
from crosscheck.faults import Fault
from crosscheck.references.square_well import STATES, StatePoint
from crosscheck.scene import Floats, Output, Scene, explicit
from crosscheck.statistics import Mean, combined, correlated_mean
from crosscheck.verdict import Judged, Judgement, statistical, worst


class _Liquid(NamedTuple):
    """A state of the reference, and the number of particles."""

    point: StatePoint
    number: int


def _at_state(density: float, temperature: float, number: int) -> _Liquid:
    return _Liquid(next(one for one in STATES if one[:2] == (density, temperature)), number)


#: Duration of a production run of 256 particles; of more, shorter in proportion. Below the density `DENSE` longer, as
#: the time between collisions is: that of correlations grows with it; the error needs a hundred independent samples.
DURATION, SAMPLES, DENSE = 200.0, 200, 0.5
#: The two production runs are this much above and below the temperature asked for.
BRACKET = 0.04


def _rescaled(laboratory: Laboratory, scene: Scene, temperature: float, rounds: int, span: float) -> Scene:
    """Runs of `span`, after each of which the velocities are scaled to the temperature."""
    for _ in range(rounds):
        run = laboratory.run(
            scene.changed(duration=span, output=Output(interval=span, observables=OBSERVABLES)), EVENT_DRIVEN
        )
        kinetic = 0.5 * float((run["final_velocities"] ** 2).sum())
        factor = np.sqrt(1.5 * (scene.number - 1) * temperature / kinetic)
        scene = scene.changed(initial=explicit(run["final_positions"], factor * run["final_velocities"]))
    return scene


class _Production(NamedTuple):
    """Averages over intervals: temperature, energy of the wells a particle, Z with the ideal part 1.

    kept: that the energy is.
    """

    temperature: Floats
    energy: Floats
    compressibility: Floats
    kept: Judgement


def _produced(laboratory: Laboratory, scene: Scene, duration: float) -> _Production:
    interval = duration / SAMPLES
    scene = scene.changed(duration=duration, output=Output(interval=interval, observables=OBSERVABLES))
    run = laboratory.run(scene, EVENT_DRIVEN)
    t = temperatures(scene, run)
    energy = np.diff(run["potential_energy_integral"]) / (interval * scene.number)
    # over the mean temperature: that of an interval fluctuates together with its virial
    z = 1 + np.diff(run["collisional_virial"]) / (3 * scene.number * t.mean() * interval)
    return _Production(t, energy, z, constant_energy(scene, run))


def _judge(laboratory: Laboratory, liquid: _Liquid) -> Judged:
    """Two runs at constant energy about the temperature; energy and Z on the line through them, at that temperature."""
    point, number = liquid
    scene = fluid(3, number, point.density, 1.5 * point.temperature, laboratory.seed())
    scene = _rescaled(laboratory, scene, point.temperature, 10, 4.0)
    duration = DURATION * 256 / number * max(1.0, DENSE / point.density)
    runs = [
        _produced(laboratory, _rescaled(laboratory, scene, factor * point.temperature, 6, 4.0), duration)
        for factor in (1 - BRACKET, 1 + BRACKET)
    ]
    energy, slope = _at(runs, point.temperature, "energy")
    z, _ = _at(runs, point.temperature, "compressibility")
    t, capacity = point.temperature, 1.5 + slope
    # <T> at constant E is not the canonical T: u(T) differs by -T^2 c'/(2 N c), c' of the size 2 u'/T
    ensemble = 1 / 256 * t * abs(slope) / capacity
    means = [[float(series.mean()) for series in run[:3]] for run in runs]
    judgements = [
        *(run.kept for run in runs),
        statistical(
            f"u at T = {t:g}",
            energy.value,
            energy.error,
            point.energy.value,
            point.energy.uncertainty,
            "standard errors of correlated data; off by 1/N between constant energy and constant temperature",
            samples=energy,
            doubt=ensemble,
            needed=0.04,
        ),
        statistical(
            f"Z at T = {t:g}",
            z.value,
            z.error,
            point.compressibility.value,
            point.compressibility.uncertainty,
            "standard error of correlated data; 1 % of g at contact and at the edge behind the reference",
            samples=z,
            doubt=point.compressibility.doubt,
            needed=0.12,
        ),
    ]
    found = "; ".join(f"T = {one[0]:.4f}, u = {one[1]:.4f}, Z = {one[2]:.4f}" for one in means)
    return worst(judgements, f"N = {number}, du/dT = {slope:.2f}: {found}")


def _at(runs: list[_Production], temperature: float, name: str) -> tuple[Mean, float]:
    """A quantity at the temperature, from both runs, each moved along the line through them; and its slope.

    At constant energy a quantity and the temperature fluctuate together: the series that is averaged has both.
    """
    values = [np.asarray(getattr(run, name)) for run in runs]
    t = [float(run.temperature.mean()) for run in runs]
    slope = float((values[1].mean() - values[0].mean()) / (t[1] - t[0]))
    moved = [correlated_mean(y - slope * (run.temperature - temperature)) for y, run in zip(values, runs, strict=True)]
    weights = np.array([t[1] - temperature, temperature - t[0]]) / (t[1] - t[0])
    value = sum(w * one.value for w, one in zip(weights, moved, strict=True))
    error = float(np.hypot(*(w * one.error for w, one in zip(weights, moved, strict=True))))
    return combined(float(value), error, moved), slope


CHECKS = (
    Check(
        name="events/square-well-liquid",
        title="Square-well liquid: energy and pressure against Monte Carlo at constant temperature",
        equation="u(T), Z = 1 + sum r_ij.dp_ij/(3 N T t), T = 2 <K>/(3 (N - 1)); range 1.5",
        criterion="within the standard errors of correlated data and of the reference",
        citation="own Monte Carlo, 256 particles, 9000 sweeps; Barker & Henderson, Rev. Mod. Phys. 48, 587 (1976)",
        judge=_judge,
        variants=full(
            **{
                "n0.1-T2.0": _at_state(0.1, 2.0, 256),
                "n0.3-T1.5": _at_state(0.3, 1.5, 256),
                "n0.5-T2.0": _at_state(0.5, 2.0, 256),
                "n0.7-T1.5": _at_state(0.7, 1.5, 256),
                "n0.7-T1.5-N864": _at_state(0.7, 1.5, 864),
            }
        ),
        needs=event_driven(f"dimension=3 {WORDS}", " ".join(OBSERVABLES)),
        faults=(
            (
                "n0.7-T1.5",
                Fault(
                    "shallow-well",
                    "events/rules.py",
                    "square = gn * gn + (-twice_depth if inside else twice_depth)",
                    "square = gn * gn + 0.8 * (-twice_depth if inside else twice_depth)",
                    "the wells act as if they were a fifth shallower",
                ),
            ),
        ),
    ),
)
