"""The Lorentz gas: points, or one finite particle, among fixed disks or spheres; speed, free path, diffusion.

Units: radius of the scatterers (as a point sees them) and speed are 1; x = n R^d is the density of scatterers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, variants_of
from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references import lorentz as reference
from crosscheck.scene import Box, Floats, HardSpheres, Output, Scene, explicit
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import standard_error
from crosscheck.verdict import Judged, Judgement, bounded, round_off, statistical, worst


class Arrangement(NamedTuple):
    """Fixed scatterers and moving points in a periodic box.

    centres: of the scatterers, (scatterers, d). places, velocities: of the points, in the free volume and of speed 1,
    (points, d). length: side of the box.
    """

    centres: Floats
    places: Floats
    velocities: Floats
    length: float


def arrangement(dimension: int, x: float, scatterers: int, points: int, seed: int, overlapping: bool) -> Arrangement:
    """Scatterers of radius 1 at random, one after the other, and points at random in the volume between them.

    dimension: 2 or 3. x: scatterers a unit of volume. scatterers, points: numbers of them. seed: of all that is random.
    overlapping: whether scatterers may overlap.
    """
    rng = np.random.default_rng(seed)
    length = (scatterers / x) ** (1 / dimension)
    if overlapping:
        centres = rng.uniform(0, length, (scatterers, dimension))
    else:
        centres = np.empty((0, dimension))
        while len(centres) < scatterers:
            trial = _apart_from(centres, rng.uniform(0, length, (scatterers, dimension)), length, 2.0)
            centres = np.vstack([centres, _apart(trial, length)])[:scatterers]
    places = np.empty((0, dimension))
    while len(places) < points:
        trial = rng.uniform(0, length, (2 * points, dimension))
        places = np.vstack([places, _apart_from(centres, trial, length, 1.0)])[:points]
    velocities = rng.normal(size=(points, dimension))
    velocities /= np.linalg.norm(velocities, axis=1)[:, None]
    return Arrangement(centres, places, velocities, length)


def _tree(places: Floats, length: float) -> Any:
    """k-d tree of places in the periodic box."""
    from scipy.spatial import cKDTree

    return cKDTree(places, boxsize=np.full(places.shape[1], length))


def _apart_from(centres: Floats, trial: Floats, length: float, distance: float) -> Floats:
    """Those of `trial` that are at least `distance` from all centres."""
    if len(centres) == 0:
        return trial
    nearest, _ = _tree(centres, length).query(trial)
    return np.asarray(trial[nearest >= distance])


def _apart(trial: Floats, length: float) -> Floats:
    """`trial` without those that overlap one before them."""
    pairs = _tree(trial, length).query_pairs(2.0, output_type="ndarray")
    kept = np.ones(len(trial), dtype=bool)
    kept[pairs.max(axis=1)] = False
    return np.asarray(trial[kept])


def _lorentz_gas(gas: Arrangement, dimension: int, duration: float, interval: float, size: float = 0.0) -> Scene:
    """Scatterers first, then the particles that move, of diameter `size`; contact is at 1 for any size."""
    scatterers, points = len(gas.centres), len(gas.places)
    return Scene(
        name=f"lorentz-gas-{dimension}d",
        dimension=dimension,  # type: ignore[arg-type]
        duration=duration,
        species=(0,) * scatterers + (1,) * points,
        hard_spheres=HardSpheres(diameter=(2.0 - size, size), fixed=(0,)),
        box=Box(lengths=(gas.length,) * dimension),
        initial=explicit(np.vstack([gas.centres, gas.places]), np.vstack([np.zeros_like(gas.centres), gas.velocities])),
        output=Output(interval=interval, trajectory=True, observables=("collisions",)),
    )


# -- gas of points -----------------------------------------------------------------------------------------------------

#: Numbers of scatterers and of points, by dimension, and of arrangements.
SCATTERERS, POINTS, ARRANGEMENTS = {2: 1000, 3: 2000}, {2: 1000, 3: 1000}, 20
#: In mean free paths: duration, samples, and the two times between which the mean-square displacement is straight.
PATHS, EVERY, EARLY, LATE = 240, 10, 20, 40


class _Measured(NamedTuple):
    """Of one arrangement: mean free path, diffusion coefficient, worst change of a speed, deepest place, collisions."""

    path: float
    diffusion: float
    speed_error: float
    depth: float
    collisions: float


def _measure(gas: Arrangement, scene: Scene, run: Run, interval: float) -> _Measured:
    points = slice(len(gas.centres), None)
    collisions = float(run["collisions"][-1])
    squares = []
    for paths in (EARLY, LATE):
        lag = paths // EVERY
        moved = run["positions"][lag:, points] - run["positions"][:-lag, points]
        squares.append(float((moved**2).sum(axis=2).mean()))
    diffusion = (squares[1] - squares[0]) / (2 * scene.dimension * (LATE - EARLY) / EVERY * interval)
    speed_error = float(abs(np.linalg.norm(run["final_velocities"][points], axis=1) - 1).max())
    ends = wrapped(run["final_positions"][points], np.full(scene.dimension, gas.length))
    nearest, _ = _tree(gas.centres, gas.length).query(ends)
    depth = max(1.0 - float(nearest.min()), 0.0)
    return _Measured(len(gas.places) * scene.duration / collisions, diffusion, speed_error, depth, collisions)


class _PointGas(NamedTuple):
    """Points among scatterers, which may overlap or not; x: scatterers a unit of volume."""

    dimension: int
    overlapping: bool
    x: float


def _judge_points(laboratory: Laboratory, gas_of_points: _PointGas) -> Judged:
    """Many points in each of several arrangements: the arrangements are the independent samples."""
    dimension, overlapping, x = gas_of_points
    path = reference.free_path(x, 1.0, dimension, overlapping)
    interval = EVERY * path
    found = []
    for number in range(ARRANGEMENTS):
        seed = laboratory.seed(str(number))
        gas = arrangement(dimension, x, SCATTERERS[dimension], POINTS[dimension], seed, overlapping)
        scene = _lorentz_gas(gas, dimension, PATHS * path, interval)
        found.append(_measure(gas, scene, laboratory.run(scene, EVENT_DRIVEN), interval))
    each = np.array(found)
    mean, error = each.mean(axis=0), standard_error(each)
    # reflections of one point: four times the mean over all
    most = 4 * float(each[:, 4].max()) / POINTS[dimension]
    speed = round_off(
        "largest change of a point's speed",
        float(each[:, 2].max()),
        8 * EPSILON * most,
        f"eight roundings for each of {most:.0f} reflections, four times the mean number",
    )
    depth = round_off(
        "deepest place of a point in a scatterer",
        float(each[:, 3].max()),
        4 * EPSILON * (SCATTERERS[dimension] / x) ** (1 / dimension),
        "four roundings of the box's length",
    )
    free = statistical(
        "mean free path",
        float(mean[0]),
        float(error[0]),
        path,
        0.0,
        f"standard error over {ARRANGEMENTS} arrangements; off by 1/N of their fluctuation",
        samples=ARRANGEMENTS,
        doubt=path / SCATTERERS[dimension],
        needed=0.03,
    )
    judgements = [speed, depth, free]
    if overlapping:
        judgements.append(_diffusion(dimension, x, float(mean[1]), float(error[1])))
    return worst(judgements, f"{each[:, 4].sum():.3g} collisions")


def _diffusion(dimension: int, x: float, diffusion: float, error: float) -> Judgement:
    dilute = reference.boltzmann_diffusion(x, 1.0, dimension)
    known = reference.DIFFUSION[dimension][x]
    ratio, ratio_error = diffusion / dilute, error / dilute
    return statistical(
        "D/D_Boltzmann",
        ratio,
        ratio_error,
        known.value,
        known.uncertainty,
        f"standard error over {ARRANGEMENTS} arrangements, and of the reference",
        samples=ARRANGEMENTS,
        needed=0.07,
        figures=(_diffusion_figure(dimension, x, ratio, ratio_error),),
    )


def _diffusion_figure(dimension: int, x: float, ratio: float, error: float) -> Figure:
    table = reference.DIFFUSION[dimension]
    curves = [
        Series(f"measured, x = {x:g}", [x], [ratio], [error]),
        Series(
            "reference", list(table), [one.value for one in table.values()], [one.uncertainty for one in table.values()]
        ),
    ]
    if dimension == 2:
        fine = np.linspace(0.001, 0.05, 50)
        series = [reference.diffusion_series(value) for value in fine]
        curves.append(Series("series to (x ln x)^2", fine.tolist(), series, theory=True))
    return Figure(f"diffusion among overlapping scatterers, {dimension} dimensions", "x = n R^d", "D/D_Boltzmann",
                  series=tuple(curves))  # fmt: skip


# -- a finite particle -------------------------------------------------------------------------------------------------

#: Number of starts, duration in mean free paths, diameter of the particle.
STARTS, STRIDES, SIZE = 20, 5.0, 0.8
#: Dense, and below the density where no further sphere finds a place at random.
FINITE = {2: 0.1, 3: 0.06}


def _judge_finite(laboratory: Laboratory, dimension: int) -> Judged:
    """A particle of radius a among scatterers of radius 1 - a goes the way of a point among those of radius 1."""
    x = FINITE[dimension]
    path = reference.free_path(x, 1.0, dimension)
    errors, tolerances, collisions = np.zeros(STARTS), np.zeros(STARTS), 0.0
    for number in range(STARTS):
        gas = arrangement(dimension, x, 100, 1, laboratory.seed(str(number)), False)
        runs = []
        for size, shift in ((0.0, 0.0), (SIZE, 0.0), (0.0, 1e-9)):
            turned = gas.velocities + shift * np.roll(gas.velocities, 1, axis=1) * np.where(np.arange(dimension), 1, -1)
            scene = _lorentz_gas(gas._replace(velocities=turned), dimension, STRIDES * path, STRIDES * path, size)
            runs.append(laboratory.run(scene, EVENT_DRIVEN))
        point, finite, disturbed = (run["final_positions"][-1] for run in runs)
        count = float(runs[0]["collisions"][-1])
        collisions += count
        growth = max(1.0, float(np.linalg.norm(disturbed - point)) / 1e-9)
        errors[number] = np.linalg.norm(finite - point)
        tolerances[number] = 4 * EPSILON * gas.length * growth * (1 + count)
    return round_off(
        "largest distance between the particle and the point, in its own rounding",
        float((errors / tolerances).max()),
        1.0,
        "four roundings of the box's length per collision, times the growth of a disturbance of 1e-9 in the same run",
        note=f"{STARTS} starts, {collisions:.0f} collisions, largest distance {errors.max():.1e}",
    )


# -- points among themselves -------------------------------------------------------------------------------------------

#: Number of pairs, distance of the two points at the start, spacing of the pairs.
HEAD_ON, APART, BESIDE = 64, 3.4, 10.0


def _judge_head_on(laboratory: Laboratory, dimension: int) -> Judged:
    """Pairs of points that fly straight at each other, in all directions: they must pass."""
    rng = np.random.default_rng(laboratory.seed())
    directions = rng.normal(size=(HEAD_ON, dimension))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    side = int(np.ceil((HEAD_ON + 1) ** (1 / dimension)))
    places = BESIDE * (np.stack(np.meshgrid(*[np.arange(side)] * dimension), -1).reshape(-1, dimension) + 0.5)
    signs = np.tile([-0.5, 0.5], HEAD_ON)[:, None]
    lines = np.repeat(directions, 2, axis=0)
    middles = np.repeat(places[1 : HEAD_ON + 1], 2, axis=0)
    speeds = np.tile([1.0, 0.5], HEAD_ON)[:, None]
    gas = Arrangement(places[:1], middles + APART * signs * lines, -2 * signs * speeds * lines, BESIDE * side)
    run = laboratory.run(_lorentz_gas(gas, dimension, APART, APART), EVENT_DRIVEN)
    return bounded(
        f"collisions of {HEAD_ON} pairs of points",
        float(run["collisions"][-1]),
        0.0,
        "particles of diameter 0 never hit each other",
    )


_POINT_GASES = {f"{d}d-overlapping-x{x:g}": _PointGas(d, True, x) for d in (2, 3) for x in reference.DIFFUSION[d]} | {
    "2d-separate-x0.1": _PointGas(2, False, 0.1),
    "3d-separate-x0.05": _PointGas(3, False, 0.05),
}
_NEEDS = event_driven(
    "hard_spheres.fixed hard_spheres.diameter[] box.boundaries=periodic", "positions velocities collisions"
)

CHECKS = (
    Check(
        name="events/lorentz-gas",
        title="Lorentz gas: points among fixed disks or spheres; speed, mean free path, diffusion",
        equation="l = V_free/(n sigma) (pi A/perimeter, 4 V/surface), D = d<r^2>/dt/(2 d), from 20 to 40 free paths",
        criterion="speed to 8 roundings a reflection; l and D within the standard error over the arrangements",
        citation="Bruin, Phys. Rev. Lett. 29, 1670 (1972); Machta & Zwanzig, Phys. Rev. Lett. 50, 1959 (1983)",
        judge=_judge_points,
        variants=variants_of(_POINT_GASES, "full"),
        needs=_NEEDS,
        faults=(
            (
                "3d-separate-x0.05",
                Fault(
                    "reduced-mass",
                    "events/rules.py",
                    "return 1.0 / (inverse_masses[i] + inverse_masses[j])",
                    "return 1.0000000001 / (inverse_masses[i] + inverse_masses[j])",
                    "reflections return 2e-10 too much momentum",
                ),
            ),
        ),
    ),
    Check(
        name="events/lorentz-finite-particle",
        title="Lorentz gas: one finite particle against a point among larger scatterers",
        equation="contact at R + a: the same path for (R, a) and (R + a, 0)",
        criterion="same place after 5 mean free paths, to rounding times the growth of a disturbance",
        citation="Machta & Zwanzig, Phys. Rev. Lett. 50, 1959 (1983)",
        judge=_judge_finite,
        variants=full(**{"2d": 2, "3d": 3}),
        needs=_NEEDS,
        faults=(
            (
                "2d",
                Fault(
                    "contact-of-the-larger",
                    "events/prediction.py",
                    "return radii[i] + radii[j]",
                    "return max(radii[i], radii[j]) + 0.999999999 * min(radii[i], radii[j])",
                    "the contact distance lacks 1e-9 of the smaller radius",
                ),
            ),
        ),
    ),
    Check(
        name="events/lorentz-points",
        title="Lorentz gas: points that fly straight at each other pass",
        equation="contact distance 0: no collision",
        criterion="no collisions",
        citation="Machta & Zwanzig, Phys. Rev. Lett. 50, 1959 (1983)",
        judge=_judge_head_on,
        variants=full(**{"2d": 2, "3d": 3}),
        needs=_NEEDS,
        faults=(
            (
                "2d",
                Fault(
                    "points-with-a-size",
                    "events/prediction.py",
                    "return radii[i] + radii[j]",
                    "return radii[i] + radii[j] + 1e-9",
                    "contact is 1e-9 too early",
                ),
            ),
        ),
    ),
)
