"""Initial states: lattices, Kepler orbits, random velocities."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.scene.parts import AXES, Explicit, Face, Floats, Gravity, Kepler, Lattice, SceneEntries, Vector

#: Sites of a unit cell, in units of its edges.
_BASES = {
    "fcc": [[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]],
    "sc": [[0, 0, 0]],
    "square": [[0, 0]],
    "triangular": [[0, 0], [0.5, 0.5]],
}
#: A lattice of more than about this many sites a particle is made anew, for boxes that are flat.
_SURPLUS = 100


class State(NamedTuple):
    """The initial state of N particles in d dimensions, in the units of the scene.

    positions: (N, d), length. velocities: (N, d), length/time. masses: (N,), mass. species: (N,), from 0; None: all are
    of one species. lengths: sides of the box, (d,), length; None: open space. diameters: (N,), length; of hard spheres
    only. angular_velocities: (N, 1) in the plane, (N, 3) in space, 1/time; of hard spheres with friction only.
    """

    positions: Floats
    velocities: Floats
    masses: Floats
    species: NDArray[np.int64] | None
    lengths: Floats | None
    diameters: Floats | None = None
    angular_velocities: Floats | None = None


def lattice_sites(initial: Lattice, lengths: Floats) -> Floats:
    """Positions (N, d), length, on the sites of a lattice that fills a box.

    initial: gives structure and N. lengths: sides of the box, (d,), length. UsageError if the structure is not one of d
    dimensions.
    """
    basis, counts = _unit_cells(initial, lengths, initial.number)
    sites = ((_cells(counts)[:, None, :] + basis + 0.25) / counts * lengths).reshape(-1, lengths.size)
    return _spread(sites, initial.number)


def _unit_cells(initial: Lattice, lengths: Floats, number: int) -> tuple[Floats, NDArray[np.int64]]:
    """The basis (sites, d) of the structure, and the least numbers of unit cells (d,) with at least `number` sites."""
    basis = np.array(_BASES[initial.structure])
    if basis.shape[1] != lengths.size:
        raise UsageError(
            f"initial.structure = '{initial.structure}' fills {basis.shape[1]} dimensions, "
            f"the scene has {lengths.size}: take another structure"
        )
    # unit cells as near to their ideal shape as the box allows; sites are left empty at the end
    cell = np.ones(lengths.size)
    if initial.structure == "triangular":
        cell[1] = 3**0.5
    sides = lengths / cell
    counts = _counts(sides, number / len(basis), np.zeros(lengths.size, dtype=bool))
    flat = np.zeros(lengths.size, dtype=bool)
    while np.prod(counts) * len(basis) > _SURPLUS * number + _SURPLUS and not flat.all():
        # a box that is flat along some axes, one cell there: without it the others have no more cells than they need
        flat[np.argmin(np.where(flat, np.inf, sides))] = True
        counts = _counts(sides, number / len(basis), flat)
    while np.prod(counts) * len(basis) < number:
        counts[np.argmax(sides / counts)] += 1
    return basis, counts.astype(np.int64)


def _counts(sides: Floats, cells: float, flat: NDArray[np.bool_]) -> Floats:
    """How many of about `cells` cells, of nearly equal edges, go into each side, (d,); one along axes that are flat."""
    if flat.all():
        return np.ones(sides.size)
    edge = (np.prod(sides[~flat]) / cells) ** (1.0 / np.count_nonzero(~flat))
    return np.where(flat, 1.0, np.maximum(1.0, np.floor(sides / edge + 1e-9)))


def _cells(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Indices of all unit cells, (cells, d), the last axis fastest."""
    return np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, counts.size)


def _spread(sites: Floats, number: int) -> Floats:
    """`number` of the sites, at even distances in their order."""
    keep = np.linspace(0, len(sites) - 1, number).round().astype(int)
    return np.ascontiguousarray(sites[keep])


