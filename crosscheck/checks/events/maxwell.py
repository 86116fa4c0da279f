"""Relaxation of a gas whose particles start with one speed to Maxwell's distribution; V0 = sigma = m = 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, quick, small
from crosscheck.checks.events.gases import TALLIES, event_driven, gas
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Histogram, Series
from crosscheck.references import EPSILON
from crosscheck.references import speeds as reference
from crosscheck.scene import Floats, Output
from crosscheck.statistics import standard_error
from crosscheck.verdict import Judged, by_chance, round_off, statistical, worst


class _Speeds(NamedTuple):
    """Runs of N particles of one speed, V0 = 1, dilute. needed: relative deviation that must be seen."""

    dimension: int
    number: int
    runs: int
    needed: float


#: Pair collisions of all particles over their number.
COUNTS = (0.5, 1.0, 2.0, 3.0, 10.0)
#: n sigma^d; the free path is 3.5 (3D: 5) lattice spacings.
DILUTE = 0.01


def _judge(laboratory: Laboratory, gases: _Speeds) -> Judged:
    """Moments of the speeds after so many collisions, and the distance from Maxwell's distribution."""
    from scipy.stats import kstwo

    d, number, runs, needed = gases
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
    judgements = [
        round_off(
            "mean square speed less 1, by which the fourth power is divided",
            float(abs(squares.mean(axis=2) - 1).max()),
            16 * EPSILON * COUNTS[-1],
            "elastic: eight roundings a collision of each partner, at worst all alike",
        )
    ]
    for index, count in enumerate(COUNTS):
        known = reference.mono_speed_moment_ratio(count, np.inf, d)
        judgements.append(
            statistical(
                f"<v^4>/<v^2>^2 after {count:g} N collisions",
                float(means[index]),
                float(errors[index]),
                known.value,
                known.uncertainty,
                f"standard error over {runs} runs, and that of the table; off by 1/N, and pairs that meet again",
                samples=runs,
                doubt=few + reference.MEETING_AGAIN * DILUTE,
                needed=needed,
            )
        )
    temperature = reference.mono_speed_temperature(1.0, d)
    distances = [_distance(speeds[:, index].ravel(), d, temperature) for index in range(len(COUNTS))]
    why = f"Kolmogorov's distribution for {runs * number} speeds"
    law = kstwo(runs * number)
    judgements.append(by_chance("distance from Maxwell (Kolmogorov-Smirnov) after 10 N", distances[-1], law, why))
    figures = _figures(gases, speeds, means, errors)
    rise = float(np.diff(distances).max())
    why = f"{why}: a rise is less than the distance that it ends at"
    judgements.append(by_chance("largest rise of that distance", rise, law, why, figures=figures))
    earlier = zip(distances[:-1], COUNTS, strict=False)
    shown = ", ".join(f"{distance:.4f} ({count:g} N)" for distance, count in earlier)
    return worst(judgements, f"earlier distances from Maxwell {shown}; {runs} runs of {number}, n = {DILUTE}")


def _distance(speeds: Floats, dimension: int, temperature: float) -> float:
    """Largest difference of the cumulative distributions of these speeds and of Maxwell (Kolmogorov and Smirnov)."""
    expected = reference.maxwell_cumulative(np.sort(speeds), dimension, temperature)
    found = np.arange(speeds.size + 1) / speeds.size
    return float(max((found[1:] - expected).max(), (expected - found[:-1]).max()))


def _figures(gases: _Speeds, speeds: Floats, means: Floats, errors: Floats) -> tuple[Figure, ...]:
    d = gases.dimension
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
            f"speeds, {d}D, N = {gases.number}", "v/V0", "probability density", "linear", "linear",
            (*bins, Series("Maxwell", fine.tolist(), np.round(law, 5).tolist(), theory=True)),
        ),
        Figure(
            f"relaxation from one speed, {d}D", "collisions a particle", "<v^4>/<v^2>^2", "log", "linear",
            (
                Series(f"N = {gases.number}", list(COUNTS), means.tolist(), errors.tolist()),
                Series("Boltzmann", x, [row.moment_ratio for row in table], theory=True),
            ),
        ),
    )  # fmt: skip


_SLIGHTLY_INELASTIC = Fault(
    "slightly-inelastic",
    "events/rules.py",
    "    if restitution is None:\n        return 1.0",
    "    if restitution is None:\n        return 0.99",
    "elastic collisions lose 1 % of the normal velocity",
)

CHECKS = (
    Check(
        name="events/maxwell",
        title="Disks and spheres of one speed in a box relax to Maxwell's distribution",
        equation="f(v) = 2 v^(d-1) exp(-v^2/w^2)/(Gamma(d/2) w^d), w^2 = 2 V0^2/d; <v^4>/<v^2>^2 from 1 to 1 + 2/d",
        criterion="<v^4>/<v^2>^2 at N/2, N, 2N, 3N, 10N collisions within the errors over runs of Boltzmann's; "
        "Kolmogorov-Smirnov distance falls, to that of a sample of Maxwell",
        citation="Chapman & Cowling, The Mathematical Theory of Non-uniform Gases (1970), chapters 4, 5; relaxation: "
        "own direct simulation of the Boltzmann equation (Bird 1994)",
        judge=_judge,
        variants=(
            *quick(**{"2d": _Speeds(2, 1600, 24, 0.05)}),
            small("2d-N100", _Speeds(2, 100, 24, 0.2), "2d"),
            *full(**{"2d-large": _Speeds(2, 10000, 24, 0.02), "3d": _Speeds(3, 4096, 24, 0.02)}),
        ),
        needs=event_driven("box.boundaries=hard output.collisions", f"positions velocities {' '.join(TALLIES)}"),
        faults=(("2d", _SLIGHTLY_INELASTIC), ("2d-N100", _SLIGHTLY_INELASTIC)),
    ),
)
