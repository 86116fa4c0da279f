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
    """An extrapolation to step 0. value: (...). error: its estimated error, the largest of all components. weights:
    (runs,), of the runs in the value; their rounding errors are multiplied by these.
    """

    value: Floats
    error: float
    weights: Floats


def extrapolate(steps: ArrayLike, values: ArrayLike) -> Limit:
    """Results of a symmetric scheme, extrapolated to step 0.

    The error of a symmetric scheme has even powers of the step only, so the values lie on a polynomial in dt^2 (Hairer,
    Norsett and Wanner). steps: (runs,), coarsest first. values: (runs, ...). The estimated error is the largest change
    of the value when the coarsest run is left out. ValueError for fewer than 3 runs.
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
