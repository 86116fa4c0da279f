"""Orders of convergence and extrapolation to a vanishing step: what the checks of integrators share.

Literature: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927); E. Hairer, S. P. Norsett and G. Wanner, Solving
Ordinary Differential Equations I, 2nd ed., Springer (1993), section II.9.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Orders are whole numbers: a quarter keeps the neighbouring orders three tolerances away.
ORDER_TOLERANCE = 0.25
WHY_ORDER = "orders are whole numbers; a quarter keeps the neighbouring ones three tolerances away"


class Limit(NamedTuple):
    """Value at step 0; error: its own estimate; weights: of the runs, by which their rounding errors add up."""

    value: Floats
    error: float
    weights: Floats


def extrapolate(steps: ArrayLike, values: ArrayLike) -> Limit:
    """Results of a symmetric scheme at several steps, coarsest first, taken to step 0.

    The error of a symmetric scheme has even powers of the step alone, so the values are on a polynomial in dt^2; shape
    (runs, ...). The error is the largest change when the coarsest run is left out: that of one order less.
    ValueError for fewer than 3 runs.
    """
    x, y = np.asarray(steps, dtype=np.float64) ** 2, np.asarray(values, dtype=np.float64)
    if x.size < 3:
        raise ValueError(f"an extrapolation with an error needs at least 3 runs, got {x.size}")
    weights, fewer = _at_zero(x), _at_zero(x[1:])
    value = np.tensordot(weights, y, 1)
    return Limit(value, float(abs(value - np.tensordot(fewer, y[1:], 1)).max()), weights)


def _at_zero(x: Floats) -> Floats:
    """Weights of Lagrange's polynomial through the points x, at 0."""
    apart = x[None, :] - x[:, None]
    np.fill_diagonal(apart, 1.0)
    factors = x[None, :] / apart
    np.fill_diagonal(factors, 1.0)
    return np.asarray(factors.prod(1))
