"""How many frames of a NetCDF file of the classic formats are whole: its library returns zeros for what is missing.

Literature: NetCDF documentation, file format specifications (CDF-1, CDF-2, CDF-5).
"""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import IO, NamedTuple

#: Bytes of a number of each type.
_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}


class _Variable(NamedTuple):
    """Where a variable begins (bytes), its bytes (those of one record), and whether it has records."""

    begin: int
    size: int
    records: bool


class _Header:
    """Reads the parts of a header one after another."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        version = self._read(4)[3]
        self._count = ">q" if version == 5 else ">i"
        self._offset = ">i" if version == 1 else ">q"
        self.records = self._number(self._count)
        lengths = [(self._name(), self._number(self._count))[1] for _ in range(self._listed())]
        self._attributes()
        self.variables = [self._variable(lengths) for _ in range(self._listed())]

    def _read(self, size: int) -> bytes:
        data = self._file.read(size)
        if len(data) < size:
            raise ValueError("its header is not complete")
        return data

    def _number(self, form: str) -> int:
        return int(struct.unpack(form, self._read(struct.calcsize(form)))[0])

    def _padded(self, size: int) -> bytes:
        return self._read(size + -size % 4)

    def _name(self) -> bytes:
        return self._padded(self._number(self._count))

    def _listed(self) -> int:
        """Number of elements of a list, after its tag."""
        self._number(">i")
        return self._number(self._count)

    def _attributes(self) -> None:
        for _ in range(self._listed()):
            self._name()
            kind = self._number(">i")
            self._padded(self._number(self._count) * _SIZES[kind])

    def _variable(self, lengths: list[int]) -> _Variable:
        self._name()
        dimensions = [lengths[self._number(self._count)] for _ in range(self._number(self._count))]
        self._attributes()
        kind = self._number(">i")
        self._number(self._count)  # its bytes, which overflow in large files
        begin = self._number(self._offset)
        records = bool(dimensions) and dimensions[0] == 0
        return _Variable(begin, math.prod(dimensions[records:]) * _SIZES[kind], records)


def whole_frames(path: Path) -> int:
    """Number of frames of which every number is there. path: of a NetCDF file of a classic format.

    ValueError if the header, or what is no frame, is not complete.
    """
    end = path.stat().st_size
    with path.open("rb") as file:
        try:
            header = _Header(file)
        except (KeyError, IndexError):
            raise ValueError("its header is damaged") from None
    alone = [one for one in header.variables if not one.records]
    framed = [one for one in header.variables if one.records]
    if any(one.begin + one.size > end for one in alone):
        raise ValueError("it is not complete")
    # the records of several variables take turns, each padded to four bytes
    step = sum(one.size + -one.size % 4 for one in framed) if len(framed) > 1 else sum(one.size for one in framed)
    most = min(((end - one.begin - one.size) // step + 1 for one in framed), default=0)
    return max(min(most, header.records), 0) if header.records >= 0 else max(most, 0)
