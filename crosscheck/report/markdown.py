"""A summary in Markdown, for the pages of CI servers: counts, failures with their numbers, what changed."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

from crosscheck.files import naming
from crosscheck.record import Line, case_name, deciding
from crosscheck.report import numbers
from crosscheck.status import false_alarms
from crosscheck.text import printable

#: The environment variable that names the file whose text GitHub shows on the page of a job.
VARIABLE = "GITHUB_STEP_SUMMARY"
#: Bytes of a summary, and of all that the commands of one step write: of more than 1 MiB GitHub shows nothing.
MOST_BYTES, MOST_BYTES_OF_A_STEP = 1 << 19, 1 << 20
#: Rows of a table: a page of thousands helps nobody.
MOST_ROWS = 200
#: Verdicts by what should be read first.
_ORDER = ("fail", "error", "inconclusive", "skip", "pass")


class Section(NamedTuple):
    """A table of a summary. title: its own. head: those of its columns. rows: cells. folded: hidden at first."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    folded: bool = False


def of_run(
    lines: Sequence[Line], reasons: Sequence[str], command: str, compared: str = "", sections: Iterable[Section] = ()
) -> str:
    """The summary of a run.

    lines: of the record. reasons: why nothing was judged, or not all. command: the command line. compared: a sentence
    on what the run was compared with, and sections: the tables of that.
    """
    counts = Counter(line["outcome"] for line in lines)
    total = ", ".join(f"{counts[one]} {one}" for one in _ORDER if counts[one]) or "nothing was judged"
    opening = [f"**{total}**", *(_plain(one) for one in (*reasons, compared) if one)]
    red = Section("Not green", ("case", "engine", "verdict", "quantity", "measured", "expected", "off by"), _red(lines))
    skipped = Counter((line["engine"], line["message"]) for line in lines if line["outcome"] == "skip")
    reasons_of = [(engine, str(number), reason) for (engine, reason), number in skipped.items()]
    tables = [red, *sections, Section("Skipped", ("engine", "cases", "reason"), reasons_of, folded=True)]
    closing = [*filter(None, [false_alarms(lines)]), f"<code>{escape(printable(command), quote=False)}</code>"]
    return page(opening, [one for one in tables if one.rows], closing)


def page(opening: Sequence[str], sections: Iterable[Section], closing: Sequence[str]) -> str:
    """The text of a summary of at most `MOST_BYTES`: what does not fit is left out, and said to be.

    opening, closing: paragraphs, as they are. sections: the tables between them.
    """
    last = "\n\n".join(closing) + "\n"
    parts = ["## particle-crosscheck", *opening]
    size = sum(len(part.encode()) + 2 for part in (*parts, last))
    for section in sections:
        text = _table(section)
        size += len(text.encode()) + 2
        if size > MOST_BYTES - 200:
            parts.append("The rest does not fit on this page: the record has it.")
            break
        parts.append(text)
    return "\n\n".join([*parts, last])


def _table(section: Section) -> str:
    """A section: its title, its table, and how many rows were left out."""
    shown = section.rows[:MOST_ROWS]
    rows = [section.head, ["---"] * len(section.head), *([_plain(cell) for cell in row] for row in shown)]
    text = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    if len(section.rows) > len(shown):
        text += f"\n\nand {len(section.rows) - len(shown)} more"
    if section.folded:
        return f"<details><summary>{escape(printable(section.title), quote=False)}</summary>\n\n{text}\n\n</details>"
    return f"### {_plain(section.title)}\n\n{text}"


def _red(lines: Sequence[Line]) -> list[tuple[str, ...]]:
    """A row for every judgement that decides a verdict that is not green, and for every error."""
    rows: list[tuple[str, ...]] = []
    for line in sorted(lines, key=lambda one: (_ORDER.index(one["outcome"]), case_name(one), one["engine"])):
        head = (case_name(line), line["engine"], line["outcome"])
        if line["outcome"] == "error":
            rows.append((*head, line["message"].partition("\n")[0], "", "", ""))
        elif line["outcome"] in ("fail", "inconclusive"):
            shown = (numbers.measured, numbers.expected, numbers.deviation)
            rows += [(*head, one["quantity"], *(show(one) for show in shown)) for one in deciding(line)]
    return rows


def _plain(text: str) -> str:
    """The text on one line, without anything that Markdown or HTML would read as more than text."""
    return re.sub(r"([\\`*_{}\[\]<>|#~])", r"\\\1", printable(text)).replace("&", "&amp;")


def append(text: str, path: Path | None) -> None:
    """Appends a summary to the file of the CI server, and writes it to another one.

    text: the summary. path: a file for it, which is replaced; None: none. The server's is the one that the environment
    variable `VARIABLE` names, if it is set; where it has no room left, nothing is added.
    """
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        with naming(path):
            path.write_text(text, encoding="utf-8")
    if (server := of_server()) is not None:
        before = server.stat().st_size if server.exists() else 0
        with naming(server), server.open("a", encoding="utf-8") as file:
            if before + len(text.encode()) <= MOST_BYTES_OF_A_STEP:
                file.write(text)


def of_server() -> Path | None:
    """The file of the CI server for summaries; None: there is none."""
    name = os.environ.get(VARIABLE)
    return Path(name) if name else None
