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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosscheck.scene import Floats
from crosscheck.trajectories.formats import Format
from crosscheck.trajectories.trajectory import Trajectory, box_around

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
    import gsd.hoomd

    lower, upper = np.ascontiguousarray(box_around(trajectory).T)
    with np.errstate(over="ignore", under="ignore"), _in_utf8(path) as name:
        sides = upper - lower
        file = gsd.fl.open(name, "w", application="particle-crosscheck", schema="hoomd", schema_version=[1, 4])
        with gsd.hoomd.HOOMDTrajectory(file) as frames:
            for sample, step in enumerate(trajectory.steps.tolist()):
                frame = gsd.hoomd.Frame()
                frame.configuration.step = step
                frame.configuration.dimensions = max(trajectory.dimension, 2)
                frame.configuration.box = np.array([*sides, 0, 0, 0], dtype=np.float32)
                _set_particles(frame.particles, trajectory, sample, lower, sides)
                frame.log = _log(trajectory, sample)
                if sample == 0:
                    frame.log |= {"box_lower": lower, "box_sides": sides, "cell": trajectory.cell}
                frames.append(frame)


def _set_particles(particles: Any, trajectory: Trajectory, sample: int, lower: Floats, sides: Floats) -> None:
    """HOOMD's chunks of one frame; those that are as in frame 0 are not written again.

    lower, sides: of the box, (3,), length.
    """
    numbers, kinds = np.unique(trajectory.species_of_all, return_inverse=True)
    more = trajectory.more
    particles.N = kinds.size
    particles.types = [str(number) for number in numbers]
    particles.typeid = kinds.astype(np.uint32)
    particles.mass = trajectory.masses.astype(np.float32)
    if "radius" in more:
        particles.diameter = (2 * more["radius"]).astype(np.float32)
    particles.position, particles.image = wrapped(trajectory.positions[sample], lower, sides, trajectory.periodic)
    if "velocities" in more:
        particles.velocity = more["velocities"][sample].astype(np.float32)
    if "moment_of_inertia" in more:
        axes = [0.0, 0.0, 1.0] if trajectory.dimension == 2 else [1.0, 1.0, 1.0]
        moments = more["moment_of_inertia"][:, None]
        particles.moment_inertia = (moments * axes).astype(np.float32)
        momenta = 2 * moments * more["angular_velocities"][sample]
        particles.angmom = np.pad(momenta, ((0, 0), (1, 0))).astype(np.float32)


def _log(trajectory: Trajectory, sample: int) -> dict[str, Floats]:
    """What is written in double precision; the constants of the particles in frame 0 alone."""
    log = {"time": trajectory.time[[sample]], "particles/positions": trajectory.positions[sample]}
    log |= {f"particles/{name}": values[sample] for name, values in trajectory.more.items() if values.ndim > 1}
    if sample == 0:
        log |= {f"particles/{name}": values for name, values in trajectory.more.items() if values.ndim == 1}
        log["particles/masses"] = trajectory.masses
    return log


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
