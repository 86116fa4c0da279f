"""Elastic hard disks and spheres in equilibrium: speeds, pressure, collision rates, diffusion, mixtures.

sigma = m = 1; T = 2K/f with f = d N between hard walls, d (N - 1) in a periodic box whose total momentum is zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Tier, fixed, legacy_check
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Histogram, Series
from crosscheck.references import EPSILON
from crosscheck.references import hard_spheres as reference
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Observable, Output, Scene, explicit
from crosscheck.statistics import Mean, correlated_mean, standard_error
from crosscheck.verdict import FALSE_ALARM, Judged, Judgement, bounded, round_off, statistical, worst

#: Of every scene here: what is asked for selects the compiled loop, and one is enough.
TALLIES: tuple[Observable, ...] = ("collisions", "collisional_virial", "wall_impulse", "wall_collisions")
#: Intervals of a run that are left out while it settles, and those whose averages are taken.
SETTLING, BLOCKS = 10, 50
#: The square lattice and its twin in space: as far from the fluid as from the crystal, and soon gone.
LATTICE = {2: "square", 3: "sc"}


def gas(
    dimension: int,
    number: int,
    density: float,
    seed: int,
    output: Output,
    duration: float,
    *,
    hard: bool = False,
    speed: float | None = None,
) -> Scene:
    """Disks or spheres of one size from a square (simple cubic) lattice: T = 1, or all of one speed."""
    return Scene(
        name=f"hard-gas-{dimension}d",
        dimension=dimension,  # type: ignore[arg-type]
        duration=duration,
        hard_spheres=HardSpheres(),
        box=Box(density=density, boundaries=("hard" if hard else "periodic",) * dimension),
        initial=Lattice(
            kind="lattice",
            structure=LATTICE[dimension],  # type: ignore[arg-type]
            number=number,
            temperature=1.0 if speed is None else None,
            speed=speed,
            seed=seed,
        ),
        output=output,
    )


def _duration(collisions: float, number: int, eta: float, dimension: int, temperature: float = 1.0) -> float:
    """Time in which N particles have so many pair collisions."""
    return 2 * collisions / (number * reference.collision_rate(eta, dimension, temperature).value)


def _in_blocks(duration: float, trajectory: bool = False) -> Output:
    return Output(interval=duration / (SETTLING + BLOCKS), observables=TALLIES, trajectory=trajectory)


def _rates(run: Run, tally: Floats) -> Floats:
    """Growth per time of a cumulative sum, in each interval after the run has settled."""
    return np.asarray((np.diff(tally) / np.diff(run["time"]))[SETTLING:])


# -- speeds --------------------------------------------------------------------------------------------


class Speeds(NamedTuple):
    """Runs of N particles of one speed, V0 = 1, dilute."""

    dimension: int
    number: int
    runs: int
    needed: float


SPEEDS = {"2d": Speeds(2, 1600, 24, 0.05), "2d-large": Speeds(2, 10000, 24, 0.02), "3d": Speeds(3, 4096, 24, 0.02)}
#: Pair collisions a particle: those of the exercise.
COUNTS = (0.5, 1.0, 2.0, 3.0, 10.0)
#: n sigma^d; the free path is 3.5 (3D: 5) lattice spacings.
DILUTE = 0.01
#: Departure of the moment ratio from Boltzmann's gas by pairs that meet again, over n: 0.010 at most at n = 0.1.
MEETING_AGAIN = 0.1


def _judge_speeds(laboratory: Laboratory, variant: str) -> Judged:
    d, number, runs, needed = SPEEDS[variant]
    output = Output(collisions=tuple(round(c * number) for c in COUNTS), observables=TALLIES, trajectory=True)
    speeds = np.empty((runs, len(COUNTS), number))
    for one in range(runs):
        scene = gas(d, number, DILUTE, laboratory.seed(str(one)), output, 1e9, hard=True, speed=1.0)
        run = laboratory.run(scene, EVENT_DRIVEN)
        speeds[one] = np.linalg.norm(run["velocities"][1:], axis=2)
    squares = speeds**2
    ratios = (squares**2).mean(axis=2) / squares.mean(axis=2) ** 2
    means, errors = ratios.mean(axis=0), standard_error(ratios)
    # what a finite number at constant energy lacks in equilibrium: as much at most before
    few = reference.moment_ratio(d) - reference.moment_ratio(d, d * number)
    judgements = []
    for index, count in enumerate(COUNTS):
        known = reference.mono_speed_moment_ratio(count, np.inf, d)
        judgements.append(
            statistical(
                f"<v^4>/<v^2>^2 after {count:g} N collisions",
                float(means[index]),
                float(errors[index]),
                known.value,
                float(np.sqrt(known.uncertainty**2 + few**2 + (MEETING_AGAIN * DILUTE) ** 2)),
                f"standard error over {runs} runs, that of the table, 1/N, and pairs that meet again",
                samples=runs,
                needed=needed,
            )
        )
    temperature = reference.mono_speed_temperature(1.0, d)
    distances = [_distance(speeds[:, index].ravel(), d, temperature) for index in range(len(COUNTS))]
    noise = _largest_distance(runs * number)
    why = f"quantile of Kolmogorov's distribution for {runs * number} speeds, false-alarm rate {FALSE_ALARM:g}"
    judgements.append(bounded("distance from Maxwell (Kolmogorov-Smirnov) after 10 N", distances[-1], noise, why))
    figures = _speed_figures(variant, speeds, means, errors)
    rise = float(np.diff(distances).max())
    judgements.append(bounded("largest rise of that distance", rise, noise, why, figures=figures))
    shown = ", ".join(f"{distance:.4f}" for distance in distances)
    return worst(judgements, f"distances from Maxwell {shown}; {runs} runs of {number}, n = {DILUTE}")


def _distance(speeds: Floats, dimension: int, temperature: float) -> float:
    """Kolmogorov and Smirnov's: the largest difference of the cumulative distributions."""
    expected = reference.maxwell_cumulative(np.sort(speeds), dimension, temperature)
    found = np.arange(speeds.size + 1) / speeds.size
    return float(max((found[1:] - expected).max(), (expected - found[:-1]).max()))


