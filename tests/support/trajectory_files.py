"""Random trajectories, and what is in a file of one, read without the code that wrote it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crosscheck.trajectories.trajectory import Trajectory

#: Of any size, with the smallest ones, which have fewer bits.
ANY = st.floats(-1e300, 1e300, allow_subnormal=True) | st.floats(-1e-300, 1e-300) | st.floats(-100.0, 100.0)
#: What a scene's sizes can be, and what they can be in single precision.
POSITIVE = st.floats(1e-100, 1e100) | st.floats(0.1, 10.0)
SINGLE = st.floats(1e-30, 1e30)


def bits(values: Any) -> bytes:
    return np.ascontiguousarray(values, dtype=np.float64).tobytes()


@st.composite
def trajectories(draw: st.DrawFn, sizes: st.SearchStrategy[float] = POSITIVE) -> Trajectory:
    """1 to 3 samples of 1 to 4 particles, in 1 to 3 dimensions, with any box or none.

    sizes: of boxes, masses, radii and moments of inertia.
    """
    d, n, samples = draw(st.integers(1, 3)), draw(st.integers(1, 4)), draw(st.integers(1, 3))
    cell, periodic, walled = np.zeros(3), np.zeros(3, dtype=bool), np.zeros((3, 2), dtype=bool)
    if draw(st.booleans()):
        cell[:d] = draw(arrays(np.float64, d, elements=sizes))
        periodic[:d] = draw(arrays(np.bool_, d))
        walled[:d] = draw(arrays(np.bool_, (d, 2))) & ~periodic[:d, None]

    def vectors(axes: slice) -> Any:
        found = np.zeros((samples, n, 3))
        found[..., axes] = draw(arrays(np.float64, found[..., axes].shape, elements=ANY))
        return found

    more = {}
    if draw(st.booleans()):
        more["velocities"] = vectors(slice(d))
    if draw(st.booleans()):
        more["radius"] = draw(arrays(np.float64, n, elements=st.just(0.0) | sizes))
        if draw(st.booleans()):
            more["angular_velocities"] = vectors(slice(2, 3) if d == 2 else slice(3))
            more["moment_of_inertia"] = draw(arrays(np.float64, n, elements=sizes))
    species = draw(st.none() | arrays(np.int64, n, elements=st.integers(0, 3) | st.integers(0, 2**31 - 1)))
    return Trajectory(
        draw(arrays(np.float64, samples, elements=ANY)),
        np.arange(samples) * draw(st.integers(1, 2**40)),
        vectors(slice(d)),
        d,
        cell,
        periodic,
        walled,
        draw(arrays(np.float64, n, elements=sizes)),
        species,
        more,
    )


def dump_frames(path: Path) -> list[dict[str, Any]]:
    """The frames of a dump: `step`, `boundaries`, `box` (3, 2), and the columns of the particles by name."""
    frames = []
    for text in path.read_text(encoding="utf-8").split("ITEM: TIMESTEP\n")[1:]:
        lines = text.splitlines()
        names = lines[7].removeprefix("ITEM: ATOMS ").split()
        rows = [line.split() for line in lines[8:]]
        assert [lines[1], len(rows)] == ["ITEM: NUMBER OF ATOMS", int(lines[2])]
        frames.append(
            {
                "step": int(lines[0]),
                "boundaries": lines[3].removeprefix("ITEM: BOX BOUNDS ").split(),
                "box": np.array([[float(edge) for edge in line.split()] for line in lines[4:7]]),
                **{name: np.array([float(row[k]) for row in rows]) for k, name in enumerate(names)},
            }
        )
    return frames


def side_by_side(frame: dict[str, Any], *names: str) -> Any:
    """Columns of a frame of a dump, (N, len(names))."""
    return np.stack([frame[name] for name in names], axis=1)
