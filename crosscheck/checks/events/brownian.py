"""Brownian motion: heavy large particles in a bath of small ones; velocity autocorrelation, friction, speeds.

Units: diameter and mass of the bath's particles and the temperature are 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Histogram, Series
from crosscheck.references import speeds, transport
from crosscheck.references.brownian import Tracers, returned_share, tracers_in_bath
from crosscheck.references.hard_spheres import collision_rate, degrees_of_freedom, packing_fraction
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import independent_mean, standard_error
from crosscheck.verdict import Judged, Judgement, statistical, worst

#: Mass and diameter of the tracers; the small particles have 1 and 1.
MASS, SIZE = 50.0, 3.0


class Bath(NamedTuple):
    """A bath of small particles with some large ones, the tracers, in `dimension` dimensions; small diameter, mass 1.

    sites: of the lattice, one particle each. tracers: number of large particles. density: number of particles a unit of
    volume. duration: of a run (time). early: time at which the initial decay is measured: several collisions of the
    tracer, and too short for the momentum it gave to the bath to act on it again.
    """

    dimension: int
    sites: int
    tracers: int
    density: float
    duration: float
    early: float


BATHS = {"2d": Bath(2, 900, 6, 0.05, 1000.0, 1.0), "3d": Bath(3, 1331, 8, 0.02, 600.0, 1.0)}
#: Runs of a bath: the independent samples.
RUNS = 16


def brownian(bath: Bath, seed: int, interval: float) -> Scene:
    """A lattice wide enough for the large particles, which are spread evenly over its sites.

    bath: what is run. seed: of the velocities. interval: between samples (time).
    """
    dimension = bath.dimension
    species = np.zeros(bath.sites, dtype=int)
    species[(np.arange(bath.tracers) * bath.sites) // bath.tracers + bath.sites // (2 * bath.tracers)] = 1
    return Scene(
        name=f"brownian-{dimension}d",
        dimension=dimension,  # type: ignore[arg-type]
        duration=bath.duration,
        masses=tuple(np.where(species == 1, MASS, 1.0).tolist()),
        species=tuple(species.tolist()),
        hard_spheres=HardSpheres(diameter=(1.0, SIZE)),
        box=Box(density=bath.density * bath.sites / (bath.sites - bath.tracers)),
        initial=Lattice(
            kind="lattice",
            structure="square" if dimension == 2 else "sc",
            number=bath.sites,
            temperature=1.0,
            seed=seed,
        ),
        output=Output(interval=interval, trajectory=True, observables=("collisions",)),
    )


class _Decay(NamedTuple):
    """Lags; (runs, lags): C, and half the mean square of v_x(t) - v_x(0), that is C(0) - C(t) with less noise.

    squares: (runs, 2) means of v^2 and v^4. speeds: of all tracers at all samples.
    """

    time: Floats
    correlation: Floats
    loss: Floats
    squares: Floats
    speeds: Floats


def _theory(bath: Bath) -> Tracers:
    """Enskog's theory of the tracers in this bath."""
    return tracers_in_bath(bath.density, bath.sites - bath.tracers, bath.tracers, SIZE, MASS, bath.dimension)


def _decays(laboratory: Laboratory, bath: Bath, longest: float) -> _Decay:
    lags = np.arange(round(longest / bath.early) + 1)
    correlation, loss = np.empty((2, RUNS, lags.size))
    squares, lengths = np.empty((RUNS, 2)), []
    for number in range(RUNS):
        scene = brownian(bath, laboratory.seed(str(number)), bath.early)
        v = _tracers(scene, laboratory.run(scene, EVENT_DRIVEN))
        for lag in lags:
            start, end = v[: len(v) - lag], v[lag:]
            correlation[number, lag] = (start * end).mean()
            loss[number, lag] = 0.5 * ((end - start) ** 2).mean()
        square = (v**2).sum(axis=-1)
        squares[number] = square.mean(), (square**2).mean()
        lengths.append(np.sqrt(square).ravel())
    return _Decay(lags * bath.early, correlation, loss, squares, np.concatenate(lengths))


