"""Driven and confined systems: shaken bed, column at rest, channel, drum, heat conduction; snapshots.

Balances that hold exactly are asked for to round-off, those of a steady state to a standard error.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.checks.base import Laboratory, reference_check
from crosscheck.checks.events.fields import OBSERVABLES, column, energy_defect, run_on, run_whole, temperature
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import FieldMap, Figure, Frame, RoundFrame, Series, Snapshot
from crosscheck.references import EPSILON
from crosscheck.references.hard_spheres import (
    Estimate,
    contact_value,
    disk_compressibility,
    packing_fraction,
)
from crosscheck.scene import (
    Box,
    Cylinder,
    Face,
    Floats,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Output,
    RandomPhase,
    Scene,
)
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import Mean, correlated_mean, standard_error
from crosscheck.verdict import FALSE_ALARM, Judged, Judgement, bounded, round_off, statistical, worst

#: Stretches that a steady state is measured in.
STRETCHES = 16
_STEADY = f"standard error over {STRETCHES} stretches of one run, of a steady state"


def _mean(values: ArrayLike, quantity: str, expected: float, needed: float, why: str = _STEADY) -> Judgement:
    """The mean over stretches against a number."""
    mean = correlated_mean(values)
    samples = mean.independent
    return statistical(quantity, mean.value, mean.error, expected, 0.0, why, samples=samples, needed=needed)


def _last(runs: list[Run], name: str) -> Floats:
    """A tally at the end of each stretch."""
    return np.array([run[name][-1] for run in runs])


def _field(runs: list[Run], name: str) -> Floats:
    """A field of each stretch, (stretches, ...)."""
    return np.array([run[f"field_{name}"] for run in runs])


def _budget(runs: list[Run]) -> Judgement:
    """K + U changes by what walls give less what pairs dissipate."""
    defects = [energy_defect(run) for run in runs]
    events = max(float(run["events"][-1]) for run in runs)
    return round_off(
        "change of K + U - walls' work + dissipated, over the largest term",
        max(defect / size for defect, size in defects),
        EPSILON * events,
        f"one unit of the largest term at each of {events:.3g} events, at worst all alike",
    )


def _map(title: str, values: Floats, frame: Frame | RoundFrame, label: str) -> Figure:
    """values[ix, iy] on the container."""
    return Figure(title, "x", "y", map=FieldMap(values.T.tolist(), frame, label))


def snapshot_figure(
    title: str, run: Run, frame: Frame | RoundFrame, period: float, values: Floats, label: str
) -> Figure:
    """Disks of diameter 1 at the end of a run, coloured by `values`; period: of x, or 0."""
    x, y = wrapped(run["final_positions"], np.array([period, 0.0])).T
    ends = (0.0, float(np.nanquantile(values, 0.98)))
    return Figure(title, "x", "y", snapshot=Snapshot(x.tolist(), y.tolist(), 0.5, frame, values.tolist(), label, ends))


def _local_temperature(run: Run, reach: float, period: float) -> Floats:
    """(<v^2> - <v>^2)/2 of each disk with its neighbours within `reach`; NaN for a lone one; period: of x, or 0."""
    from scipy.spatial import cKDTree

    periods = np.array([period, 0.0])
    x, v = wrapped(run["final_positions"], periods), run["final_velocities"]
    near = cKDTree(x, boxsize=periods)
    groups = [near.query_ball_point(place, reach) for place in x]
    return np.array([0.5 * v[group].var(axis=0).sum() if len(group) > 1 else math.nan for group in groups])


# -- a bed on a shaken floor ---------------------------------------------------------------------------


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


def _judge_bed(laboratory: Laboratory, variant: str) -> Judged:
    return _judge_column(laboratory) if variant == "elastic" else _judge_shaken(laboratory)


def _heights(scene: Scene, runs: list[Run]) -> tuple[Floats, float, Floats]:
    """Middles of the rows, their height, and the mass in each row of each stretch, averaged over time."""
    mass = _field(runs, "mass").sum(axis=1) / scene.duration
    lengths = scene.lengths()
    assert lengths is not None
    step = lengths[1] / mass.shape[1]
    return (np.arange(mass.shape[1]) + 0.5) * step, float(step), mass


def _hydrostatic(scene: Scene, runs: list[Run], mass: Floats) -> Judgement:
    """p_yy integrated over the heights, against the weight above each."""
    flux = _field(runs, "flux_momentum")[:, 1, :, 1:, 1].sum(axis=1) / scene.duration
    above = np.cumsum(mass[:, ::-1], axis=1)[:, ::-1][:, 1:]
    return _mean(
        flux.sum(axis=1) / above.sum(axis=1), "momentum flux through a height over the weight above", 1.0, 0.05
    )


def _judge_shaken(laboratory: Laboratory) -> Judged:
    scene = _bed(laboratory.seed())
    runs = run_on(laboratory, scene, STRETCHES, 500.0)
    z, step, mass = _heights(scene, runs)
    number, width = scene.number, 20.0
    given, lost = _last(runs, "wall_energy")[:, 2], _last(runs, "dissipated_energy")
    force = -_last(runs, "wall_impulse")[:, 2, 1] / scene.duration
    rows = [_field(runs, name).sum(axis=1) for name in ("mass", "momentum", "kinetic")]
    profiles = temperature(*rows)
    hot, full = profiles.mean(axis=0), mass.mean(axis=0)
    dense = np.flatnonzero(full > 0.001 * number)  # rows that hold something at all times
    low, top = int(dense[np.argmin(hot[dense])]), int(dense[-1])
    judgements = [
        _budget(runs),
        _mean(given / lost.mean(), "power of the floor over the power dissipated", 1.0, 0.05),
        _mean(force / number, "force on the floor over the weight", 1.0, 0.05),
        _hydrostatic(scene, runs, mass),
        _significant(profiles[:, 0] - profiles[:, low], f"fall of T from the floor to z = {z[low]:.3g}"),
        _significant(profiles[:, top] - profiles[:, low], f"rise of T from there to z = {z[top]:.3g}"),
        _significant(mass.max(axis=1) - mass[:, 0], f"density at z = {z[np.argmax(full)]:.3g} less that at the floor"),
    ]
    frame = Frame(0.0, width, 0.0, z[top] + step / 2, ("bottom",))
    total = [_field(runs, name).sum(axis=0)[:, : top + 1] for name in ("mass", "momentum", "kinetic")]
    cells = total[0] / (STRETCHES * scene.duration * step * width / 8)
    figures = (
        Figure(
            "Bed on a shaken floor: temperature",
            "height",
            "T",
            series=(_curve("shaken bed", z[dense], profiles[:, dense]),),
        ),
        Figure(
            "Bed on a shaken floor: density",
            "height",
            "packing fraction",
            series=(_curve("shaken bed", z[dense], mass[:, dense] / (step * width) * math.pi / 4),),
        ),
        _map("Bed: packing fraction", cells * math.pi / 4, frame, "packing fraction, by centres"),
        _map("Bed: temperature", temperature(*total), frame, "T"),
        snapshot_figure(
            "Bed: grains", runs[-1], frame, width, np.linalg.norm(runs[-1]["final_velocities"], axis=1), "speed"
        ),
        snapshot_figure(
            "Bed: granular temperature",
            runs[-1],
            frame,
            width,
            _local_temperature(runs[-1], 4.0, width),
            "T of the neighbours",
        ),
    )
    note = f"power {given.mean() / scene.duration:.4g}, {int(_last(runs, 'collisions').sum())} collisions"
    return worst(judgements, note, figures)


def _curve(label: str, x: Floats, values: Floats) -> Series:
    """Mean and standard error over stretches."""
    error = standard_error(values)
    return Series(label, x.tolist(), values.mean(axis=0).tolist(), error.tolist())


def _significant(values: Floats, quantity: str) -> Judgement:
    """A difference that must be positive beyond doubt."""
    from scipy.stats import t

    mean = correlated_mean(values)
    return bounded(
        f"{quantity}, in standard errors",
        mean.value / mean.error,
        float(t.isf(FALSE_ALARM, len(values) - 1)),
        f"Student's t of {len(values)} stretches, false-alarm rate {FALSE_ALARM:g}; the difference is {mean.value:.4g}",
        at_least=True,
    )


# -- an elastic column at rest -------------------------------------------------------------------------


def mean_compressibility(pressure: float, temperature: float) -> float:
    """(1/p0) int_0^p0 Z dp of disks at one temperature: U/(N T) of a column whose floor bears the pressure p0.

    From dp = -n m g dz: U = int n m g z dz = int p dz = int p dp/(n m g), and p = n T Z. The density changes little
    over a diameter.
    """
    eta = np.linspace(0.0, 0.3, 3001)
    z = np.array([disk_compressibility(x).value for x in eta])
    p = eta * 4 / math.pi * temperature * z
    if not p[-1] > pressure:
        raise ValueError(f"a floor that bears {pressure:g} is denser than eta = 0.3 at T = {temperature:g}")
    grid = np.linspace(0.0, pressure, 2001)
    return float(np.trapezoid(np.interp(grid, p, z), grid) / pressure)


def column_profile(mass_below: ArrayLike, pressure: float, temperature: float) -> Floats:
    """Height z (gravity and mass 1) below which this share of a column of disks is: z = T int_p^p0 Z dp/p."""
    eta = np.linspace(0.0, 0.3, 3001)
    z = np.array([disk_compressibility(x).value for x in eta])
    p = eta * 4 / math.pi * temperature * z
    grid = np.geomspace(1e-6, 1.0, 20001) * pressure
    integrand = np.interp(grid, p, z)
    depth = np.concatenate([[0.0], np.cumsum(0.5 * (integrand[1:] + integrand[:-1]) * np.diff(np.log(grid)))])
    heights = temperature * (depth[-1] - depth)
    return np.asarray(np.interp(1 - np.asarray(mass_below), grid / pressure, heights))


def fixed_energy(height: ArrayLike, number: int, temperature: float) -> Floats:
    """Share of an ideal column below a height (gravity and mass 1), at fixed energy less at fixed temperature.

    (1 - z/E)^(2N - 3/2), E = (2N - 1/2) T, in place of exp(-z/T), in two dimensions and without momentum sideways.
    """
    z, power = np.asarray(height, dtype=np.float64), 2 * number - 1.5
    return np.asarray(np.exp(-z / temperature) - np.maximum(1 - z / ((power + 1) * temperature), 0.0) ** power)


def _judge_column(laboratory: Laboratory) -> Judged:
    """K and U share the energy as their numbers of freedoms, 2N - 1 and 2N, times the non-ideal part of U."""
    number, width, warmth = 200, 20.0, 50.0
    scene = column(number, width, warmth, 1500.0, laboratory.seed())
    scene = scene.changed(output=Output(interval=1500.0, observables=OBSERVABLES, fields=(1, 20)))
    runs = run_on(laboratory, scene, STRETCHES, 1000.0)
    z, step, mass = _heights(scene, runs)
    kinetic = _last(runs, "kinetic_energy_integral") / scene.duration
    potential = _last(runs, "potential_energy_integral") / scene.duration - 0.5 * number
    warm = 2 * kinetic.mean() / (2 * number - 1)
    load = number / width
    z_mean = mean_compressibility(load, warm)
    # grains that the floor attracts: (2/3) n^2 sigma^3 per length, which are not higher up
    layer = 4 / 3 * (load / warm) / warm
    ratio = correlated_mean(potential / kinetic)
    expected = 2 * number / (2 * number - 1) * z_mean
    below = np.cumsum(mass, axis=1)[:, :12] / number
    at = z[:12] + step / 2 - 0.5
    shares = column_profile(np.linspace(0, 0.999, 4000), load, warm)
    theory = np.interp(at, shares, np.linspace(0, 0.999, 4000)) + fixed_energy(at, number, warm)
    excess = correlated_mean((below - theory).mean(axis=1))
    judgements = [
        _budget(runs),
        statistical(
            "<U>/<K> of an elastic column, exact integrals",
            ratio.value,
            ratio.error,
            expected,
            layer * expected,
            f"2N/(2N-1) times the mean of Z over the pressures, {z_mean:.5f}; uncertain by the layer at the floor",
            samples=ratio.independent,
            needed=0.02,
        ),
        statistical(
            "share of the mass below a height, mean over 12 heights",
            float(theory.mean()) + excess.value,
            excess.error,
            float(theory.mean()),
            (z_mean - 1) / number + layer,
            "barometric profile with Z(eta), at fixed energy; uncertain by the layer at the floor and (<Z> - 1)/N",
            samples=excess.independent,
            needed=0.02,
        ),
        _mean(
            -_last(runs, "wall_impulse")[:, 2, 1] / scene.duration / number,
            "force on the floor over the weight",
            1.0,
            0.05,
        ),
        _hydrostatic(scene, runs, mass),
    ]
    curve = np.diff(np.concatenate([[0.0], theory])) * number / step / width
    figure = Figure(
        "Elastic column: density over height",
        "height",
        "density",
        y_scale="log",
        series=(
            _curve("elastic column", z[:12], mass[:, :12] / step / width),
            Series("barometric, with Z", z[:12].tolist(), curve.tolist(), theory=True),
        ),
    )
    return worst(
        judgements, f"T = {warm:.4g}, packing fraction at the floor {load / warm * math.pi / 4:.3g}", (figure,)
    )


# -- a channel -----------------------------------------------------------------------------------------


def _channel(seed: int) -> Scene:
    """Rough inelastic disks that fall between two rough walls, periodic along the fall."""
    wall = Face(restitution=0.9, friction=Friction(tangential_restitution=0.0))
    return Scene(
        name="channel",
        dimension=2,
        duration=1000.0,
        acceleration=(0.1, 0.0),
        hard_spheres=HardSpheres(
            restitution=0.9, friction=GrainFriction(tangential_restitution=0.5, static=0.3, sliding=0.3)
        ),
        box=Box(lengths=(26.0, 13.0), boundaries=("periodic", "hard"), faces={"y-": wall, "y+": wall}),
        initial=Lattice(kind="lattice", structure="square", number=130, temperature=1.0, seed=seed),
        output=Output(interval=1000.0, observables=OBSERVABLES, fields=(1, 12)),
    )


def _judge_channel(laboratory: Laboratory, variant: str) -> Judged:
    scene = _channel(laboratory.seed())
    assert scene.acceleration is not None
    runs = run_on(laboratory, scene, STRETCHES, 400.0)
    pull, number = scene.acceleration[0], scene.number
    drag = _last(runs, "wall_impulse")[:, 2:4, 0].sum(axis=1) / scene.duration
    momentum = _field(runs, "momentum")[:, 0, :, 0]
    work = pull * momentum.sum(axis=1)
    lost = _last(runs, "dissipated_energy") - _last(runs, "wall_energy").sum(axis=1)
    mass = _field(runs, "mass")[:, 0] / scene.duration
    stress = _field(runs, "flux_momentum")[:, 1, 0, 1:, 0] / scene.duration
    share = pull * (np.cumsum(mass, axis=1)[:, :-1] - 0.5 * number)
    slope = (stress * share).sum(axis=1) / (share**2).sum(axis=1)
    judgements = [
        _budget(runs),
        _mean(drag / (pull * number), "drag of both walls over the weight", 1.0, 0.03),
        _mean(lost / work.mean(), "power lost in pairs and at walls over that of gravity", 1.0, 0.05),
        _mean(slope, "shear stress over the weight between there and the middle", 1.0, 0.1),
    ]
    speed = momentum / scene.duration / mass
    hot = temperature(_field(runs, "mass")[:, 0], _field(runs, "momentum")[:, 0], _field(runs, "kinetic")[:, 0])
    y = (np.arange(12) + 0.5) * 13.0 / 12
    figures = (
        Figure("Channel: velocity", "y", "velocity along the fall", series=(_curve("channel", y, speed),)),
        Figure("Channel: temperature", "y", "T", series=(_curve("channel", y, hot),)),
        Figure(
            "Channel: shear stress",
            "y",
            "stress per length",
            series=(
                _curve("channel", y[1:] - 13.0 / 24, stress / 26.0),
                Series("weight", (y[1:] - 13.0 / 24).tolist(), (share.mean(axis=0) / 26.0).tolist(), theory=True),
            ),
        ),
    )
    note = f"mean speed {speed.mean():.4g}, {int(_last(runs, 'collisions').sum())} collisions"
    return worst(judgements, note, figures)


# -- a drum --------------------------------------------------------------------------------------------

#: Radius of the drum, and time between samples of its runs.
DRUM_RADIUS, DRUM_SAMPLE = 10.0, 0.5
_DRUM_SPEED = 0.2
#: By which the angle falls with t_c, in degrees a unit of time; measured for t_c from 6e-5 to 1e-3.
_ANGLE_SLOPE = 1.06e4


def drum_scene(seed: int, contact: float) -> Scene:
    """Rough disks that fill some 45 % of a drum; contact: t_c of the TC model."""
    radius = DRUM_RADIUS
    return Scene(
        name="drum",
        dimension=2,
        duration=300.0,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(
            restitution=0.6,
            contact_duration=contact,
            friction=GrainFriction(tangential_restitution=0.5, static=0.5, sliding=0.5),
        ),
        box=Box(
            lengths=(2 * radius, 2 * radius),
            boundaries=("open", "open"),
            cylinder=Cylinder(
                radius=radius,
                angular_velocity=_DRUM_SPEED,
                restitution=0.6,
                friction=Friction(tangential_restitution=0.0, static=0.8, sliding=0.8),
            ),
        ),
        initial=Lattice(kind="lattice", structure="triangular", number=150, temperature=0.1, seed=seed),
        output=Output(
            interval=DRUM_SAMPLE, observables=(*OBSERVABLES, "wall_torque"), trajectory=True, fields=(16, 16)
        ),
    )


def surface_angle(positions: Floats, middle: Floats, radius: float) -> float:
    """Angle, in degrees, of the line through the highest disks of a heap in a drum, by least squares.

    positions: (N, 2). Highest are those of each strip, one diameter wide and normal to the line from the middle to the
    centre of mass turned by 90 degrees, within 0.6 radii of the middle. NaN with fewer than 4 of them.
    """
    centre = positions.mean(axis=0) - middle
    down = centre / np.hypot(*centre)
    along = np.array([-down[1], down[0]])
    x, height = (positions - middle) @ along, -(positions - middle) @ down
    strips = np.floor(x).astype(int)
    tops = [np.flatnonzero(strips == s)[np.argmax(height[strips == s])] for s in np.unique(strips)]
    tops = [i for i in tops if abs(x[i]) < 0.6 * radius]
    if len(tops) < 4:
        return math.nan
    slope = np.polyfit(x[tops], height[tops], 1)[0]
    return float(np.degrees(np.arctan2(along[1], along[0]) + np.arctan(slope)))


def _judge_drum(laboratory: Laboratory, variant: str) -> Judged:
    contact = 2e-4
    runs = [run_whole(laboratory, drum_scene(laboratory.seed(f"drum-{part}"), contact / part)) for part in (1, 2)]
    skip = round(15.0 / DRUM_SAMPLE)
    middle = np.full(2, DRUM_RADIUS)
    series = []
    for run in runs:
        series.append(np.array([surface_angle(x, middle, DRUM_RADIUS) for x in run["positions"]]))
    angles = [correlated_mean(one[skip:]) for one in series]
    halves = [correlated_mean(one) for one in np.array_split(series[0][skip:], 2)]
    judgements = [
        _budget(runs),
        _difference(
            "angle of the surface, t_c and t_c/2",
            angles[0],
            angles[1],
            "both runs' standard errors, and what is left of the angle's linear fall with t_c (docs/driven.md)",
            _ANGLE_SLOPE * contact / 2,
        ),
        _difference(
            "angle of the surface, first and second half", halves[0], halves[1], "both halves' standard errors"
        ),
    ]
    for run in runs:
        judgements += _drum_balances(run, skip)
    frame = RoundFrame(DRUM_RADIUS, DRUM_RADIUS, DRUM_RADIUS)
    run = runs[0]
    t = run
    inside = t["field_mass"] > 0.02 * t["field_mass"].max()
    hot = np.where(inside, temperature(t["field_mass"], t["field_momentum"], t["field_kinetic"]), math.nan)
    share = t["field_mass"] / run["time"][-1] * (math.pi / 4) / (DRUM_RADIUS / 8) ** 2
    figures = (
        snapshot_figure("Drum: grains", run, frame, 0.0, np.linalg.norm(run["final_velocities"], axis=1), "speed"),
        snapshot_figure(
            "Drum: granular temperature", run, frame, 0.0, _local_temperature(run, 2.0, 0.0), "T of the neighbours"
        ),
        _map("Drum: packing fraction", np.where(inside, share, math.nan), frame, "packing fraction, by centres"),
        _map("Drum: mean temperature", hot, frame, "T"),
        Figure(
            "Drum: angle of the surface",
            "time",
            "degrees",
            series=tuple(
                Series(label, run["time"][10:].tolist(), one[10:].tolist())
                for label, one in zip(("t_c", "t_c/2"), series, strict=True)
            ),
        ),
    )
    collisions = " and ".join(f"{int(run['collisions'][-1])}" for run in runs)
    note = f"angle {angles[0].value:.2f} +- {angles[0].error:.2f} degrees; {collisions} collisions"
    return worst(judgements, note, figures)


def _difference(quantity: str, one: Mean, other: Mean, why: str, doubt: float = 0.0) -> Judgement:
    samples = min(one.independent, other.independent)
    error = math.hypot(other.error, doubt)
    return statistical(quantity, one.value, one.error, other.value, error, why, samples=samples)


def _drum_balances(run: Run, skip: int) -> list[Judgement]:
    """Of the steady part: the walls' work against the dissipated, their torque against that of the weight."""
    t = run
    given, lost = np.diff(t["wall_energy"][skip:, 4]), np.diff(t["dissipated_energy"][skip:])
    torque = np.diff(t["wall_torque"][skip:]) / DRUM_SAMPLE
    lever = (run["positions"][skip:, :, 0] - DRUM_RADIUS).sum(axis=1)
    lever = 0.5 * (lever[1:] + lever[:-1])
    why = "standard error of the correlated series of samples"
    supplied = _DRUM_SPEED * (t["wall_torque"][-1] - t["wall_torque"][0])
    return [
        _mean((given - lost) / lost.mean(), "walls' work less dissipation in pairs, over the latter", 0.0, 0.3, why),
        _mean(
            torque / lever.mean() - lever / lever.mean(),
            "torque of the wall less that of the weight, over the latter",
            0.0,
            0.1,
            why,
        ),
        bounded(
            "energy given by the wall over torque times angular velocity",
            float((t["wall_energy"][-1, 4] - t["wall_energy"][0, 4]) / supplied),
            1.0,
            "impacts on the wall lose energy as well",
        ),
    ]


