"""Messages for mistakes in a scene: a line for each, with the path of the key, what was found, and how to mend it."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence

from pydantic import ValidationError

from crosscheck.scene.parts import LARGEST, Part
from crosscheck.scene.tables import Table, tables
from crosscheck.text import shortened

#: Characters of the longest message, more than the lists of allowed words have, and lines that are shown of many.
_LONGEST, _MOST = 1500, 20
#: For an entry that may be one value or a list of values, pydantic reports the errors of both forms, and the place of
#: each error ends in the name of its form.
_ONE, _LIST = re.compile(r"constrained-float|float|function-after\[.*"), re.compile(r"tuple\[.*")


def explain(error: ValidationError, where: str, scene: type[Part]) -> str:
    """A line for each mistake: the path of the key, what is wrong, and how to mend it.

    error: as pydantic raised it. where: what every line starts with, such as the path of a file. scene: the model that
    was validated.
    """
    lines: list[str] = []
    suggested: set[str] = set()
    kinds = [table.path for table in tables(scene) if "kind" in table.part.model_fields]
    # unknown keys first: a key that is misspelt is not reported as missing too
    for problem in sorted(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden"):
        place, kind, found = problem["loc"], problem["type"], problem["input"]
        last = str(place[-1]) if place else ""
        # of the two forms, report the errors of the one that was given
        if _LIST.fullmatch(last) or (_ONE.fullmatch(last) and isinstance(found, list | tuple)):
            continue
        keys = [
            shortened(str(key))
            for i, key in enumerate(place)
            if tuple(place[: i + 1]) not in kinds and not (_ONE.fullmatch(str(key)) or _LIST.fullmatch(str(key)))
        ]
        path = ".".join(keys)
        if kind == "extra_forbidden":
            near, hint = _hint(last, place[:-1], tables(scene))
            suggested.add(".".join([*keys[:-1], near]))
            lines.append(f"unknown key '{path}'; {hint}")
        elif kind == "missing":
            if path not in suggested:
                lines.append(f"'{path}' is missing: add it")
        elif kind in ("union_tag_not_found", "union_tag_invalid"):
            names = ", ".join(names[-1] for names in kinds if names[:-1] == place)
            if kind == "union_tag_not_found":
                lines.append(f"'{path}.kind' is missing: add it, one of {names}")
            else:
                lines.append(f"{path}.kind: Input should be one of {names} (found {_value(problem['ctx']['tag'])})")
        else:
            message = shortened(problem["msg"].removeprefix("Value error, "), _LONGEST)
            value = f" (found {_value(found)})" if path and isinstance(found, str | int | float | bool) else ""
            lines.append(f"{path + ': ' if path else ''}{message}{value}")
    lines = list(dict.fromkeys(lines))
    if len(lines) > _MOST:
        lines[_MOST:] = [f"{len(lines) - _MOST} mistakes more"]
    return "\n".join(f"{where}: {line}" for line in lines)


def _value(found: str | float) -> str:
    """What was found, on one line; of a long one the beginning."""
    if isinstance(found, str):
        return repr(shortened(found))
    if isinstance(found, int) and abs(found) > LARGEST:
        return f"a whole number of size above {LARGEST:g}"
    return repr(found)


def _hint(key: str, place: tuple[int | str, ...], known: Sequence[Table]) -> tuple[str, str]:
    """A similar key of the table at this place, or "", and what to do about the unknown one."""
    for table in known:
        if table.matches(place):
            near = difflib.get_close_matches(key, table.part.model_fields, 1)
            if near:
                return near[0], f"did you mean '{near[0]}'?"
    scene, *others = known
    owners = list(dict.fromkeys(table.title for table in others if key in table.part.model_fields))
    if key in scene.part.model_fields:
        owners.append("the scene itself, above the first table")
    return "", f"it belongs in {' or '.join(owners)}" if owners else "remove it"
