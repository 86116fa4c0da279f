"""Disks under gravity: inelastic on a shaken floor, elastic on a floor at rest."""

from __future__ import annotations

import itertools
import math

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import (
    OBSERVABLES,
    STRETCHES,
    column,
    curve,
    energy_budget,
    field,
    field_figure,
    last,
    local_temperature,
    run_on,
    significant,
    snapshot_figure,
    steady_mean,
    temperature,
)
from crosscheck.checks.events.over_floor import FLOOR
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame, Series
from crosscheck.references import EPSILON
from crosscheck.references.under_gravity import column_profile, fixed_energy, floor_layer, mean_compressibility
from crosscheck.scene import Box, Face, Floats, HardSpheres, Lattice, Output, RandomPhase, Scene
from crosscheck.statistics import mean_of_stretches
from crosscheck.verdict import Judged, Judgement, round_off, statistical, worst


def _bed(seed: int) -> Scene:
    """Six layers of disks, restitution 0.9, on a floor in the limit of fast and small vibration, V0 = 5."""
    width, height = 20.0, 80.0
    return Scene(
        name="bed",
        dimension=2,
        duration=1000.0,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(restitution=0.9),
        box=Box(
            lengths=(width, height),
            boundaries=("periodic", "hard"),
            faces={"y-": Face(random_phase=RandomPhase(speed=5.0)), "y+": Face(open=True)},
        ),
        initial=Lattice(kind="lattice", structure="square", number=120, temperature=5.0, seed=seed),
        output=Output(interval=1000.0, observables=OBSERVABLES, fields=(8, 32)),
    )


def _heights(scene: Scene, runs: list[Run]) -> tuple[Floats, float, Floats]:
    """Middles of the rows, their height, and the mass in each row of each stretch, averaged over time."""
    mass = field(runs, "mass").sum(axis=1) / scene.duration
    lengths = scene.lengths()
    assert lengths is not None
    step = lengths[1] / mass.shape[1]
    return (np.arange(mass.shape[1]) + 0.5) * step, float(step), mass


def _hydrostatic(scene: Scene, runs: list[Run], mass: Floats) -> Judgement:
    """p_yy integrated over the heights, against the weight above each."""
    flux = field(runs, "flux_momentum")[:, 1, :, 1:, 1].sum(axis=1) / scene.duration
    above = np.cumsum(mass[:, ::-1], axis=1)[:, ::-1][:, 1:]
    return steady_mean(
        flux.sum(axis=1) / above.sum(axis=1), "momentum flux through a height over the weight above", 1.0, 0.05
    )


def _judge_shaken(laboratory: Laboratory) -> Judged:
    """Power of the floor against dissipation, its force against the weight; minimum of T, maximum of density."""
    scene = _bed(laboratory.seed())
    runs = run_on(laboratory, scene, STRETCHES, 500.0)
    z, _, mass = _heights(scene, runs)
    number = scene.number
    given, lost = last(runs, "wall_energy")[:, FLOOR], last(runs, "dissipated_energy")
    force = -last(runs, "wall_impulse")[:, FLOOR, 1] / scene.duration
    rows = [field(runs, name).sum(axis=1) for name in ("mass", "momentum", "kinetic")]
    profiles = temperature(*rows)
    hot, filling = profiles.mean(axis=0), mass.mean(axis=0)
    dense = np.flatnonzero(filling > 0.001 * number)  # rows that hold something at all times
    low, top = int(dense[np.argmin(hot[dense])]), int(dense[-1])
    judgements = [
        energy_budget(runs),
        steady_mean(given / lost.mean(), "power of the floor over the power dissipated", 1.0, 0.05),
        steady_mean(force / number, "force on the floor over the weight", 1.0, 0.05),
        _hydrostatic(scene, runs, mass),
        significant(profiles[:, 0] - profiles[:, low], "fall of T from the floor to its least"),
        significant(profiles[:, top] - profiles[:, low], "rise of T from there to the top"),
        significant(mass.max(axis=1) - mass[:, 0], "largest mass of a row less that at the floor"),
    ]
    note = (
        f"power {given.mean() / scene.duration:.4g}, {int(last(runs, 'collisions').sum())} collisions; least T at "
        f"z = {z[low]:.3g}, top at {z[top]:.3g}, densest at {z[np.argmax(filling)]:.3g}"
    )
    return worst(judgements, note, _bed_figures(scene, runs, dense))


