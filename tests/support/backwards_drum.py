"""A foreign engine of soft grains whose drum turns backwards."""

from __future__ import annotations

import os

os.environ["NUMBA_DISABLE_JIT"] = "1"  # the scenes are small; before the first import of numba in this process

from crosscheck.engines.protocol import Run
from crosscheck.engines.refimpl.engine import RefimplEngine
from crosscheck.scene import Method, Scene


class BackwardsDrum(RefimplEngine):
    """The drum turns the other way."""

    name = "backwards-drum"

    def run(self, scene: Scene, method: Method) -> Run:
        cylinder = None if scene.box is None else scene.box.cylinder
        if scene.box is not None and cylinder is not None:
            turned = cylinder.model_copy(update={"angular_velocity": -cylinder.angular_velocity})
            scene = scene.changed(box=scene.box.model_copy(update={"cylinder": turned}))
        return super().run(scene, method)
