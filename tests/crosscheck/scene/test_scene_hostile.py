"""Scene files that are damaged, impossible or meant to harm: each is a scene, or a message for each mistake."""

from __future__ import annotations

import os
from pathlib import Path
from random import Random
from typing import Any

import hostile
import numpy as np
import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_files import DISKS, DRUM, FLUID, SPRING, changed, load

from crosscheck.engines.sizes import refuse_large_run
from crosscheck.errors import UsageError
from crosscheck.scene import Scene

#: Particles, sites or samples of scenes that are started here: what a few milliseconds are enough for.
FEW = 5000
GAS: dict[str, Any] = {
    "name": "a",
    "dimension": 2,
    "duration": 1,
    "lattice_gas": {"model": "fhp1", "columns": 8, "rows": 8},
    "initial": {"kind": "occupations", "density": 0.3, "seed": 0},
}


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("scene")


def start(scene: Scene) -> None:
    """What happens before any engine starts, of scenes that are small enough."""
    if scene.method is not None:
        refuse_large_run(scene, scene.method)
    gas = scene.lattice_gas
    if (scene.number if gas is None else gas.rows * gas.columns) <= FEW:
        scene.check_start()
    if scene.output.interval is None or scene.duration / scene.output.interval < FEW:
        scene.samples()


def a_scene_or_a_message(path: Path, data: bytes) -> str:
    """Loads and starts a scene file; "" if both work, else the message, which must be printable, and of short lines."""
    path.write_bytes(data)
    message = ""
    try:
        scene = Scene.load(path)
        assert Scene.from_json(scene.to_json()) == scene
        start(scene)
    except UsageError as error:
        message = str(error) or "nothing"
    lines = message.split("\n")
    assert len(lines) <= 21
    assert all(line.isprintable() and len(line) < 2000 for line in lines)
    return message


@given(random=st.randoms(use_true_random=True))
@settings(max_examples=1500, deadline=None)
def test_a_changed_scene_is_a_scene_or_a_message(random: Random, directory: Path) -> None:
    a_scene_or_a_message(directory / "scene.toml", hostile.scene_file(random))


@given(random=st.randoms(use_true_random=True))
@settings(max_examples=1000, deadline=None)
def test_a_made_up_scene_is_a_scene_or_a_message(random: Random, directory: Path) -> None:
    a_scene_or_a_message(directory / "scene.toml", hostile.made_up_scene_file(random))


def test_changed_scenes_are_valid_often_enough_to_try_their_start(directory: Path) -> None:
    random = Random(1)
    found = [a_scene_or_a_message(directory / "scene.toml", hostile.scene_file(random)) for _ in range(200)]
    assert found.count("") > 10


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (DRUM, "box.cylinder.radius", 1e308, "box.cylinder: radius: 1e+308 is out of range"),
        (DISKS, "box.lengths", [1e-300, 1.0], "box.lengths.0: out of range: the smallest number above 0 is 1e-100"),
        (DISKS, "box.lengths", [5e-324, 1.0], "box.lengths.0: out of range"),
        (FLUID, "initial.temperature", 1e308, "initial: temperature: 1e+308 is out of range"),
        (GAS, "lattice_gas.obstacles", [{"centre": [1.0, 1.0], "radius": 1e308}], "radius: 1e+308 is out of range"),
        (DISKS, "method", {"scheme": "verlet", "dt": 0.1, "contact": {"duration": 1e-300}},
         "method.contact.duration: out of range"),
        (SPRING, "initial.positions", [[1e200], [1.0]], "initial: positions: 1e+200 is out of range"),
        (SPRING, "masses", [5e-324, 1.0], "give it one of at least 1e-100"),
        (FLUID, "lennard_jones.epsilon", [1.0, 2.0],
         "lennard_jones.epsilon has 2 values, one per species: add species"),
        (FLUID, "lennard_jones.length", [], "lennard_jones.length is empty"),
        (FLUID | {"species": [0, 1, 2, 0]}, "lennard_jones.epsilon", [1.0, 2.0],
         "species 2 has no lennard_jones.epsilon: there are 2 values"),
        (SPRING, "name", "two\nlines", "name: a name is one line of text without control characters"),
        (SPRING, "name", "x" * 201, "name: a name of 201 characters is too long: take at most 200"),
        (SPRING, "species", [2**31, 0], "species.0: Input should be less than or equal to 2147483647"),
        (SPRING, "seed", 2**63, "seed: Input should be less than or equal to 9223372036854775807"),
        (SPRING, "initial.kind", "x" * 5000, "... (5000 characters)"),
        (SPRING, "x\ny", 1.0, "unknown key 'x\\ny'"),
    ],
)  # fmt: skip
def test_impossible_values_are_named(tmp_path: Path, table: Any, path: str, value: Any, message: str) -> None:
    with pytest.raises(UsageError) as error:
        load(tmp_path, changed(table, path, value))
    (line,) = str(error.value).split("\n")
    assert message in line
    assert line.isprintable()


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"masses = " + b"9" * 5000, "not valid TOML"),
        (b"a = " + b"[" * 1000 + b"]" * 1000, "not valid TOML: tables or lists are nested too deeply"),
        ("name = 'a'".encode("utf-16"), "not valid TOML"),
        (b"name = '\xff'", "not valid TOML"),
        (b"name = 'a'\nname = 'b'", "not valid TOML"),
        (b"\x00\x01\x02", "not valid TOML"),
        (b"masses = [" + b"'x'," * 100 + b"]", "mistakes more"),
    ],
)
def test_files_that_are_no_scene(tmp_path: Path, data: bytes, message: str) -> None:
    assert message in a_scene_or_a_message(tmp_path / "scene.toml", data)


def test_a_byte_order_mark_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    load(tmp_path, SPRING)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert Scene.load(path).name == "a"


@pytest.mark.parametrize("where", ["scene", "initial.path"])
def test_only_a_regular_file_is_opened(tmp_path: Path, where: str) -> None:
    """A pipe without a writer would block for ever, and /dev/zero would fill the memory."""
    os.mkfifo(tmp_path / "pipe")
    for name, reason in (("pipe", "a pipe"), ("/dev/zero", "a device"), (".", "a directory"), ("x" * 300, "too long")):
        path = tmp_path / name
        if where == "initial.path":
            path = tmp_path / "scene.toml"
            path.write_text(tomli_w.dumps(changed(SPRING, "initial", {"kind": "file", "path": name})))
        with pytest.raises(UsageError, match=f"cannot be read.*{reason}"):
            Scene.load(path)


def test_a_configuration_of_three_dimensional_arrays(tmp_path: Path) -> None:
    np.savez(tmp_path / "start.npz", positions=np.zeros((2, 2, 2)))
    with pytest.raises(UsageError, match=r"initial.path = .*start.npz: ") as error:
        load(tmp_path, changed(SPRING, "initial", {"kind": "file", "path": "start.npz"}))
    assert str(error.value).isprintable() or "\n" in str(error.value)


def test_without_a_kind_a_start_with_positions_is_explicit(tmp_path: Path) -> None:
    assert load(tmp_path, changed(SPRING, "initial.kind", ...)) == load(tmp_path, SPRING)
