"""Differences of two trajectories, frame by frame: bits, what rounding of the files explains, and how far apart."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.compare.pairing import Pairing
from crosscheck.trajectories.frames import DOUBLE, QUANTITIES, Box, Floats, Frame, Integers, Rounding, Source

#: Vectors of a frame that are compared, and what one of their components is called.
VECTORS = {"positions": "position", "velocities": "velocity", "spins": "angular velocity"}


class Difference(NamedTuple):
    """One component of one particle that differs.

    pair: number of the pair of frames. quantity: see `VECTORS`. particle: its id. axis: 0, 1 or 2. first, second: the
    numbers, in the units of the first file. rounding: by how much the files' rounding lets them differ.
    """

    pair: int
    quantity: str
    particle: int
    axis: int
    first: float
    second: float
    rounding: float


class Gap(NamedTuple):
    """How far two frames are apart.

    time: of the frame. same: all numbers that both hold have the same bits. beyond: of the components
    beyond the files' rounding, the one that differs most, None: none is. differing: the same of those whose bits
    differ, None: none. rms: quantity
    -> root mean square of the distance of a particle from itself. largest: quantity -> the largest such distance.
    farthest: quantity -> id of that particle. floor: quantity -> what rounding makes of `rms` at most. most: quantity
    -> what it makes of `largest` at most. extent: the largest |coordinate|, about the mean. number: of particles in
    both frames. missing: numbers of ids in one frame alone. kinetic: mean kinetic energy of a particle in each (of mass
    1 where no masses are stated); None without velocities. finite: whether all numbers are. momentum: total momentum of
    both (masses 1 where none are stated), None without velocities. momentum_rounding: by how much the files' rounding
    may have changed either. momentum_scale: sum of the absolute momenta of particles.
    """

    time: float
    same: bool
    beyond: Difference | None
    differing: Difference | None
    rms: dict[str, float]
    largest: dict[str, float]
    farthest: dict[str, int]
    floor: dict[str, float]
    most: dict[str, float]
    extent: float
    number: int
    missing: tuple[int, int]
    kinetic: tuple[float | None, float | None]
    finite: bool
    momentum: tuple[tuple[float, ...], tuple[float, ...]] | None
    momentum_rounding: float
    momentum_scale: float


def gaps(one: Source, other: Source, pairing: Pairing) -> Iterator[Gap]:
    """How far the frames of each pair are apart, in their order; two frames are in memory at a time.

    one, other: the trajectories. pairing: of their frames. Where a file has wrapped positions into a periodic box, the
    distance is that to the nearest image.
    """
    nearest = "wrapped" in (one.wrapping, other.wrapping)
    roundings = roundings_of(one, other, pairing)
    for number in range(len(pairing.first)):
        yield gap(number, float(pairing.times[number]), *frames_of(one, other, pairing, number), nearest, roundings)


def frames_of(one: Source, other: Source, pairing: Pairing, number: int) -> tuple[Frame, Frame]:
    """A pair of frames in the units of the first trajectory, their boxes periodic as `informed` says.

    one, other: the trajectories. pairing: of their frames. number: of the pair.
    """
    first, second = one.read(int(pairing.first[number])), other.read(int(pairing.second[number]))
    return informed(first, second.box), informed(converted(second, pairing), first.box)


def informed(frame: Frame, other: Box | None) -> Frame:
    """A frame whose box is periodic as the other file states it, where its own file does not.

    Where neither states it, every axis along which one of them may be periodic is. frame: of one file. other: a box of
    the other file, None: it has none.
    """
    if frame.box is None or frame.box.stated or other is None:
        return frame
    periodic = other.periodic if other.stated else frame.box.periodic | other.periodic
    return frame._replace(box=frame.box._replace(periodic=periodic))


def converted(frame: Frame, pairing: Pairing) -> Frame:
    """A frame of the second trajectory in the units of the first. pairing: has the factors."""
    if pairing.length == pairing.velocity == pairing.spin == 1:
        return frame
    length = pairing.length
    box = frame.box
    if box is not None:
        box = box._replace(vectors=box.vectors * length, lower=box.lower * length)
    return frame._replace(
        positions=frame.positions * length,
        velocities=None if frame.velocities is None else frame.velocities * pairing.velocity,
        spins=None if frame.spins is None else frame.spins * pairing.spin,
        diameters=None if frame.diameters is None else frame.diameters * length,
        box=box,
    )


def roundings_of(one: Source, other: Source, pairing: Pairing) -> dict[str, tuple[Rounding, Rounding]]:
    """By how much the two files have rounded each of `QUANTITIES`, in the units of the first.

    one, other: the trajectories. pairing: has the factors of their units.
    """
    factors = dict.fromkeys(("positions", "diameters", "box"), pairing.length)
    factors |= {"velocities": pairing.velocity, "spins": pairing.spin, "masses": 1.0}
    return {name: (one.rounding[name], _converted(other.rounding[name], factors[name])) for name in QUANTITIES}


def _converted(rounding: Rounding, factor: float) -> Rounding:
    if factor == 1:
        return rounding
    return Rounding(rounding.absolute * factor, rounding.relative + 2 * DOUBLE.relative, rounding.name)


def gap(
    number: int,
    time: float,
    first: Frame,
    second: Frame,
    nearest: bool,
    roundings: dict[str, tuple[Rounding, Rounding]],
) -> Gap:
    """How far two frames are apart.

    number, time: of the pair. first, second: the frames, in the same units. nearest: positions may be in different
    images of the box. roundings: quantity -> of both files.
    """
    rows = common_rows(first.ids, second.ids)
    box = first.box if second.box is None or first.box is not None else second.box
    missing = (len(first.ids) - len(rows[0]), len(second.ids) - len(rows[1]))
    ids = first.ids[rows[0]]
    same = missing == (0, 0)
    beyond = differing = None
    rms: dict[str, float] = {}
    largest: dict[str, float] = {}
    farthest: dict[str, int] = {}
    floor: dict[str, float] = {}
    most: dict[str, float] = {}
    extent = 0.0
    for name in VECTORS:
        parts = [getattr(frame, name) for frame in (first, second)]
        if parts[0] is None or parts[1] is None or not len(ids):
            continue
        mine, yours = parts[0][rows[0]], parts[1][rows[1]]
        apart = mine - yours
        if name == "positions":
            extent = float(np.abs(mine - mine.mean(axis=0)).max()) or float(np.abs(mine).max())
            if nearest and box is not None:
                apart = nearest_image(apart, box)
        allowed = roundings[name][0].of(mine) + roundings[name][1].of(yours)
        if nearest and name == "positions" and box is not None:
            # a whole number of edges was taken away by a code, and rounds once more
            allowed = allowed + DOUBLE.relative * (np.abs(mine) + np.abs(yours))
        same &= bool(np.array_equal(mine, yours))
        differing = differing or _first(number, name, ids, mine, yours, apart, apart != 0, allowed)
        beyond = beyond or _first(number, name, ids, mine, yours, apart, ~(np.abs(apart) <= allowed), allowed)
        distance = np.linalg.norm(apart, axis=1)
        rms[name] = float(np.sqrt(np.mean(distance**2)))
        largest[name] = float(np.max(distance))
        farthest[name] = int(ids[np.argmax(distance)])
        bounds = np.linalg.norm(allowed, axis=1)
        floor[name], most[name] = float(np.sqrt(np.mean(bounds**2))), float(np.max(bounds))
    kinetic = _kinetic(first), _kinetic(second)
    return Gap(
        time,
        same,
        beyond,
        differing,
        rms,
        largest,
        farthest,
        floor,
        most,
        extent,
        len(ids),
        missing,
        kinetic,
        all(map(np.isfinite, rms.values())),
        *_momenta(first, second, roundings["velocities"]),
    )


def _momenta(
    first: Frame, second: Frame, roundings: tuple[Rounding, Rounding]
) -> tuple[tuple[tuple[float, ...], tuple[float, ...]] | None, float, float]:
    """Total momenta, by how much the files' rounding may have changed them, and the sum of absolute values."""
    sums, allowed, scale = [], 0.0, 0.0
    for frame, rounding in zip((first, second), roundings, strict=True):
        if frame.velocities is None or not len(frame.ids):
            return None, 0.0, 0.0
        masses = np.ones(len(frame.ids)) if frame.masses is None else frame.masses
        sums.append(tuple(float(one) for one in masses @ frame.velocities))
        allowed = max(allowed, float(np.linalg.norm(masses @ rounding.of(frame.velocities))))
        scale = max(scale, float(np.linalg.norm(masses @ np.abs(frame.velocities))))
    return (sums[0], sums[1]), allowed, scale


