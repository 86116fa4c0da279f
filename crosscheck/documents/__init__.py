"""Pages of docs/reference that are generated from the code: `python -m crosscheck.documents [DIRECTORY]` writes them.

One of them, of the extreme cases, stands above, beside the pages that explain what the checks judge. A page is a
function that returns its text, and an entry of `PAGES`. A test fails if a written page differs from it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from crosscheck.documents.compare_schema import compare_schema
from crosscheck.documents.extreme import extreme
from crosscheck.documents.record_schema import record_schema
from crosscheck.documents.registry import checks, engines, observables, schemes
from crosscheck.documents.scene_words import scene_schema, scene_words

#: Path of each generated file from docs/reference, and the function that returns its text.
PAGES: dict[str, Callable[[], str]] = {
    "scene-words.md": scene_words,
    "scene.schema.json": scene_schema,
    "record.schema.json": record_schema,
    "compare.schema.json": compare_schema,
    "observables.md": observables,
    "engines.md": engines,
    "schemes.md": schemes,
    "checks.md": checks,
    "../extreme.md": extreme,
}


def write(directory: Path) -> list[Path]:
    """Writes all pages into `directory`, which is made if need be; returns their paths."""
    directory.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, text in PAGES.items():
        paths.append(directory / name)
        paths[-1].write_text(text(), encoding="utf-8", newline="\n")
    return paths
