"""Laws of the largest of many values, whose location and scale follow from the middle of their distribution.

One value that is wrong does not change quartiles, so it can be told by them. The tails that are assumed fall off as
exponentials do, which holds for whatever falls off faster too; or as those of normal values, for means of many
particles.

Literature: E. J. Gumbel, Statistics of Extremes (1958), chapters 5 and 6; M. G. Kendall and A. Stuart, The Advanced
Theory of Statistics, vol. 1, chapter 14, for the errors of sample quantiles.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.statistics import correlated_mean
from crosscheck.trajectories.frames import Floats

#: Fewest independent values whose quartiles are trusted.
_FEWEST = 20
#: Gumbel's law exp(-exp(-x)): its median, and the distance of its quartiles.
_MEDIAN, _QUARTILES = -math.log(math.log(2)), math.log(math.log(4) / math.log(4 / 3))
#: The median of |x| of normal values, and of Laplace's law exp(-|x|)/2.
_NORMAL, _LAPLACE = 0.6745, math.log(2)
#: Standard error of a scale from n values, relative, times n^(1/2): of Gumbel's law from its quartiles, and of the
#: others from the median of |x|.
_ERRORS = {"gumbel": 1.26, "normal": 1.17, "laplace": 1 / math.log(2)}


class Largest(NamedTuple):
    """The law of the largest of F values.

    location, scale: of one value. number: F. error: standard error of the scale, relative. tail: of one value. floor:
    the limit is not below it.
    """

    location: float
    scale: float
    number: float
    error: float
    tail: Literal["gumbel", "normal", "laplace"]
    floor: float = -math.inf

    def isf(self, probability: float) -> float:
        """What the largest exceeds with this probability at most.

        probability: small. The scale is taken as large as it may be with the same probability, by its own error.
        """
        from scipy.stats import norm

        one = probability / self.number
        beyond = float(norm.isf(one / 2)) if self.tail == "normal" else -math.log(one)
        wide = self.scale * (1 + float(norm.isf(probability)) * self.error)
        return max(self.location + wide * beyond, self.floor)

    def sf(self, largest: float) -> float:
        """The probability, at most, that the largest is beyond `largest`; 1/2 where it is not small."""
        low, high = -300.0, math.log10(0.5)
        if largest <= self.isf(0.5):
            return 0.5
        for _ in range(60):  # halves the interval of the logarithm of the probability, of which isf is the limit
            middle = (low + high) / 2
            low, high = (middle, high) if self.isf(10**middle) > largest else (low, middle)
        return float(10**high)


def of_maxima(values: Floats, floor: float = -math.inf) -> Largest | None:
    """The law of the largest of values that are maxima themselves, by Gumbel's law; None: too few are independent.

    values: (F,), in time. floor: see `Largest`.
    """
    independent = _independent(values)
    if independent is None:
        return None
    low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
    scale = float(high - low) / _QUARTILES
    location = float(middle) - _MEDIAN * scale
    return Largest(location, scale, len(values), _ERRORS["gumbel"] / independent**0.5, "gumbel", floor)


def of_deviations(values: Floats, tail: Literal["normal", "laplace"], floor: float = -math.inf) -> Largest | None:
    """The law of the largest |value| of values about 0; None: too few are independent.

    values: (F,), in time. tail: of their distribution. floor: see `Largest`.
    """
    independent = _independent(values)
    if independent is None:
        return None
    scale = float(np.median(np.abs(values))) / (_NORMAL if tail == "normal" else _LAPLACE)
    return Largest(0.0, scale, len(values), _ERRORS[tail] / independent**0.5, tail, floor)


def _independent(values: Floats) -> float | None:
    """The number of independent ones of these values; None: fewer than are needed."""
    if len(values) < _FEWEST:
        return None
    found = correlated_mean(values).independent
    return min(found, float(len(values))) if found >= _FEWEST else None