# -- heat conduction -----------------------------------------------------------------------------------


def enskog_conductivity(density: float, temperature: float, dimension: int) -> Estimate:
    """Thermal conductivity of hard disks or spheres of mass and diameter 1, Enskog's theory.

    lambda = lambda_0 b n (1/y + c_1 + c_2 y), y = b n g = Z - 1. Disks: lambda_0 = 1.02925 (2/sqrt(pi)) sqrt(T), c_1 =
    3/2, c_2 = 0.8718 (Gass 1971); spheres: 1.02513 (75/64) sqrt(T/pi), 6/5, 0.7574 (Chapman and Cowling). Uncertain by
    3 % and 2 %: what correlated collisions change at these densities (Alder, Gass and Wainwright 1970; Garcia-Rojo,
    Luding and Brey 2006).
    """
    g = contact_value(packing_fraction(density, dimension), dimension).value
    bn = math.pi / 2 * density if dimension == 2 else 2 * math.pi / 3 * density
    y = bn * g
    if dimension == 2:
        value = 1.02925 * 2 * math.sqrt(temperature / math.pi) * bn * (1 / y + 1.5 + 0.8718 * y)
        return Estimate(value, 0.03 * value)
    value = 1.02513 * 75 / 64 * math.sqrt(temperature / math.pi) * bn * (1 / y + 1.2 + 0.7574 * y)
    return Estimate(value, 0.02 * value)