def _largest_distance(samples: int) -> float:
    """Exceeded by samples of the distribution itself with probability `FALSE_ALARM`."""
    from scipy.stats import kstwo

    return float(kstwo(samples).isf(FALSE_ALARM))


def _speed_figures(variant: str, speeds: Floats, means: Floats, errors: Floats) -> tuple[Figure, ...]:
    d = SPEEDS[variant].dimension
    edges = np.linspace(0, 2.5, 51)
    fine = np.linspace(0, 2.5, 126)
    bins = tuple(
        Histogram(
            f"{count:g} N collisions",
            edges.tolist(),
            np.round(np.histogram(speeds[:, index], edges)[0] / (speeds[:, index].size * 0.05), 5).tolist(),
        )
        for index, count in enumerate(COUNTS)
    )
    law = reference.maxwell_density(fine, d, reference.mono_speed_temperature(1.0, d))
    table = reference.MONO_SPEED[d]
    x = [row.collisions_per_particle for row in table]
    return (
        Figure(
            f"speeds, {variant}", "v/V0", "probability density", "linear", "linear",
            (*bins, Series("Maxwell", fine.tolist(), np.round(law, 5).tolist(), theory=True)),
        ),
        Figure(
            f"relaxation from one speed, {d}D", "collisions a particle", "<v^4>/<v^2>^2", "log", "linear",
            (
                Series(variant, list(COUNTS), means.tolist(), errors.tolist()),
                Series("Boltzmann", x, [row.moment_ratio for row in table], theory=True),
            ),
        ),
    )  # fmt: skip


# -- wall pressure -------------------------------------------------------------------------------------

