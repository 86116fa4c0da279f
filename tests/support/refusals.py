"""Why a scene is refused for an engine: by the suite, from its declarations, or by itself."""

from __future__ import annotations

from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Engine
from crosscheck.engines.soft_spheres import resolved
from crosscheck.scene import Method, Scene


def refused(engine: Engine, scene: Scene, method: Method) -> str | None:
    """As a worker answers."""
    method = resolved(scene, method)
    return refusal(engine, scene, method) or engine.supports(scene, method)
