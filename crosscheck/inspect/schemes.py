"""What a scene's scheme makes of what is conserved."""

from __future__ import annotations

from crosscheck.engines.registry import engine_class
from crosscheck.scene import Scene


def not_symplectic(scene: Scene | None) -> str:
    """Why nothing that symplectic schemes conserve is asked of a scene's scheme; "" if it may be asked.

    scene: what was run; None: not known, and what codes of molecular dynamics use is symplectic. A scheme goes by its
    name in `refimpl`.
    """
    if scene is None or scene.method is None:
        return ""
    claims = engine_class("refimpl").schemes.get(scene.method.scheme)
    if claims is None or claims.symplectic is not False or claims.kind != "stepping":
        return ""
    return f"scheme {scene.method.scheme} is not symplectic"
