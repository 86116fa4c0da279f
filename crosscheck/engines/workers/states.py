"""Files with arrays: .npz with the state of a run, and what a worker hands to the suite, which is numbers alone.

A quick tier hands over thousands of small runs. Members of a .npz, each with a header of its own, cost several times
what the numbers do; so shapes are in the answer, and the file has nothing but numbers.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError

#: Name of the text within the file.
HEADER = "header.json"


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """All arrays of a restart file by name. path: of the file. UsageError if it is damaged, or holds Python objects."""
    try:
        with np.load(path, allow_pickle=False) as members:
            return {name: members[name] for name in members if name != HEADER}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise UsageError(f"{path}: its arrays cannot be read ({error})") from None


def hand_over(path: Path, arrays: Mapping[str, NDArray[np.float64]]) -> dict[str, list[int]]:
    """Writes the numbers of the arrays, one array after the other. path: of the file. Returns the shapes by name."""
    with path.open("wb") as file:
        for array in arrays.values():
            file.write(array.tobytes())
    return {name: list(array.shape) for name, array in arrays.items()}


def taken_over(path: Path, shapes: Mapping[str, Sequence[int]]) -> dict[str, NDArray[np.float64]]:
    """The arrays that `hand_over` wrote.

    path: of the file. shapes: what `hand_over` returned. ValueError if the file holds more or fewer numbers than that.
    """
    numbers = {name: math.prod(shape) for name, shape in shapes.items()}
    if path.stat().st_size != 8 * sum(numbers.values()):
        raise ValueError(f"the file of the arrays does not hold the {sum(numbers.values())} numbers of their shapes")
    with path.open("rb") as file:
        return {
            name: np.fromfile(file, dtype=np.float64, count=numbers[name]).reshape(shape)
            for name, shape in shapes.items()
        }
