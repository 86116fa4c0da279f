"""Planted faults: named source substitutions in `refimpl`, applied to an overlay copy, never to the installed one."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from crosscheck.errors import UsageError


@dataclass(frozen=True)
class Fault:
    """In `refimpl/<file>`, `old` becomes `new`; `breaks` says in words what is then wrong.

    `old` must occur exactly once in the file: a substitution that no longer matches is an error.
    """

    name: str
    file: str
    old: str
    new: str
    breaks: str

    def apply(self, directory: Path) -> None:
        """Writes a copy of `refimpl` with the fault in it to `directory`/refimpl."""
        import refimpl

        shutil.copytree(Path(refimpl.__path__[0]), directory / "refimpl", ignore=shutil.ignore_patterns("__pycache__"))
        target = directory / "refimpl" / self.file
        text = target.read_text(encoding="utf-8") if target.is_file() else ""
        count = text.count(self.old)
        if count != 1:
            raise UsageError(
                f"fault '{self.name}': its text occurs {count} times in refimpl/{self.file}, not once; "
                f"mend the fault: {self.old!r}"
            )
        target.write_text(text.replace(self.old, self.new), encoding="utf-8")
