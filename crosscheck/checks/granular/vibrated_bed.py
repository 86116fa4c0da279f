"""Inelastic disks on an oscillating floor: temperature profile and centre of mass, event-driven and soft.

Literature: S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994);
S. Luding, H. J. Herrmann and A. Blumen, Phys. Rev. E 50, 3100 (1994).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, soft
from crosscheck.checks.events.driven import run_whole, snapshot_figure
from crosscheck.checks.granular.driven import (
    Profile,
    against,
    against_duration,
    curves,
    hard_limit,
    listed,
    profile,
    trajectory,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame
from crosscheck.scene import Box, Face, HardSpheres, Lattice, Oscillation, Output, Scene
from crosscheck.statistics import Mean, correlated_mean
from crosscheck.verdict import Judged, worst

#: Contact times, and the samples of a run at each.
_DURATIONS, _SAMPLES = (0.01, 0.005), (17280, 12960)
#: Not commensurate with the floor's period 2 pi/8: samples at all phases alike.
_SAMPLE = 0.37
_WARM_UP = 100.0
#: Bins of the height: above 14 too few grains come for a temperature to a quarter.
_EDGES = np.arange(0.0, 15.0, 2.0)
_MIDDLE = 0.5 * (_EDGES[1:] + _EDGES[:-1])


def _bed(seed: int, samples: int) -> Scene:
    """Six layers of disks, restitution 0.9, on a floor that oscillates with a = 0.3, a omega^2 = 19 g."""
    floor = Face(oscillation=Oscillation(amplitude=0.3, frequency=8.0))
    return Scene(
        name="vibrated-bed",
        dimension=2,
        duration=samples * _SAMPLE,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(restitution=0.9),
        box=Box(lengths=(10.0, 100.0), boundaries=("periodic", "hard"), faces={"y-": floor, "y+": Face(open=True)}),
        initial=Lattice(kind="lattice", structure="square", number=60, temperature=1.0, seed=seed),
        output=Output(interval=_SAMPLE, trajectory=True),
    )


class _Bed(NamedTuple):
    """Height of the centre of mass, kinetic energy of a grain, and temperature over the height."""

    height: Mean
    energy: Mean
    temperature: Profile


def _measured_bed(run: Run) -> _Bed:
    positions, velocities = trajectory(run, round(_WARM_UP / _SAMPLE))
    z, energy = positions[:, :, 1], 0.5 * (velocities**2).sum(axis=2)
    # the mean velocity is zero at every height: all of the kinetic energy is temperature
    return _Bed(correlated_mean(z.mean(axis=1)), correlated_mean(energy.mean(axis=1)), profile(z, energy, _EDGES))


def _figures(engine: str, runs: Sequence[_Bed], hard: _Bed, event_run: Run) -> tuple[Figure, ...]:
    heights, energies = [run.height for run in runs], [run.energy for run in runs]
    hot, reference = _temperatures(runs), _temperatures([hard])[0]
    share = [run.temperature.means(run.temperature.share) for run in runs]
    shared = hard.temperature.means(hard.temperature.share)
    return (
        against_duration("Vibrated bed: kinetic energy of a grain", "K/N", engine, _DURATIONS, energies, hard.energy),
        against_duration(
            "Vibrated bed: height of the centre of mass", "height", engine, _DURATIONS, heights, hard.height
        ),
        Figure("Vibrated bed: temperature", "height", "T", series=curves(engine, _MIDDLE, _DURATIONS, hot, reference)),
        Figure(
            "Vibrated bed: mass",
            "height",
            "share of the grains",
            y_scale="log",
            series=curves(engine, _MIDDLE, _DURATIONS, share, shared),
        ),
        snapshot_figure(
            "Vibrated bed: grains",
            event_run,
            Frame(0.0, 10.0, 0.0, 20.0, ("bottom",)),
            10.0,
            np.linalg.norm(event_run["final_velocities"], axis=1),
            "speed",
        ),
    )


def _temperatures(beds: Sequence[_Bed]) -> list[list[Mean]]:
    """Of each bed, the mean temperature of every bin."""
    return [bed.temperature.means(bed.temperature.mean) for bed in beds]


def _judge_bed(laboratory: Laboratory, _: str) -> Judged:
    runs = [
        _measured_bed(
            run_whole(
                laboratory, _bed(laboratory.seed(f"soft-{t_c:g}"), samples), soft(duration=t_c, resolution=1 / 30)
            )
        )
        for t_c, samples in zip(_DURATIONS, _SAMPLES, strict=True)
    ]
    event_run = run_whole(laboratory, _bed(laboratory.seed("event-driven"), 43200), EVENT_DRIVEN, REFERENCE)
    hard = _measured_bed(event_run)
    heights, energies = [run.height for run in runs], [run.energy for run in runs]
    judgements = [
        against("height of the centre of mass", hard_limit(_DURATIONS, heights), hard.height, 0.04),
        against("kinetic energy of a grain", hard_limit(_DURATIONS, energies), hard.energy, 0.08),
    ]
    hot, reference = _temperatures(runs), _temperatures([hard])[0]
    for index, z in enumerate(_MIDDLE):
        limit = hard_limit(_DURATIONS, [means[index] for means in hot])
        judgements.append(against(f"temperature at z = {z:g}", limit, reference[index], 0.25))
    note = f"height: {listed(_DURATIONS, heights)}; K/N: {listed(_DURATIONS, energies)}"
    return worst(judgements, note, _figures(laboratory.engine, runs, hard, event_run))


CHECKS = (
    Check(
        name="granular/vibrated-bed",
        title="Inelastic disks on an oscillating floor: temperature profile and centre of mass, event-driven and soft",
        equation="z_floor = a cos(omega t); T(z) = <v^2>/2; soft: + O(t_c)",
        criterion="standard errors of correlated series and of 20 stretches; soft ones taken to t_c = 0 by a line",
        citation="S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994); S. "
        "Luding, H. J. Herrmann and A. Blumen, Phys. Rev. E 50, 3100 (1994)",
        judge=_judge_bed,
        variants=full("disks"),
        needs=soft_needs(
            "dimension=2 method.contact.duration hard_spheres.restitution acceleration "
            "box.boundaries=hard box.faces.oscillation",
            "positions velocities",
        ),
        faults=(
            (
                "disks",
                Fault(
                    "light-grains",
                    CONTACTS,
                    "a[i] = gravity[k]",
                    "a[i] = 0.9 * gravity[k]",
                    "grains fall with nine tenths of g",
                ),
            ),
        ),
    ),
)
