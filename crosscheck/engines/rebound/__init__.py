"""REBOUND as an engine."""

from crosscheck.engines.rebound.engine import ReboundEngine

__all__ = ["ReboundEngine"]