#: Disks between hard walls. Beyond n = 0.127 (eta = 0.1) the reference's uncertainty, which grows as eta^2, covers it.
WALLED, WALLED_DENSITIES = 400, (0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
WALLED_COLLISIONS = {"n0.05": 4e5}
SPEED_DENSITY, V0 = 0.05, (1.0, 3.0, 10.0)
#: Of the positions of a twin, relative to the box: some 450 roundings of a coordinate.
DISTURBANCE = 1e-13
PRESSURE_FIGURE = ("wall pressure", "n sigma^2", "p/(n T)")


class Pressure(NamedTuple):
    """mean, over the blocks; residual: of the virial theorem, and its bound; impulse: per hit, over the blocks."""

    mean: Mean
    residual: float
    bound: float
    impulse: Mean


def _wall_pressure(scene: Scene, run: Run) -> Pressure:
    """Mean force per length on the four walls of a square box.

    With positions from the box's middle and centres that stop at (L - sigma)/2, the virial theorem is exact for any
    span of time: (L - sigma)/2 sum I = 2 K t + W - [sum m r.v], with the impulses I that the walls got, the collisional
    virial W and the change of the last term. That change is bounded, and most of the noise in the impulses: it is added
    to them here. Without collisions nothing but 2 K t is left.
    """
    lengths = scene.lengths()
    assert lengths is not None
    length = float(lengths[0])
    outwards = np.array([-1.0, 1.0, -1.0, 1.0])
    pushed = run["wall_impulse"][:, [0, 1, 2, 3], [0, 0, 1, 1]] @ outwards
    hits, virial = run["wall_collisions"].sum(axis=1), run["collisional_virial"]
    moment = ((run["positions"] - length / 2) * run["velocities"]).sum(axis=(1, 2))
    kinetic = 0.5 * float((run["velocities"][0] ** 2).sum())
    right = 2 * kinetic * run["time"] + virial - (moment - moment[0])
    residual = np.abs(0.5 * (length - 1) * pushed - right).max() / right[-1]
    complete = pushed + 2 * moment / (length - 1)
    per_hit = (np.diff(pushed) / np.diff(hits))[SETTLING:]
    return Pressure(
        correlated_mean(_rates(run, complete) / (4 * length)),
        float(residual),
        EPSILON * float(run["collisions"][-1] + hits[-1]),
        correlated_mean(per_hit),
    )


def _walled(density: float, speed: float, collisions: float, seed: int) -> Scene:
    """Disks of one speed in a square box with hard walls, T = V0^2/2."""
    temperature = reference.mono_speed_temperature(speed, 2)
    duration = _duration(collisions, WALLED, reference.packing_fraction(density, 2), 2, temperature)
    return gas(2, WALLED, density, seed, _in_blocks(duration, True), duration, hard=True, speed=speed)


def _judge_pressure(laboratory: Laboratory, variant: str) -> Judged:
    if variant == "speeds":
        return _judge_scaling(laboratory)
    density = float(variant.removeprefix("n"))
    scene = _walled(density, 1.0, WALLED_COLLISIONS.get(variant, 1.5e6), laboratory.seed())
    found = _wall_pressure(scene, laboratory.run(scene, EVENT_DRIVEN))
    temperature = reference.mono_speed_temperature(1.0, 2)
    ideal = density * temperature
    known = reference.disk_box_pressure(WALLED, (WALLED / density) ** 0.5, temperature)
    theorem = round_off(
        "residual of the virial theorem, relative",
        found.residual,
        found.bound,
        "one rounding of a running sum for every collision and every hit",
    )
    pressure = statistical(
        "p/(n T)",
        found.mean.value / ideal,
        found.mean.error / ideal,
        known.value / ideal,
        known.uncertainty / ideal,
        "standard error of correlated blocks; of the reference, which grows as eta^2",
        samples=found.mean.independent,
        needed=0.02,
        figures=(_pressure_figure(density, found.mean.value / ideal, found.mean.error / ideal),),
    )
    impulse = statistical(
        "impulse of a hit",
        found.impulse.value,
        found.impulse.error,
        (2 * np.pi * temperature) ** 0.5 / reference.finite_speed_factor(2 * WALLED),
        0.0,
        "standard error of correlated blocks; <v^2> of f = 2N components is exact, <|v|> nearly",
        samples=found.impulse.independent,
        needed=0.03,
    )
    return worst([theorem, pressure, impulse], f"N = {WALLED}; the ideal gas of points has p/(n T) = 1")


def _pressure_figure(density: float, value: float, error: float) -> Figure:
    x = np.geomspace(0.004, 0.2, 40)
    law = [reference.disk_box_pressure(WALLED, (WALLED / n) ** 0.5).value / n for n in x]
    bulk = [reference.disk_compressibility(reference.packing_fraction(n, 2)).value for n in x]
    return Figure(
        *PRESSURE_FIGURE, "log", "linear",
        (
            Series("measured", [density], [value], [error]),
            Series(f"box with {WALLED} disks", x.tolist(), law, theory=True),
            Series("Z of the bulk", x.tolist(), bulk, theory=True),
            Series("ideal gas", x.tolist(), [1.0] * x.size, theory=True),
        ),
    )  # fmt: skip


def _judge_scaling(laboratory: Laboratory) -> Judged:
    """V0 sets the unit of time alone: the same trajectory until chaos, p ~ V0^2 afterwards."""
    seed = laboratory.seed()
    pressures = []
    for speed in V0:
        scene = _walled(SPEED_DENSITY, speed, 2e5, seed)
        pressures.append(_wall_pressure(scene, laboratory.run(scene, EVENT_DRIVEN)).mean)
    p, u = np.array([m.value for m in pressures]), np.array([m.error / m.value for m in pressures])
    weights = np.log(V0) - np.mean(np.log(V0))
    weights /= (weights**2).sum()
    exponent = statistical(
        "exponent of V0 in the pressure",
        float(weights @ np.log(p)),
        float(np.sqrt(weights**2 @ u**2)),
        2.0,
        0.0,
        "standard errors of correlated blocks",
        samples=min(m.independent for m in pressures),
        needed=0.01,
        figures=(_scaling_figure(p, u),),
    )
    return worst([_same_events(laboratory, seed), exponent], f"V0 = {V0}, N = {WALLED}, n = {SPEED_DENSITY}")


def _same_events(laboratory: Laboratory, seed: int) -> Judgement:
    """Positions after the same number of collisions, N/4: no further apart than those of a twin disturbed a little."""
    output = Output(collisions=(WALLED // 16, WALLED // 8, WALLED // 4), observables=TALLIES, trajectory=True)
    scenes = [gas(2, WALLED, SPEED_DENSITY, seed, output, 1e9, hard=True, speed=speed) for speed in V0]
    state, lengths = scenes[0].initial_state(), scenes[0].lengths()
    assert lengths is not None
    shake = np.random.default_rng(laboratory.seed("disturbance")).normal(size=state.positions.shape)
    disturbed = state.positions + DISTURBANCE * lengths * shake
    twin = scenes[0].changed(initial=explicit(disturbed, state.velocities))
    runs = [laboratory.run(scene, EVENT_DRIVEN) for scene in (*scenes, twin)]
    apart = [_separation(runs[0], run) for run in runs[1:]]
    return bounded(
        "largest separation from V0 = 1 after N/4 collisions",
        max(apart[:-1]),
        apart[-1],
        f"that of a twin disturbed by {DISTURBANCE:g} L, some 450 roundings of a coordinate",
        note="V0 scales velocities and times, and nothing else",
    )


def _separation(one: Run, two: Run) -> float:
    """Largest rms distance of the same particle in two runs."""
    return float(np.sqrt(((one["positions"] - two["positions"]) ** 2).mean(axis=(1, 2))).max())


def _scaling_figure(p: Floats, u: Floats) -> Figure:
    known = reference.disk_box_pressure(WALLED, (WALLED / SPEED_DENSITY) ** 0.5).value
    law = [known * reference.mono_speed_temperature(speed, 2) for speed in V0]
    return Figure(
        f"wall pressure against V0, n = {SPEED_DENSITY}", "V0", "p", "log", "log",
        (Series("measured", list(V0), p.tolist(), (p * u).tolist()), Series("V0^2", list(V0), law, theory=True)),
    )  # fmt: skip


# -- equation of state and collision rate --------------------------------------------------------------

POINTS = {
    **{f"disks-eta{eta:g}": (2, eta) for eta in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65)},
    **{f"spheres-n{n:g}": (3, reference.packing_fraction(n, 3)) for n in (0.1, 0.3, 0.5, 0.7, 0.9)},
}
PERIODIC = {2: 1024, 3: 1000}
STATE_COLLISIONS, RATE_COLLISIONS = 4e6, 2e6
QUICK_POINT, QUICK_COLLISIONS = "spheres-n0.4", 4e5


def _periodic(laboratory: Laboratory, dimension: int, eta: float, number: int, collisions: float) -> Run:
    duration = _duration(collisions, number, eta, dimension)
    density = reference.number_density(eta, dimension)
    scene = gas(dimension, number, density, laboratory.seed(), _in_blocks(duration), duration)
    return laboratory.run(scene, EVENT_DRIVEN)


def _judge_state(laboratory: Laboratory, variant: str) -> Judged:
    """Z from impulses; and from the number of collisions, which differ by the mean impulse of a collision."""
    if variant == QUICK_POINT:
        (d, eta), collisions, needed = (3, reference.packing_fraction(0.4, 3)), QUICK_COLLISIONS, 0.012
    else:
        (d, eta), collisions, needed = POINTS[variant], STATE_COLLISIONS, 0.02 if "0.65" in variant else 0.005
    number = PERIODIC[d]
    run = _periodic(laboratory, d, eta, number, collisions)
    virial = _rates(run, run["collisional_virial"]) / (d * number)
    rate = 2 * _rates(run, run["collisions"]) / number
    slowness = reference.finite_speed_factor(reference.degrees_of_freedom(number, d, True))
    counted = rate * np.pi**0.5 / (2 * d * slowness)
    excess, difference = correlated_mean(virial), correlated_mean(virial - counted)
    known = reference.finite_compressibility(eta, number, d)
    z = statistical(
        "Z from the collisional virial",
        1 + excess.value,
        excess.error,
        known.value,
        known.uncertainty,
        "standard error of correlated blocks; of the reference for this N",
        samples=excess.independent,
        needed=needed,
        figures=(_state_figure(d, eta, 1 + excess.value, excess.error),),
    )
    routes = statistical(
        "(Z - 1) from impulses over that from the collision rate",
        1 + difference.value / counted.mean(),
        difference.error / float(counted.mean()),
        1.0,
        0.0,
        "standard error of the correlated blocks' differences; exact in equilibrium at constant energy",
        samples=difference.independent,
        needed=0.01,
    )
    return worst([z, routes], f"N = {number}, {run['collisions'][-1]:.3g} collisions, infinite N: "
                 f"{reference.compressibility(eta, d).value:.5g}")  # fmt: skip


def _state_figure(dimension: int, eta: float, z: float, error: float) -> Figure:
    x = np.linspace(0.01, 0.65 if dimension == 2 else reference.packing_fraction(0.9, 3), 50)
    known = [reference.compressibility(e, dimension).value for e in x]
    older = [reference.henderson(e) if dimension == 2 else reference.carnahan_starling(e) for e in x]
    name = "disks" if dimension == 2 else "spheres"
    return Figure(
        f"equation of state, {name}", "eta", "Z = p/(n T)", "linear", "linear",
        (
            Series("measured", [eta], [z], [error]),
            Series("best known", x.tolist(), known, theory=True),
            Series("Henderson" if dimension == 2 else "Carnahan-Starling", x.tolist(), older, theory=True),
        ),
    )  # fmt: skip


class Gas(NamedTuple):
    dimension: int
    eta: float
    number: int


#: Other states than those of the equation of state; the small ones test the dependence on N.
RATES = {
    **{f"disks-eta{eta:g}": Gas(2, eta, 1024) for eta in (0.02, 0.15, 0.35, 0.55)},
    "disks-eta0.3-N16": Gas(2, 0.3, 16),
    **{f"spheres-n{n:g}": Gas(3, reference.packing_fraction(n, 3), 1000) for n in (0.2, 0.4, 0.6, 0.8)},
    "spheres-n0.4-N64": Gas(3, reference.packing_fraction(0.4, 3), 64),
}


def _judge_rate(laboratory: Laboratory, variant: str) -> Judged:
    d, eta, number = RATES[variant]
    run = _periodic(laboratory, d, eta, number, RATE_COLLISIONS)
    rate = correlated_mean(2 * _rates(run, run["collisions"]) / number)
    known, infinite = reference.finite_collision_rate(eta, number, d), reference.collision_rate(eta, d)
    path = reference.maxwell_mean_speed(d) / rate.value
    dilute = infinite.value / reference.contact_value(eta, d).value
    x = np.linspace(0.005, 0.65 if d == 2 else reference.packing_fraction(0.9, 3), 50)
    law = [reference.contact_value(e, d).value for e in x]
    figure = Figure(
        "collision rate, " + ("disks" if d == 2 else "spheres"), "eta", "rate over that of Boltzmann's gas", "linear",
        "log", (
            Series(f"N = {number}", [eta], [rate.value / dilute], [rate.error / dilute]),
            Series("Enskog, g at contact", x.tolist(), law, theory=True),
        ),
    )  # fmt: skip
    return statistical(
        "collisions of a particle per time",
        rate.value,
        rate.error,
        known.value,
        known.uncertainty,
        "standard error of correlated blocks; of the reference for this N",
        samples=rate.independent,
        needed=0.01 if number > 16 else 0.03,  # to order 1/N alone, which is rough for 16
        note=f"N = {number}, mean free path {path:.4g}; infinite N: {infinite.value:.5g}",
        figures=(figure,),
    )


# -- self-diffusion ------------------------------------------------------------------------------------

#: Spheres; samples to the start of the window, which ends at twice that time; the longest time shown; origins.
DIFFUSING, WINDOW, SHOWN, ORIGINS = 1728, 10, 40, 360


def _window_start(density: float, number: int) -> float:
    """Five decay times of the slowest: the velocity, D/T, or the longest shear wave of the box, L^2/(4 pi^2 nu).

    After that the box has no long-time tail left, and the mean-square displacement is straight to exp(-5).
    """
    eta = reference.packing_fraction(density, 3)
    shear = (number / density) ** (2 / 3) / (4 * np.pi**2 * reference.enskog_viscosity(eta) / density)
    return float(5 * max(reference.enskog_diffusion(eta, 3).value, shear))


def _squares(positions: Floats, lag: int, origins: int) -> Floats:
    """Mean-square displacement of all particles over `lag` samples, for each origin."""
    return np.asarray(((positions[lag : lag + origins] - positions[:origins]) ** 2).sum(axis=2).mean(axis=1))


def _judge_diffusion(laboratory: Laboratory, variant: str) -> Judged:
    density = float(variant.removeprefix("n"))
    step = _window_start(density, DIFFUSING) / WINDOW
    samples = ORIGINS + 2 * SHOWN
    output = Output(interval=step, observables=TALLIES, trajectory=True)
    run = laboratory.run(gas(3, DIFFUSING, density, laboratory.seed(), output, samples * step), EVENT_DRIVEN)
    positions = run["positions"][SHOWN:]  # settled
    slope = (_squares(positions, 2 * WINDOW, ORIGINS) - _squares(positions, WINDOW, ORIGINS)) / (6 * WINDOW * step)
    mean = correlated_mean(slope)
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
        f"standard error of {ORIGINS} correlated origins; of the reference for this N",
        samples=mean.independent,
        needed=0.05,
        note=f"N = {DIFFUSING}, window from t1 = {WINDOW * step:.4g} to 2 t1; infinite N: {infinite.value:.5g}",
        figures=(figure,),
    )


# -- mixtures ------------------------------------------------------------------------------------------

#: Diameters and masses of the small and of the large.
SIZES, WEIGHTS = (1.0, 2.0), (1.0, 5.0)
MIXTURES = {
    **{f"disks-eta{eta:g}": (2, eta) for eta in (0.2, 0.4, 0.5)},
    **{f"spheres-eta{eta:g}": (3, eta) for eta in (0.2, 0.35, 0.45)},
}
#: Unit cells of a compound: the large one on the corner, the small ones in the middle (and on the faces).
_SMALL_SITES = {2: [[0.5, 0.5]], 3: [[0.5, 0.5, 0.5], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]]}
MIXTURE_CELLS = {2: 24, 3: 6}
MIXTURE_COLLISIONS, MIXTURE_SAMPLES = 3e6, 240


