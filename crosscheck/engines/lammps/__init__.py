"""LAMMPS as an engine."""

from crosscheck.engines.lammps.engine import LammpsEngine

__all__ = ["LammpsEngine"]
