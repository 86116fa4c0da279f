"""Markdown of generated pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

COMMAND = "python -m crosscheck.documents"
#: At the top of every generated file.
NOTICE = f"This file is generated: change the code and run `{COMMAND}`."


def page(title: str, lines: Iterable[str]) -> str:
    """A page with this title; it says that it is generated, and how."""
    return "\n".join([f"<!-- {NOTICE} -->", "", f"# {title}", "", *lines]) + "\n"


def table_of(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The lines of a table; cells may hold any text of one line."""
    cells = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in cells]
