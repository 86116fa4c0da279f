"""Three hard disks in a box, and a run of them that an engine might have returned."""

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import Box, Explicit, HardSpheres, Method, Output, Scene

EVENTS = Method(scheme="event_driven")


def disks(**changes):
    entries = {
        "name": "disks",
        "dimension": 2,
        "duration": 2.0,
        "hard_spheres": HardSpheres(),
        "box": Box(lengths=(6.0, 5.0)),
        "initial": Explicit(
            positions=((1.0, 1.0), (3.0, 3.0), (5.9, 1.5)), velocities=((1.0, 0.0), (0.0, 0.0), (0.0, 1.9))
        ),
        "output": Output(interval=1.0, observables=("kinetic_energy",), trajectory=True),
    }
    return Scene(**(entries | changes))


def fall(scene, **more):
    """A run of straight paths through the box, with everything else that is given."""
    state, time = scene.initial_state(), scene.samples()
    positions = state.positions + state.velocities * time[:, None, None]
    velocities = np.broadcast_to(state.velocities, positions.shape)
    return Run(
        time=time,
        final_positions=positions[-1],
        final_velocities=state.velocities,
        positions=positions,
        velocities=velocities,
        **more,
    )
