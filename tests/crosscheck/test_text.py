"""Text of users breaks no line, no terminal and no file format, and loses nothing."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.text import printable, shortened

#: Any text, with halves of surrogate pairs, as names of files hold that are not UTF-8.
anything = st.text(st.characters(codec=None, exclude_categories=()))


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a b σ é 漢 🙂", "a b σ é 漢 🙂"),
        ("two\nlines\t", "two\\nlines\\t"),
        ("\x1b[31m\x00\x7f\x9f", "\\x1b[31m\\x00\\x7f\\x9f"),
        ("\u2028\udcff\ufffe", "\\u2028\\udcff\\ufffe"),
        ("$\\foo$", "$\\foo$"),
    ],
)
def test_what_cannot_be_shown_is_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown


@given(text=anything)
def test_printable_text_is_one_line_of_utf8(text: str) -> None:
    shown = printable(text)
    assert shown.encode("utf-8").decode() == shown
    assert len(shown.splitlines()) <= 1
    assert printable(shown) == shown
    assert printable(text, keep="\n").count("\n") == text.count("\n")


@given(text=anything.filter(lambda text: "\\" not in text))
def test_the_escapes_are_those_of_python(text: str) -> None:
    shown = printable(text)
    hidden = [character for character in text if printable(character) != character]
    assert len(shown) == len(text) + sum(len(printable(character)) - 1 for character in hidden)
    for character in hidden:
        assert json.loads('"\\u' + f'{ord(character):04x}"') == character == eval(f"'{printable(character)}'")


def test_a_long_text_is_shortened() -> None:
    assert shortened("x" * 60) == "x" * 60
    assert shortened("x" * 61) == "x" * 60 + "... (61 characters)"
    assert shortened("a\nb", 1) == "a... (3 characters)"
