"""The generated pages of docs/reference are up to date, complete, and their examples run."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from crosscheck.documents import PAGES, write
from crosscheck.documents.markdown import COMMAND
from crosscheck.documents.scene_words import EXAMPLES, scene_words, unit_and_meaning
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.scene import Scene
from crosscheck.scene.parts import INTERACTIONS
from crosscheck.scene.tables import Table, tables

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"


@pytest.mark.parametrize("name", PAGES)
def test_a_written_page_is_up_to_date(name: str) -> None:
    written = (REFERENCE / name).read_text(encoding="utf-8")
    assert written == PAGES[name](), f"docs/reference/{name} is stale: run `{COMMAND}` in the root of the project"


def test_nothing_else_is_among_the_generated_pages() -> None:
    assert {path.name for path in REFERENCE.iterdir()} == set(PAGES)


def test_pages_are_written_into_a_directory(tmp_path: Path) -> None:
    for path in write(tmp_path / "new" / "pages"):
        text = path.read_text(encoding="utf-8")
        assert text == PAGES[path.name]()
        assert f"This file is generated: change the code and run `{COMMAND}`." in text[:200]


# -- words of a scene -----------------------------------------------------------------------------------


@pytest.mark.parametrize("table", tables(Scene), ids=lambda table: table.title or "scene")
def test_every_word_says_what_it_is_in_which_unit_and_what_holds_without_it(table: Table) -> None:
    for word, entry in table.part.model_json_schema()["properties"].items():
        unit, meaning = unit_and_meaning(entry["description"])
        assert meaning.endswith("."), word
        if "number" in json.dumps([entry.get("type"), entry.get("items"), entry.get("anyOf")]):
            assert unit, f"{table.title}: {word} is a number and needs a unit: [length], [1/time], [1] ..."
        if "default" in entry and (entry["default"] is None or isinstance(entry["default"], list | dict)):
            assert "absent" in meaning.lower(), f"{table.title}: say what holds if {word} is absent"


def test_the_page_has_every_word_of_every_table() -> None:
    page = scene_words()
    for table in tables(Scene):
        assert not table.title or f"\n## `{table.title}`\n" in page
        for word in table.part.model_fields:
            assert f"\n| `{word}` |" in page


def test_the_schema_describes_every_word() -> None:
    schema = json.loads(PAGES["scene.schema.json"]())
    for definition in (schema, *schema["$defs"].values()):
        assert definition["description"]
        for word, entry in definition["properties"].items():
            assert entry["description"], word


def test_there_is_an_example_of_each_interaction() -> None:
    assert set(EXAMPLES) == set(INTERACTIONS)
    page = scene_words()
    assert all(example in page for example in EXAMPLES.values())


@pytest.mark.parametrize("interaction", INTERACTIONS)
def test_an_example_is_a_scene_that_can_be_run(interaction: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(EXAMPLES[interaction], encoding="utf-8")
    assert interaction in tomllib.loads(EXAMPLES[interaction])
    scene = Scene.load(path)
    assert scene.method is not None
    assert RefimplEngine().supports(scene, scene.method) is None
    if scene.number:
        assert len(scene.initial_state().positions) == scene.number
    else:
        assert scene.initial_sites().size > 0
