"""Whether two runs have the same particles in the same box: numbers, types, masses, sizes, edges, and along which of
them the box is periodic."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosscheck.compare.differences import common_rows, flat_axes
from crosscheck.trajectories.frames import SINGLE, Frame, Rounding

#: Edges of a box that were kept as 32 bits, or computed from its bounds, agree to this, relative.
_EDGES = 4 * SINGLE.relative


def different_setup(first: Frame, second: Frame, roundings: dict[str, tuple[Rounding, Rounding]]) -> list[str]:
    """What is different in the set-up of two runs, as sentences; empty if nothing is.

    first, second: first common frames, in the same units. roundings: quantity -> of both files, in these units. What
    one file does not state is not compared.
    """
    found = []
    mine, yours = len(first.ids), len(second.ids)
    if mine != yours:
        found.append(f"{mine} particles against {yours}")
    rows = common_rows(first.ids, second.ids)
    alone = np.setxor1d(first.ids, second.ids)
    if mine == yours and len(alone):
        found.append(f"{len(alone)} ids occur in one of them alone, such as {alone[0]}")
    ids = first.ids[rows[0]]
    if not len(ids):
        return found
    for name, what in (("masses", "mass"), ("diameters", "diameter")):
        parts = getattr(first, name), getattr(second, name)
        if parts[0] is None or parts[1] is None:
            continue
        a, b = parts[0][rows[0]], parts[1][rows[1]]
        wrong = np.flatnonzero(np.abs(a - b) > roundings[name][0].of(a) + roundings[name][1].of(b))
        if wrong.size:
            k = wrong[0]
            more = f", and {wrong.size - 1} more" if wrong.size > 1 else ""
            found.append(f"the {what} of particle {ids[k]} is {a[k]:.10g} against {b[k]:.10g}{more}")
    if first.types is not None and second.types is not None:
        found += _types(ids, first.types[rows[0]], second.types[rows[1]])
    if first.box is not None and second.box is not None:
        edges = first.box.vectors, second.box.vectors
        allowed = (
            sum(one.of(box) for one, box in zip(roundings["box"], edges, strict=True)) + _EDGES * np.abs(edges[0]).max()
        )
        # a plane has no edge across in one file, and a thin one in another
        both = first.box.extended & second.box.extended
        if len(first.positions) > 1:
            both &= ~flat_axes(first.positions)
        if (np.abs(edges[0] - edges[1]) > allowed)[both].any():
            sides = [" x ".join(f"{side:.8g}" for side in np.linalg.norm(one, axis=1)) for one in edges]
            found.append(f"the edges of the box are {sides[0]} against {sides[1]}")
        found += _periodic(first, second)
    return found


def _periodic(first: Frame, second: Frame) -> list[str]:
    """Boxes that are periodic along other axes, where both files state along which."""
    assert first.box is not None
    assert second.box is not None
    if not (first.box.stated and second.box.stated):
        return []
    # along an axis that the plane does not have, LAMMPS wants a periodic box
    still = flat_axes(first.positions) if len(first.positions) > 1 else first.positions[0] == 0
    mine, yours = (box.around & ~still for box in (first.box, second.box))
    if (mine == yours).all():
        return []
    named = [", ".join(axis for axis, is_one in zip("xyz", axes, strict=True) if is_one) for axes in (mine, yours)]
    return [f"the box is periodic along {named[0] or 'no axis'} against {named[1] or 'no axis'}"]


def _types(ids: NDArray[np.int64], mine: NDArray[Any], yours: NDArray[Any]) -> list[str]:
    """Types may have other names in the other file, such as numbers from 0 or from 1; one must go with one."""
    _, one = np.unique(mine, return_inverse=True)
    _, other = np.unique(yours, return_inverse=True)
    pairs = np.unique(np.stack([one, other]), axis=1)
    for side in range(2):
        values, counts = np.unique(pairs[side], return_counts=True)
        if (counts > 1).any():
            shared = values[counts > 1][0]
            rows = np.flatnonzero((one, other)[side] == shared)
            partner = (other, one)[side][rows]
            k = rows[np.flatnonzero(partner != partner[0])[0]]
            text = f"the type of particle {ids[k]} is {mine[k]} against {yours[k]}, "
            return [text + f"and that of particle {ids[rows[0]]} is {mine[rows[0]]} against {yours[rows[0]]}"]
    return []
