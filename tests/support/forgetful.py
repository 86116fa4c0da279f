"""Engines that promise to go on where a run ended, and forget something."""

from __future__ import annotations

from collections.abc import Mapping

from crosscheck.engines.protocol import Run
from crosscheck.engines.refimpl.engine import RefimplEngine
from crosscheck.scene import Floats, Method, Scene


class FromTheStart(RefimplEngine):
    """Goes on from the initial state of the very first run."""

    def run_from(
        self, scene: Scene, method: Method, start: Mapping[str, Floats] | None
    ) -> tuple[Run, dict[str, Floats] | None]:
        return super().run_from(scene, method, None)


class LeavesNothing(RefimplEngine):
    """Has no state to go on from."""

    def run_from(
        self, scene: Scene, method: Method, start: Mapping[str, Floats] | None
    ) -> tuple[Run, dict[str, Floats] | None]:
        return super().run_from(scene, method, start)[0], None
