"""What a command of `crosscheck` leaves behind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Outcome(NamedTuple):
    """Exit status, output, and errors of one command."""

    status: Any
    out: str
    err: str


#: Runs `crosscheck <words>`.
Command = Callable[..., Outcome]
