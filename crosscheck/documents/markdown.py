"""Markdown of generated pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

COMMAND = "python -m crosscheck.documents"
#: At the top of every generated file.
NOTICE = f"This file is generated: change the code and run `{COMMAND}`."


def page(title: str, lines: Iterable[str]) -> str:
    """The text of a page: the notice that it is generated, its title, and the lines."""
    return "\n".join([f"<!-- {NOTICE} -->", "", f"# {title}", "", *lines]) + "\n"


def table_of(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The lines of a table. head: its column titles. rows: its cells, texts of one line, in which "|" is escaped."""
    cells = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in cells]
