"""LAMMPS data files: one frame.

ASE's reader knows four atom styles, none of grains, and leaves no position the same to the last bit, for it adds image
flags to fractions of the box.

Literature: documentation of LAMMPS, command `read_data`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.columns import SAMPLE, printed, read_columns, whole
from crosscheck.lammps_dump import opened
from crosscheck.trajectories.frames import DOUBLE, Box, Floats, Frame, Integers, Rounding, Source, Units, ordered
from crosscheck.trajectories.readers.dump import UNITS
from crosscheck.trajectories.rounding import of_decimals, unwrapped
from crosscheck.trajectories.vectors import moved

FORMAT = "LAMMPS data"
HOLDS = "frame"

#: Atom styles -> columns of the section Atoms, before the image flags.
STYLES = {
    "angle": "id mol type x y z",
    "atomic": "id type x y z",
    "bond": "id mol type x y z",
    "bpm/sphere": "id mol type diameter density x y z",
    "charge": "id type q x y z",
    "dipole": "id type q x y z mux muy muz",
    "ellipsoid": "id type flag density x y z",
    "full": "id mol type q x y z",
    "molecular": "id mol type x y z",
    "peri": "id type volume density x y z",
    "sphere": "id type diameter density x y z",
    "spin": "id type x y z spx spy spz sp",
}
_IMAGES = ("ix", "iy", "iz")
#: Where the style is not named, and no other one has so many columns.
_ATOMIC = (5, 8)
_WHERE = re.compile(rb"^\s*\d+\s+atoms\b", re.MULTILINE)
_BOX = re.compile(r"\b(xlo xhi|ylo yhi|zlo zhi|xy xz yz|avec|bvec|cvec|abc origin|atoms)\b")


class _Text(NamedTuple):
    """A data file.

    title: its first line. header: what stands before the sections, by its words. bounds: rounding of the box there.
    sections: name -> what follows the mark #, and the rows.
    """

    title: str
    header: dict[str, list[float]]
    bounds: Rounding
    sections: dict[str, tuple[str, list[bytes]]]


@dataclass(frozen=True)
class _Data(Source):
    frame: Frame = field(default_factory=lambda: Frame(0.0, None, np.empty(0, dtype=np.int64), np.empty((0, 3))))

    def _frame(self, index: int) -> Frame:
        return self.frame


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    with path.open("rb") as file:
        start = file.read(8192)
    if start[:2] == b"\x1f\x8b":
        return path.name.endswith((".data.gz", ".lmp.gz"))
    return b"LAMMPS (" not in start and bool(_WHERE.search(start)) and (b"xlo xhi" in start or b"avec" in start)


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens the file, which is kept in memory. path: of the file. topology: not used. ValueError, with the reason, if
    it is not whole, or of an atom style that is none of `STYLES`."""
    text = _read(path)
    comment, rows = text.sections.get("Atoms", ("", []))
    names = _names_of(comment, rows)
    table = read_columns(rows, names, {"type"} if _labelled(rows, names) else set())
    stated = int(text.header.get("atoms", [-1])[0])
    if stated != len(rows):
        raise ValueError(f"section Atoms has {len(rows)} rows for {stated} atoms: it is not complete")
    box = _box(text.header)
    step, units = re.search(r"timestep = (\d+)", text.title), re.search(r"units = (\w+)", text.title)
    imaged = "ix" in names
    remarks = ["it states no time."]
    if not imaged:
        remarks.append("it states no boundaries: all are taken to be periodic.")
    return _Data(
        path,
        FORMAT,
        np.array([np.nan]),
        np.array([int(step[1])]) if step else None,
        "unwrapped" if imaged else "wrapped",
        UNITS.get(units[1], Units())._replace(time="") if units else Units(),
        _rounding(text, names, box),
        tuple(remarks),
        _as_frame(text, table, box, int(step[1]) if step else None),
    )


def _read(path: Path) -> _Text:
    header: dict[str, list[float]] = {}
    bounds: list[str] = []
    sections: dict[str, tuple[str, list[bytes]]] = {}
    current: list[bytes] | None = None
    with opened(path) as file:
        title = file.readline().decode("utf-8", "replace").strip()
        for line in file:
            content, _, comment = line.partition(b"#")
            content = content.strip()
            if not content:
                continue
            if content[:1].isalpha() and not any(map(_is_number, content.split())):
                current = []
                sections[content.decode("utf-8", "replace")] = (comment.decode("utf-8", "replace").strip(), current)
            elif current is not None:
                current.append(content)
            else:
                words = content.decode("utf-8", "replace")
                found = _BOX.search(words)
                if found:
                    printed_here = words[: found.start()].split()
                    header[found[1]] = [float(word) for word in printed_here]
                    bounds += printed_here if found[1] != "atoms" else []
        cut = bool(line) and not line.endswith(b"\n") if sections else False
    if cut:
        raise ValueError("its last line has no end: it may be cut in a number; add the end of the line if it is not")
    return _Text(title, header, of_decimals(bounds), sections)


