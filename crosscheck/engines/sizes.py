"""What a run asks of the machine's memory and of counters, estimated before any engine starts."""

from __future__ import annotations

import math

from crosscheck.engines.protocol import shapes, strides
from crosscheck.scene import Method, Scene
from crosscheck.scene.sizes import refuse_large, refuse_large_start

#: An array of results exists twice for a while: with the engine, and where it is read.
_COPIES = 2


def refuse_large_run(scene: Scene, method: Method) -> None:
    """UsageError, with the numbers, if start or results of a run need more memory than the machine has.

    What an engine itself needs is not known, nor how many events there will be. scene: what is to be run. method: the
    scheme and its time step; also refused is a run of more steps than can be counted.
    """
    refuse_large_start(scene)
    output = scene.output
    if output.collisions is not None:
        samples = len(output.collisions) + 1
    elif method.dt is not None:
        steps, every = strides(scene, method)
        samples = steps // every + 1
    else:
        samples = 2 if output.interval is None else math.floor(scene.duration / output.interval) + 1
    numbers = sum(math.prod(shape) for shape in shapes(scene, samples).values())
    what = f"output: {samples} samples"
    if output.fields is not None:
        what += f" and {math.prod(output.fields)} cells"
    what += f" of {scene.number} particles" if scene.lattice_gas is None else ""
    refuse_large(8.0 * _COPIES * numbers, what, "record less often, less, or in larger cells")