def _slab(dimension: Literal[2, 3], seed: int) -> Scene:
    """Elastic disks or spheres between walls at T = 4 and 1, periodic sideways, 0.2 a unit of volume."""
    lengths = (60.0, 30.0) if dimension == 2 else (30.0, 8.0, 8.0)
    number = round(0.2 * math.prod(lengths))
    return Scene(
        name=f"slab-{dimension}d",
        dimension=dimension,
        duration=2000.0 if dimension == 2 else 400.0,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=lengths,
            boundaries=("hard", "periodic") if dimension == 2 else ("hard", "periodic", "periodic"),
            faces={"x-": Face(temperature=4.0), "x+": Face(temperature=1.0)},
        ),
        initial=Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=number, temperature=2.0, seed=seed
        ),
        output=Output(
            interval=2000.0 if dimension == 2 else 400.0,
            observables=OBSERVABLES,
            fields=(12, 6) if dimension == 2 else (12, 1, 1),
        ),
    )


#: Cells next to either wall that are left out: the gas slips there.
_EDGE = 2


def _judge_heat(laboratory: Laboratory, variant: str) -> Judged:
    dimension: Literal[2, 3] = 2 if variant == "2d" else 3
    scene = _slab(dimension, laboratory.seed())
    runs = run_on(laboratory, scene, STRETCHES, scene.duration)
    lengths = scene.lengths()
    assert lengths is not None
    area, step = float(np.prod(lengths[1:])), lengths[0] / 12
    beside = tuple(range(2, 1 + dimension))
    mass, momentum, kinetic = (_field(runs, name).sum(axis=beside) for name in ("mass", "momentum", "kinetic"))
    hot = temperature(mass, momentum, kinetic)
    density = mass / scene.duration / (area * step)
    scale = area * scene.duration
    heat = _field(runs, "flux_energy")[:, 0].sum(axis=beside)[:, 1:] / scale
    pressure = _field(runs, "flux_momentum")[:, 0].sum(axis=beside)[:, 1:, 0] / scale
    walls = _last(runs, "wall_energy")[:, :2] * [1, -1] / scale
    x = np.arange(1, 12) * step
    lever = (x - x.mean()) / np.sum((x - x.mean()) ** 2) * lengths[0]
    q = float(heat.mean())
    # -kappa dT/dx between neighbouring cells, with the Enskog kappa of their mean state
    inner = range(_EDGE, 12 - 1 - _EDGE)
    states = [
        (0.5 * (density[:, i] + density[:, i + 1]).mean(), 0.5 * (hot[:, i] + hot[:, i + 1]).mean()) for i in inner
    ]
    theory = np.array([enskog_conductivity(float(n), float(t), dimension).value for n, t in states])
    gradient = np.array([(hot[:, i] - hot[:, i + 1]) / step for i in inner]).T
    ratio = correlated_mean(heat.mean(axis=1) / (gradient * theory).mean(axis=1))
    doubt = 0.03 if dimension == 2 else 0.02
    judgements = [
        _budget(runs),
        _mean(heat @ lever / q, "change of the heat flux from wall to wall, over the flux", 0.0, 0.1),
        _mean(walls.mean(axis=1) / heat.mean(axis=1), "heat through the walls over the flux inside", 1.0, 0.05),
        _mean(
            pressure @ lever / pressure.mean(), "change of the pressure from wall to wall, over the pressure", 0.0, 0.02
        ),
        statistical(
            "conductivity over Enskog's",
            ratio.value,
            ratio.error,
            1.0,
            doubt,
            f"{_STEADY}; theory uncertain by {doubt:.0%}, cells next to the walls left out",
            samples=ratio.independent,
            needed=0.25,
        ),
        bounded(
            "rise of T from one cell to the next towards the cold wall, largest",
            float(np.diff(hot.mean(axis=0)).max()),
            0.0,
            "temperature falls all the way",
        ),
    ]
    middle = (np.arange(12) + 0.5) * step
    # Fourier's law with Enskog's kappa, from the middle outwards
    fine = np.linspace(middle[0], middle[-1], 401)
    rates = [
        -q / enskog_conductivity(float(n), float(t), dimension).value
        for n, t in zip(
            np.interp(fine, middle, density.mean(axis=0)), np.interp(fine, middle, hot.mean(axis=0)), strict=True
        )
    ]
    curve = np.concatenate([[0.0], np.cumsum(0.5 * (np.array(rates)[1:] + np.array(rates)[:-1]) * np.diff(fine))])
    curve += np.interp(lengths[0] / 2, middle, hot.mean(axis=0)) - np.interp(lengths[0] / 2, fine, curve)
    figures = [
        Figure(
            "Heat conduction: temperature",
            "x",
            "T",
            series=(
                _curve(f"{dimension}D", middle, hot),
                Series(
                    f"{dimension}D, Fourier with Enskog's conductivity",
                    fine[::20].tolist(),
                    curve[::20].tolist(),
                    theory=True,
                ),
            ),
        ),
        Figure("Heat conduction: density", "x", "n", series=(_curve(f"{dimension}D", middle, density),)),
        Figure(
            "Heat conduction: heat flux",
            "x",
            "q",
            series=(
                _curve(
                    f"{dimension}D",
                    np.concatenate([[0.0], x, [lengths[0]]]),
                    np.column_stack([walls[:, 0], heat, walls[:, 1]]),
                ),
            ),
        ),
    ]
    if dimension == 2:
        frame = Frame(0.0, lengths[0], 0.0, lengths[1], ("left", "right"))
        total = [_field(runs, name).sum(axis=0) for name in ("mass", "momentum", "kinetic")]
        cell = STRETCHES * scene.duration * float(np.prod(lengths)) / total[0].size
        figures += [
            _map("Heat conduction: temperature, cells", temperature(*total), frame, "T"),
            _map("Heat conduction: density, cells", total[0] / cell, frame, "n"),
        ]
    jumps = 4.0 - (1.5 * hot[:, 0] - 0.5 * hot[:, 1]).mean(), (1.5 * hot[:, -1] - 0.5 * hot[:, -2]).mean() - 1.0
    note = f"q = {q:.4g}, p = {pressure.mean():.4g}, jumps of T at the walls about {jumps[0]:.2g} and {jumps[1]:.2g}"
    return worst(judgements, note, tuple(figures))