def _is_number(word: bytes) -> bool:
    """Whether a word is a number, as titles of sections have none, and rows that begin with a label have one."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _names_of(comment: str, rows: list[bytes]) -> list[str]:
    """Columns of the section Atoms. ValueError if the style is not known, or if it has another number of them."""
    count = len(rows[0].split()) if rows else 0
    style = comment.split()[0] if comment else ("atomic" if count in _ATOMIC else "")
    if style == "hybrid" and rows:  # columns of the other styles follow, and nothing tells where image flags are
        return [*STYLES["atomic"].split(), *(f"column{k}" for k in range(6, count + 1))]
    if style not in STYLES:
        which = f"atom style {style} is none of those read" if style else "it does not name its atom style"
        raise ValueError(f"{which}: name one beside its section, as 'Atoms # full', of {', '.join(STYLES)}")
    names = STYLES[style].split()
    if rows and count == len(names) + 3:
        return [*names, *_IMAGES]
    if rows and count != len(names):
        raise ValueError(f"section Atoms has {count} columns, atom style {style} has {len(names)} and image flags")
    return names


def _labelled(rows: list[bytes], names: list[str]) -> bool:
    """Whether types are names."""
    return bool(rows) and not rows[0].split()[names.index("type")].isdigit()


def _box(header: dict[str, list[float]]) -> Box:
    periodic = np.ones(3, dtype=bool)
    if "avec" in header:
        vectors = np.array([header[name] for name in ("avec", "bvec", "cvec")])
        return Box(vectors, np.array(header.get("abc origin", [0.0, 0.0, 0.0])), periodic, stated=False)
    try:
        bounds = np.array([header[f"{axis}lo {axis}hi"] for axis in "xyz"])
    except KeyError as error:
        raise ValueError(f"its header has no {error.args[0]}: it is not complete") from None
    vectors = np.diag(bounds[:, 1] - bounds[:, 0])
    vectors[1, 0], vectors[2, 0], vectors[2, 1] = header.get("xy xz yz", (0.0, 0.0, 0.0))
    return Box(vectors, bounds[:, 0], periodic, stated=False)


def _as_frame(text: _Text, table: dict[str, NDArray[Any]], box: Box, step: int | None) -> Frame:
    ids = whole("id", table["id"])
    positions = np.stack([table[axis] for axis in "xyz"], axis=1)
    if "ix" in table:
        positions = moved(positions, np.stack([whole(name, table[name]) for name in _IMAGES], axis=1), box.vectors)
    types = table["type"] if table["type"].dtype.kind == "U" else whole("type", table["type"])
    velocities, spins = _velocities(text, ids, "diameter" in table)
    masses = _masses(text, table, types)
    return ordered(
        Frame(float("nan"), step, ids, positions, velocities, spins, types, masses, table.get("diameter"), box)
    )


def _velocities(text: _Text, ids: Integers, grains: bool) -> tuple[Floats | None, Floats | None]:
    """Velocities and angular velocities of these particles; None if they are not there."""
    if "Velocities" not in text.sections:
        return None, None
    rows = text.sections["Velocities"][1]
    table = read_columns(rows, _of_velocities(rows), ())
    numbers = whole("id", table["id"])
    order, mine = np.argsort(numbers), np.argsort(ids)
    if not np.array_equal(numbers[order], ids[mine]):
        raise ValueError("section Velocities has other ids than section Atoms: it is not complete")
    place = np.empty_like(order)
    place[mine] = order
    vectors = np.stack(list(table.values())[1:], axis=1)[place]
    return vectors[:, :3], vectors[:, 3:6] if grains and vectors.shape[1] >= 6 else None


def _of_velocities(rows: list[bytes]) -> list[str]:
    """Columns of the section Velocities: those of grains have angular velocities, others have more."""
    return ["id", "vx", "vy", "vz", *(f"column{k}" for k in range(5, len(rows[0].split()) + 1 if rows else 0))]


def _masses(text: _Text, table: dict[str, NDArray[Any]], types: NDArray[Any]) -> Floats | None:
    """Masses of the types, else those of spheres of the stated density; a point particle's density is its mass."""
    if "diameter" in table:
        volume = 4.0 * np.pi / 3.0 * (table["diameter"] / 2) ** 3
        return np.asarray(np.where(table["diameter"] > 0, volume, 1.0) * table["density"])
    if "Masses" not in text.sections:
        return None
    of_types = {row.split()[0].decode(): float(row.split()[1]) for row in text.sections["Masses"][1]}
    labels = {row.split()[1]: row.split()[0] for row in text.sections.get("Atom Type Labels", ("", []))[1]}
    for name, number in labels.items():
        of_types.setdefault(name.decode(), of_types.get(number.decode(), np.nan))
    unknown = next((str(one) for one in np.unique(types) if str(one) not in of_types), None)
    if unknown is not None:
        raise ValueError(f"section Masses has no type {unknown}")
    return np.array([of_types[str(one)] for one in types])


def _rounding(text: _Text, names: list[str], box: Box) -> dict[str, Rounding]:
    """By how much the file has rounded each quantity, from its decimals."""
    atoms = printed(text.sections["Atoms"][1][:SAMPLE], names) if "Atoms" in text.sections else {}
    positions = of_decimals([word for axis in "xyz" for word in atoms.get(axis, ())])
    rows = text.sections.get("Velocities", ("", []))[1][:SAMPLE]
    moving = printed(rows, _of_velocities(rows))
    masses = of_decimals([row.split()[1].decode() for row in text.sections.get("Masses", ("", []))[1]])
    if "density" in atoms and "diameter" in atoms:
        masses = of_decimals(atoms["density"])
        size = of_decimals(atoms["diameter"])
        masses = Rounding(0.0, masses.relative + 3 * size.relative + 8 * DOUBLE.relative, masses.name)
    return {
        "positions": unwrapped(positions, box.vectors) if "ix" in names else positions,
        "velocities": of_decimals([word for name in ("vx", "vy", "vz") for word in moving.get(name, ())]),
        "spins": of_decimals([word for k in (5, 6, 7) for word in moving.get(f"column{k}", ())]),
        "masses": masses,
        "diameters": of_decimals(atoms.get("diameter", ())),
        "box": text.bounds._replace(absolute=2 * text.bounds.absolute, relative=2 * text.bounds.relative),
    }
