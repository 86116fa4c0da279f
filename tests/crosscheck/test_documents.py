"""The generated pages of docs/reference are up to date, complete, and their examples run."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from random import Random
from typing import Any

import hostile
import jsonschema
import pytest
import synthetic
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.documents import PAGES, write
from crosscheck.documents.markdown import COMMAND
from crosscheck.documents.record_schema import record_schema
from crosscheck.documents.scene_words import EXAMPLES, scene_words, unit_and_meaning
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.record import FILE, SCHEMA, case_name, read, worst_judgement
from crosscheck.record_form import check_form, parse
from crosscheck.scene import Scene
from crosscheck.scene.parts import INTERACTIONS
from crosscheck.scene.tables import Table, tables

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"


@pytest.mark.parametrize("name", PAGES)
def test_a_written_page_is_up_to_date(name: str) -> None:
    written = (REFERENCE / name).read_text(encoding="utf-8")
    assert written == PAGES[name](), f"docs/reference/{name} is stale: run `{COMMAND}` in the root of the project"


def test_nothing_else_is_among_the_generated_pages() -> None:
    assert {path.name for path in REFERENCE.iterdir()} == {name for name in PAGES if "/" not in name}


def test_pages_are_written_into_a_directory(tmp_path: Path) -> None:
    for name, path in zip(PAGES, write(tmp_path / "new" / "pages"), strict=True):
        text = path.read_text(encoding="utf-8")
        assert text == PAGES[name]()
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


# -- lines of the record --------------------------------------------------------------------------------


LINE_SCHEMA = json.loads(record_schema())
LINE_FORM = jsonschema.Draft202012Validator(LINE_SCHEMA)


def faults_of_line(line: dict[str, Any]) -> list[str]:
    """Where a line departs from the schema, and how."""
    return [f"{fault.json_path}: {fault.message}" for fault in LINE_FORM.iter_errors(line)]


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(LINE_SCHEMA)


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """A record with every outcome and every kind of figure."""
    return read(synthetic.write(tmp_path_factory.mktemp("record")))


def test_lines_of_a_record_follow_the_schema(lines: list[dict[str, Any]]) -> None:
    assert {line["outcome"] for line in lines} == {"pass", "fail", "inconclusive", "skip", "error"}
    for line in lines:
        assert faults_of_line(line) == []
        assert line.keys() == LINE_SCHEMA["properties"].keys()
        for judgement in line["judgements"]:
            assert judgement.keys() == LINE_SCHEMA["$defs"]["Judgement"]["properties"].keys()


def as_schema_1(line: dict[str, Any]) -> dict[str, Any]:
    """The line as schema 1 had it, whose figures, in its last version, were those of now."""
    old = {key: value for key, value in line.items() if key not in ("variant", "tier", "judgements", "worst")}
    found = worst_judgement(line)
    names = ("quantity", "measured", "uncertainty", "expected", "expected_uncertainty", "deviation", "sensitivity")
    old |= {name: None if found is None else found[name] for name in names}
    old |= {"schema": 1, "check": case_name(line), "criterion": None, "deviation_unit": None}
    if found is not None:
        criterion = {key: value for key, value in found["criterion"].items() if key != "sense"}
        unit = "tolerance" if found["sigmas"] is None else "sigma"
        deviation = found["deviation"] if found["sigmas"] is None else found["sigmas"]
        old |= {"criterion": criterion, "deviation_unit": unit, "deviation": deviation}
    return old


def test_lines_of_schema_1_are_brought_to_the_schema(lines: list[dict[str, Any]], tmp_path: Path) -> None:
    old = [as_schema_1(line) for line in lines]
    assert all(faults_of_line(line) for line in old)
    (tmp_path / FILE).write_text("".join(json.dumps(line) + "\n" for line in old))
    brought = read(tmp_path)
    assert len(brought) == len(lines)
    for line, new in zip(brought, lines, strict=True):
        assert faults_of_line(line) == []
        found, meant = worst_judgement(line), worst_judgement(new)
        if found is not None and meant is not None:
            assert found["criterion"] == meant["criterion"]
            assert found["sensitivity"] == meant["sensitivity"]
            assert found["deviation"] == pytest.approx(meant["deviation"])


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"schema": 1}, "$.schema: 2 was expected"),
        ({"outcome": "green"}, "$.outcome: 'green' is not one of"),
        ({"worst": 0.5}, "$.worst: 0.5 is not"),
        ({"judgements": [{}]}, "$.judgements[0]: 'outcome' is a required property"),
        ({"figures": [{"title": 1}]}, "$.figures[0].title: 1 is not of type 'string'"),
        ({"cost": {"seconds": "1"}}, "$.cost.seconds: '1' is not"),
    ],
)
def test_the_schema_finds_faults(lines: list[dict[str, Any]], change: dict[str, Any], fault: str) -> None:
    assert any(found.startswith(fault) for found in faults_of_line(lines[0] | change))
    without = {key: value for key, value in lines[0].items() if key not in change}
    assert faults_of_line(without) == [f"$: {key!r} is a required property" for key in change]


@given(random=st.randoms(use_true_random=True))
@settings(max_examples=200, deadline=None)
def test_what_is_read_from_a_damaged_record_follows_the_schema(random: Random, lines: Any) -> None:
    """What `read` accepts is declared apart from the schema, which follows what is written."""
    valid = tuple(text for text in (json.dumps(line).encode() for line in lines) if len(text) < 5000)
    for text in hostile.record(random, valid).split(b"\n")[:-1]:
        try:
            line = parse(text.decode())
            check_form(line, SCHEMA)
        except ValueError:
            continue
        assert line["schema"] != SCHEMA or faults_of_line(line) == []


def test_the_page_of_the_record_has_every_field() -> None:
    text = (REFERENCE.parent / "record.md").read_text("utf-8")
    rows = "".join(row for row in text.splitlines() if row.startswith("| `"))
    named = set(re.findall("`([a-z_]+)`", rows))
    named |= {"title", "x_label", "y_label", "x_scale", "y_scale"}  # in the sentence above the table of a figure
    for part in (LINE_SCHEMA, *LINE_SCHEMA["$defs"].values()):
        assert set(part["properties"]) <= named


def test_the_example_of_the_page_of_the_record_follows_the_schema() -> None:
    text = (REFERENCE.parent / "record.md").read_text("utf-8")
    example = json.loads(text.partition("```json\n")[2].partition("```")[0])
    assert faults_of_line(example) == []
