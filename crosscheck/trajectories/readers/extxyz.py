"""XYZ and extended XYZ, also gzipped: the second line of a frame read by ASE, the numbers by numpy.

ASE's own reader drops names that are no elements, and takes a time, an id or a mass only by some of their names.
"""

from __future__ import annotations

import gzip
import itertools
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from crosscheck.columns import SAMPLE, printed, read_columns, whole
from crosscheck.trajectories.frames import DOUBLE, EXACT, Box, Cut, Floats, Frame, Rounding, Source, Units, ordered
from crosscheck.trajectories.rounding import of_decimals
from crosscheck.trajectories.vectors import in_space

FORMAT = "extended XYZ"
HOLDS = "frames"

#: Quantities of `Frame` and names of their columns, in lower case; radius and momenta lead to diameters and velocities.
_NAMES = {
    "ids": ("id", "ids", "atom_id"),
    "types": ("species_number", "species", "type", "types", "z"),
    "positions": ("pos", "positions", "position"),
    "velocities": ("velocities", "velocity", "velo", "vel"),
    "momenta": ("momenta",),
    "spins": ("angular_velocities", "angular_velocity", "omega"),
    "masses": ("masses", "mass"),
    "diameters": ("diameters", "diameter"),
    "radii": ("radius", "radii"),
}
#: Keys of the second line, in lower case.
_TIMES, _STEPS = ("time",), ("step", "timestep", "i")
#: Time and step in the second line of plain XYZ, such as "Atoms. Timestep: 20 Time: 0.1".
_TIME = re.compile(r"\btime *[:=] *([-+.\deE]+)", re.IGNORECASE)
_STEP = re.compile(r"\b(?:time ?)?step *[:=]? *(\d+)", re.IGNORECASE)
_LATTICE = re.compile(r'\blattice *= *"([^"]*)"', re.IGNORECASE)
#: Columns of plain XYZ.
_PLAIN = "species:S:1:pos:R:3"
_DAMAGED = (ValueError, EOFError, OSError, zlib.error)


class _Head(NamedTuple):
    """Where a frame begins (bytes, of the text without compression), its number of particles, its second line, and what
    this says by keys in lower case."""

    offset: int
    number: int
    comment: str
    known: dict[str, Any]


