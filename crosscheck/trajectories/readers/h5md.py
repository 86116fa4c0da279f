"""H5MD, read by h5py with all bits: MDAnalysis keeps 32 of them.

Literature: P. de Buyl, P. H. Colberg and F. Höfling, Comput. Phys. Commun. 185, 1546 (2014); H5MD specification 1.1.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.trajectories.frames import (
    DOUBLE,
    EXACT,
    SINGLE,
    Box,
    Floats,
    Frame,
    Rounding,
    Source,
    Units,
    Wrapping,
    chosen,
    ordered,
)
from crosscheck.trajectories.readers._coordinates import decimal
from crosscheck.trajectories.rounding import unwrapped
from crosscheck.trajectories.vectors import in_space, moved

FORMAT = "H5MD"
HOLDS = "frames"
#: Quantities of `Frame` -> elements of a group of particles.
_ELEMENTS = {"positions": "position", "velocities": "velocity", "masses": "mass"}


@dataclass(frozen=True)
class _H5md(Source):
    group: str = ""

    @cached_property
    def _particles(self) -> Any:
        import h5py

        return h5py.File(self.path, "r")["particles"][self.group]

    def _frame(self, index: int) -> Frame:
        particles = self._particles
        positions = in_space(_element(particles, "position", index))
        ids = _element(particles, "id", index)
        numbers = np.arange(1, len(positions) + 1) if ids is None else ids.astype(np.int64)
        there = numbers >= 0 if ids is None else (numbers >= 0) & (numbers != _absent(particles["id"]))
        box = _box(particles, index)
        image = _element(particles, "image", index)
        if image is not None and box is not None:
            positions = moved(positions, in_space(image), box.vectors)
        velocities, types, masses = (_element(particles, name, index) for name in ("velocity", "species", "mass"))
        if types is not None:
            types = _named(particles["species"], types)
        frame = Frame(
            float(self.times[index]),
            None if self.steps is None else int(self.steps[index]),
            numbers,
            positions,
            None if velocities is None else in_space(velocities),
            None,
            None if types is None else np.broadcast_to(types, numbers.shape),
            None if masses is None else np.broadcast_to(masses, numbers.shape),
            box=box,
        )
        return ordered(chosen(frame, there))


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return path.suffix in (".h5md", ".h5", ".hdf5")


def open_file(path: Path, topology: Path | None) -> Source:
    """Opens the file; of several groups of particles the first. path: of the file. topology: not used.

    ValueError if it has no positions in time.
    """
    import h5py

    with h5py.File(path, "r") as file:
        groups = [name for name in file.get("particles", {}) if _in_time(file["particles"][name], "position")]
        if not groups:
            raise ValueError("there is no particles/<group>/position/value")
        particles = file["particles"][groups[0]]
        position = particles["position"]
        count = len(position["value"])
        if not count:
            raise ValueError("there is no frame")
        steps = _fixed(position["step"], count) if "step" in position else None
        times = _fixed(position["time"], count) if "time" in position else np.full(count, np.nan)
        if len(times) < count or (steps is not None and len(steps) < count):
            raise ValueError("position has fewer steps or times than values")
        units = Units(
            _unit(position["value"]),
            _unit(position["time"]) if "time" in position else "",
            _unit(particles["velocity/value"]) if _in_time(particles, "velocity") else "",
        )
        rounding = {quantity: _rounding(particles, name) for quantity, name in _ELEMENTS.items()}
        box = _box(particles, 0)
        if box is not None:
            rounding["box"] = _rounding(particles["box"], "edges")
        imaged = "image" in particles and box is not None
        if imaged and box is not None:
            rounding["positions"] = unwrapped(rounding["positions"], box.vectors)
        periodic = box is not None and bool(box.periodic.any())
        wrapping: Wrapping = "wrapped" if periodic and not imaged else "unwrapped"
        remarks = [] if len(groups) == 1 else [f"of its groups of particles {', '.join(groups)}, the first is read."]
        if not np.isfinite(times).all():
            remarks.append("it states no times.")
        for name in ("velocity", "image", "species", "mass"):
            rarer = _rarer(particles, name)
            if rarer:
                remarks.append(f"{name} is there in {rarer} of {count} frames.")
    return _H5md(
        path,
        FORMAT,
        times,
        None if steps is None else steps.astype(np.int64),
        wrapping,
        units,
        EXACT | rounding,
        tuple(remarks),
        groups[0],
    )


def _in_time(particles: Any, name: str) -> bool:
    """Whether an element is there, and is not constant in time."""
    return name in particles and hasattr(particles[name], "keys") and "value" in particles[name]


def _fixed(values: Any, count: int) -> Floats:
    """Times or steps of the frames; a scalar is the interval between them, which starts at its attribute offset."""
    if values.shape == ():
        return np.asarray(np.arange(count) * float(values[()]) + float(values.attrs.get("offset", 0)))
    found = np.asarray(values[:count])
    return np.array([decimal(one) for one in found]) if found.dtype == np.float32 else found.astype(np.float64)


def _unit(values: Any) -> str:
    """A unit as others name it: "nm ps-1" is nm/ps."""
    text = _word(values.attrs.get("unit", "")).strip()
    return re.sub(r"\s+([A-Za-z]+)-1\b", r"/\1", text)


def _word(text: Any) -> str:
    return text.decode("utf-8") if isinstance(text, bytes) else str(text)


def _rounding(particles: Any, name: str) -> Rounding:
    if name not in particles:
        return DOUBLE
    element = particles[name]
    values = element["value"] if hasattr(element, "keys") else element
    return DOUBLE if values.dtype.itemsize >= 8 else SINGLE


def _absent(ids: Any) -> int:
    """The id of a particle that is not there: the fill value, where the file sets one."""
    values = ids["value"] if hasattr(ids, "keys") else ids
    plist = values.id.get_create_plist()
    import h5py

    return int(values.fillvalue) if plist.fill_value_defined() == h5py.h5d.FILL_VALUE_USER_DEFINED else -1


def _named(species: Any, numbers: Any) -> Any:
    """Names of species, of a file that lists them; else the numbers."""
    import h5py

    values = species["value"] if hasattr(species, "keys") else species
    listed = h5py.check_enum_dtype(values.dtype)
    if listed is None:
        return numbers
    names = {number: name for name, number in listed.items()}
    return np.array([names.get(int(number), str(number)) for number in np.atleast_1d(numbers)])


def _place(particles: Any, name: str, index: int) -> int | None:
    """Where an element has its value for a frame of positions: at the same step, for elements may be stored at their
    own intervals; None if it has none."""
    element, position = particles[name], particles["position"]
    count, frames = len(element["value"]), len(position["value"])
    key = next((key for key in ("step", "time") if key in element and key in position), None)
    if key is None or element[key] == position[key]:  # often one data set under two names
        return index if index < count else None
    mine, wanted = _fixed(element[key], count), _fixed(position[key], frames)[index]
    found = np.flatnonzero(mine == wanted)
    return int(found[-1]) if found.size else None


def _rarer(particles: Any, name: str) -> int:
    """In how many frames an element in time is there, if not in all; else 0."""
    if not _in_time(particles, name):
        return 0
    count = len(particles["position"]["value"])
    if len(particles[name]["value"]) == count and _place(particles, name, count - 1) == count - 1:
        return 0
    found = sum(_place(particles, name, index) is not None for index in range(count))
    return found if found < count else 0


def _element(particles: Any, name: str, index: int) -> Any:
    """An element at one frame, or one that is constant in time; None if it is not there."""
    if name not in particles:
        return None
    element = particles[name]
    if hasattr(element, "keys"):
        place = index if name == "position" else _place(particles, name, index)
        if place is None:
            return None
        values = np.asarray(element["value"][place])
    else:
        values = np.asarray(element[()])
    return values.astype(np.float64) if values.dtype.kind == "f" else values


def _box(particles: Any, index: int) -> Box | None:
    """The box, from its edges, which are constant, or of the last step that is not later; None without them."""
    if "box" not in particles or "edges" not in particles["box"]:
        return None
    box = particles["box"]
    edges = box["edges"]
    if hasattr(edges, "keys"):
        values = np.asarray(edges["value"][_of_box(edges, particles["position"], index)])
    else:
        values = np.asarray(edges[()])
    sides = np.diag(values) if values.ndim == 1 else values
    axes = len(sides)
    vectors = np.zeros((3, 3))
    vectors[:axes, :axes] = sides
    kinds = np.ravel(box.attrs.get("boundary", ["none"] * axes))
    periodic = np.zeros(3, dtype=bool)
    periodic[:axes] = np.broadcast_to([_word(one) == "periodic" for one in kinds], axes)
    return Box(vectors, np.zeros(3), periodic, stated="boundary" in box.attrs)


def _of_box(edges: Any, position: Any, index: int) -> int:
    count = len(edges["value"])
    key = next((key for key in ("step", "time") if key in edges and key in position), None)
    if key is None or edges[key] == position[key]:
        return min(index, count - 1)
    wanted = _fixed(position[key], len(position["value"]))[index]
    return max(int(np.searchsorted(_fixed(edges[key], count), wanted, side="right")) - 1, 0)
