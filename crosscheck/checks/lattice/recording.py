"""Runs of lattice gases in which every site is seen after every step, and what the auditor finds in them."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.gases import LATTICE
from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import Unsupported
from crosscheck.references.lattice_audit import Forbidden, Lattice, Motion, forbidden, motion
from crosscheck.scene import Floats, Method, Output, Scene


class Recorded(NamedTuple):
    """A run whose populations are those of single sites, at every step.

    scene: with its output. method: the scheme. run: what it measured. lattice: the auditor's. walls: rules of the
    sites, the auditor's. trajectory: occupations (steps + 1, rows, columns, b).
    """

    scene: Scene
    method: Method
    run: Run
    lattice: Lattice
    walls: np.ndarray
    trajectory: Floats

    @property
    def force(self) -> float | None:
        """The scene's, or None."""
        assert self.scene.lattice_gas is not None
        return self.scene.lattice_gas.force

    @property
    def whole(self) -> bool:
        """Whether all occupations are 0 or 1: particles, not means."""
        return bool(np.isin(self.trajectory, (0.0, 1.0)).all())

    @property
    def motion(self) -> Motion:
        """The steps, of particles."""
        return motion(self.lattice, self.trajectory)

    @property
    def forbidden(self) -> Forbidden:
        """Changes of sites that no rule allows, of particles."""
        assert self.scene.lattice_gas is not None
        reversals = self.scene.lattice_gas.reversals or ()
        return forbidden(self.lattice, self.walls, self.force, self.motion, reversals)


def recorded(laboratory: Laboratory, scene: Scene, method: Method) -> Recorded:
    """Runs `scene`, of a lattice gas, with all that the scheme can measure of every site at every step.

    laboratory: of the case. scene: its output is replaced. method: a scheme of the laboratory's engine. Unsupported if
    it measures no populations, or cannot run the scene.
    """
    gas = scene.lattice_gas
    assert gas is not None
    names = ["populations", "sites", "h_function", *(["force_impulse"] if gas.force is not None else [])]
    declared = engine_class(laboratory.engine)

    def seen(*observables: str) -> Scene:
        return scene.changed(output=Output(interval=1, fields=(gas.columns, gas.rows), observables=observables))

    able = [name for name in names if refusal(declared, seen(name), method) is None]
    if "populations" not in able:
        raise Unsupported(f"{laboratory.engine}, {method.scheme}: {refusal(declared, seen('populations'), method)}")
    asked = seen(*able)
    run = laboratory.run(asked, method)
    lattice = _lattice(gas.model, gas.rows, gas.columns)
    trajectory = run["populations"].transpose(0, 2, 1, 3)
    return Recorded(asked, method, run, lattice, lattice.walls(gas.obstacles), trajectory)


@lru_cache(maxsize=4)
def _lattice(model: str, rows: int, columns: int) -> Lattice:
    """The auditor's lattice, which is the same for many runs of a check."""
    return Lattice(model, rows, columns)


def lattice_methods(engine: str) -> list[Method]:
    """All lattice schemes of the engine, in its own order."""
    return [Method(scheme=name) for name, claims in engine_class(engine).schemes.items() if claims.kind == LATTICE]
