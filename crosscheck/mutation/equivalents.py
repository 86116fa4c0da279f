"""Mutations that change nothing that a check could see, each with the reason: `equivalents.toml` beside this file."""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from crosscheck.errors import UsageError
from crosscheck.mutation.draw import Mutant

_FILE = Path(__file__).parent / "equivalents.toml"
#: In place of `after`: whatever the mutation makes of the line.
ANY = "*"


@dataclass(frozen=True)
class Equivalent:
    """An entry of the file.

    file: path, "refimpl/..." or "crosscheck/...". function: dotted name of the function around the mutation, "" for the
    module. before, after: the text of the changed lines, without the white space around it; `ANY` for any text after.
    reason: why no check can see it.
    """

    file: str
    function: str
    before: str
    after: str
    reason: str

    def matches(self, mutant: Mutant) -> bool:
        """Whether the mutant is this one."""
        before, after = mutant.lines
        return (
            self.file == f"{mutant.package}/{mutant.file}"
            and self.function == mutant.mutation.function
            and self.before == before
            and self.after in (after, ANY)
        )


def equivalents(path: Path = _FILE) -> list[Equivalent]:
    """The entries of the file; path: another file. UsageError if an entry is incomplete, or says more."""
    found = []
    for number, entry in enumerate(tomllib.loads(path.read_text(encoding="utf-8")).get("equivalent", []), 1):
        try:
            one = Equivalent(**entry)
        except TypeError as error:
            raise UsageError(f"{path}: entry {number}: {error}") from None
        if not one.reason.strip():
            raise UsageError(f"{path}: entry {number}: it has no reason")
        found.append(one)
    return found


def unmatched(entries: Sequence[Equivalent]) -> list[Equivalent]:
    """The entries whose line is not in the sources any more."""
    found = []
    for one in entries:
        package, _, file = one.file.partition("/")
        path = Path(importlib.import_module(package).__path__[0]) / file
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        if one.before not in text:
            found.append(one)
    return found