# -- snapshots -----------------------------------------------------------------------------------------

_NUMBER, _DENSITY, _NEAR = 200, 0.1, 1.2
_MODES = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0, 2))


def structure_factor(density: float, wave_number: ArrayLike) -> Floats:
    """S(k) of disks of diameter 1 at small k: 1/(1 - n c(k)), 1 - n c(0) = d(eta Z)/deta, c(k)/c(0) = 2 J_1(k)/k.

    The shape of c(k) is that of its lowest order in the density.
    """
    from scipy.special import j1

    eta = packing_fraction(density, 2)
    h = 1e-3 * eta
    stiffness = sum(s * (eta + s * h) * disk_compressibility(eta + s * h).value for s in (-1, 1)) / (2 * h)
    k = np.asarray(wave_number, dtype=np.float64)
    return np.asarray(1 / (1 + (stiffness - 1) * 2 * j1(k) / k))


def neighbour_share(density: float, reach: float) -> float:
    """Share of the disks (diameter 1) of a dilute fluid with another centre within `reach`, to second order.

    n int g d2r - (n^2/2) int int e(r_12) d2r1 d2r2 over 1 < r < reach, with g = 1 + n A(r), A the lens that two unit
    circles share, scaled to the known g at contact; e = 0 for r_12 < 1.
    """
    x, w = np.polynomial.legendre.leggauss(40)
    r, w = 1 + 0.5 * (reach - 1) * (x + 1), 0.5 * (reach - 1) * w
    lens = 2 * np.arccos(r / 2) - 0.5 * r * np.sqrt(4 - r * r)
    contact = contact_value(packing_fraction(density, 2), 2).value
    scale = contact / (1 + density * (2 * math.pi / 3 - 0.5 * 3**0.5))
    one = density * 2 * math.pi * float(np.sum(w * r * (1 + density * lens))) * scale
    cosine = (r[:, None] ** 2 + r[None, :] ** 2 - 1) / (2 * r[:, None] * r[None, :])
    free = 2 * (math.pi - np.arccos(np.clip(cosine, -1, 1)))
    two = 0.5 * density**2 * 2 * math.pi * float(np.einsum("i,j,ij->", w * r, w * r, free))
    return one - two


