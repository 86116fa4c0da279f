"""Configuration files: the particles that a file states, and whether they are those of the scene.

Numbers are taken as they stand in the file, in the scene's own units, to the last bit; no unit is converted. What the
scene leaves out and the file states (masses, species) is taken from the file; what both state must agree; what no scene
can hold (charges, tilted boxes) is refused. Nothing is dropped in silence but results: forces, energies, stresses.

Of several frames the last one is taken. ASE reads .xyz and .extxyz (where it keeps every number), and its own .traj;
LAMMPS dumps are read here, for ASE multiplies their velocities by 0.01018, as if they were in units "metal".
"""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
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
    """What a file states: .npz, .xyz or .extxyz, a LAMMPS dump (text, also .gz), or an ASE .traj.

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
    opened = gzip.open if path.suffix == ".gz" else open
    with opened(path, "rb") as file:
        start = file.read(64)
    if start.startswith(b"ITEM:"):
        return _dump(path, opened)
    if path.suffix in (".xyz", ".extxyz", ".traj"):
        return _ase(path)
    raise ValueError(
        "the formats are .npz, .xyz, .extxyz, ASE's .traj, and LAMMPS dumps in text: convert it, as by `ase convert`, "
        "and check its units"
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
        _whole("species", found["species"]) if "species" in found else None,
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
        _whole("species_number", arrays["species_number"]) if "species_number" in arrays else None,
        names=None if set(symbols) <= {"X"} else symbols,
        lower=np.zeros(3) if boxed else None,
        sides=np.diag(cell) if boxed else None,
        periodic=tuple(map(bool, atoms.pbc)) if boxed else None,
    )


def _dump(path: Path, opened: Any) -> Configuration:
    """The last frame of a LAMMPS dump, particles in the order of their ids."""
    frame: dict[str, list[str]] = {}
    section = ""
    with opened(path, "rt", encoding="utf-8") as file:
        for line in file:
            if line.startswith("ITEM:"):
                section = line[5:].strip()
                if section == "TIMESTEP":
                    frame = {}
                frame[section] = []
            elif line.strip():
                frame[section].append(line)
    titles = {
        name: next((title for title in frame if title.startswith(name)), None) for name in ("BOX BOUNDS", "ATOMS")
    }
    box, atoms = titles["BOX BOUNDS"], titles["ATOMS"]
    if box is None or atoms is None or not frame.get("NUMBER OF ATOMS"):
        raise ValueError("the last frame has no NUMBER OF ATOMS, BOX BOUNDS and ATOMS: it is not complete")
    number = int(frame["NUMBER OF ATOMS"][0])
    if len(frame[atoms]) != number:
        raise ValueError(f"the last frame has {len(frame[atoms])} lines for {number} particles: it is not complete")
    names, rows = atoms.split()[1:], [line.split() for line in frame[atoms]]
    wrong = next((row for row in rows if len(row) != len(names)), None)
    if wrong is not None:
        raise ValueError(f"'{' '.join(wrong)}' has {len(wrong)} values for the columns {' '.join(names)}")
    table = {name: [row[k] for row in rows] for k, name in enumerate(names)}
    if "id" in table:
        ids = _whole("id", _numbers(table["id"]))
        if len(set(ids.tolist())) != number:
            raise ValueError("two particles have the same id")
        order = np.argsort(ids)
        table = {name: [column[k] for k in order] for name, column in table.items()}
    lower, sides, kinds = _bounds(box, frame[box])
    found = _particles(table, lower, sides, tuple(kind == "pp" for kind in kinds))
    # a face that goes with the outermost particle ("s", "m") is no side of a box
    return found._replace(sides=np.where([bool(set(kind) & {"s", "m"}) for kind in kinds], 0.0, sides))


def _bounds(title: str, lines: list[str]) -> tuple[Floats, Floats, list[str]]:
    """Lower corner, sides, and the letters of the boundaries of each axis; ValueError for a tilted box."""
    flags = title.split()[2:]
    rows = [_numbers(line.split()) for line in lines]
    if len(rows) != 3 or any(len(row) < 2 for row in rows):
        raise ValueError("BOX BOUNDS needs three lines of two numbers")
    if "abc" in flags or any(len(row) > 2 and row[2] != 0 for row in rows):
        raise ValueError("its box is tilted, a scene's is not: convert it to an orthogonal one")
    kinds = [flag for flag in flags if flag not in ("xy", "xz", "yz")] or ["ff"] * 3
    low, high = np.array([row[:2] for row in rows]).T
    return low, high - low, kinds


def _particles(table: dict[str, list[str]], lower: Floats, sides: Floats, periodic: tuple[bool, ...]) -> Configuration:
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
        return np.stack([_numbers(table[name]) for name in names], axis=1)

    positions = None
    for suffix, scaled in (("", False), ("s", True), ("u", False), ("su", True)):
        coordinates = vectors([f"{axis}{suffix}" for axis in AXES])
        if coordinates is not None:
            positions = lower + coordinates * sides if scaled else coordinates
            break
    if positions is None:
        raise ValueError("it has no coordinates: dump x y z, xs ys zs, xu yu zu or xsu ysu zsu")
    for axis, name in enumerate(("ix", "iy", "iz")):
        if name in table and not periodic[axis] and np.any(_numbers(table[name])):
            raise ValueError(f"column {name} counts images along an axis that is not periodic")
    for name in _FOREIGN:
        if name in table and np.any(_numbers(table[name])):
            raise ValueError(f"a scene has nothing like column {name}, which is not 0: it cannot start from this dump")
    diameters = _numbers(table["diameter"]) if "diameter" in table else None
    if diameters is None and "radius" in table:
        diameters = 2 * _numbers(table["radius"])
    species = names = None
    if "type" in table and all(value.lstrip("+-").isdigit() for value in table["type"]):
        species = _whole("type", _numbers(table["type"])) - 1
    elif "type" in table or "element" in table:
        names = tuple(table["type" if "type" in table else "element"])
    return Configuration(
        positions,
        vectors(["vx", "vy", "vz"]),
        vectors(["omegax", "omegay", "omegaz"]),
        _numbers(table["mass"]) if "mass" in table else None,
        diameters,
        species,
        names,
        lower,
        sides,
        periodic,
    )


def _numbers(words: Sequence[str]) -> Floats:
    """The nearest doubles of decimal numbers."""
    return np.array([float(word) for word in words])


def _whole(name: str, values: Floats) -> NDArray[np.int64]:
    if not (np.isfinite(values).all() and (values == np.rint(values)).all() and (abs(values) < 2**53).all()):
        raise ValueError(f"{name} must hold whole numbers")
    return values.astype(np.int64)


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
