"""What files that hold coordinates alone have in common: particles are named by a topology."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.trajectories.frames import Box, Floats, Frame, Integers, Series, Source, ordered

#: What to say where no topology is given.
NO_TOPOLOGY = "it holds coordinates alone: no types and masses are compared (--topology gives them)."


class Topology(NamedTuple):
    """Particles (N,) of a topology, in the order of the coordinates. ids, types, masses, diameters: as of `Frame`."""

    ids: Integers
    types: NDArray[Any] | None = None
    masses: Floats | None = None
    diameters: Floats | None = None


class Numbers(NamedTuple):
    """Numbers of a frame. positions, velocities: (N, 3). box: as of `Frame`."""

    positions: Floats
    velocities: Floats | None
    box: Box | None


@dataclass(frozen=True)
class Coordinates(Source):
    """A file of coordinates.

    topology: of its particles; None: they are 1, 2 ... path, format, times, steps, wrapping, units, rounding, remarks:
    as of `Source`.
    """

    topology: Topology | None = None

    @abstractmethod
    def numbers(self, index: int) -> Numbers:
        """Those of frame number `index`; any exception if it is damaged."""

    def _frame(self, index: int) -> Frame:
        found = self.numbers(index)
        count = len(found.positions)
        known = self.topology or Topology(np.arange(1, count + 1))
        if len(known.ids) != count:
            raise ValueError(f"the topology has {len(known.ids)} particles, the coordinates {count}")
        step = None if self.steps is None else int(self.steps[index])
        return ordered(
            Frame(
                float(self.times[index]),
                step,
                known.ids,
                found.positions,
                found.velocities,
                None,
                known.types,
                known.masses,
                known.diameters,
                found.box,
            )
        )


def read_topology(path: Path | None) -> Topology | None:
    """Particles of a topology: the first frame of a file of results, in the order of the ids, or what MDAnalysis reads.

    Of the latter, particles are numbered 1, 2 ... in their order, for the numbers of PDB files have gaps, and wrap.

    path: of the topology. UsageError, or what MDAnalysis raises, if it cannot be read.
    """
    if path is None:
        return None
    from crosscheck.trajectories.reading import open_results, reader_of

    if reader_of(path) is not None:
        source = open_results(path)
        if isinstance(source, Series):
            raise ValueError(f"{path.name} is a table in time, not a topology")
        frame = source.read(0)
        return Topology(frame.ids, frame.types, frame.masses, frame.diameters)
    import MDAnalysis

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what the topology does not state
        atoms = MDAnalysis.Universe(str(path), to_guess=()).atoms

    def held(name: str) -> Any:
        return np.asarray(getattr(atoms, name)) if hasattr(atoms, name) else None

    types = held("types")
    return Topology(np.arange(1, len(atoms) + 1), held("names") if types is None else types, held("masses"))


def decimal(time: float) -> float:
    """A time of 32 bits as the shortest decimal that rounds to it: 1.6, not 1.60000002384. time: of any precision."""
    return float(str(np.float32(time)))
