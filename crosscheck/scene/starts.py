"""Where particles start: lattices, orbits, random velocities, configuration files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.scene.hard_spheres import wall_strokes
from crosscheck.scene.parts import AXES, Explicit, Floats, Gravity, Kepler, Lattice, Vector

if TYPE_CHECKING:
    from crosscheck.scene.scene import Scene

_BASES = {
    "fcc": [[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]],
    "sc": [[0, 0, 0]],
    "square": [[0, 0]],
    "triangular": [[0, 0], [0.5, 0.5]],
}


def lattice_sites(initial: Lattice, lengths: Floats) -> Floats:
    basis, counts = _unit_cells(initial, lengths, initial.number)
    sites = ((_cells(counts)[:, None, :] + basis + 0.25) / counts * lengths).reshape(-1, lengths.size)
    return _spread(sites, initial.number)


def _unit_cells(initial: Lattice, lengths: Floats, number: int) -> tuple[Floats, NDArray[np.int64]]:
    """The basis, and how many unit cells along each axis have at least `number` sites."""
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
    edge = (np.prod(lengths / cell) * len(basis) / number) ** (1.0 / lengths.size)
    counts = np.maximum(1, np.floor(lengths / (cell * edge) + 1e-9)).astype(int)
    while np.prod(counts) * len(basis) < number:
        counts[np.argmax(lengths / (cell * counts))] += 1
    return basis, counts


def _cells(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, counts.size)


def _spread(sites: Floats, number: int) -> Floats:
    """`number` of the sites, evenly out of their order."""
    keep = np.linspace(0, len(sites) - 1, number).round().astype(int)
    return np.ascontiguousarray(sites[keep])


def lattice_sites_inside(initial: Lattice, scene: Scene, lengths: Floats, radius: float) -> Floats:
    """Sites for particles of this radius inside hard walls, between which the lattice is compressed where need be."""
    assert scene.box is not None
    cylinder = scene.box.cylinder
    margins = radius + wall_strokes(scene).max(axis=1)
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
        found = sites(number)
    return _spread(found, initial.number)


def random_velocities(initial: Lattice, masses: Floats, dimension: int, fixed: NDArray[np.bool_]) -> Floats:
    """Of one temperature or one speed; the fixed ones' are zero, and then the others' total momentum is not."""
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


def read_configuration(path: Path, dimension: int) -> Explicit:
    spins = None
    try:
        if path.suffix == ".npz":
            with np.load(path) as arrays:
                positions = np.asarray(arrays["positions"], dtype=np.float64)
                velocities = np.asarray(arrays.get("velocities", np.zeros_like(positions)), dtype=np.float64)
                if "angular_velocities" in arrays:
                    spins = np.asarray(arrays["angular_velocities"], dtype=np.float64)
        else:
            import ase.io

            atoms = ase.io.read(path)
            assert not isinstance(atoms, list)
            positions, velocities = atoms.get_positions(), atoms.get_velocities()
        positions, velocities = positions[:, :dimension], velocities[:, :dimension]
    except Exception as error:
        raise UsageError(f"initial.path = {path}: cannot be read as a configuration ({error})") from None
    for name, vectors in (("positions", positions), ("velocities", velocities), ("angular_velocities", spins)):
        if vectors is not None and not np.isfinite(vectors).all():
            raise UsageError(f"initial.path = {path}: {name} holds values that are not finite")
    if spins is not None and spins.ndim != 2:
        raise UsageError(f"initial.path = {path}: angular_velocities needs two dimensions, found {spins.ndim}")
    return explicit(positions, velocities, spins)


def explicit(positions: Floats, velocities: Floats, angular_velocities: Floats | None = None) -> Explicit:
    """Arrays of shape (N, d), and (N, 1 | 3) for the angular velocities, as an initial state."""

    def rows(array: Floats) -> tuple[Vector, ...]:
        return tuple(map(tuple, array.tolist()))

    return Explicit(
        positions=rows(positions),
        velocities=rows(velocities),
        angular_velocities=None if angular_velocities is None else rows(angular_velocities),
    )
