"""Damaged records: each is read, and can then be shown, or one line says which line is no verdict, and why."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from random import Random
from typing import Any

import hostile
import pytest
import synthetic
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.errors import UsageError
from crosscheck.record import FILE, is_torn, read
from crosscheck.record_form import check_form, parse
from crosscheck.report.html import render
from crosscheck.report.junit import write_junit


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("record")


class Lines(tuple[bytes, ...]):
    """Lines of a record, which a failing example does not print."""

    def __repr__(self) -> str:
        return f"{len(self)} lines"


@pytest.fixture(scope="module")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Lines:
    """Lines of every outcome and with every kind of figure, the shorter ones."""
    lines = synthetic.write(tmp_path_factory.mktemp("valid")).joinpath(FILE).read_bytes().split(b"\n")[:-1]
    return Lines(line for line in lines if len(line) < 20000)


@pytest.fixture(scope="module")
def line(valid: Lines) -> dict[str, Any]:
    """A verdict with a judgement and a figure."""
    lines = [json.loads(text) for text in valid]
    found: dict[str, Any] = next(one for one in lines if one["outcome"] == "fail" and one["figures"])
    return found


def lines_or_a_message(directory: Path, data: bytes) -> list[dict[str, Any]] | str:
    """The lines of a record, or the message, one line that names the line of the file."""
    (directory / FILE).write_bytes(data)
    try:
        return read(directory)
    except UsageError as error:
        message = str(error)
        assert message.isprintable()
        assert message.startswith(f"{directory / FILE}:")
        return message


@given(random=st.randoms(use_true_random=True))
@settings(max_examples=2500, deadline=None)
def test_a_damaged_record_is_read_or_named(random: Random, valid: Lines, directory: Path) -> None:
    found = lines_or_a_message(directory, hostile.record(random, valid))
    if not isinstance(found, str):
        write_junit(found, directory / "junit.xml")
        assert len(list(ET.parse(directory / "junit.xml").iter("testcase"))) == len(found)


@given(random=st.randoms(use_true_random=True))
@settings(max_examples=5, deadline=None)
def test_what_is_read_can_be_drawn(random: Random, valid: Lines, directory: Path) -> None:
    found: list[dict[str, Any]] | str = ""
    while isinstance(found, str):
        found = lines_or_a_message(directory, hostile.record(random, valid))
    assert "</html>" in render(found, "a record")


def changed(line: Any, path: str, value: Any) -> Any:
    """A copy of a line with another value at a path, as "figures.0.title"; without the field, if the value is ..."""
    copy = json.loads(json.dumps(line))
    *above, last = [int(key) if key.isdecimal() else key for key in path.split(".")]
    owner = copy
    for key in above:
        owner = owner[key]
    if value is ...:
        del owner[last]
    else:
        owner[last] = value
    return copy


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("cost", ..., "'cost' is missing"),
        ("cost.seconds", "1", "'cost.seconds': Input should be a valid number"),
        ("cost.seconds", True, "'cost.seconds': Input should be a valid number"),
        ("check", 5, "'check': Input should be a valid string"),
        ("engine", None, "'engine': Input should be a valid string"),
        ("outcome", "green", "'outcome': Input should be 'pass', 'fail'"),
        ("outcome", "pass", "'outcome' is not that of the judgement 'worst'"),
        ("outcome", "skip", "a verdict 'skip' has no judgements, and 'worst' is null"),
        ("worst", None, "'worst' is not the index of a judgement"),
        ("worst", -1, "'worst' is not the index of a judgement"),
        ("worst", 10**17, "'worst' is not the index of a judgement"),
        ("judgements.0", [], "'judgements.0': Input should be a valid dictionary"),
        ("judgements.0.measured", "x", "'judgements.0.measured': Input should be a valid number"),
        ("judgements.0.measured", 10**400, "'judgements.0.measured': Input should be a finite number"),
        ("judgements.0.criterion", ..., "'judgements.0.criterion' is missing"),
        ("judgements.0.criterion.kind", "guess", "'judgements.0.criterion.kind': Input should be 'round_off'"),
        ("provenance", {}, "'provenance.seed' is missing"),
        ("provenance.versions", [], "'provenance.versions': Input should be a valid dictionary"),
        ("figures.0.x_scale", "wide", "'figures.0.x_scale': Input should be 'linear' or 'log'"),
        ("figures.0.series.0.y", [1.0], "'figures.0.series.0': x, y and error differ in length"),
        ("figures.0.series.0.x", "abc", "'figures.0.series.0.x': Input should be a valid list"),
        ("schema", 3, "schema 3, this version reads 1 to 2; run again"),
        ("schema", True, "schema True, this version reads 1 to 2"),
        ("schema", None, "'schema' is missing"),
    ],
)
def test_the_first_field_that_is_wrong_is_named(
    line: dict[str, Any], directory: Path, path: str, value: Any, message: str
) -> None:
    damaged = json.dumps(changed(line, path, value)).encode()
    found = lines_or_a_message(directory, json.dumps(line).encode() + b"\n" + damaged + b"\n")
    assert isinstance(found, str)
    assert f"{FILE}:2: " in found
    assert message in found


@pytest.mark.parametrize(
    ("container", "message"),
    [
        ({"shape": "drum", "x": 0, "y": 0, "radius": 0}, "a container needs an inside that can be drawn"),
        ({"shape": "drum", "x": 1e308, "y": 0, "radius": 1}, "a container needs an inside"),
        ({"shape": "box", "left": 1, "right": 0, "bottom": 0, "top": 1, "walls": []}, "a container needs an inside"),
        ({"shape": "box", "left": 0, "right": 1, "bottom": 0, "top": 1, "walls": ["front"]}, "walls.0"),
        ({"shape": "ball"}, "container"),
    ],
)
@pytest.mark.parametrize("what", ["snapshot", "map"])
def test_pictures_that_cannot_be_drawn(
    line: dict[str, Any], directory: Path, what: str, container: dict[str, Any], message: str
) -> None:
    snapshot = {
        "x": [1],
        "y": [1],
        "radius": 1,
        "container": container,
        "value": None,
        "value_label": "",
        "limits": None,
    }
    field = {"values": [[1]], "container": container, "value_label": "", "limits": None, "arrows": None}
    picture = {"snapshot": snapshot, "map": field | {"arrow_label": ""}}[what]
    found = lines_or_a_message(directory, json.dumps(changed(line, f"figures.0.{what}", picture)).encode() + b"\n")
    assert isinstance(found, str)
    assert message in found


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"y": [1, 2]}, "x, y, radius and value differ in length"),
        ({"radius": [1, 2]}, "x, y, radius and value differ in length"),
        ({"limits": [1, 1]}, "limits must rise"),
        ({"limits": [1]}, "List should have at least 2 items"),
    ],
)
def test_snapshots_that_contradict_themselves(
    line: dict[str, Any], directory: Path, changes: dict[str, Any], message: str
) -> None:
    drum = {"shape": "drum", "x": 0, "y": 0, "radius": 1}
    snapshot = {"x": [1], "y": [1], "radius": 1, "container": drum, "value": [1], "value_label": "", "limits": None}
    for picture, expected in ((snapshot, ""), (snapshot | changes, message)):
        damaged = changed(changed(line, "figures.0.series", []), "figures.0.snapshot", picture)
        found = lines_or_a_message(directory, json.dumps(damaged).encode() + b"\n")
        assert (expected in found) if isinstance(found, str) else not expected


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b'"seconds": 0.31', b'"seconds": NaN', "NaN is no number in JSON: what is not finite is null"),
        (b'"seconds": 0.31', b'"seconds": -Infinity', "-Infinity is no number in JSON"),
        (b'"seconds": 0.31', b'"seconds": 1e999', "'cost.seconds': Input should be a finite number"),
        (b'"seconds": 0.31', b'"seconds": ' + b"9" * 400, "'cost.seconds': Input should be a finite number"),
        (b'"seconds": 0.31', b'"seconds": ' + b"9" * 5000, "'cost.seconds': Input should be a finite number"),
        (b'"seconds": 0.31', b'"seconds": 1, "seconds": 2', "'seconds' is there twice"),
        (b'"seconds": 0.31', b'"seconds": ' + b"[" * 10**5, "nested too deeply"),
        (b'"seconds"', b'"\xff"', "not UTF-8 (byte "),
        (b'"seconds"', b'"sec\nonds"', "not JSON ("),
        (b"{", b"", "not JSON ("),
        (b"{", b"[1, {", "not JSON ("),
    ],
)
def test_lines_that_are_not_json(line: dict[str, Any], directory: Path, old: bytes, new: bytes, message: str) -> None:
    whole = json.dumps(changed(line, "cost.seconds", 0.31)).encode() + b"\n"
    assert old in whole
    found = lines_or_a_message(directory, whole.replace(old, new, 1))
    assert isinstance(found, str)
    assert f"{FILE}:1: not a verdict: {message}" in found


@pytest.mark.parametrize("data", [b"\n", b"[]\n", b"null\n", b"\0\0\0\n"])
def test_lines_that_hold_nothing(directory: Path, data: bytes) -> None:
    assert "not a verdict" in lines_or_a_message(directory, data)


@pytest.mark.parametrize("text", ["\u2028", "\x85", "\r", "\x1c", "\ud800", "\x00", "$\\foo$", "</script>"])
def test_a_text_holds_any_character(line: dict[str, Any], directory: Path, text: str) -> None:
    """U+2028 and others end lines of text, but not those of a record; a surrogate is a byte of a file's name."""
    damaged = changed(changed(line, "message", text), "engine", f"{text}.py:Class")
    for data in (json.dumps(damaged), json.dumps(damaged, ensure_ascii=False)):
        if text == "\ud800" and text in data:
            continue
        assert lines_or_a_message(directory, data.encode() + b"\n") == [damaged]
    write_junit([damaged], directory / "junit.xml")
    ET.parse(directory / "junit.xml")


def test_a_byte_order_mark_and_line_ends_of_windows_are_left_out(line: dict[str, Any], directory: Path) -> None:
    assert lines_or_a_message(directory, b"\xef\xbb\xbf" + json.dumps(line).encode() + b"\r\n") == [line]


def test_fields_of_later_versions_are_left_alone(line: dict[str, Any], directory: Path) -> None:
    later = changed(changed(line, "new", [1]), "judgements.0.new", {"a": None})
    assert lines_or_a_message(directory, json.dumps(later).encode() + b"\n") == [later]


def test_a_torn_last_line_is_seen(line: dict[str, Any], directory: Path) -> None:
    whole = json.dumps(line).encode() + b"\n"
    for data, torn in ((whole, False), (whole + whole[:50], True), (whole[:-1], True), (b"", False)):
        assert lines_or_a_message(directory, data) == ([line] if whole in data else [])
        assert is_torn(directory) == torn


def test_every_line_that_is_written_has_the_form(valid: Lines) -> None:
    for text in valid:
        check_form(parse(text.decode()), 2)
