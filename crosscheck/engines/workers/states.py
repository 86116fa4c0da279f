"""Files with the state of a run: arrays in .npz, and beside them one text, the header of a restart file."""

from __future__ import annotations

import zipfile
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