def lattice_sites_inside(initial: Lattice, scene: SceneEntries, lengths: Floats, radius: float) -> Floats:
    """Positions (N, d) on the sites of a lattice inside hard walls and cylinder, all in units of length.

    The lattice is compressed between walls where it would not fit otherwise. initial: gives structure and N. scene:
    gives the walls. lengths: sides of the box, (d,). radius: of the particles. UsageError if the structure is not one
    of d dimensions, or if a single particle does not fit between the walls.
    """
    assert scene.box is not None
    cylinder = scene.box.cylinder
    margins = radius + wall_strokes(scene.faces).max(axis=1)
    across = np.isin(np.arange(scene.dimension), scene.across)
    room = lengths
    if cylinder is not None:
        if cylinder.radius <= radius:
            raise UsageError(f"box.cylinder.radius = {cylinder.radius:g} must exceed that of the particles, {radius:g}")
        room = np.where(across, 2 * (cylinder.radius - radius), lengths)
        margins = np.where(across, (lengths - room) / 2, margins)
    bounded = np.array([boundary == "hard" for boundary in scene.boundaries]) | across
    narrow = bounded & (lengths < 2 * margins)
    if narrow.any():
        axis = int(narrow.argmax())
        raise UsageError(
            f"box: {lengths[axis]:.6g} along {AXES[axis]} is too narrow for a particle of diameter {2 * radius:g} "
            "between its walls: take a larger box"
        )

    def sites(number: int) -> Floats:
        basis, counts = _unit_cells(initial, room, number)
        cells = _cells(counts)[:, None, :] + basis
        # between walls: in the middle, and no nearer to a wall than a particle's surface may be
        last = counts - 1 + basis.max(axis=0)
        width = np.minimum(last / counts * room, lengths - 2 * margins)
        between = (lengths - width) / 2 + width * cells / np.where(last > 0, last, 1)
        return np.where(bounded, between, (cells + 0.25) / counts * lengths).reshape(-1, scene.dimension)

    number, found = initial.number, sites(initial.number)
    while cylinder is not None:
        distances = np.linalg.norm((found - lengths / 2)[:, across], axis=1)
        found = found[distances <= cylinder.radius - radius]
        if len(found) >= initial.number:
            break
        number += max(1, number // 20)
        if number > _SURPLUS * initial.number + _SURPLUS:
            raise UsageError(
                f"box.cylinder.radius = {cylinder.radius:g} leaves no room for {initial.number} particles of diameter "
                f"{2 * radius:g}: make it larger"
            )
        found = sites(number)
    return _spread(found, initial.number)


def random_velocities(initial: Lattice, masses: Floats, dimension: int, fixed: NDArray[np.bool_]) -> Floats:
    """Random velocities (N, d), length/time, of the temperature or of the speed that `initial` gives.

    masses: (N,), mass. dimension: d. fixed: (N,), particles that never move. At a temperature T the total momentum is
    removed and the kinetic energy is exactly (d/2) (N - 1) T; with fixed particles it is (d/2) N_moving T, and the
    momentum is not removed.
    """
    rng = np.random.default_rng(initial.seed)
    velocities = rng.normal(size=(masses.size, dimension))
    velocities[fixed] = 0.0
    if initial.temperature is None:
        norms = np.linalg.norm(velocities, axis=1, keepdims=True)
        return (initial.speed or 0.0) * np.divide(velocities, norms, out=velocities, where=norms > 0)
    velocities /= np.sqrt(masses)[:, None]
    freedom = masses.size - 1 if not fixed.any() else np.count_nonzero(~fixed)
    if freedom == 0 or initial.temperature == 0:
        return np.zeros_like(velocities)
    if not fixed.any():
        velocities -= (masses[:, None] * velocities).sum(axis=0) / masses.sum()
    kinetic = 0.5 * (masses[:, None] * velocities**2).sum()
    return velocities * np.sqrt(0.5 * dimension * freedom * initial.temperature / kinetic)


def apocentre(initial: Kepler, masses: Floats, gravity: Gravity | None, dimension: int) -> tuple[Floats, Floats]:
    """Positions and velocities, (2, d) each, of two bodies at apocentre on the x axis, moving along y.

    Their distance is a (1 + e), their relative speed sqrt(G M (1 - e)/(a (1 + e))), with the total mass M. initial:
    gives a and e. masses: (2,), mass. gravity: gives G. dimension: d. UsageError without gravity, in dimension 1, or if
    both masses are 0.
    """
    if gravity is None or dimension == 1:
        raise UsageError("initial.kind = 'kepler' needs [gravity] and dimension 2 or 3")
    a, e, total = initial.semi_major_axis, initial.eccentricity, masses.sum()
    if total == 0:
        raise UsageError("masses: one of the two bodies of initial.kind = 'kepler' needs a mass")
    r, v = np.zeros((2, dimension)), np.zeros((2, dimension))
    share = np.array([-masses[1], masses[0]]) / total
    r[:, 0] = share * a * (1 + e)
    v[:, 1] = share * np.sqrt(gravity.G * total * (1 - e) / (a * (1 + e)))
    return r, v


def explicit(positions: Floats, velocities: Floats, angular_velocities: Floats | None = None) -> Explicit:
    """An initial state from arrays.

    positions: (N, d), length. velocities: (N, d), length/time. angular_velocities: (N, 1) in the plane, (N, 3) in
    space, 1/time; None: no rotation.
    """

    def rows(array: Floats) -> tuple[Vector, ...]:
        return tuple(map(tuple, array.tolist()))

    return Explicit(
        positions=rows(positions),
        velocities=rows(velocities),
        angular_velocities=None if angular_velocities is None else rows(angular_velocities),
    )


def check_rows(initial: Explicit, dimension: int) -> None:
    """ValueError unless all tables of `initial` have one row per particle, with the components of this dimension."""
    if not initial.positions:
        raise ValueError("initial.positions is empty: give at least one particle")
    table = {
        "positions": (initial.positions, dimension),
        "velocities": (initial.velocities, dimension),
        "angular_velocities": (initial.angular_velocities, 1 if dimension == 2 else 3),
    }
    for name, (rows, components) in table.items():
        if rows is None:
            continue
        if len(rows) != len(initial.positions):
            raise ValueError(f"initial.{name} has {len(rows)} rows for {len(initial.positions)} particles")
        for i, row in enumerate(rows):
            if len(row) != components:
                raise ValueError(f"initial.{name}[{i}] has {len(row)} components in dimension {dimension}")


def wall_strokes(faces: tuple[Face | None, ...]) -> Floats:
    """Amplitudes (d, 2), in units of length, with which the lower and upper walls of each axis oscillate; 0 at rest.

    faces: 2d entries x-, x+, y-, y+ ...; None: no wall.
    """
    strokes = [0.0 if face is None or face.oscillation is None else face.oscillation.amplitude for face in faces]
    return np.reshape(strokes, (-1, 2))


def refuse_not_finite(state: State) -> None:
    """UsageError if a number of an initial state, computed from those of the scene, is beyond all numbers.

    state: all of it.
    """
    for name, values in (("positions", state.positions), ("velocities", state.velocities), ("box", state.lengths)):
        if values is not None and not np.isfinite(values).all():
            raise UsageError(f"initial: {name} are not finite: the numbers of the scene are too large or too small")


def refuse_coincidence(positions: Floats, lengths: Floats | None, periodic: Iterable[bool]) -> None:
    """UsageError that names two particles in the same place, if there are any.

    positions: (N, d), length. lengths: sides of the box, (d,), length; None: open space. periodic: which axes are,
    (d,).
    """
    wrapped = positions.copy()
    if lengths is not None:
        for axis, wraps in enumerate(periodic):
            if wraps:
                wrapped[:, axis] %= lengths[axis]
    order = np.lexsort(wrapped.T)
    same = np.flatnonzero((np.diff(wrapped[order], axis=0) == 0).all(axis=1))
    if same.size:
        i, j = sorted(order[same[0] : same[0] + 2])
        raise UsageError(f"particles {i} and {j} are at the same place: move one of them")
