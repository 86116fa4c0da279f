"""The first contact of two spheres that fly freely, from any distance and with every image of a periodic box.

Decimal arithmetic of 60 digits, rounded once at the end: of use where double precision is what is judged. Lengths and
times in any consistent units.

Literature: B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31, 459 (1959), the quadratic equation of a contact; the
rest is derived in the docstrings.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_DIGITS = 60


@dataclass(frozen=True)
class Impact:
    """A contact. time: from the start. normal: (d,) unit vector from the first sphere to the second one."""

    time: float
    normal: Floats


def first_impact(
    apart: Sequence[float], velocity: Sequence[float], sigma: float, periods: Sequence[float], until: float
) -> Impact | None:
    """The first contact at a distance sigma before the time `until`; None if there is none.

    apart, velocity: (d,) of the second sphere relative to the first. sigma: contact distance. periods: (d,) sides of
    the box, 0 along axes that are not periodic: the spheres have images at all multiples of them. For each image, the
    smaller root of |r + v t| = sigma, c/(sqrt(D) - b) with b = r.v, c = r.r - sigma^2, D = b^2 - v.v c, where b < 0 and
    D > 0. ValueError for spheres that overlap at the start.
    """
    with localcontext(prec=_DIGITS):
        v = [Decimal(x) for x in map(float, velocity)]
        size, end = Decimal(float(sigma)), Decimal(float(until))
        w = sum((x * x for x in v), Decimal(0))
        best: tuple[Decimal, list[Decimal]] | None = None
        for shift in itertools.product(*map(_images, apart, velocity, periods, itertools.repeat((sigma, until)))):
            r = [Decimal(float(x)) + k * Decimal(float(p)) for x, k, p in zip(apart, shift, periods, strict=True)]
            b = sum((x * y for x, y in zip(r, v, strict=True)), Decimal(0))
            c = sum((x * x for x in r), Decimal(0)) - size * size
            if c < 0:
                raise ValueError(f"the spheres overlap at the start, in the image {shift}")
            square = b * b - w * c
            if b < 0 and square > 0:
                time = c / (square.sqrt() - b)
                if time <= end and (best is None or time < best[0]):
                    best = time, [(x + y * time) / size for x, y in zip(r, v, strict=True)]
        return None if best is None else Impact(float(best[0]), np.array([float(x) for x in best[1]]))


def _images(x: float, v: float, period: float, limits: tuple[float, float]) -> range:
    """Numbers of periods by which an image may come within sigma of 0 along one axis."""
    if period == 0:
        return range(1)
    sigma, until = limits
    low, high = min(x, x + v * until) - 2 * sigma, max(x, x + v * until) + 2 * sigma
    return range(math.floor(-high / period), math.ceil(-low / period) + 1)


def after_impact(impact: Impact, first: Sequence[float], second: Sequence[float]) -> tuple[Floats, Floats]:
    """Velocities after the elastic impact of two equal spheres: they exchange the components along the normal.

    impact: gives the normal. first, second: (d,) velocities before it.
    """
    u, v = np.array(first, dtype=float), np.array(second, dtype=float)
    exchanged = ((v - u) @ impact.normal) * impact.normal
    return u + exchanged, v - exchanged
