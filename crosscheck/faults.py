"""Planted faults: named substitutions in the source of `refimpl`, made in a copy, never in the installed one."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from crosscheck.errors import UsageError


def sources(overlay: Path | None = None) -> Path:
    """The directory of the installed `refimpl`, or of the one in the directory `overlay`, which a worker runs."""
    import refimpl

    return Path(refimpl.__path__[0]) if overlay is None else overlay / "refimpl"


def copy_sources(package: Path, directory: Path) -> Path:
    """Copies a package without its bytecode to `directory`, under its own name, and returns the place.

    package: its directory.
    """
    copy = directory / package.name
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


@dataclass(frozen=True)
class Fault:
    """A substitution in a source file of `refimpl`, which a check must detect.

    name: of the fault. file: path below `refimpl/`. old, new: text that is replaced, and the text in its place. breaks:
    what is then wrong, in words.
    """

    name: str
    file: str
    old: str
    new: str
    breaks: str

    def apply(self, directory: Path) -> None:
        """Writes a copy of `refimpl` with the fault in it to `directory`/refimpl.

        UsageError unless `old` occurs exactly once in the file.
        """
        target = copy_sources(sources(), directory) / self.file
        text = target.read_text(encoding="utf-8") if target.is_file() else ""
        count = text.count(self.old)
        if count != 1:
            raise UsageError(
                f"fault '{self.name}': its text occurs {count} times in refimpl/{self.file}, not once; "
                f"mend the fault: {self.old!r}"
            )
        target.write_text(text.replace(self.old, self.new), encoding="utf-8")
