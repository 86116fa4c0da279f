"""Arrays of `crosscheck simulate` (.npz), read a frame at a time without the others in memory."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np

from crosscheck.trajectories.frames import DOUBLE, EXACT, Box, Floats, Frame, Integers, Series, Source, Units

FORMAT = "arrays of simulate (.npz)"
HOLDS = "frames"
#: The time step in the label of a method, such as "verlet, dt = 0.01, k = 1000.0".
_STEP = re.compile(r"\bdt = ([-+.\deE]+)(?:,|$)")


class _Rows:
    """Rows of one array of an .npz file, read in their order; going back begins anew."""

    def __init__(self, path: Path, name: str) -> None:
        self._path, self._name = path, name
        self._begin()

    def _begin(self) -> None:
        self._file: IO[bytes] = zipfile.ZipFile(self._path).open(f"{self._name}.npy")  # noqa: SIM115 - until the end
        version = np.lib.format.read_magic(self._file)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        self.shape, fortran, self._type = read(self._file)
        if fortran or self._type.hasobject:
            raise ValueError(f"{self._name} is not stored row by row")
        self._size = int(np.prod(self.shape[1:])) * self._type.itemsize
        self._next = 0

    def read(self, index: int) -> Floats:
        if index < self._next:
            self._begin()
        while self._next <= index:
            data = self._file.read(self._size)
            self._next += 1
        if len(data) < self._size:
            raise ValueError(f"{self._name} ends before row {index}")
        return np.frombuffer(data, dtype=self._type).reshape(self.shape[1:]).astype(np.float64)


@dataclass(frozen=True)
class _Arrays(Source):
    rows: dict[str, _Rows] = field(default_factory=dict)
    constant: dict[str, Any] = field(default_factory=dict)
    box: Box | None = None

    def _frame(self, index: int) -> Frame:
        found = {name: _in_space(rows.read(index), name) for name, rows in self.rows.items()}
        ids = np.arange(1, len(found["positions"]) + 1)
        return Frame(
            float(self.times[index]),
            None if self.steps is None else int(self.steps[index]),
            ids,
            found["positions"],
            found.get("velocities"),
            found.get("angular_velocities"),
            self.constant.get("species"),
            self.constant.get("mass"),
            self.constant.get("diameter"),
            self.box,
        )


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    return path.suffix == ".npz"


def open_file(path: Path, topology: Path | None) -> Source | Series:
    """Opens the file: a trajectory, or quantities in time if it records none. path: of the file. topology: not used.

    ValueError if it is not one of `crosscheck simulate`.
    """
    with np.load(path, allow_pickle=False) as arrays:
        if "about" not in arrays or "time" not in arrays:
            raise ValueError("it has no entries 'about' and 'time', which crosscheck simulate writes")
        about = json.loads(str(arrays["about"]))
        times = np.asarray(arrays["time"], dtype=np.float64)
        constant = {
            name: np.asarray(arrays[f"particle_{name}"])
            for name in ("mass", "species", "diameter")
            if f"particle_{name}" in arrays
        }
        held = [name for name in ("positions", "velocities", "angular_velocities") if name in arrays]
        if "positions" not in held:
            columns = {name: np.asarray(values, dtype=np.float64) for name, values in _in_time(arrays, about)}
            return Series(path, FORMAT, times, columns, dict.fromkeys(columns, DOUBLE))
    outcome = about.get("outcome", ())
    rows = {name: _Rows(path, name) for name in held}
    if any(one.shape[0] != len(times) for one in rows.values()):
        raise ValueError("its arrays have not as many samples as its times")
    if outcome:  # a run that ended early has no numbers in its last samples
        times = times[: _good(rows, len(times))]
    if not len(times):
        raise ValueError("there is no sample")
    return _Arrays(
        path,
        f"simulate, {about.get('engine', '?')}, {about.get('method', '?')}",
        times,
        _steps(str(about.get("method", "")), times),
        "unwrapped",
        Units(),
        EXACT,
        tuple(f"{text}." for text in outcome),
        rows,
        constant,
        _box(about["scene"]),
    )


def _good(rows: dict[str, _Rows], count: int) -> int:
    """Number of samples before the first one that holds what is no number."""
    for index in range(count):
        if not all(np.isfinite(one.read(index)).all() for one in rows.values()):
            return index
    return count


def _steps(method: str, times: Floats) -> Integers | None:
    """Numbers of the time steps, from the label of the method; None of a method without them."""
    found = _STEP.search(method)
    return None if found is None else np.rint(times / float(found[1])).astype(np.int64)


def _in_time(arrays: Any, about: dict[str, Any]) -> Iterator[tuple[str, Floats]]:
    """Observables with one value a sample, by name."""
    for name, told in about["arrays"].items():
        if list(told["axes"]) == ["sample"] and name != "time":
            yield name, arrays[name]


def _in_space(vectors: Floats, name: str) -> Floats:
    """Vectors (N, d) completed with zeros to (N, 3); a rotation in the plane is about z."""
    missing = 3 - vectors.shape[1]
    before = missing if name == "angular_velocities" else 0
    return np.pad(vectors, ((0, 0), (before, missing - before)))


def _box(scene: dict[str, Any]) -> Box | None:
    """The box of the scene, from its entries; None in open space."""
    from crosscheck.scene import Scene

    built = Scene.from_json(json.dumps(scene))
    sides = built.lengths()
    if sides is None:
        return None
    lengths, periodic = np.zeros(3), np.zeros(3, dtype=bool)
    lengths[: built.dimension] = sides
    periodic[: built.dimension] = [boundary == "periodic" for boundary in built.boundaries]
    return Box(np.diag(lengths), np.zeros(3), periodic)
