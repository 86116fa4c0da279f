"""`python -m crosscheck.budget [PATTERN ...]`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Optional

import typer

from crosscheck.budget.counting import count
from crosscheck.budget.loads import FILE

_FILE = Path(__file__).with_name(FILE)


def main(
    patterns: Annotated[Optional[list[str]], typer.Argument(help="Shell patterns of cases; none: all.")] = None,  # noqa: UP045
    path: Annotated[Path, typer.Option(help="The file that is written.")] = _FILE,
) -> None:
    """Count what the cases consist of, in steps, events and sites, for `crosscheck run --budget`."""
    for line in count(path, patterns or []):
        print(line, flush=True)


if __name__ == "__main__":
    typer.run(main)
