"""`python -m crosscheck.documents [DIRECTORY]`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from crosscheck.documents import write


def main(
    directory: Annotated[Path, typer.Argument(help="where the pages are written")] = Path("docs/reference"),
) -> None:
    """Write the pages of docs/reference that are generated from the code."""
    for path in write(directory):
        print(path)


if __name__ == "__main__":
    typer.run(main)
