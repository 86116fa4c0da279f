"""The reference implementations as an engine."""

from crosscheck.engines.refimpl.engine import RefimplEngine

__all__ = ["RefimplEngine"]
