"""A trajectory in memory, as one that has been read."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crosscheck.trajectories.frames import (
    DOUBLE,
    QUANTITIES,
    Box,
    Floats,
    Frame,
    Integers,
    Rounding,
    Source,
    Units,
    Wrapping,
)


@dataclass(frozen=True)
class InMemory(Source):
    """A trajectory whose arrays are in memory, as `in_memory` makes it.

    path, format, times, steps, wrapping, units, rounding, remarks: as of `Source`. ids: (N,). positions: (S, N, 3),
    length. velocities: (S, N, 3), length/time. types, masses, diameters: (N,). box: of all frames.
    """

    ids: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    positions: Floats = field(default_factory=lambda: np.empty((0, 0, 3)))
    velocities: Floats | None = None
    types: NDArray[np.generic] | None = None
    masses: Floats | None = None
    diameters: Floats | None = None
    box: Box | None = None

    def _frame(self, index: int) -> Frame:
        return Frame(
            float(self.times[index]),
            None if self.steps is None else int(self.steps[index]),
            self.ids,
            self.positions[index],
            None if self.velocities is None else self.velocities[index],
            types=self.types,
            masses=self.masses,
            diameters=self.diameters,
            box=self.box,
        )


def in_memory(
    name: str,
    times: Floats,
    positions: Floats,
    velocities: Floats | None = None,
    *,
    steps: Integers | None = None,
    types: NDArray[np.generic] | None = None,
    masses: Floats | None = None,
    diameters: Floats | None = None,
    box: Box | None = None,
    wrapping: Wrapping = "unwrapped",
    rounding: Rounding = DOUBLE,
) -> InMemory:
    """A trajectory from arrays.

    name: of it. times: (S,), time. positions: (S, N, 3), length. velocities: (S, N, 3), length/time. steps: (S,).
    types, masses, diameters: (N,). box: of all frames. wrapping: of the positions. rounding: of all quantities.
    """
    return InMemory(
        Path(name),
        "memory",
        times,
        steps,
        wrapping,
        Units(),
        dict.fromkeys(QUANTITIES, rounding),
        (),
        np.arange(1, positions.shape[1] + 1),
        positions,
        velocities,
        types,
        masses,
        diameters,
        box,
    )
