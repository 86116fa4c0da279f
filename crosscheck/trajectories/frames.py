"""What a trajectory is, whatever file it comes from: frames of particles, and what the file says of itself."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.files import shown_path

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: How positions leave a periodic box: on and on; or back into it, or not known.
Wrapping = Literal["unwrapped", "wrapped"]


class Rounding(NamedTuple):
    """By how much a number x of a file may differ from what was computed: absolute + relative |x|.

    Half a unit of the last digit, or of the last bit. name: in words, such as "6 significant digits".
    """

    absolute: float
    relative: float
    name: str

    def of(self, values: Floats) -> Floats:
        """The largest error of each of `values`, in their unit."""
        return np.asarray(self.absolute + self.relative * np.abs(values))


#: Half a unit of the last bit of binary64 and of binary32 numbers.
DOUBLE = Rounding(0.0, 2.0**-53, "float64")
SINGLE = Rounding(0.0, 2.0**-24, "float32")
#: Quantities whose rounding a source states; "box": of its edges.
QUANTITIES = ("positions", "velocities", "spins", "masses", "diameters", "box")
#: Rounding of a file of doubles.
EXACT = dict.fromkeys(QUANTITIES, DOUBLE)


def first_line(error: Exception) -> str:
    """What an exception says, on one line. error: the exception."""
    return (str(error).splitlines() or [""])[0] or type(error).__name__


class Box(NamedTuple):
    """A box.

    vectors: its edges as rows, (3, 3), length. lower: its lower corner, (3,), length. periodic: along which of them it
    is periodic, (3,). stated: whether the file says so; if not, `periodic` is what is taken where nothing tells it.
    """

    vectors: Floats
    lower: Floats
    periodic: NDArray[np.bool_]
    stated: bool = True

    @property
    def extended(self) -> NDArray[np.bool_]:
        """Along which of its edges it has an extent, (3,): a plane has none across."""
        return np.asarray(self.vectors.any(axis=1))

    @property
    def around(self) -> NDArray[np.bool_]:
        """Along which of its edges it has images, (3,)."""
        return self.periodic & self.extended

    @property
    def shares(self) -> Floats:
        """The matrix that turns a row of lengths into shares of its edges, (3, 3), 1/length; 1 without an extent."""
        return np.asarray(np.linalg.inv(self.vectors + np.diag(~self.extended * 1.0)))


class Frame(NamedTuple):
    """N particles at one time, in the units of the file, in the order of their ids.

    time: of the file; NaN if it states none. step: number of the time step; None if the file states none. ids: (N,),
    ascending. positions: (N, 3), length. velocities: (N, 3), length/time. spins: angular velocities, (N, 3), 1/time.
    types: (N,) numbers or names. masses: (N,). diameters: (N,), length. box: None: open space, or the file states none.
    What the file does not hold is None.
    """

    time: float
    step: int | None
    ids: Integers
    positions: Floats
    velocities: Floats | None = None
    spins: Floats | None = None
    types: NDArray[Any] | None = None
    masses: Floats | None = None
    diameters: Floats | None = None
    box: Box | None = None


#: Fields of a frame that have a value for each particle.
_OF_PARTICLES = ("ids", "positions", "velocities", "spins", "types", "masses", "diameters")


class Units(NamedTuple):
    """Units of length, time (of `Frame.time`) and velocity of a file, by name; "" if it does not state them."""

    length: str = ""
    time: str = ""
    velocity: str = ""


class Cut(str):
    """A remark of a `Source` that says that the file ends within a frame, and what is not read."""

    @classmethod
    def after(cls, frames: int, reason: object) -> Cut:
        """What is said of a file of which only the first frames can be read. frames: how many. reason: why not more."""
        return cls(f"what follows frame {frames - 1} (counted from 0) is not read: {reason}.")


@dataclass(frozen=True)
class Source(ABC):
    """A trajectory file that has been opened; frames are read when they are asked for.

    path: of the file. format: its name. times: of all frames, (F,), in the file's own unit and order; NaN if it states
    none. steps: (F,), or None. wrapping: how positions leave a periodic box. units: see `Units`. rounding: of each of
    `QUANTITIES`, by how much the file may have rounded it. remarks: whole sentences on what the file, or the library
    that reads it, lost or left open.
    """

    path: Path
    format: str
    times: Floats
    steps: Integers | None
    wrapping: Wrapping
    units: Units
    rounding: dict[str, Rounding]
    remarks: tuple[str, ...] = field(default=())

    @abstractmethod
    def _frame(self, index: int) -> Frame:
        """Frame number `index`; any exception if it is damaged."""

    def read(self, index: int) -> Frame:
        """Frame number `index`, from 0 in the order of the file. UsageError, with the reason, if it is damaged."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of libraries, on what is not asked for
                return self._frame(index)
        except (UsageError, MemoryError):
            raise
        except Exception as error:  # the libraries raise what they like for a damaged file
            raise UsageError(
                f"{shown_path(self.path)}: frame {index} (counted from 0) cannot be read ({first_line(error)})"
            ) from None

    def __len__(self) -> int:
        return len(self.times)

    def frames(self) -> Iterator[Frame]:
        """All frames in the order of the file."""
        for index in range(len(self)):
            yield self.read(index)


@dataclass(frozen=True)
class Series:
    """Quantities of a whole system in time, as of a log file.

    path, format, remarks: as of `Source`. time: (F,), or the number of the step if the file states no time. columns:
    name -> (F,), in the units of the file. rounding: of each column.
    """

    path: Path
    format: str
    time: Floats
    columns: dict[str, Floats]
    rounding: dict[str, Rounding]
    remarks: tuple[str, ...] = ()


def ordered(frame: Frame) -> Frame:
    """A frame whose particles are in any order, in the order of their ids; ValueError if two have the same one."""
    order = np.argsort(frame.ids, kind="stable")
    ids = frame.ids[order]
    twice = np.flatnonzero(ids[1:] == ids[:-1])
    if twice.size:
        raise ValueError(f"two particles have the id {ids[twice[0]]}")
    return frame if (order == np.arange(order.size)).all() else chosen(frame, order)


def chosen(frame: Frame, rows: NDArray[Any]) -> Frame:
    """Some of the particles of a frame. rows: their numbers, or whether each one is among them, (N,)."""
    columns = {name: getattr(frame, name) for name in _OF_PARTICLES}
    return frame._replace(**{name: column[rows] for name, column in columns.items() if column is not None})