def _judge_snapshots(laboratory: Laboratory, variant: str) -> Judged:
    scene = Scene(
        name="snapshots",
        dimension=2,
        duration=30000.0,
        hard_spheres=HardSpheres(),
        box=Box(density=_DENSITY),
        initial=Lattice(kind="lattice", structure="square", number=_NUMBER, temperature=1.0, seed=laboratory.seed()),
        output=Output(interval=10.0, observables=OBSERVABLES, trajectory=True),
    )
    run = run_whole(laboratory, scene)
    lengths = scene.lengths()
    assert lengths is not None
    positions = run["positions"][10:]
    return _judge_modes(positions, lengths[0]) if variant == "modes" else _judge_clusters(positions, lengths[0])


def _judge_modes(positions: Floats, length: float) -> Judged:
    measured, expected = [], []
    for mode in _MODES:
        wave = 2 * math.pi / length * np.array(mode)
        amplitude = np.exp(-1j * (positions @ wave)).sum(axis=1)
        measured.append(np.abs(amplitude) ** 2 / _NUMBER)
        expected.append(float(structure_factor(_DENSITY, float(np.hypot(*wave)))))
    theory = np.array(expected)
    mean = correlated_mean((np.array(measured) / theory[:, None]).mean(axis=0) * theory.mean())
    k = np.array([2 * math.pi / length * math.hypot(*mode) for mode in _MODES])
    means = [correlated_mean(one) for one in measured]
    figure = Figure(
        "Snapshots: structure factor",
        "k",
        "<|n(k)|^2>/N",
        series=(
            Series("snapshots", k.tolist(), [m.value for m in means], [m.error for m in means]),
            Series("compressibility", sorted(k.tolist()), structure_factor(_DENSITY, np.sort(k)).tolist(), theory=True),
        ),
    )
    return statistical(
        f"<|n(k)|^2>/N, mean of {len(_MODES)} long waves",
        mean.value,
        mean.error,
        float(theory.mean()),
        float(theory.mean()) / _NUMBER,
        f"correlated series of {len(positions)} snapshots; theory off by 1/N: fixed number",
        samples=mean.independent,
        needed=0.2,
        note="1 for an ideal gas",
        figures=(figure,),
    )


