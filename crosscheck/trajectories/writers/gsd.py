"""GSD files of HOOMD's schema, which HOOMD-blue, OVITO and MDAnalysis read.

Schema 1.4, which all of them know, has numbers of single precision, and a periodic box about the origin. So that
nothing is lost, the chunks below `log/`, where the schema has room for quantities of one's own, hold the same in double
precision, in the scene's coordinates.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from crosscheck.scene import Floats
from crosscheck.trajectories.formats import Format
from crosscheck.trajectories.trajectory import Trajectory, box_around

#: Arrays by the names of their chunks.
Chunks: TypeAlias = dict[str, NDArray[Any]]
#: HOOMD's images are whole numbers of 32 bits.
_MOST_IMAGES = 2**31 - 1


def write(path: Path, trajectory: Trajectory) -> None:
    """Writes a trajectory to `path`.

    HOOMD's chunks (single precision): step; dimensions, 2 for a scene of one; box, that of `box_around`; types, named
    by the numbers of the species, and typeid; mass; diameter, of hard spheres; position, from the middle of the box and
    wrapped along its periodic axes, and image; velocity; moment_inertia and angmom of grains that rotate. As their
    orientation is not known, it is HOOMD's default (1, 0, 0, 0), with which angmom = 2 q S is (0, 2 I omega). In the
    plane, only the axis z has a moment of inertia.

    Chunks below log/ (double precision): `time`; `particles/positions`, not wrapped, `particles/velocities` and
    `particles/angular_velocities`; and once, in frame 0, `box_lower` and `box_sides` of the box, `cell` (the sides of
    the scene's own), `particles/masses`, `particles/radius` and `particles/moment_of_inertia`.

    trajectory: what to write.
    """
    import gsd.fl

    lower, upper = box_around(trajectory).T
    # not `gsd.hoomd`, which leaves out what is equal to HOOMD's defaults, as diameters of 1: OVITO has other ones
    with (
        np.errstate(over="ignore", under="ignore"),
        _in_utf8(path) as name,
        gsd.fl.open(name, "w", "particle-crosscheck", "hoomd", [1, 4]) as file,
    ):
        for sample in range(len(trajectory.time)):
            chunks = _of_sample(trajectory, sample, lower, upper - lower)
            if sample == 0:
                chunks |= _constants(trajectory, lower, upper - lower)
            for chunk, values in chunks.items():
                file.write_chunk(chunk, np.ascontiguousarray(values))
            file.end_frame()


def _constants(trajectory: Trajectory, lower: Floats, sides: Floats) -> Chunks:
    """Chunks of frame 0, which hold for all frames. lower, sides: of the box, (3,), length."""
    numbers, kinds = np.unique(trajectory.species_of_all, return_inverse=True)
    names = numbers.astype(np.bytes_)
    log: Chunks = {
        "box_lower": lower,
        "box_sides": sides,
        "cell": trajectory.cell,
        "particles/masses": trajectory.masses,
    }
    log |= {f"particles/{name}": values for name, values in trajectory.more.items() if values.ndim == 1}
    chunks: Chunks = {
        "configuration/dimensions": np.array([max(trajectory.dimension, 2)], dtype=np.uint8),
        "configuration/box": np.array([*sides, 0, 0, 0], dtype=np.float32),
        "particles/N": np.array([kinds.size], dtype=np.uint32),
        # each name ends with a zero
        "particles/types": np.pad(names.view(np.int8).reshape(numbers.size, -1), ((0, 0), (0, 1))),
        "particles/typeid": kinds.astype(np.uint32),
        "particles/mass": trajectory.masses.astype(np.float32),
    }
    if "radius" in trajectory.more:
        chunks["particles/diameter"] = (2 * trajectory.more["radius"]).astype(np.float32)
    if "moment_of_inertia" in trajectory.more:
        axes = [0.0, 0.0, 1.0] if trajectory.dimension == 2 else [1.0, 1.0, 1.0]
        moments = trajectory.more["moment_of_inertia"][:, None] * axes
        chunks["particles/moment_inertia"] = moments.astype(np.float32)
    return chunks | {f"log/{name}": values for name, values in log.items()}


def _of_sample(trajectory: Trajectory, sample: int, lower: Floats, sides: Floats) -> Chunks:
    """Chunks of every frame: of this sample. lower, sides: of the box, (3,), length."""
    more = trajectory.more
    position, image = wrapped(trajectory.positions[sample], lower, sides, trajectory.periodic)
    log: Chunks = {"time": trajectory.time[[sample]], "particles/positions": trajectory.positions[sample]}
    log |= {f"particles/{name}": values[sample] for name, values in more.items() if values.ndim > 1}
    chunks: Chunks = {
        "configuration/step": trajectory.steps[[sample]].astype(np.uint64),
        "particles/position": position,
        "particles/image": image,
    }
    if "velocities" in more:
        chunks["particles/velocity"] = more["velocities"][sample].astype(np.float32)
    if "moment_of_inertia" in more:
        momenta = 2 * more["moment_of_inertia"][:, None] * more["angular_velocities"][sample]
        chunks["particles/angmom"] = np.pad(momenta, ((0, 0), (1, 0))).astype(np.float32)
    return chunks | {f"log/{name}": values for name, values in log.items()}


def wrapped(
    positions: Floats, lower: Floats, sides: Floats, periodic: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Positions from the middle of a box, in single precision, -L/2 <= r < L/2 along periodic axes; and their images.

    positions: (N, 3), length. lower, sides: of the box, (3,), length. periodic: which axes are, (3,). Returns (N, 3)
    positions and (N, 3) numbers of boxes; those beyond 32 bits are the largest of 32 bits.
    """
    with np.errstate(over="ignore", under="ignore"):
        from_lower = positions - lower
        periods = np.where(periodic, sides, 1.0)
        crossed = np.where(periodic, from_lower, 0.0)  # what has boxes to be counted
        inside = np.mod(crossed, periods)
        images = np.rint((crossed - inside) / periods)
        half = (sides / 2).astype(np.float32)
        rounded = (np.where(periodic, inside, from_lower) - sides / 2).astype(np.float32)
    beyond = periodic & (rounded >= half)  # by rounding alone
    return np.where(beyond, -half, rounded), np.clip(images + beyond, -_MOST_IMAGES, _MOST_IMAGES).astype(np.int32)


@contextmanager
def _in_utf8(path: Path) -> Iterator[str]:
    """A name of the file `path` in UTF-8, which GSD's library demands: a directory of other bytes has a number too."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        directory = os.open(path.parent, os.O_RDONLY)
        try:
            yield f"/proc/self/fd/{directory}/{path.name}"
        finally:
            os.close(directory)
    else:
        yield str(path)


FORMAT = Format("gsd", write, ("velocities", "angular_velocities", "radius", "moment_of_inertia"), package="gsd")
