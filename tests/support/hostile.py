"""Input as it should not be: scene files and records, changed at random from valid ones or made up."""

from __future__ import annotations

import copy
import json
import math
import struct
import tomllib
from collections.abc import Callable
from datetime import date
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, Literal, get_args, get_origin

import tomli_w

import crosscheck
from crosscheck.documents.scene_words import EXAMPLES
from crosscheck.scene import Scene
from crosscheck.scene.parts import INTERACTIONS
from crosscheck.scene.tables import ANY_INDEX, ANY_KEY, tables

#: Values that have broken programs, by what they are.
NUMBERS = (
    *(0, 1, 2, 3, -1, 2**31, 2**53, 10**12, 2**63 - 1, 2**63, 10**30),
    *(-0.0, 0.5, 1e-3, 5e-324, 1e-300, 1e-100, 1e100, 1e308, -1e308, math.inf, -math.inf, math.nan),
)
TEXTS = (
    *("", "x", "a/b", "a\nb", "\x1b[31m", "$\\foo$", "x" * 5000, "\u2028", "..", "/dev/zero", "\x00"),
    *("hard", "open", "wall", "fcc", "square", "explicit", "lattice", "file", "occupations"),
    *("event_driven", "kinetic_energy", "populations", "fhp3"),
)
OTHERS: tuple[Any, ...] = (
    *(True, False, [], {}, [[]], ["x"], [{}], date(2020, 1, 1), {"kind": "lattice"}, {"radius": 1.0}),
    *([1.0], [1.0, 2.0], [1, 2, 3], [0, 0], [[1.0, 2.0]], [[0.0], [1.0]], [{"centre": [1.0, 1.0], "radius": 3.0}]),
)
#: Pieces that are put into the text of a file.
PIECES = (
    *(b"\xef\xbb\xbf", b"\xff", b"\x00", b"\r", b"\n", b"\xe2\x80\xa8", b'"', b"'", b"[", b"{", b"}", b"]", b"="),
    *(b"9" * 400, b"9" * 5000, b"[" * 1000, b"{a=" * 1000, b"a." * 200, b"e999", b"1e400", b"NaN", b"-inf", b"null"),
    *(b".", b"#", b"[x]\n", b"[[x]]\n"),
)


def value(random: Random) -> Any:
    """Any value of a scene or a record, likely one that means trouble."""
    how = random.random()
    if how < 0.1:
        return float(struct.unpack("<d", random.randbytes(8))[0])
    if how < 0.2:
        return random.randrange(-(2 ** random.choice((3, 10, 70))), 2 ** random.choice((3, 10, 70)))
    return copy.deepcopy(random.choice(NUMBERS if how < 0.6 else TEXTS if how < 0.75 else OTHERS))


def alike(random: Random, old: Any, new: Callable[[Random], Any]) -> Any:
    """A value of the type of `old`: of a number often a multiple of it, so that a scene may stay valid.

    new: makes a value of any type, where there is none like it.
    """
    if isinstance(old, bool):
        return not old
    if isinstance(old, int | float) and random.random() < 0.5:
        number = old * random.choice((0.5, 2, 3, -1, 10, 1e-3, 1e3, 1e6, 1e-6, 1e-12, 1e12, 1e-40, 1e40))
        return int(number) if isinstance(old, int) else number
    choices = [one for one in (*NUMBERS, *TEXTS, *OTHERS) if type(one) is type(old)]
    return copy.deepcopy(random.choice(choices)) if choices else new(random)


@cache
def shipped() -> tuple[dict[str, Any], ...]:
    """The shipped scenes as tables, with fewer particles, sites and steps."""
    found = []
    for file in sorted((Path(crosscheck.__path__[0]) / "scenes").glob("*.toml")):
        table = tomllib.loads(file.read_text(encoding="utf-8"))
        if table["initial"].get("number", 0) > 100 and "lengths" not in table["box"]:
            table["initial"]["number"] = 64
        found.append(table)
    return tuple(found)