def _judge_clusters(positions: Floats, length: float) -> Judged:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    lengths = np.full(2, length)
    crowded, sizes = np.zeros(len(positions)), np.zeros(_NUMBER + 1)
    for sample, x in enumerate(positions):
        pairs = cKDTree(wrapped(x, lengths), boxsize=lengths).query_pairs(_NEAR, output_type="ndarray")
        graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(_NUMBER, _NUMBER))
        labels = connected_components(graph, directed=False)[1]
        members = np.bincount(np.bincount(labels), minlength=_NUMBER + 1)
        sizes += members
        crowded[sample] = 1 - members[1] / _NUMBER
    mean = correlated_mean(crowded)
    expected = neighbour_share(_DENSITY * (_NUMBER - 1) / _NUMBER, _NEAR)
    largest = int(np.flatnonzero(sizes)[-1])
    count = sizes[1 : largest + 1] / len(positions)
    figure = Figure(
        "Snapshots: clusters",
        "size",
        "number of clusters",
        y_scale="log",
        series=(Series(f"linked within {_NEAR}", list(map(float, range(1, largest + 1))), count.tolist()),),
    )
    return statistical(
        f"share of disks with another within {_NEAR} diameters",
        mean.value,
        mean.error,
        expected,
        0.01 * expected,
        f"correlated series of {len(positions)} snapshots; third order in the density, about 1 %, left out",
        samples=mean.independent,
        needed=0.1,
        note=f"largest cluster {largest}",
        figures=(figure,),
    )