@dataclass(frozen=True)
class _Xyz(Source):
    heads: tuple[_Head, ...] = ()

    @cached_property
    def _file(self) -> IO[bytes]:
        return _opened(self.path)

    def _frame(self, index: int) -> Frame:
        head = self.heads[index]
        self._file.seek(head.offset)
        rows = list(itertools.islice(self._file, head.number + 2))[2:]
        step = None if self.steps is None else int(self.steps[index])
        return ordered(_as_frame(rows, head.known, float(self.times[index]), step))


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return path.name.endswith((".xyz", ".extxyz", ".xyz.gz", ".extxyz.gz"))


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens the file. path: of the file. topology: not used. ValueError, with the reason, if no frame of it is whole.

    Times are those of the key `time` of the second line of each frame, steps those of `step` or `timestep`.
    """
    heads: list[_Head] = []
    sample: tuple[_Head, list[bytes]] | None = None
    remarks: list[str] = []
    try:
        for head, rows in _heads(path):
            heads.append(head)
            sample = (head, rows) if rows else sample
    except _DAMAGED as error:
        if not heads:
            raise
        remarks.append(Cut.after(len(heads), error))
    if not heads:
        raise ValueError("there is no frame")
    times = np.array([_number(head.known, _TIMES) for head in heads])
    steps = np.array([_number(head.known, _STEPS) for head in heads])
    numbered = bool(np.isfinite(steps).all() and (steps == np.rint(steps)).all())
    if numbered and len(set(times)) < len(set(steps)) and np.isfinite(times).all():
        remarks.append("its times have too few digits to tell the frames apart: its steps are taken.")
        times = np.full(len(heads), np.nan)
    elif 0 < np.isfinite(times).sum() < len(times):
        remarks.append(f"{int(np.isnan(times).sum())} of {len(times)} frames state no time.")
    rounding = dict(EXACT)
    if sample is None:
        remarks.append("none of its frames has particles.")
    else:
        remarks += _lost(*sample)
        rounding |= _rounding(*sample)
    return _Xyz(
        path,
        FORMAT,
        times,
        steps.astype(np.int64) if numbered else None,
        "wrapped",
        Units(),
        rounding,
        tuple(remarks),
        tuple(heads),
    )


def _opened(path: Path) -> IO[bytes]:
    return gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb")  # type: ignore[return-value]


def _heads(path: Path) -> Iterator[tuple[_Head, list[bytes]]]:
    """The head of each frame, and its first rows. ValueError for a frame that is cut."""
    with _opened(path) as file:
        while True:
            offset = file.tell()
            first = file.readline()
            if not first:
                return
            if not first.strip():
                continue
            if not first.strip().isdigit():
                text = first[:40].decode("utf-8", "replace").strip()
                raise ValueError(f"'{text}' stands where a number of particles is due")
            number = int(first)
            comment = file.readline().decode("utf-8", "replace").strip()
            rows, count, line = [], 0, b"\n"
            for line in itertools.islice(file, number):
                if count < SAMPLE:
                    rows.append(line)
                count += 1
            if not line.endswith(b"\n"):
                count -= 1  # the last number may have lost digits
            if count < number:
                raise ValueError(f"the last frame has {count} whole lines for {number} particles: it is not complete")
            yield _Head(offset, number, comment, _keys(comment)), rows


def _keys(comment: str) -> dict[str, Any]:
    """Keys and values of the second line of a frame, the keys in lower case."""
    from ase.io.extxyz import key_val_str_to_dict

    known: dict[str, Any] = {}
    if "=" in comment:
        known = {key.lower(): value for key, value in key_val_str_to_dict(comment).items()}
    if "properties" not in known:
        for name, pattern in (("time", _TIME), ("step", _STEP)):
            found = pattern.search(comment)
            if found and name not in known:
                known[name] = float(found[1])
    return known


def _number(known: dict[str, Any], names: tuple[str, ...]) -> float:
    """The first of these keys that is a number; NaN if none is."""
    for name in names:
        value = known.get(name)
        if isinstance(value, int | float | np.number) and not isinstance(value, bool):
            return float(value)
    return float("nan")


class _Property(NamedTuple):
    """names: of its columns. words: whether they hold words."""

    names: tuple[str, ...]
    words: bool


def _properties(known: dict[str, Any], rows: list[bytes]) -> tuple[dict[str, _Property], list[str]]:
    """Properties by their names in lower case, and further columns, which plain XYZ has without names."""
    stated = known.get("properties")
    parts = str(stated or _PLAIN).split(":")
    if len(parts) % 3 or not all(width.isdigit() for width in parts[2::3]):
        raise ValueError(f"Properties={stated} is no list of name:type:number")
    found: dict[str, _Property] = {}
    count = 0
    for name, kind, width in zip(parts[::3], parts[1::3], map(int, parts[2::3]), strict=True):
        names = (name,) if width == 1 else tuple(f"{name}_{k + 1}" for k in range(width))
        found[name.lower()] = _Property(names, kind.upper() in ("S", "L"))
        count += width
    more = len(rows[0].split()) - count if rows and not stated else 0
    return found, [f"column{count + k + 1}" for k in range(max(more, 0))]


def _all_names(properties: dict[str, _Property], unnamed: list[str]) -> list[str]:
    return [*(name for one in properties.values() for name in one.names), *unnamed]


def _values(rows: list[bytes], known: dict[str, Any]) -> dict[str, Any]:
    """Quantities of the columns of a frame, by the names of `_NAMES`: (N,) or (N, k)."""
    properties, unnamed = _properties(known, rows)
    words = {name for one in properties.values() if one.words for name in one.names}
    table = read_columns(rows, _all_names(properties, unnamed), words | set(unnamed))
    found = {}
    for quantity, one in _used(properties).items():
        parts = [table[name] for name in one.names]
        found[quantity] = parts[0] if len(parts) == 1 else np.stack(parts, axis=1)
    if "positions" not in found:
        raise ValueError(f"Properties={known.get('properties')} has no pos")
    return found


def _used(properties: dict[str, _Property]) -> dict[str, _Property]:
    """The properties that are read, by the names of `_NAMES`."""
    named = {quantity: next((name for name in names if name in properties), "") for quantity, names in _NAMES.items()}
    return {quantity: properties[name] for quantity, name in named.items() if name}


def _as_frame(rows: list[bytes], known: dict[str, Any], time: float, step: int | None) -> Frame:
    found = _values(rows, known)
    number = len(rows)
    velocities, types, masses = found.get("velocities"), found.get("types"), found.get("masses")
    if velocities is None and "momenta" in found:
        masses = _masses_of(types) if masses is None else masses
        velocities = found["momenta"] / masses[:, None]
    if types is not None and types.dtype.kind == "f":
        types = whole("types", types)
    elif types is not None and (types == "X").all():
        types = None  # what `simulate` and ASE write for particles without names
    diameters = found.get("diameters")
    if diameters is None and "radii" in found:
        diameters = 2 * found["radii"]
    return Frame(
        time,
        step,
        whole("id", found["ids"]) if "ids" in found else np.arange(1, number + 1),
        in_space(found["positions"]),
        None if velocities is None else in_space(velocities),
        None if "spins" not in found else in_space(found["spins"]),
        types,
        masses,
        diameters,
        _box(known),
    )


def _masses_of(names: Any) -> Floats:
    """Masses of elements by which ASE divides momenta."""
    from ase.data import atomic_masses, atomic_numbers

    unknown = None if names is None else next((name for name in names if name not in atomic_numbers), None)
    if names is None or unknown is not None:
        raise ValueError(f"it has momenta and no masses, and {unknown or 'its particles'} is no element")
    return np.array([atomic_masses[atomic_numbers[name]] for name in names])


def _box(known: dict[str, Any]) -> Box | None:
    lattice = known.get("lattice")
    if lattice is None:
        return None
    vectors = np.asarray(lattice, dtype=np.float64).T
    lower = np.asarray(known.get("origin", np.zeros(3)), dtype=np.float64)
    periodic = np.broadcast_to(np.asarray(known.get("pbc", True), dtype=bool), 3)
    return Box(vectors, lower, periodic, stated="pbc" in known)


def _lost(head: _Head, rows: list[bytes]) -> Iterator[str]:
    """Sentences on what a frame does not state."""
    properties, unnamed = _properties(head.known, rows)
    used = _used(properties)
    if "ids" not in used:
        yield "it states no ids: particles are taken in the order of the file."
    if unnamed:
        yield "it has columns without names (no key Properties), which are not read."
    if "momenta" in used and "velocities" not in used:
        yield "its velocities are momenta over masses, the file's or those of ASE."


def _rounding(head: _Head, rows: list[bytes]) -> dict[str, Rounding]:
    """By how much the file has rounded each quantity, from the decimals of a frame."""
    properties, unnamed = _properties(head.known, rows)
    values = _values(rows, head.known)
    words = printed(rows, _all_names(properties, unnamed))
    found = {
        quantity: of_decimals([word for name in one.names for word in words[name]])
        for quantity, one in _used(properties).items()
        if not one.words
    }
    lattice = _LATTICE.search(head.comment)
    if lattice:
        found["box"] = of_decimals(lattice[1].split())
    if "radii" in found:
        radii = found.pop("radii")
        found.setdefault("diameters", radii._replace(absolute=2 * radii.absolute))
    if "momenta" in found and "velocities" not in found:
        momenta = found["momenta"]
        masses = _masses_of(values.get("types")) if values.get("masses") is None else values["masses"]
        found["velocities"] = momenta._replace(
            absolute=momenta.absolute / float(np.min(masses)), relative=momenta.relative + 2 * DOUBLE.relative
        )
    return {name: rounding for name, rounding in found.items() if name not in ("ids", "types", "momenta")}
