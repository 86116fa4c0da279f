"""Where each scheme is stable on the damped oscillator, and what rounding may do to its steps.

The step matrix M of `crosscheck.references.oscillator` acts on the scheme's state; kappa = (omega0 dt)^2 and
c = gamma dt/m = 2 zeta omega0 dt, zeta = gamma/(2 m omega0) the damping ratio. A step is stable where the largest
|eigenvalue| of M is at most 1. Along a *ray* the ratio zeta/(omega0 dt) = c/(2 kappa) = gamma/(2 k dt) is fixed:
springs of one k and gamma and of all masses lie on one ray.

Literature: M. P. Allen and D. J. Tildesley, Computer Simulation of Liquids (1987), chapter 3; E. Hairer, S. P. Norsett
and G. Wanner, Solving Ordinary Differential Equations I (1993), section III.3, for regions of stability; N. J. Higham,
Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), section 18.2, for the rounding of powers of a matrix.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.references import EPSILON
from crosscheck.references.oscillator import Linear, matrices

Floats = NDArray[np.float64]

#: Points of a scan along a ray, per factor of 10, between which at most one boundary is looked for; and the relative
#: width to which it is bisected.
_SCAN, _WIDTH = 20, 1e-13
#: Growth in a step that counts as none: eigenvalues of size 1 are known no better.
_ONE = 1e-12
#: Roundings of each term of a step: of products, sums, and the coefficients of the scheme.
ROUNDINGS = 8.0


def log_growth(scheme: str, h: float, zeta: float) -> float:
    """ln of the largest |eigenvalue| of the step matrix at h = omega0 dt and the damping ratio zeta; -inf for 0.

    scheme: a name known to `oscillator.has_matrix`, else KeyError. h: radians a step, > 0. zeta: >= 0.
    """
    advance = matrices(scheme, h * h, 2 * zeta * h)[1].astype(np.float64)
    largest = float(np.abs(np.linalg.eigvals(advance)).max())
    return math.log(largest) if largest > 0 else -math.inf


def boundaries(scheme: str, ratio: float, low: float, high: float) -> list[float]:
    """All h = omega0 dt between `low` and `high` at which the scheme turns stable or unstable along a ray.

    ratio: zeta/h along the ray, >= 0. scheme: as in `log_growth`. Growth by less than a part in 1e12 a step counts as
    none. So without damping (ratio = 0) a scheme that is stable for no step, but grows as a high power of h, seems to
    have a boundary where its growth begins to be seen.
    """

    def unstable(h: float) -> bool:
        return log_growth(scheme, h, ratio * h) > _ONE

    number = max(2, math.ceil(_SCAN * math.log10(high / low)))
    grid = [(h, unstable(h)) for h in np.geomspace(low, high, number).tolist()]
    found = []
    for (left, first), (right, last) in pairwise(grid):
        if first == last:
            continue
        below, above = left, right
        while above / below > 1 + _WIDTH:
            middle = math.sqrt(below * above)
            if middle in (below, above):
                break
            below, above = (middle, above) if unstable(middle) == first else (below, middle)
        found.append(math.sqrt(below * above))
    return found


class _Size:
    """The sum of the sizes of the terms of a number: differences add up. A matrix in such numbers is |M| of its terms.

    1 - c is as large as 1 + c where it is rounded, even if it is 0 (Higham, section 3.1).
    """

    def __init__(self, value: Any) -> None:
        self.value = abs(float(value))

    def __float__(self) -> float:
        return self.value

    def __add__(self, other: Any) -> _Size:
        return NotImplemented if isinstance(other, np.ndarray) else _Size(self.value + abs(float(other)))

    def __mul__(self, other: Any) -> _Size:
        return NotImplemented if isinstance(other, np.ndarray) else _Size(self.value * abs(float(other)))

    def __truediv__(self, other: Any) -> _Size:
        return _Size(self.value / abs(float(other)))

    def __neg__(self) -> _Size:
        return self

    __radd__ = __sub__ = __rsub__ = __add__
    __rmul__ = __mul__


class Steps(NamedTuple):
    """The states of n oscillators after 0, 1, ... steps, and what rounding may do to them.

    r, u: r and v dt, (steps + 1, n), in the unit of length. r_error, u_error: bounds on their rounding, the same shape.
    """

    r: Floats
    u: Floats
    r_error: Floats
    u_error: Floats


def steps_of(scheme: str, h: Floats, zeta: Floats, r: Floats, u: Floats, steps: int) -> Steps:
    """The scheme's own steps on n oscillators, from its matrix in long double, and bounds on their rounding in double.

    Every term of a step is rounded `ROUNDINGS` times, by eps/2 of its size; an error of step k is carried on by
    M^(n - k). So |error after n steps| <= sum_k |M^(n-k)| (ROUNDINGS eps/2 S |x_k|) in each component, where S has the
    sums of the sizes of the terms of M.

    scheme: as in `log_growth`. h, zeta: omega0 dt and the damping ratio of each, (n,). r, u: r and v dt at the start,
    (n,), in any unit of length. steps: their number, so few that no long double overflows.
    """
    exact = [
        matrices(scheme, np.longdouble(a) ** 2, 2 * np.longdouble(b) * np.longdouble(a))
        for a, b in zip(h, zeta, strict=True)
    ]
    sizes = [matrices(scheme, _Size(a * a), _Size(2 * b * a)) for a, b in zip(h, zeta, strict=True)]
    begin, advance, read = _stacks(exact)
    from_start, in_step, from_state = (abs(one) for one in _stacks(sizes))
    given = np.stack([r, u], axis=1).astype(np.longdouble)[:, :, None]
    powers = [read]
    states = [begin @ given]
    unit = ROUNDINGS * EPSILON / 2
    made = [unit * (from_start @ abs(given))]
    for _ in range(steps):
        powers.append(powers[-1] @ advance)
        made.append(unit * (in_step @ abs(states[-1])))
        states.append(advance @ states[-1])
    values: list[Any] = [given]
    errors: list[Any] = [np.zeros_like(given)]
    for n in range(1, steps + 1):
        carried = sum(abs(powers[n - k]) @ made[k] for k in range(n + 1))
        values.append(read @ states[n])
        errors.append(carried + unit * (from_state @ abs(states[n])))
    value, error = (np.array(one, dtype=np.float64)[..., 0] for one in (values, errors))
    return Steps(value[..., 0], value[..., 1], error[..., 0], error[..., 1])


def _stacks(several: Sequence[Linear]) -> list[NDArray[np.longdouble]]:
    """(start, advance, read) of several oscillators, each as one array (n, rows, columns)."""
    return [np.array([one[part].astype(np.longdouble) for one in several]) for part in range(3)]