_MEASURE = "events/kernels/measure.py"
CHECKS = (
    reference_check(
        "events/drum",
        "Rough disks in a turning drum: angle of the surface, work of the wall, torque of the weight",
        "d(K+U)/dt = wall - dissipation; torque of the wall = M g x_cm in the mean; angle converges as t_c -> 0",
        "round-off for the budget of the run; standard errors of correlated samples for the rest",
        "S. Luding and S. McNamara, Granular Matter 1, 113 (1998); O. R. Walton, in Particulate Two-Phase Flow (1993); "
        "G. H. Ristow, Pattern Formation in Granular Materials, Springer (2000)",
        _judge_drum,
        faults=(
            (
                "disks",
                Fault(
                    "torque-at-the-centre",
                    _MEASURE,
                    "sums[TORQUE] += stretch * (x * py - y * px)",
                    "sums[TORQUE] += 0.8 * stretch * (x * py - y * px)",
                    "the torque is taken with an arm that is too short",
                ),
            ),
        ),
        variants=("disks",),
    ),
    reference_check(
        "events/heat-conduction",
        "Elastic disks and spheres between two thermal walls: flux, pressure, temperature, conductivity",
        "q = -kappa dT/dx, uniform; kappa of Enskog: lambda_0 b n (1/y + 3/2 + 0.8718 y) for disks",
        "standard error of stretches; the conductivity to 3 % (2D), 2 % (3D), the doubt in Enskog's theory",
        "D. M. Gass, J. Chem. Phys. 54, 1898 (1971); B. J. Alder, D. M. Gass and T. E. Wainwright, J. Chem. Phys. 53, "
        "3813 (1970); D. Risso and P. Cordero, J. Stat. Phys. 82, 1453 (1996)",
        _judge_heat,
        faults=(
            (
                "2d",
                Fault(
                    "slow-carriers",
                    _MEASURE,
                    "energy += 0.5 * mass * v * v",
                    "energy += 0.4 * mass * v * v",
                    "particles carry too little of their kinetic energy through the faces of cells",
                ),
            ),
        ),
        variants=("2d", "3d"),
    ),
    reference_check(
        "events/pipe-flow",
        "Rough inelastic disks fall down a channel with rough walls: momentum and energy in the steady state",
        "drag of the walls = M g; g.p = dissipation in pairs and at walls; stress(y) = g (mass below - M/2)",
        "round-off for the budget of the run; standard error of stretches for the rest",
        "R. Soto, P. Cordero and D. Risso, SCAT workshop, Valparaiso (2007); J. T. Jenkins and M. W. Richman, J. Fluid "
        "Mech. 171, 53 (1986)",
        _judge_channel,
        faults=(
            (
                "channel",
                Fault(
                    "drag-cut",
                    _MEASURE,
                    "walls[face, 0] -= px",
                    "walls[face, 0] -= 0.9 * px",
                    "walls are told of nine tenths of the momentum along x that they get",
                ),
            ),
        ),
        variants=("channel",),
    ),
    reference_check(
        "events/snapshots",
        "Snapshots of a dilute gas of disks: long density waves against the compressibility, and clusters",
        "<|n(k)|^2>/N -> 1/(d(eta Z)/deta) for k -> 0; share with a neighbour: n int g - (n^2/2) int int e",
        "standard error of the correlated series of snapshots",
        "J.-P. Hansen and I. R. McDonald, Theory of Simple Liquids, sections 2.6, 3.5; S. Luding, Phys. Rev. E 63, "
        "042201 (2001)",
        _judge_snapshots,
        faults=(
            (
                "modes",
                Fault(
                    "small-disks",
                    "events/prediction.py",
                    "return diameter",
                    "return 0.5 * diameter",
                    "disks collide at half their diameter",
                ),
            ),
        ),
        variants=("modes", "clusters"),
    ),
    reference_check(
        "events/vibrated-bed",
        "Disks under gravity: inelastic on a shaken floor, elastic on a floor at rest",
        "floor's power = dissipation, force = M g, flux of momentum = weight above; elastic: U/K = 2N/(2N-1) <Z>_p",
        "round-off for the budget of the run; standard error of stretches for the rest",
        "J. J. Brey, M. J. Ruiz-Montero and F. Moreno, Phys. Rev. E 63, 061305 (2001); R. Soto, P. Cordero and D. "
        "Risso, SCAT workshop, Valparaiso (2007)",
        _judge_bed,
        faults=(
            (
                "shaken",
                Fault(
                    "one-partner-loses",
                    _MEASURE,
                    "sums[DISSIPATED] += lost_i + lost_j",
                    "sums[DISSIPATED] += 2.0 * lost_i",
                    "the loss of a pair is taken as twice that of one partner",
                ),
            ),
            (
                "elastic",
                Fault(
                    "height-drifts",
                    _MEASURE,
                    "sums[HEIGHT] += s * (sums[RISE] + 0.5 * s * sums[PULL])",
                    "sums[HEIGHT] += s * (sums[RISE] + s * sums[PULL])",
                    "the moment of the field is taken along a parabola that falls twice as fast",
                ),
            ),
        ),
        variants=("shaken", "elastic"),
    ),
)
