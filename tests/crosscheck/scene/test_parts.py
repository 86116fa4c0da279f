"""Entries of single tables: their ranges, what they may not be beside each other, and what follows from them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from scene_files import DISKS, DRUM, FLUID, ROUGH, SPRING, TURNING, assert_one_message, changed, load

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Explicit,
    Face,
    Method,
    Scene,
    Spring,
)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (SPRING, "dimension", 4, "dimension: Input should be 1, 2 or 3 (found 4)"),
        (SPRING, "duration", math.nan, "duration: Input should be a finite number (found nan)"),
        (SPRING, "spring.k", math.inf, "spring.k: Input should be a finite number (found inf)"),
        (SPRING, "initial.positions", [[1.0], [math.nan]], "initial.positions.1.0: Input should be a finite number"),
        (SPRING, "output", {"interval": 1.0, "observables": ["heat"]}, "output.observables.0: Input should be"),
        (SPRING, "method", {"scheme": "verlet", "dt": 0.0}, "method.dt: Input should be greater than 0 (found 0.0)"),
        (SPRING, "method", {"scheme": "RK45", "tolerance": 1.0}, "method.tolerance: Input should be less than 1"),
        (SPRING, "method", {"scheme": "RK45", "dt": 0.1, "tolerance": 0.1}, "dt and tolerance both say how long"),
        (FLUID, "box.density", 1.0, "box: give exactly one of lengths, density and packing_fraction"),
        (FLUID, "box.boundaries", ["wall"] * 3, 'box: a boundary "wall" and the table [box.wall] go together'),
        (FLUID, "initial.structure", "hcp", "initial.structure: Input should be 'fcc', 'sc', 'square' or 'triangular'"),
        (DISKS, "hard_spheres.diameter", -1.0,
         "hard_spheres.diameter: Input should be greater than or equal to 0 (found -1.0)"),
        (DISKS, "hard_spheres.diameter", [1.0, -1.0],
         "hard_spheres.diameter.1: Input should be greater than or equal to 0"),
        (DISKS, "hard_spheres.restitution", 1.2,
         "hard_spheres.restitution: Input should be less than or equal to 1 (found 1.2)"),
        (DISKS, "hard_spheres.contact_duration", 0.0, "hard_spheres.contact_duration: Input should be greater than 0"),
        (TURNING, "hard_spheres.friction.tangential_restitution", -1.5,
         "tangential_restitution: Input should be greater than or equal to -1 (found -1.5)"),
        (TURNING, "hard_spheres.friction", ROUGH | {"static": 0.3, "sliding": 0.4},
         "hard_spheres.friction: sliding = 0.4 exceeds static = 0.3: make it smaller"),
        (TURNING, "hard_spheres.friction", ROUGH | {"static": 0.3}, "friction: static and sliding go together"),
        (TURNING, "hard_spheres.diameter", 0.0, "hard_spheres: diameter = 0 with [hard_spheres.friction]"),
        (DISKS, "hard_spheres.well", {"depth": 1.0, "range": 1.0},
         "hard_spheres.well.range: Input should be greater than 1"),
        (DISKS, "box.boundaries", ["wall", "hard"], 'a boundary "wall" and the table [box.wall] go together'),
        (DISKS, "box.faces", {"y-": {"velocity": 1.0, "temperature": 1.0}},
         "box.faces.y-: give at most one of velocity, random_phase, oscillation, temperature; found velocity and temp"),
        (DISKS, "box.faces", {"y-": {"open": True, "velocity": 1.0}},
         "box.faces.y-: open = true means that there is no wall"),
        (DISKS, "box.faces", {"y-": {"temperature": 1.0, "restitution": 0.5}}, "remove restitution and friction"),
        (DISKS, "box.faces", {"y-": {"restitution": 1.5}},
         "box.faces.y-.restitution: Input should be less than or equal to 1"),
        (DISKS, "box.faces", {"y-": {"velocity": -1.0}},
         "box.faces.y-.velocity: Input should be greater than or equal to 0"),
        (DISKS, "box.faces", {"y-": {"random_phase": {"speed": 1.0, "law": "normal"}}},
         "law: Input should be 'uniform' or 'flux'"),
        (DRUM, "box.cylinder.radius", -1.0, "box.cylinder.radius: Input should be greater than 0 (found -1.0)"),
        (DRUM, "box.cylinder.angular_velocity", 1.0,
         "angular_velocity = 1: a smooth wall exerts no torque: add friction"),
        (DISKS, "output", {"interval": 1.0, "observables": ["heat"]}, "output.observables.0: Input should be"),
        (DISKS, "output", {"interval": 1.0, "collisions": [1]},
         "interval and collisions both say when to record: remove one"),
        (DISKS, "output", {"collisions": [2, 2]}, "output: collisions must increase: found 2 after 2"),
        (DISKS, "output", {"collisions": []}, "output: collisions is empty"),
        (DISKS, "output", {"collisions": [0]}, "output.collisions.0: Input should be greater than 0 (found 0)"),
        (FLUID, "initial.speed", 1.0, "initial: give exactly one of temperature and speed"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_with_its_path(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    assert_one_message(tmp_path, changed(table, path, value), message)


def test_a_scene_is_frozen() -> None:
    scene = Scene(name="a", dimension=1, duration=0.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))
    with pytest.raises(ValueError, match="frozen"):
        scene.duration = 2.0
    assert scene.changed(duration=2.0).duration == 2
    with pytest.raises(UsageError, match="duration: Input should be greater than or equal to 0"):
        scene.changed(duration=-2.0)


def test_a_time_step_is_asked_for() -> None:
    assert Method(scheme="verlet", dt=0.5).step == 0.5
    with pytest.raises(UsageError, match=r"method.dt is missing: scheme 'verlet' takes time steps: add dt"):
        _ = Method(scheme="verlet").step


def test_faces_of_a_scene(tmp_path: Path) -> None:
    scene = load(tmp_path, changed(DISKS, "box.faces", {"y-": {"velocity": 1.0}}))
    assert scene.faces == (None, None, Face(velocity=1.0), Face())
    assert load(tmp_path, changed(DISKS, "box.faces", {"y+": {"open": True}})).faces == (None, None, Face(), None)
    assert load(tmp_path, changed(DISKS, "box", ...)).faces == (None,) * 4