def _bed_figures(scene: Scene, runs: list[Run], dense: Floats) -> tuple[Figure, ...]:
    """Profiles and maps of temperature and density, and the last state; dense: numbers of the rows that are shown."""
    width, top = 20.0, int(dense[-1])
    z, step, mass = _heights(scene, runs)
    profiles = temperature(*[field(runs, name).sum(axis=1) for name in ("mass", "momentum", "kinetic")])
    frame = Frame(0.0, width, 0.0, z[top] + step / 2, ("bottom",))
    total = [field(runs, name).sum(axis=0)[:, : top + 1] for name in ("mass", "momentum", "kinetic")]
    cells = total[0] / (STRETCHES * scene.duration * step * width / 8)
    return (
        Figure(
            "Bed on a shaken floor: temperature",
            "height",
            "T",
            series=(curve("shaken bed", z[dense], profiles[:, dense]),),
        ),
        Figure(
            "Bed on a shaken floor: density",
            "height",
            "packing fraction",
            series=(curve("shaken bed", z[dense], mass[:, dense] / (step * width) * math.pi / 4),),
        ),
        field_figure("Bed: packing fraction", cells * math.pi / 4, frame, "packing fraction, by centres"),
        field_figure("Bed: temperature", temperature(*total), frame, "T"),
        snapshot_figure(
            "Bed: grains", runs[-1], frame, width, np.linalg.norm(runs[-1]["final_velocities"], axis=1), "speed"
        ),
        snapshot_figure(
            "Bed: granular temperature",
            runs[-1],
            frame,
            width,
            local_temperature(runs[-1], 4.0, width),
            "T of the neighbours",
        ),
    )


def _constant_energy(runs: list[Run]) -> Judgement:
    """The time integral of K + U of each run but the first, over E t, with E of the state that it starts from."""
    defects = []
    for before, run in itertools.pairwise(runs):
        energy = 0.5 * float((before["final_velocities"] ** 2).sum()) + float(before["final_positions"][:, 1].sum())
        integral = float(run["kinetic_energy_integral"][-1] + run["potential_energy_integral"][-1])
        defects.append(abs(integral / (energy * float(run["time"][-1])) - 1))
    events = max(float(run["events"][-1]) for run in runs)
    return round_off(
        "time integral of K + U over E t, less 1, E of the places and velocities at the start",
        max(defects),
        EPSILON * events,
        f"one unit of the largest term at each of {events:.3g} events, at worst all alike",
    )


