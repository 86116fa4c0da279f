"""What LAMMPS held in memory when it wrote its files (`lammps_files`), as a reader must return it."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crosscheck.trajectories.frames import Frame, Source
from crosscheck.trajectories.reading import open_results


class Truth:
    """The directory of files, and the arrays of each run."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory

    @cached_property
    def _arrays(self) -> dict[str, NDArray[np.float64]]:
        with np.load(self.directory / "truth.npz") as arrays:
            return dict(arrays)

    def path(self, name: str) -> Path:
        return self.directory / name

    def source(self, name: str) -> Source:
        found = open_results(self.directory / name)
        assert isinstance(found, Source)
        return found

    def of(self, run: str, name: str) -> NDArray[np.float64]:
        return self._arrays[f"{run}/{name}"]

    def edges(self, run: str) -> NDArray[np.float64]:
        """Edges of the box as rows."""
        low, high, tilts = np.split(self.of(run, "box"), (3, 6))
        edges = np.diag(high - low)
        edges[1, 0], edges[2, 0], edges[2, 1] = tilts
        return edges

    def unwrapped(self, run: str) -> NDArray[np.float64]:
        """Positions with their images, (F, N, 3), summed up as LAMMPS sums them up."""
        positions = self.of(run, "x").copy()
        for axis, edge in enumerate(self.edges(run)):
            positions += self.of(run, "image")[:, :, axis, None] * edge
        return positions


def frames_of(source: Source) -> list[Frame]:
    return list(source.frames())


def positions_of(source: Source) -> NDArray[np.float64]:
    """(F, N, 3)."""
    return np.array([frame.positions for frame in source.frames()])


def beyond(source: Source, quantity: str, true: NDArray[np.float64]) -> float:
    """The largest error of a quantity, in units of the rounding that is stated for it: 1 is at its edge."""
    read = np.array([getattr(frame, quantity) for frame in source.frames()])
    bound = source.rounding[quantity].of(read)
    error = np.abs(read - true)
    return float(np.max(np.where(error > 0, error / np.maximum(bound, 5e-324), 0.0)))
