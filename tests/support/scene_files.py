"""Scenes as tables, their way through files, and the message for a mistake in one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import tomli_w

from crosscheck.errors import UsageError
from crosscheck.scene import Scene

SPRING: dict[str, Any] = {
    "name": "a",
    "dimension": 1,
    "duration": 1.0,
    "spring": {"k": 1.0},
    "initial": {"kind": "explicit", "positions": [[1.0], [2.0]]},
}
FLUID: dict[str, Any] = {
    "name": "a",
    "dimension": 3,
    "duration": 1.0,
    "lennard_jones": {"cutoff": 2.5},
    "box": {"lengths": [5.0, 5.0, 5.0]},
    "initial": {"kind": "lattice", "structure": "fcc", "number": 4, "temperature": 1.0, "seed": 0},
}


def changed(table: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """A copy with another value at `path`, or without the key, if the value is ..."""
    key, _, rest = path.partition(".")
    copy = dict(table)
    if rest:
        copy[key] = changed(copy.get(key, {}), rest, value)
    elif value is ...:
        del copy[key]
    else:
        copy[key] = value
    return copy


DISKS: dict[str, Any] = {
    "name": "a",
    "dimension": 2,
    "duration": 1.0,
    "hard_spheres": {"diameter": 1.0},
    "box": {"lengths": [5.0, 5.0], "boundaries": ["periodic", "hard"]},
    "initial": {"kind": "explicit", "positions": [[1.0, 1.0], [3.0, 3.0]], "velocities": [[1.0, 0.0], [0.0, 0.0]]},
}
ROUGH = {"tangential_restitution": 0.5}
MIXTURE = changed(changed(DISKS, "hard_spheres.diameter", [1.0, 2.0]), "species", [0, 1])
TURNING = changed(DISKS, "hard_spheres.friction", ROUGH)
DRUM = changed(changed(DISKS, "box.boundaries", ["open", "open"]), "box.cylinder", {"radius": 2.5})


def load(tmp_path: Path, table: dict[str, Any]) -> Scene:
    path = tmp_path / "scene.toml"
    path.write_text(tomli_w.dumps(table))
    return Scene.load(path)


def assert_one_message(tmp_path: Path, table: dict[str, Any], message: str) -> None:
    """Loading the table fails with one line, which starts with the file's path and has this message in it."""
    with pytest.raises(UsageError) as error:
        load(tmp_path, table)
    (line,) = str(error.value).splitlines()
    assert line.startswith(f"{tmp_path / 'scene.toml'}: ")
    assert message in line


def assert_survives_files(scene: Scene, directory: Path) -> None:
    """TOML and JSON give back an equal scene."""
    assert Scene.from_json(scene.to_json()) == scene
    path = directory / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8", newline="")
    again = Scene.load(path)
    assert again == scene
    assert again.to_toml() == scene.to_toml()
    assert scene.changed() == scene
