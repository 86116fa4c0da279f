"""All arrays of a run as numpy holds them: `arrays-<engine>.npz`, which `simulate` writes of every run.

It has the times, and positions, velocities and angular velocities of a trajectory in the scene's own dimension, to the
last bit: a second file would hold the same arrays again. See `crosscheck.simulate.arrays`.
"""

from __future__ import annotations

from crosscheck.trajectories.formats import Format

FORMAT = Format("npz", None)