def _kinetic(frame: Frame) -> float | None:
    if frame.velocities is None or not len(frame.ids):
        return None
    masses = 1.0 if frame.masses is None else frame.masses
    return float(np.mean(masses * np.sum(frame.velocities**2, axis=1)) / 2)


def common_rows(mine: Integers, yours: Integers) -> tuple[Integers, Integers]:
    """Rows of the ids that two frames both have, in the same order. mine, yours: ids, ascending."""
    if np.array_equal(mine, yours):
        rows = np.arange(len(mine))
        return rows, rows
    _, first, second = np.intersect1d(mine, yours, assume_unique=True, return_indices=True)
    return first, second


def nearest_image(apart: Floats, box: Box) -> Floats:
    """Differences of positions to the nearest image along the periodic axes of a box, whose edges are reduced.

    apart: differences, (N, 3), length. box: with its periodic axes.
    """
    if not box.around.any():
        return apart
    images = np.rint(apart @ box.shares) * box.around
    return apart - images @ box.vectors if images.any() else apart


def spacing(frame: Frame) -> float:
    """Distance of neighbours, length: that of N particles spread over the box, or over what they take up.

    frame: of them. Along axes without extent there is none.
    """
    number = max(len(frame.ids), 1)
    sides = np.ptp(frame.positions, axis=0) if len(frame.ids) else np.ones(3)
    if frame.box is not None:
        edges = np.linalg.norm(frame.box.vectors, axis=1)
        sides = np.where((edges > 0) & (sides > 0), edges, sides)
    sides = sides[sides > 0]
    if not sides.size:
        return 1.0
    return float(np.prod(sides) / number) ** (1 / sides.size)


def flat_axes(positions: Floats) -> NDArray[np.bool_]:
    """Along which axes no particle is elsewhere than the others, as in the plane, (3,). positions: (N, 3)."""
    return np.asarray(np.ptp(positions, axis=0) == 0)


def _first(
    number: int,
    name: str,
    ids: Integers,
    mine: Floats,
    yours: Floats,
    apart: Floats,
    wrong: NDArray[np.bool_],
    allowed: Floats,
) -> Difference | None:
    """Of the components that are `wrong`, the one with the largest difference `apart`; None if none is."""
    if not wrong.any():
        return None
    size = np.where(wrong, np.where(np.isfinite(apart), np.abs(apart), np.inf), -1.0)
    row, axis = np.unravel_index(int(np.argmax(size)), size.shape)
    values: Any = (float(mine[row, axis]), float(yours[row, axis]), float(allowed[row, axis]))
    return Difference(number, name, int(ids[row]), int(axis), *values)
