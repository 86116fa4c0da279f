"""Driven scenes of hard spheres: means of soft grains, whose contacts last t_c, in the limit t_c -> 0.

Averages of soft runs carry an error of the first order in t_c: of a grain's time the share nu t_c is spent in contact
(nu the collision rate), and of its contacts the same share are with two grains at once. So runs at two or more t_c give
the value at t_c = 0 by a straight line, with its standard error, and that is compared with the event-driven run, which
has no t_c. The error of second order, (nu t_c)^2, is not corrected: it lies below the standard error.

The step's own error does not vanish with t_c at a given dt/t_c. At the dt/t_c of these checks an impact has alpha to
1e-3 (of 0.9), alpha_t of a dashpot to 3e-3 and of a tangential spring to 0.6 dt/t_c at worst, in the mean over impacts.

Literature: S. Luding et al., Phys. Rev. E 49, 1634 (1994) and 50, 4113 (1994); S. Luding and S. McNamara, Granular
Matter 1, 113 (1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.engines.protocol import Run
from crosscheck.figure import Figure, Series
from crosscheck.scene import Floats
from crosscheck.statistics import Mean, combined, standard_error
from crosscheck.verdict import Judgement, statistical

#: Stretches of a run, whose means give a profile its standard errors.
BLOCKS = 20


def trajectory(run: Run, skip: int) -> tuple[Floats, Floats]:
    """Positions and velocities of the samples of `run` from number `skip` on, both (samples, N, d)."""
    return run["positions"][skip:], run["velocities"][skip:]


# -- means in the limit ------------------------------------------------------------------------------------------------


def hard_limit(durations: Sequence[float], means: Sequence[Mean]) -> Mean:
    """Value at t_c = 0 of the straight line through means at several t_c, by least squares with weights 1/error^2.

    durations: t_c of each mean (time). means: one for each of them. The error of the result is propagated from theirs;
    its number of independent samples is the smallest of theirs. ValueError for fewer than two different durations, or
    an error that is not positive.
    """
    errors = np.array([mean.error for mean in means])
    if len(set(durations)) < 2 or not (errors > 0).all():
        raise ValueError(f"a limit needs two durations and positive errors, got {durations} and {errors}")
    values = [mean.value for mean in means]
    line, covariance = np.polyfit(durations, values, 1, w=1 / errors, cov="unscaled")
    return combined(float(line[1]), float(covariance[1, 1] ** 0.5), means)


class Profile(NamedTuple):
    """A quantity over bins of the place; share: of the grains in a bin; mean: over these; both (blocks, bins)."""

    share: Floats
    mean: Floats

    def means(self, values: Floats) -> list[Mean]:
        """Mean over the blocks, for each bin; values: `share` or `mean`, (blocks, bins)."""
        errors, number = standard_error(values), len(values)
        return [
            Mean(float(v), float(e), number, number - 1.0) for v, e in zip(values.mean(axis=0), errors, strict=True)
        ]


def profile(places: ArrayLike, quantity: ArrayLike, edges: ArrayLike, blocks: int = BLOCKS) -> Profile:
    """Share and mean of a quantity over bins of the place, in each of `blocks` stretches of the samples.

    places, quantity: (samples, N); edges: of the bins, (bins + 1,). blocks: number of stretches. A bin
    that is empty in a stretch has the mean NaN there. Samples beyond a whole number of stretches are left out.
    """
    x, q, ends = np.asarray(places), np.asarray(quantity), np.asarray(edges)
    length = len(x) // blocks
    shares, means = np.empty((blocks, len(ends) - 1)), np.empty((blocks, len(ends) - 1))
    for block in range(blocks):
        part = slice(block * length, (block + 1) * length)
        count = np.histogram(x[part], ends)[0]
        shares[block] = count / x[part].size
        with np.errstate(invalid="ignore"):
            means[block] = np.histogram(x[part], ends, weights=q[part])[0] / count
    return Profile(shares, means)


_WHY = "standard errors of correlated series; soft ones taken to t_c = 0 along a straight line"


def against(quantity: str, limit: Mean, hard: Mean, needed: float, why: str = _WHY, doubt: float = 0.0) -> Judgement:
    """The limit of the soft runs against the event-driven mean.

    quantity: what both measure, in words. limit: of the soft runs, at t_c = 0. hard: of the event-driven run. needed:
    the relative deviation that must be visible. why: the reason of the tolerance, in words. doubt: by how much the
    limit may be off.
    """
    return statistical(
        quantity, limit.value, limit.error, hard.value, hard.error, why, samples=(limit, hard), doubt=doubt,
        needed=needed,
    )  # fmt: skip


def against_duration(
    title: str, label: str, engine: str, durations: Sequence[float], means: Sequence[Mean], hard: Mean
) -> Figure:
    """A mean against t_c, with the event-driven one at 0 and the line's value there.

    title: of the figure. label: of the mean's axis. engine: name of that which ran soft grains. durations: t_c of the
    soft runs (time). means: of each of them. hard: of the event-driven run. ValueError as in `hard_limit`.
    """
    limit = hard_limit(durations, means)
    x, y = [0.0, *durations], [limit, *means]
    return Figure(
        title,
        "t_c",
        label,
        series=(
            Series(f"soft, {engine}", x, [m.value for m in y], [m.error for m in y]),
            Series("event-driven", [0.0], [hard.value], [hard.error]),
        ),
    )


def curves(
    engine: str, x: Floats, durations: Sequence[float], soft_means: list[list[Mean]], hard: list[Mean]
) -> tuple[Series, ...]:
    """Profiles of the soft runs and of the event-driven one.

    engine: name of that which ran soft grains. x: middles of the bins, (bins,). durations: t_c of the soft runs (time).
    soft_means: of each of them, one mean a bin. hard: those of the event-driven run.
    """
    labels = [f"{engine}, t_c = {duration:g}" for duration in durations] + ["event-driven"]
    return tuple(
        Series(label, x.tolist(), [m.value for m in means], [m.error for m in means])
        for label, means in zip(labels, [*soft_means, hard], strict=True)
    )


def listed(durations: Sequence[float], means: Sequence[Mean]) -> str:
    """The means that a limit is taken from, in words; durations: t_c of each (time)."""
    return ", ".join(f"{m.value:.5g} +- {m.error:.2g} at t_c = {t:g}" for t, m in zip(durations, means, strict=True))
