"""The checks of random walls and starts: a right engine is green, and wrong ones are red."""

from __future__ import annotations

import zlib
from typing import Any

import pytest

from crosscheck.checks.events import random_starts, random_walls
from crosscheck.engines.protocol import Run
from crosscheck.scene import Scene
from crosscheck.verdict import findings
from tests.support import wall_engines


class _Bench:
    """A laboratory that runs an engine in this process."""

    def __init__(self, engine: Any) -> None:
        self.engine = engine

    def run(self, scene: Scene, kind: str) -> Run:
        return self.engine.run(scene)

    def seed(self, purpose: str = "") -> int:
        return zlib.crc32(purpose.encode())


THERMAL, PHASE = ("thermal-2d", "seeds"), ("phase-uniform", "phase-flux")


def _outcome(check: Any, variant: str, engine: Any) -> str:
    (value,) = (one.value for one in check.variants if one.name == variant)
    return findings(check.judge(_Bench(engine), value)).outcome


@pytest.mark.parametrize("variant", [*THERMAL, *PHASE])
def test_a_right_engine_is_green(variant: str) -> None:
    assert _outcome(random_walls.CHECKS[0], variant, wall_engines.Right()) == "pass"


@pytest.mark.parametrize(
    ("engine", "variant"),
    [
        (wall_engines.NotTheFlux, "thermal-2d"),
        (wall_engines.NoMass, "thermal-2d"),
        (wall_engines.Slips, "thermal-2d"),
        (wall_engines.OneDraw, "thermal-2d"),
        (wall_engines.OneDraw, "phase-uniform"),
        (wall_engines.UniformForFlux, "phase-flux"),
        (wall_engines.FluxOfTheWall, "phase-flux"),
    ],
)
def test_a_wrong_engine_is_red(engine: type[wall_engines.Right], variant: str) -> None:
    assert _outcome(random_walls.CHECKS[0], variant, engine()) == "fail"


class _Starts:
    """Returns the start, times a factor by component."""

    def __init__(self, *factors: float) -> None:
        self.factors = factors

    def run(self, scene: Scene) -> Run:
        return Run(final_velocities=scene.initial_state().velocities * self.factors)


def test_a_start_is_judged() -> None:
    check = random_starts.CHECKS[0]
    assert _outcome(check, "temperature-3d", _Starts(1.0, 1.0, 1.0)) == "pass"
    assert _outcome(check, "temperature-3d", _Starts(1.0, 1.0, 1 + 1e-9)) == "fail"
    assert _outcome(check, "speed-2d", _Starts(1.0, -1.0)) == "pass"
    assert _outcome(check, "speed-2d", _Starts(0.0, 1.0)) == "fail"
