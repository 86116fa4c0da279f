"""The environment of all pages: templates of this folder, filled with escaped text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from markupsafe import Markup

from crosscheck import painter
from crosscheck.report import figures, numbers

if TYPE_CHECKING:
    import jinja2


def templates() -> jinja2.Environment:
    """Templates of this folder, with the filters for numbers, and the colours that the style sheet asks for."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(
        seconds=numbers.seconds,
        number=numbers.count,
        measured=numbers.measured,
        expected=numbers.expected,
        deviation=numbers.deviation,
        sensitivity=numbers.sensitivity,
        svg=Markup,
    )
    environment.globals.update(palette=figures.PALETTE, colour_map=painter.colours())
    return environment