def _mixture_scene(dimension: int, eta: float, seed: int) -> tuple[Scene, reference.Mixture]:
    """Small and large ones on the sites of a compound, all energy with the small: T = 2K/(d (N - 1)) = 1."""
    basis = np.array([[0.0] * dimension, *_SMALL_SITES[dimension]])
    grid = np.stack(np.meshgrid(*[np.arange(MIXTURE_CELLS[dimension])] * dimension, indexing="ij"), axis=-1)
    sites = (grid.reshape(-1, 1, dimension) + basis + 0.25).reshape(-1, dimension)
    species = np.tile([1] + [0] * (len(basis) - 1), len(sites) // len(basis))
    diameters, masses = np.array(SIZES)[species], np.array(WEIGHTS)[species]
    volume = float(np.pi / (2 * dimension) * (diameters**dimension).sum()) / eta
    length = volume ** (1 / dimension)
    numbers = np.bincount(species)
    velocities = np.random.default_rng(seed).normal(size=sites.shape) * (species == 0)[:, None]
    velocities[species == 0] -= velocities.sum(axis=0) / numbers[0]
    twice = float((masses[:, None] * velocities**2).sum())
    velocities *= (dimension * (len(sites) - 1) / twice) ** 0.5
    known = reference.mixture(numbers / volume, SIZES, WEIGHTS)
    rate = float(numbers @ reference.species_collision_rates(known, dimension).sum(axis=1)) / 2
    duration = MIXTURE_COLLISIONS / rate
    scene = Scene(
        name=f"hard-mixture-{dimension}d",
        dimension=dimension,  # type: ignore[arg-type]
        duration=duration,
        masses=tuple(masses.tolist()),
        species=tuple(species.tolist()),
        hard_spheres=HardSpheres(diameter=SIZES),
        box=Box(lengths=(length,) * dimension),
        initial=explicit(sites * length / MIXTURE_CELLS[dimension], velocities),
        output=Output(interval=duration / MIXTURE_SAMPLES, observables=TALLIES, trajectory=True),
    )
    return scene, known


def _judge_mixture(laboratory: Laboratory, variant: str) -> Judged:
    d, eta = MIXTURES[variant]
    scene, known = _mixture_scene(d, eta, laboratory.seed())
    run = laboratory.run(scene, EVENT_DRIVEN)
    number, species, masses = scene.number, np.array(scene.species), np.array(scene.masses)
    excess = correlated_mean(_rates(run, run["collisional_virial"]) / (d * number))
    rate = correlated_mean(2 * _rates(run, run["collisions"]) / number)
    # of particles of one kind as dense: for want of a theory for mixtures, the whole of it is in doubt
    infinite = reference.compressibility(eta, d).value
    few = reference.finite_compressibility(eta, number, d).value - infinite
    z = reference.mixture_compressibility(known, d)
    pressure = statistical(
        "Z from the collisional virial",
        1 + excess.value,
        excess.error,
        z.value + few,
        float(np.hypot(z.uncertainty, few)),
        "standard error of correlated blocks; 1 % of the departure from one species; the correction for finite N",
        samples=excess.independent,
        needed=0.02,
        figures=(_mixture_figure(d, eta, 1 + excess.value, excess.error),),
    )
    shares = known.densities / known.densities.sum()
    expected = float(shares @ reference.species_collision_rates(known, d).sum(axis=1))
    collisions = statistical(
        "collisions of a particle per time",
        rate.value,
        rate.error,
        expected * (1 + few / (infinite - 1)),
        0.01 * expected,
        "standard error of correlated blocks; 1 % of the contact values",
        samples=rate.independent,
        needed=0.06,
    )
    # at total momentum zero a particle of mass m has m<v^2> = d T (1 - m/M)
    kinetic = masses * (run["velocities"][SETTLING:] ** 2).sum(axis=2) / (d * (1 - masses / masses.sum()))
    small, large = (kinetic[:, species == kind].mean(axis=1) for kind in (0, 1))
    gap = correlated_mean(small - large)
    equipartition = statistical(
        "temperature of the small less that of the large, over T",
        gap.value,
        gap.error,
        0.0,
        0.0,
        f"standard error of {kinetic.shape[0]} samples",
        samples=gap.independent,
        needed=0.05,
    )
    return worst([pressure, collisions, equipartition], f"N = {number}, diameters {SIZES}, masses {WEIGHTS}")


def _mixture_figure(dimension: int, eta: float, z: float, error: float) -> Figure:
    x = np.linspace(0.02, 0.52 if dimension == 2 else reference.packing_fraction(0.89, 3), 40)
    large = 1 / (1 + len(_SMALL_SITES[dimension]))

    def law(e: float) -> float:
        mean = (1 - large) * SIZES[0] ** dimension + large * SIZES[1] ** dimension
        density = reference.number_density(e, dimension) / mean
        species = reference.mixture([density * (1 - large), density * large], SIZES)
        return reference.mixture_compressibility(species, dimension).value

    name = "disks" if dimension == 2 else "spheres"
    pure = [reference.compressibility(e, dimension).value for e in x]
    return Figure(
        f"equation of state of a mixture of {name}", "eta", "Z = p/(n T)", "linear", "linear",
        (
            Series("measured", [eta], [z], [error]),
            Series("mixture", x.tolist(), [law(e) for e in x], theory=True),
            Series("one species", x.tolist(), pure, theory=True),
        ),
    )  # fmt: skip


# -- the checks ----------------------------------------------------------------------------------------

_ELASTIC = Fault(
    "slightly-inelastic",
    "events/rules.py",
    "    if restitution is None:\n        return 1.0",
    "    if restitution is None:\n        return 0.99",
    "elastic collisions lose 1 % of the normal velocity",
)


def _speeds_check(name: str, title: str, variants: tuple[str, ...], tier: Tier) -> Check:
    return legacy_check(
        name=name,
        title=title,
        equation="f(v) = 2 v^(d-1) exp(-v^2/w^2)/(Gamma(d/2) w^d), w^2 = 2 V0^2/d; <v^4>/<v^2>^2 from 1 to 1 + 2/d",
        criterion="<v^4>/<v^2>^2 at N/2, N, 2N, 3N, 10N collisions within the errors over runs of Boltzmann's; "
        "Kolmogorov-Smirnov distance falls, to that of a sample of Maxwell",
        citation="Chapman & Cowling, The Mathematical Theory of Non-uniform Gases (1970), chapters 4, 5; relaxation: "
        "own direct simulation of the Boltzmann equation (Bird 1994)",
        judge=_judge_speeds,
        variants=fixed(*variants),
        faults=((variants[0], _ELASTIC),),
        tier=tier,
    )


def _pressure_check(
    name: str, title: str, variants: tuple[str, ...], tier: Tier, faults: tuple[tuple[str, Fault], ...]
) -> Check:
    return legacy_check(
        name=name,
        title=title,
        equation="p = sum I/(4 L t); (L - sigma)/2 sum I = 2 K t + W - [sum m r.v]; p -> n T as n -> 0; p ~ V0^2",
        criterion="virial theorem to one rounding an event; pressure within the errors of correlated blocks and of the "
        "theory of the box; impulse of a hit sqrt(2 pi m T)",
        citation="Lebowitz & Percus, Phys. Rev. 122, 1675 (1961); Clisby & McCoy, J. Stat. Phys. 122, 15 (2006); "
        "Hansen & McDonald, Theory of Simple Liquids, section 2.2",
        judge=_judge_pressure,
        variants=fixed(*variants),
        faults=faults,
        tier=tier,
    )


def _state_check(name: str, title: str, variants: tuple[str, ...], tier: Tier, faulty: tuple[str, Fault]) -> Check:
    return legacy_check(
        name=name,
        title=title,
        equation="Z = 1 + sum r_ij.dp_ij/(d N T t) = 1 + omega sigma sqrt(pi m/T)/(2 d), omega a particle's collisions",
        criterion="both within the errors of correlated blocks and of the reference, corrected for finite N",
        citation="Luding, Phys. Rev. E 63, 042201 (2001); Clisby & McCoy, J. Stat. Phys. 122, 15 (2006); NIST Standard "
        "Reference Simulation Website",
        judge=_judge_state,
        variants=fixed(*variants),
        faults=(faulty,),
        tier=tier,
    )


def _virial_fault(percent: float) -> Fault:
    return Fault(
        f"virial-{percent:g}-percent",
        "events/kernels/measure.py",
        "sums[VIRIAL] += distance * (px * x + py * y + pz * z)",
        f"sums[VIRIAL] += {1 + percent / 100} * distance * (px * x + py * y + pz * z)",
        f"the collisional virial is {percent:g} % too large",
    )


def _impulse_fault(axis: int) -> Fault:
    name = "xyz"[axis]
    old = f"walls[face, {axis}] -= p{name}"
    return Fault(
        f"impulse-{name}-0.1-percent",
        "events/kernels/measure.py",
        old,
        old.replace("-= ", "-= 1.001 * "),
        f"impulses on walls along {name} are 0.1 % too large",
    )


CHECKS = (
    _speeds_check("events/maxwell", "Disks of one speed in a box relax to Maxwell's distribution", ("2d",), "quick"),
    _speeds_check(
        "events/maxwell-full",
        "Disks and spheres of one speed in a box relax to Maxwell's distribution: larger systems",
        ("2d-large", "3d"),
        "full",
    ),
    _pressure_check(
        "events/ideal-gas",
        "Pressure of disks on hard walls at one density, and its growth with the square of the speed",
        ("n0.05", "speeds"),
        "quick",
        (
            ("n0.05", _impulse_fault(0)),
            (
                "speeds",
                Fault(
                    "coarse-clock",
                    "events/kernels/loop.py",
                    "now = max(now, due)",
                    "now = max(now, np.ceil(due * 1e9) * 1e-9)",
                    "events fall on a clock that ticks every 1e-9, whatever the speed",
                ),
            ),
        ),
    ),
    _pressure_check(
        "events/ideal-gas-full",
        "Pressure of disks on hard walls against density",
        tuple(f"n{n:g}" for n in WALLED_DENSITIES if f"n{n:g}" not in WALLED_COLLISIONS),
        "full",
        (("n0.02", _impulse_fault(1)),),
    ),
    _state_check(
        "events/equation-of-state",
        "Pressure of periodic spheres at one density, from impulses and from the number of collisions",
        (QUICK_POINT,),
        "quick",
        (QUICK_POINT, _virial_fault(3)),
    ),
    _state_check(
        "events/equation-of-state-full",
        "Equation of state of disks and spheres, from impulses and from the number of collisions",
        tuple(POINTS),
        "full",
        ("disks-eta0.5", _virial_fault(0.7)),
    ),
    legacy_check(
        name="events/collision-rate",
        title="Collision rate of a particle among periodic disks and spheres against Enskog's, many and few particles",
        equation="omega = 2 n sigma g sqrt(pi T/m) (2D), 4 n sigma^2 g sqrt(pi T/m) (3D), times the corrections for N",
        criterion="within the errors of correlated blocks and of the reference, corrected for finite N",
        citation="Chapman & Cowling (1970), chapter 16; Lebowitz & Percus, Phys. Rev. 122, 1675 (1961)",
        judge=_judge_rate,
        variants=fixed(*RATES),
        faults=(
            (
                "disks-eta0.35",
                Fault(
                    "disks-1-percent",
                    "events/prediction.py",
                    "        return diameter\n    return radii[i] + radii[j]",
                    "        return 1.01 * diameter\n    return radii[i] + radii[j]",
                    "particles of one size collide at a distance 1 % too large",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/self-diffusion",
        title="Self-diffusion of dense spheres from the mean-square displacement",
        equation="D = d<|r(t) - r(0)|^2>/dt/6; D_N = D - 2.837297 T/(6 pi viscosity L)",
        criterion="within the errors of correlated origins and of the reference, corrected for finite N",
        citation="NIST Standard Reference Simulation Website; Yeh & Hummer, J. Phys. Chem. B 108, 15873 (2004)",
        judge=_judge_diffusion,
        variants=fixed("n0.1", "n0.3", "n0.5", "n0.7"),
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
        tier="full",
    ),
    legacy_check(
        name="events/mixture",
        title="Binary mixtures of disks and spheres: pressure, collision rate, equal temperatures",
        equation="Z = 1 + sum r_ij.dp_ij/(d N T t); T_small = T_large; omega = sum x_i n_j g_ij ... sqrt(T/mu_ij)",
        criterion="within the errors of correlated blocks and of BMCSL (2D: Santos, Yuste, Lopez de Haro), 1 % of the "
        "departure from one species",
        citation="Boublik, J. Chem. Phys. 53, 471 (1970); Mansoori et al., J. Chem. Phys. 54, 1523 (1971); Santos, "
        "Yuste & Lopez de Haro, Mol. Phys. 96, 1 (1999); Jenkins & Mancini, J. Appl. Mech. 54, 27 (1987)",
        judge=_judge_mixture,
        variants=fixed(*MIXTURES),
        faults=(
            (
                "spheres-eta0.35",
                Fault(
                    "mixture-contact-1-percent",
                    "events/prediction.py",
                    "    return radii[i] + radii[j]",
                    "    return 0.99 * (radii[i] + radii[j])",
                    "particles of several sizes collide at a distance 1 % too small",
                ),
            ),
        ),
        tier="full",
    ),
)
