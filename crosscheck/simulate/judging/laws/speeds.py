"""In equilibrium the speeds have Maxwell's distribution; at constant energy, that of a component on a sphere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.figure import Figure, Histogram, Series
from crosscheck.references.speeds import moment_ratio, share_distribution
from crosscheck.scene import Floats
from crosscheck.simulate.judging.equilibrium import Equilibrium, equilibrium, extras, mean_of, settled, why_none
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.verdict import Judged, Judgement, by_chance, statistical, worst

#: Of the squares of the speeds, the correlation below which two samples count as independent, and speeds at most.
_UNCORRELATED, _MOST = 0.05, 500_000
#: Particles of one mass at least.
_FEWEST = 10


def _excuse(trial: Trial) -> str | None:
    return why_none(trial) or (None if trial.measures("velocities") else "the engine records no velocities")


def _judge(trial: Trial) -> Judged:
    """<v^4>/<v^2>^2 of all samples, and the distance of the distribution from that of independent ones."""
    found = equilibrium(trial)
    judged, figures = [], []
    d, f = trial.scene.dimension, found.freedoms
    for group, members in found.groups.items():
        if members.size < _FEWEST:
            continue
        # scaled so that the mean square is 1
        squares = found.shares[:, members].sum(axis=2) * f / d
        mean = mean_of((squares**2).mean(axis=1))
        expected = moment_ratio(d, f)
        judged.append(
            settled(
                found,
                statistical(
                    f"<v^4>/<v^2>^2{group}", mean.value, mean.error, expected, 0.0,
                    "Maxwell's distribution at constant energy; standard error of correlated samples", samples=mean,
                ),
            )
        )  # fmt: skip
        apart = _apart(squares)
        chosen = squares[::apart].ravel()[:_MOST]
        judged.append(settled(found, _distance(chosen, group, found)))
        figures.append(_figure(chosen, group, found))
    note = f"{found.samples} samples until t = {found.scene.duration:g}"
    if not judged:
        none = by_chance("distance from Maxwell", 0.0, share_distribution(d, f), "no speeds")
        return replace(none, outcome="inconclusive", note="too many different masses, or too few particles of each")
    return worst(judged, note, tuple(figures))


def _distance(squares: Floats, group: str, found: Equilibrium) -> Judgement:
    from scipy.stats import kstest, kstwo

    law = share_distribution(found.scene.dimension, found.freedoms)
    distance = float(kstest(squares * found.scene.dimension / found.freedoms, law.cdf, method="asymp").statistic)
    why = f"Kolmogorov's distribution for {squares.size} speeds, of samples so far apart that they have changed"
    return by_chance(f"distance from Maxwell (Kolmogorov-Smirnov){group}", distance, kstwo(squares.size), why)


def _apart(squares: Floats) -> int:
    """How many samples after each other are independent: twice the lag at which the squares of speeds are."""
    centred = squares - squares.mean(axis=0)
    variance = float((centred**2).mean())
    if variance == 0:
        return 1
    for lag in range(1, len(squares) // 4):
        if float((centred[:-lag] * centred[lag:]).mean()) < _UNCORRELATED * variance:
            return 2 * lag if lag > 1 else 1
    return max(1, len(squares) // 4)


def _figure(squares: Floats, group: str, found: Equilibrium) -> Figure:
    edges = np.linspace(0, 3.0, 41)
    density = np.histogram(np.sqrt(squares), edges)[0] / (squares.size * np.diff(edges))
    d, f = found.scene.dimension, found.freedoms
    fine = np.linspace(0, 3.0, 121)[1:]
    law = share_distribution(d, f).pdf(fine**2 * d / f) * 2 * fine * d / f
    return Figure(
        f"speeds{group}", "v over the root of its mean square", "probability density", "linear", "linear",
        (
            Histogram(found.trial.planned.label, edges.tolist(), np.round(density, 5).tolist()),
            Series("Maxwell", fine.tolist(), np.round(law, 5).tolist(), theory=True),
        ),
    )  # fmt: skip


LAWS = (Law("speeds", "m v^2/2K has the beta distribution of d of f dimensions", _excuse, _judge, extra=extras),)