@cache
def words() -> tuple[str, ...]:
    """All words of the scene language."""
    return tuple(sorted({word for table in tables(Scene) for word in table.part.model_fields}))


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The paths of all values below `value`, of long lists those of the first three items."""
    items: list[tuple[Any, Any]] = []
    if isinstance(value, dict):
        items = list(value.items())
    elif isinstance(value, list):
        items = list(enumerate(value[:3]))
    found = []
    for key, item in items:
        found.append((*path, key))
        found += places(item, (*path, key))
    return found


def _change(random: Random, tree: Any, new: Callable[[Random], Any], names: tuple[str, ...]) -> None:
    """One change in place: another value, a value less, one more, one twice, or one taken from elsewhere."""
    paths = places(tree)
    if not paths:
        return
    *above, key = random.choice(paths)
    owner = tree
    for step in above:
        owner = owner[step]
    how = random.choice(("set",) * 9 + ("delete", "add", "add", "repeat", "take"))
    if how == "set":
        owner[key] = alike(random, owner[key], new) if random.random() < 0.8 else new(random)
    elif how == "delete":
        del owner[key]
    elif how == "add" and isinstance(owner, dict):
        owner[random.choice(names)] = new(random)
    elif how == "repeat" and isinstance(owner, list):
        owner.insert(key, copy.deepcopy(owner[key]))
    elif how == "take":
        *there, last = random.choice(paths)
        other = tree
        for step in there:
            other = other[step]
        owner[key] = copy.deepcopy(other[last])


def _torn(random: Random, data: bytes) -> bytes:
    """The bytes with a piece put in, or some left out."""
    place = random.randint(0, len(data))
    if random.random() < 0.5:
        return data[:place] + random.choice(PIECES) + data[place:]
    return data[:place] + data[place + random.randint(1, 40) :]


def scene_file(random: Random) -> bytes:
    """A shipped scene with up to four changes of its values, and in some cases of its bytes."""
    table = copy.deepcopy(random.choice(shipped()))
    for _ in range(random.choice((1, 1, 2, 2, 4))):
        _change(random, table, value, words())
    data = tomli_w.dumps(table).encode()
    return _torn(random, data) if random.random() < 0.15 else data


def made_up_scene_file(random: Random) -> bytes:
    """A minimal scene of an interaction with words in their tables, of values of their types, and some that are not."""
    table = tomllib.loads(random.choice(list(EXAMPLES.values())))
    others = [name for name in (*INTERACTIONS, "box") if name not in table]
    fitting = [
        one
        for one in tables(Scene)
        if ANY_INDEX not in one.path
        and one.path[:1] not in [(name,) for name in others]
        and ("kind" not in one.part.model_fields or one.path[-1] == table["initial"]["kind"])
    ]
    for _ in range(random.randint(1, 4)):
        found = random.choice(list(tables(Scene)) if random.random() < 0.1 else fitting)
        owner = table
        for name in found.path[:-1] if "kind" in found.part.model_fields else found.path:
            below = owner.setdefault(random.choice(("x-", "x+", "y-")) if name == ANY_KEY else name, {})
            if not isinstance(below, dict):
                break
            owner = below
        word = random.choice([word for word in found.part.model_fields if word not in others])
        owner[word] = _typed(random, found.part.model_fields[word].annotation)
    data = tomli_w.dumps(table).encode()
    return _torn(random, data) if random.random() < 0.05 else data


def _typed(random: Random, annotation: Any) -> Any:
    """A value for an entry of this type."""
    if random.random() < 0.1:
        return value(random)
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return random.choice(arguments)
    if origin is tuple:
        number = random.choice((1, 2, 2, 2, 3, 16)) if arguments[-1] is ... else len(arguments)
        return [_typed(random, arguments[0]) for _ in range(number)]
    if annotation is bool:
        return random.random() < 0.5
    if annotation is int:
        return random.choice((0, 1, 2, 3, 10, 1000, random.choice(NUMBERS)))
    if annotation is float:
        return random.choice((0.0, 0.1, 0.5, 1.0, 2.0, 10.0, 1e-6, 1e6, random.choice(NUMBERS)))
    if annotation is str:
        return random.choice(TEXTS)
    kinds = [one for one in arguments if one is not type(None) and (isinstance(one, type) or get_origin(one))]
    return _typed(random, random.choice(kinds)) if kinds else {}


def record(random: Random, valid: tuple[bytes, ...]) -> bytes:
    """One or two lines of a record with changes. valid: lines to choose from, without line ends."""

    def new(random: Random) -> Any:
        found = value(random)
        return None if isinstance(found, date) else found

    data = b""
    for _ in range(random.randint(1, 2)):
        line = json.loads(random.choice(valid))
        for _ in range(random.randint(1, 3)):
            _change(random, line, new, ("schema", "new", ""))
        data += json.dumps(line).encode() + b"\n"
    return _torn(random, data) if random.random() < 0.25 else data