def _judge_column(laboratory: Laboratory) -> Judged:
    """K and U share the energy as their numbers of freedoms, 2N - 1 and 2N, times the non-ideal part of U."""
    number, width, warmth = 200, 20.0, 50.0
    scene = column(number, width, warmth, 1500.0, laboratory.seed())
    scene = scene.changed(output=Output(interval=1500.0, observables=OBSERVABLES, fields=(1, 20)))
    runs = run_on(laboratory, scene, STRETCHES, 1000.0)
    z, step, mass = _heights(scene, runs)
    kinetic = last(runs, "kinetic_energy_integral") / scene.duration
    potential = last(runs, "potential_energy_integral") / scene.duration - 0.5 * number
    warm = 2 * kinetic.mean() / (2 * number - 1)
    load = number / width
    z_mean = mean_compressibility(load, warm)
    layer = floor_layer(load, warm)
    ratio = mean_of_stretches(potential / kinetic)
    expected = 2 * number / (2 * number - 1) * z_mean
    below = np.cumsum(mass, axis=1)[:, :12] / number
    at = z[:12] + step / 2 - 0.5
    shares = column_profile(np.linspace(0, 0.999, 4000), load, warm)
    theory = np.interp(at, shares, np.linspace(0, 0.999, 4000)) + fixed_energy(at, number, warm)
    excess = mean_of_stretches((below - theory).mean(axis=1))
    judgements = [
        energy_budget(runs),
        _constant_energy(runs),
        statistical(
            "<U>/<K> of an elastic column, exact integrals",
            ratio.value,
            ratio.error,
            expected,
            0.0,
            f"2N/(2N-1) times the mean of Z over the pressures, {z_mean:.5f}; off by the layer at the floor",
            samples=ratio,
            doubt=layer * expected,
            needed=0.02,
        ),
        statistical(
            "share of the mass below a height, mean over 12 heights",
            float(theory.mean()) + excess.value,
            excess.error,
            float(theory.mean()),
            0.0,
            "barometric profile with Z(eta), at fixed energy; off by the layer at the floor and (<Z> - 1)/N",
            samples=excess,
            doubt=(z_mean - 1) / number + layer,
            needed=0.02,
        ),
        steady_mean(
            -last(runs, "wall_impulse")[:, FLOOR, 1] / scene.duration / number,
            "force on the floor over the weight",
            1.0,
            0.05,
        ),
        _hydrostatic(scene, runs, mass),
    ]
    density = np.diff(np.concatenate([[0.0], theory])) * number / step / width
    figure = Figure(
        "Elastic column: density over height",
        "height",
        "density",
        y_scale="log",
        series=(
            curve("elastic column", z[:12], mass[:, :12] / step / width),
            Series("barometric, with Z", z[:12].tolist(), density.tolist(), theory=True),
        ),
    )
    return worst(
        judgements, f"T = {warm:.4g}, packing fraction at the floor {load / warm * math.pi / 4:.3g}", (figure,)
    )


CHECKS = (
    Check(
        name="events/vibrated-bed",
        title="Disks under gravity: inelastic on a shaken floor, elastic on a floor at rest",
        equation="floor's power = dissipation, force = M g, momentum flux = weight above; rest: U/K = 2N/(2N-1) <Z>_p",
        criterion="round-off for the budget of the run; standard error of stretches for the rest",
        citation="J. J. Brey, M. J. Ruiz-Montero and F. Moreno, Phys. Rev. E 63, 061305 (2001); R. Soto, P. Cordero "
        "and D. Risso, SCAT workshop, Valparaiso (2007)",
        judge=lambda laboratory, judge: judge(laboratory),
        faults=(
            (
                "shaken",
                Fault(
                    "one-partner-loses",
                    "events/kernels/measure.py",
                    "_add(tallies, DISSIPATED, lost_i + lost_j)",
                    "_add(tallies, DISSIPATED, 2.0 * lost_i)",
                    "the loss of a pair is taken as twice that of one partner",
                ),
            ),
            (
                "elastic",
                Fault(
                    "height-drifts",
                    "events/kernels/measure.py",
                    "_add(tallies, HEIGHT, s * (sums[RISE] + 0.5 * s * sums[PULL]))",
                    "_add(tallies, HEIGHT, s * (sums[RISE] + s * sums[PULL]))",
                    "the moment of the field is taken along a parabola that falls twice as fast",
                ),
            ),
        ),
        variants=full(shaken=_judge_shaken, elastic=_judge_column),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "acceleration",
                    "box.boundaries=hard",
                    "box.boundaries=periodic",
                    "box.faces",
                    "box.faces.open",
                    "dimension=2",
                    "output.fields",
                }
            ),
            observables=frozenset(OBSERVABLES),
        ),
    ),
)
