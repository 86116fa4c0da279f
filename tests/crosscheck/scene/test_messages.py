"""Each mistake in a scene is one message, with the path of the key and how to mend it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scene_files import DISKS, FLUID, MIXTURE, ROUGH, SPRING, TURNING, assert_one_message, changed, load

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Scene,
)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (SPRING, "durations", 1.0, "unknown key 'durations'; did you mean 'duration'?"),
        (SPRING, "spring.gama", 1.0, "unknown key 'spring.gama'; did you mean 'gamma'?"),
        (SPRING, "initial.velocity", [[1.0]], "unknown key 'initial.velocity'; did you mean 'velocities'?"),
        (SPRING, "cutoff", 1.0, "unknown key 'cutoff'; it belongs in [lennard_jones] or [box.wall]"),
        (SPRING, "output.acceleration", 1.0, "it belongs in the scene itself, above the first table"),
        (SPRING, "zzz", 1.0, "unknown key 'zzz'; remove it"),
        (SPRING, "file", "a.npz", "unknown key 'file'; remove it"),
        (SPRING, "eccentricity", 0.5, "it belongs in [initial] kind = \"kepler\""),
        (SPRING, "amplitude", 0.5, 'it belongs in [box.faces."x-".oscillation] or [[initial.waves]]'),
        (SPRING, "duration", "long", "duration: Input should be a valid number (found 'long')"),
        (SPRING, "duration", True, "duration: Input should be a valid number (found True)"),
        (SPRING, "masses", -1.0, "masses: Input should be greater than 0 (found -1.0)"),
        (SPRING, "masses", [1.0, -1.0], "masses.1: Input should be greater than or equal to 0 (found -1.0)"),
        (SPRING, "masses", "heavy", "masses: Input should be a valid number (found 'heavy')"),
        (FLUID, "lennard_jones.epsilon", [1.0, -1.0], "lennard_jones.epsilon.1: Input should be greater than 0"),
        (SPRING, "duration", ..., "'duration' is missing: add it"),
        (SPRING, "spring.k", ..., "'spring.k' is missing: add it"),
        (FLUID, "initial.kind", ..., "'initial.kind' is missing: add it, one of explicit, lattice, kepler, file"),
        (SPRING, "initial.kind", "random", "initial.kind: Input should be one of explicit, lattice, kepler, file"),
        (FLUID, "initial.structre", "fcc", "unknown key 'initial.structre'; did you mean 'structure'?"),
        (MIXTURE, "hard_spheres.fixd", [0], "unknown key 'hard_spheres.fixd'; did you mean 'fixed'?"),
        (TURNING, "hard_spheres.friction", {}, "'hard_spheres.friction.tangential_restitution' is missing: add it"),
        (TURNING, "box.faces", {"y-": {"friction": ROUGH | {"inertia": 1.0}}},
         "unknown key 'box.faces.y-.friction.inertia'; it belongs in [hard_spheres.friction]"),
        (DISKS, "box.faces", {"y-": {"restitutoin": 1.0}}, "'box.faces.y-.restitutoin'; did you mean 'restitution'?"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_with_its_path(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    assert_one_message(tmp_path, changed(table, path, value), message)


def test_a_misspelt_key_is_not_missing_as_well(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as error:
        load(tmp_path, changed(changed(SPRING, "duration", ...), "durration", 1.0))
    assert str(error.value).endswith("unknown key 'durration'; did you mean 'duration'?")
    assert len(str(error.value).splitlines()) == 1


def test_two_mistakes_are_two_lines(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as error:
        load(tmp_path, changed(changed(SPRING, "duration", -1.0), "masses", "x"))
    assert len(str(error.value).splitlines()) == 2


@pytest.mark.parametrize("text", ["", "{", "[1]", "null"])
def test_json_that_is_no_scene(text: str) -> None:
    with pytest.raises(UsageError, match=r"^scene: "):
        Scene.from_json(text)
