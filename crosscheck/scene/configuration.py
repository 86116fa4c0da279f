"""Configuration files: the particles that a file states, and whether they are those of the scene.

Numbers are taken as they stand in the file, in the scene's own units, to the last bit; no unit is converted. What the
scene leaves out and the file states (masses, species) is taken from the file; what both state must agree; what no scene
can hold (charges, tilted boxes) is refused. Nothing is dropped in silence but results: forces, energies, stresses.

Of several frames the last one is taken. ASE reads .xyz and .extxyz (where it keeps every number), and its own .traj;
`lammps_dump` reads dumps, text or binary.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.columns import whole
from crosscheck.errors import UsageError
from crosscheck.lammps_dump import dump_index, is_dump, opened, read_frame
from crosscheck.scene.parts import AXES, Floats, SceneEntries
from crosscheck.scene.starts import explicit

#: Relative difference of two numbers of which one was printed with six digits, as by "%g": half a unit of the last one.
_PRINTED = 5e-6
#: Arrays that an .npz file may hold.
_ARRAYS = ("positions", "velocities", "angular_velocities", "masses", "species", "diameters", "lengths")
#: Columns of a dump that only the particles of other simulations have; they may be there if they are 0.
_FOREIGN = ("q", "mux", "muy", "muz", "angmomx", "angmomy", "angmomz")


class Configuration(NamedTuple):
    """N particles as a file states them, and the box; what it does not state is None.

    positions, velocities: (N, k), k the number of coordinates in the file. spins: (N, 1) or (N, 3). masses, diameters:
    (N,). species: (N,), from 0. names: (N,) names of elements or types, of a file without numbers of species. lower,
    sides, periodic: (k,), of the box: its lower corner, its sides, 0 along an axis without one, and which are periodic.
    """

    positions: Floats
    velocities: Floats | None = None
    spins: Floats | None = None
    masses: Floats | None = None
    diameters: Floats | None = None
    species: NDArray[np.int64] | None = None
    names: tuple[str, ...] | None = None
    lower: Floats | None = None
    sides: Floats | None = None
    periodic: tuple[bool, ...] | None = None


def read_configuration(path: Path) -> Configuration:
    """What a file states: .npz, .xyz or .extxyz, a LAMMPS dump (text, also .gz, or binary), or an ASE .traj.

    path: of the file. UsageError if it cannot be read, or holds numbers that are not finite.
    """
    try:
        if not path.is_file():
            raise ValueError("there is no such file" if not path.exists() else "it is not a regular file")
        found = _reader(path)
    except UsageError:
        raise
    except Exception as error:
        reason = str(error) or type(error).__name__
        raise UsageError(f"initial.path = {path}: cannot be read as a configuration ({reason})") from None
    for name in ("positions", "velocities", "masses", "diameters"):
        vectors = getattr(found, name)
        if vectors is not None and not np.isfinite(vectors).all():
            raise UsageError(f"initial.path = {path}: {name} holds values that are not finite")
    if found.spins is not None and not np.isfinite(found.spins).all():
        raise UsageError(f"initial.path = {path}: angular_velocities holds values that are not finite")
    if found.spins is not None and found.spins.ndim != 2:
        raise UsageError(f"initial.path = {path}: angular_velocities needs two dimensions, found {found.spins.ndim}")
    return found


def _reader(path: Path) -> Configuration:
    if path.suffix == ".npz":
        return _npz(path)
    if is_dump(path):
        return _dump(path)
    if path.suffix in (".xyz", ".extxyz", ".traj"):
        return _ase(path)
    raise ValueError(
        "the formats are .npz, .xyz, .extxyz, ASE's .traj, and LAMMPS dumps: convert it, as by `ase convert`, and "
        "check its units"
    )


# -- readers ---------------------------------------------------------------------------------------------------


def _npz(path: Path) -> Configuration:
    with np.load(path, allow_pickle=False) as arrays:
        if "positions" not in arrays:
            raise ValueError("there is no array positions")
        unknown = [name for name in arrays if name not in _ARRAYS]
        if unknown:
            raise ValueError(f"array {unknown[0]} is not one of {', '.join(_ARRAYS)}: remove it")
        found: dict[str, Any] = {name: np.asarray(arrays[name], dtype=np.float64) for name in arrays}
    for name in ("positions", "velocities"):
        if name in found and found[name].ndim != 2:
            raise ValueError(f"{name} needs the shape (N, d), found {found[name].shape}")
    number, axes = found["positions"].shape
    for name, length in (("masses", number), ("species", number), ("diameters", number), ("lengths", axes)):
        if name in found and found[name].shape != (length,):
            raise ValueError(f"{name} needs the shape ({length},), found {found[name].shape}")
    sides = found.get("lengths")
    return Configuration(
        found["positions"],
        found.get("velocities"),
        found.get("angular_velocities"),
        found.get("masses"),
        found.get("diameters"),
        whole("species", found["species"]) if "species" in found else None,
        lower=None if sides is None else np.zeros(axes),
        sides=sides,
    )


def _ase(path: Path) -> Configuration:
    """The last frame; velocities are its column of that name, else momenta over masses, which is what ASE writes."""
    import ase.io

    atoms = ase.io.read(path, index=-1, format="traj" if path.suffix == ".traj" else "extxyz")
    assert not isinstance(atoms, list)
    arrays = atoms.arrays
    cell = np.array(atoms.cell)
    _refuse_tilt(cell)
    velocities = arrays.get("velocities")
    if velocities is None and "momenta" in arrays:
        velocities = np.asarray(atoms.get_velocities())
    for name in ("initial_charges", "initial_magmoms"):
        if name in arrays and np.any(arrays[name]):
            raise ValueError(f"a scene has no {name.removeprefix('initial_')}: remove that column")
    symbols = tuple(atoms.get_chemical_symbols())
    boxed = bool(cell.any())  # without a lattice a file says nothing of the box
    return Configuration(
        arrays["positions"],
        velocities,
        arrays.get("angular_velocities"),
        arrays.get("masses"),
        2 * arrays["radius"] if "radius" in arrays else None,
        whole("species_number", arrays["species_number"]) if "species_number" in arrays else None,
        names=None if set(symbols) <= {"X"} else symbols,
        lower=np.zeros(3) if boxed else None,
        sides=np.diag(cell) if boxed else None,
        periodic=tuple(map(bool, atoms.pbc)) if boxed else None,
    )


def _dump(path: Path) -> Configuration:
    """The last frame of a LAMMPS dump, particles in the order of their ids."""
    index = dump_index(path)
    if index.cut or not index.keys:
        raise ValueError(index.cut or "there is no frame")
    with opened(path) as file:
        frame = read_frame(file, index.keys[-1])
    columns = frame.columns
    if "id" in columns:
        ids = columns["id"]
        if len(set(ids.tolist())) != len(ids):
            raise ValueError("two particles have the same id")
        order = np.argsort(ids)
        columns = {name: column[order] for name, column in columns.items()}
    _refuse_tilt(frame.vectors)
    sides = np.diag(frame.vectors)
    found = _particles(columns, frame.lower, sides, tuple(kind == "pp" for kind in frame.boundary))
    # a face that goes with the outermost particle ("s", "m") is no side of a box
    return found._replace(sides=np.where([bool(set(kind) & {"s", "m"}) for kind in frame.boundary], 0.0, sides))


def _particles(
    table: dict[str, NDArray[Any]], lower: Floats, sides: Floats, periodic: tuple[bool, ...]
) -> Configuration:
    """The particles in the columns of a dump.

    Coordinates in the box ("x", "xs") come before unwrapped ones ("xu", "xsu"); image flags beside them say in which
    copy of the box a particle was, which is the same configuration.
    """

    def vectors(names: Sequence[str]) -> Floats | None:
        held = [name for name in names if name in table]
        if not held:
            return None
        if len(held) < len(names):
            raise ValueError(f"column {held[0]} is there, but not all of {', '.join(names)}")
        return np.stack([table[name] for name in names], axis=1)

    positions = None
    for suffix, scaled in (("", False), ("s", True), ("u", False), ("su", True)):
        coordinates = vectors([f"{axis}{suffix}" for axis in AXES])
        if coordinates is not None:
            positions = lower + coordinates * sides if scaled else coordinates
            break
    if positions is None:
        raise ValueError("it has no coordinates: dump x y z, xs ys zs, xu yu zu or xsu ysu zsu")
    for axis, name in enumerate(("ix", "iy", "iz")):
        if name in table and not periodic[axis] and np.any(table[name]):
            raise ValueError(f"column {name} counts images along an axis that is not periodic")
    for name in _FOREIGN:
        if name in table and np.any(table[name]):
            raise ValueError(f"a scene has nothing like column {name}, which is not 0: it cannot start from this dump")
    diameters = table.get("diameter")
    if diameters is None and "radius" in table:
        diameters = 2 * table["radius"]
    kinds = next((table[name] for name in ("type", "typelabel", "element") if name in table), None)
    numbered = kinds is not None and kinds.dtype.kind == "i"
    return Configuration(
        positions,
        vectors(["vx", "vy", "vz"]),
        vectors(["omegax", "omegay", "omegaz"]),
        table.get("mass"),
        diameters,
        kinds - 1 if kinds is not None and numbered else None,
        None if kinds is None or numbered else tuple(kinds.tolist()),
        lower,
        sides,
        periodic,
    )


def _refuse_tilt(cell: Floats) -> None:
    if np.any(cell - np.diag(np.diag(cell))):
        raise ValueError("its box is tilted, a scene's is not: convert it to an orthogonal one")


# -- against the scene -----------------------------------------------------------------------------------------


def entries_from(found: Configuration, scene: SceneEntries, path: Path) -> dict[str, Any]:
    """Entries of a scene that come from a file: initial, and masses and species where the scene does not give them.

    found: what the file states. scene: the scene that starts from it. path: of the file, for messages. UsageError if
    the file states coordinates or rotation that the scene has not.
    """
    d = scene.dimension
    entries: dict[str, Any] = {
        "initial": explicit(
            _in_dimension(found.positions, d, "positions", path),
            np.zeros((len(found.positions), d))
            if found.velocities is None
            else _in_dimension(found.velocities, d, "velocities", path),
            _spins(found.spins, scene, path),
        )
    }
    if found.masses is not None and "masses" not in scene.model_fields_set:
        one = (found.masses == found.masses[0]).all()
        entries["masses"] = float(found.masses[0]) if one else tuple(found.masses.tolist())
    if scene.species is None:
        species = found.species
        if species is None and found.names is not None:
            species = np.unique(_atomic_numbers(found.names), return_inverse=True)[1]
        if species is not None and (species != species[0]).any():
            entries["species"] = tuple(int(one) for one in species)
    return entries


def _in_dimension(vectors: Floats, d: int, name: str, path: Path) -> Floats:
    """The first d components; UsageError if the others say anything."""
    beyond = vectors[:, d:]
    if np.any(beyond - beyond[:1] if name == "positions" else beyond):
        axis = AXES[d : vectors.shape[1]]
        raise UsageError(
            f"initial.path = {path}: {name} differ along {axis[0]}, and the scene has dimension {d}: "
            "give the dimension of the file, or project it"
        )
    return vectors[:, :d]


def _spins(spins: Floats | None, scene: SceneEntries, path: Path) -> Floats | None:
    if spins is None:
        return None
    if not scene.spin_dimension:
        if np.any(spins):
            raise UsageError(
                f"initial.path = {path}: particles rotate, those of the scene do not: add [hard_spheres.friction]"
            )
        return None
    if scene.spin_dimension == 1 and spins.shape[1] == 3:
        if np.any(spins[:, :2]):
            raise UsageError(f"initial.path = {path}: particles do not rotate about z, as those in a plane do")
        return spins[:, 2:]
    return spins


def _atomic_numbers(names: tuple[str, ...]) -> NDArray[Any]:
    """Numbers by which to order names: atomic numbers of elements, else the names themselves."""
    from ase.data import atomic_numbers

    if all(name in atomic_numbers for name in names):
        return np.array([atomic_numbers[name] for name in names])
    return np.array(names)


def check_against(
    found: Configuration,
    scene: SceneEntries,
    path: Path,
    *,
    lengths: Floats | None,
    diameters: Floats | None,
) -> None:
    """UsageError, with the numbers of both, if a file states other particles or another box than the scene.

    found: what the file states. scene: with the entries of `entries_from`. path: of the file, for messages. lengths:
    sides of the scene's box, (d,), length; None: open space. diameters: of its hard spheres, (N,), length; None: it has
    others.
    """

    def refuse(what: str, there: Any, here: Any, mend: str) -> None:
        raise UsageError(f"initial.path = {path}: {what} is {there} in the file, {here} in the scene: {mend}")

    number = len(found.positions)
    masses = np.broadcast_to(np.asarray(scene.masses, dtype=np.float64), (number,)) if _fits(scene, number) else None
    for name, there, here in (("mass", found.masses, masses), ("diameter", found.diameters, diameters)):
        if there is not None and here is not None and len(here) == number:
            off = np.flatnonzero(abs(there - here) > _PRINTED * abs(here))
            if off.size:
                i = int(off[0])
                refuse(f"the {name} of particle {i}", f"{there[i]:g}", f"{here[i]:g}", "give the one that is right")
    if found.diameters is not None and diameters is None and np.any(found.diameters):
        raise UsageError(f"initial.path = {path}: particles have diameters, which only [hard_spheres] have")
    species = np.zeros(number, dtype=np.int64) if scene.species is None else np.array(scene.species)
    if len(species) == number:
        _check_species(found, species, refuse)
    if found.sides is not None:
        _check_box(found, scene, lengths, refuse)


def _fits(scene: SceneEntries, number: int) -> bool:
    return isinstance(scene.masses, float) or len(scene.masses) == number


def _check_species(found: Configuration, species: NDArray[np.int64], refuse: Any) -> None:
    """Numbers must be equal; names must go with one species each, and the other way round."""
    if found.species is not None and (found.species != species).any():
        if (found.species == found.species[0]).all() and (species == species[0]).all():
            return
        i = int(np.flatnonzero(found.species != species)[0])
        refuse(f"the species of particle {i}", found.species[i], species[i], "types 1, 2 ... are the species 0, 1 ...")
    if found.names is not None:
        pairs = set(zip(found.names, species.tolist(), strict=True))
        if len(pairs) == len(set(found.names)) == len(set(species.tolist())):
            return
        for i, (name, one) in enumerate(zip(found.names, species.tolist(), strict=True)):
            if sum(other == name for other, _ in pairs) > 1 or sum(other == one for _, other in pairs) > 1:
                refuse(f"the species of particle {i}", name, one, "one name must go with one species throughout")


def _check_box(found: Configuration, scene: SceneEntries, lengths: Floats | None, refuse: Any) -> None:
    assert found.sides is not None
    periodic = found.periodic
    for k, boundary in enumerate(scene.boundaries):
        axis = AXES[k]
        if periodic is not None and periodic[k] != (boundary == "periodic"):
            words = ("periodic", "not periodic") if periodic[k] else ("not periodic", "periodic")
            refuse(f"the box along {axis}", *words, "make [box] that of the file")
        if lengths is None or boundary == "open" or found.sides[k] == 0:
            continue  # the file's box is only what its particles take up, or there is none
        if abs(found.sides[k] - lengths[k]) > _PRINTED * lengths[k]:
            refuse(
                f"the box along {axis}", f"{found.sides[k]:.10g}", f"{lengths[k]:.10g}", "make box.lengths the file's"
            )
        lower = 0.0 if found.lower is None else float(found.lower[k])
        if boundary != "periodic" and abs(lower) > _PRINTED * lengths[k]:
            refuse(f"the lower wall along {axis}", f"at {lower:g}", "at 0", "shift the file")