def _tracers(scene: Scene, run: Run) -> Floats:
    """Velocities of the large particles, (samples, tracers, d); the first tenth, near the lattice, is left out."""
    large = np.array(scene.species) == 1
    return np.asarray(run["velocities"][len(run["time"]) // 10 :, large])


def _judge(laboratory: Laboratory, bath: Bath) -> Judged:
    """Initial decay and equipartition, in space also the decay after 1/gamma; the runs are the independent samples."""
    known = _theory(bath)
    decay = _decays(laboratory, bath, 2 / known.gamma)
    model = known.autocorrelation(decay.time)
    why = f"standard error over {RUNS} runs"

    first = np.flatnonzero(decay.time >= bath.early)[0]
    initial, error = independent_mean(decay.loss[:, first] / (known.variance - model[first]))
    among = collision_rate(packing_fraction(bath.density, bath.dimension), bath.dimension).value
    back = returned_share(among, bath.early)
    judgements = [
        statistical(
            "friction from the initial decay, times M",
            initial * known.gamma * MASS,
            error * known.gamma * MASS,
            known.gamma * MASS,
            0.0,
            f"{why}; off by g at contact, and particles that come back",
            samples=RUNS,
            doubt=(known.doubt + back) * known.gamma * MASS,
            needed=0.2,
            figures=(_decay_figure(bath.dimension, decay, known),),
        )
    ]
    if bath.dimension == 3:
        judgements.append(_decay_in_space(decay, known, bath, why))
    judgements += _equipartition(bath, decay, known, why)
    return worst(judgements, f"{RUNS} runs of {bath.tracers} tracers, {bath.duration * known.gamma:.1f}/gamma each")


def _decay_in_space(decay: _Decay, known: Tracers, bath: Bath, why: str) -> Judgement:
    """1 - C/C(0) after 1/gamma: between Enskog's friction, and that of a bath which flows along."""
    viscosity = transport.enskog_viscosity(packing_fraction(bath.density, 3))
    slip = transport.slip_friction(viscosity, (1 + SIZE) / 2)
    slower = known._replace(gamma=transport.friction_in_series(known.gamma, MASS, slip))
    place = int(np.searchsorted(decay.time, 1 / known.gamma))
    measured, error = independent_mean(decay.loss[:, place] / known.variance)
    ends = [float(1 - one.autocorrelation(decay.time[place]) / one.variance) for one in (known, slower)]
    return statistical(
        "1 - C/C(0) after 1/gamma",
        measured,
        error,
        sum(ends) / 2,
        0.0,
        f"{why}; between Enskog's friction and that in series with slip",
        samples=RUNS,
        doubt=abs(ends[0] - ends[1]) / 2,
        needed=0.3,
        note=f"t = {decay.time[place]:g}",
    )


def _equipartition(bath: Bath, decay: _Decay, known: Tracers, why: str) -> list[Judgement]:
    dimension = bath.dimension
    square, square_error = independent_mean(decay.squares[:, 0])
    # <v^4>/<v^2>^2 of all runs together; its error by leaving out one run at a time
    total = decay.squares.sum(axis=0)
    ratio = float(RUNS * total[1] / total[0] ** 2)
    left = total - decay.squares
    without = (RUNS - 1) * left[:, 1] / left[:, 0] ** 2
    ratio_error = float(np.sqrt((RUNS - 1) / RUNS * ((without - without.mean()) ** 2).sum()))
    freedoms = degrees_of_freedom(bath.sites, dimension, True)
    return [
        statistical(
            "mean square speed of the tracers, times M/d",
            square * MASS / dimension,
            square_error * MASS / dimension,
            known.variance * MASS,
            0.0,
            why,
            samples=RUNS,
            needed=0.3,
            figures=(_speed_figure(dimension, decay, known),),
        ),
        statistical(
            "<v^4>/<v^2>^2 of the tracers",
            ratio,
            ratio_error,
            speeds.moment_ratio(dimension, freedoms),
            0.0,
            f"standard error by leaving out one of {RUNS} runs at a time",
            samples=RUNS,
            needed=0.3,
        ),
    ]


def _decay_figure(dimension: int, decay: _Decay, known: Tracers) -> Figure:
    shown = slice(None, None, max(1, decay.time.size // 40))
    time = decay.time[shown]
    # C(0) is known: the measured loss has less noise than C
    c = 1 - decay.loss[:, shown].mean(axis=0) / known.variance
    error = standard_error(decay.loss[:, shown]) / known.variance
    return Figure(
        f"velocity autocorrelation of the heavy particle, {dimension} dimensions", "gamma t", "C(t)/C(0)",
        series=(
            Series("measured", (known.gamma * time).tolist(), c.tolist(), error.tolist()),
            Series("Enskog, finite bath", (known.gamma * time).tolist(),
                   (known.autocorrelation(time) / known.variance).tolist(), theory=True),
            Series("exp(-gamma t)", (known.gamma * time).tolist(), np.exp(-known.gamma * time).tolist(), theory=True),
        ),
    )  # fmt: skip


def _speed_figure(dimension: int, decay: _Decay, known: Tracers) -> Figure:
    temperature = known.variance * MASS
    edges = np.linspace(0, 4 * np.sqrt(known.variance), 33)
    heights, _ = np.histogram(decay.speeds, edges, density=True)
    fine = np.linspace(0, edges[-1], 100)
    theory_curve = speeds.maxwell_density(fine, dimension, temperature, MASS)
    return Figure(
        f"speeds of the heavy particle, {dimension} dimensions", "v", "probability density",
        series=(
            Histogram("measured", edges.tolist(), heights.tolist()),
            Series("Maxwell, T/M (1 - M/total mass)", fine.tolist(), theory_curve.tolist(), theory=True),
        ),
    )  # fmt: skip


CHECKS = (
    Check(
        name="events/brownian",
        title="Brownian motion: friction, velocity autocorrelation and speeds of a heavy particle in a bath",
        equation="C(t) = <v_x(0) v_x(t)> ~ (T/M) exp(-gamma t), Enskog's gamma; <v^2> = d T/M (1 - M/M_total)",
        criterion="within the standard error over runs, and the uncertainty of g at contact and of repeated collisions",
        citation="Hansen & McDonald, Theory of Simple Liquids; Chapman & Cowling (1970); Uhlenbeck & Ornstein, Phys. "
        "Rev. 36, 823 (1930)",
        judge=_judge,
        variants=variants_of(BATHS, "full"),
        needs=event_driven(
            "masses[] hard_spheres.diameter[] box.boundaries=periodic", "positions velocities collisions"
        ),
        faults=(
            (
                "2d",
                Fault(
                    "near-contact-of-unequals",
                    "events/prediction.py",
                    "return radii[i] + radii[j]",
                    "return 0.55 * (radii[i] + radii[j]) if radii[i] != radii[j] else radii[i] + radii[j]",
                    "a particle of the bath and a tracer collide at 0.55 of their contact distance",
                ),
            ),
        ),
    ),
)
