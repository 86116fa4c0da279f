"""Every argument and every field of the public API of `crosscheck` is documented by its name.

Public: what a module defines under a name without a leading underscore. An argument or field is documented where its
name occurs as a word in the docstring of its function or of its class; a word of the scene language by the string below
its declaration; an option of the command line by its help text.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from types import ModuleType
from typing import Any, get_type_hints

import pytest
from pydantic import BaseModel

import crosscheck
from crosscheck.engines.protocol import Engine, Restartable

#: Methods that every engine has, documented once, in the protocol.
OF_ENGINES = {
    name: member.__doc__ or ""
    for protocol in (Engine, Restartable)
    for name, member in vars(protocol).items()
    if inspect.isfunction(member)
}
MODULES = tuple(module.name for module in pkgutil.walk_packages(crosscheck.__path__, "crosscheck."))


def undocumented(module: Any) -> Iterator[str]:
    """The arguments and fields of a module's public API that are not documented, as "Class.method: argument"."""
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isclass(thing):
            yield from _of_class(name, thing)
        elif inspect.isfunction(inspect.unwrap(thing)):
            yield from _of_function(name, inspect.unwrap(thing), thing.__doc__ or "")


def _of_class(name: str, cls: type) -> Iterator[str]:
    about = cls.__doc__ or ""
    if issubclass(cls, BaseModel):
        yield from (f"{name}: {field}" for field, info in cls.model_fields.items() if not info.description)
    elif is_dataclass(cls):
        yield from _missing(name, (field.name for field in fields(cls)), about)
    else:
        # named tuples, and attributes that a protocol declares
        yield from _missing(name, getattr(cls, "_fields", vars(cls).get("__annotations__", {})), about)
    for key, member in vars(cls).items():
        function = inspect.unwrap(getattr(member, "__func__", member))
        if not inspect.isfunction(function) or function.__module__ != cls.__module__:
            continue
        if key == "__init__" and not is_dataclass(cls):
            yield from _of_function(name, function, about + (function.__doc__ or ""))
        elif not key.startswith("_"):
            protocol = OF_ENGINES.get(key, "") if {"schemes", "capabilities"} <= vars(cls).keys() else ""
            yield from _of_function(f"{name}.{key}", function, about + (function.__doc__ or "") + protocol)


def _of_function(name: str, function: Any, docstring: str) -> Iterator[str]:
    hints = get_type_hints(function, include_extras=True) if "typer" in function.__globals__ else {}
    helped = {
        argument
        for argument, hint in hints.items()
        if any(getattr(item, "help", None) for item in getattr(hint, "__metadata__", ()))
    }
    arguments = [one for one in inspect.signature(function).parameters if one not in ("self", "cls")]
    yield from _missing(name, (one for one in arguments if one not in helped), docstring)


def _missing(name: str, words: Any, docstring: str) -> Iterator[str]:
    for word in words:
        if not word.startswith("_") and not re.search(rf"\b{re.escape(word)}\b", docstring):
            yield f"{name}: {word}"


@pytest.mark.parametrize("name", MODULES)
def test_every_argument_and_field_is_documented(name: str) -> None:
    found = list(undocumented(importlib.import_module(name)))
    assert not found, f"{name}: no word in the docstring on\n" + "\n".join(found)


#: A module that documents some of its arguments and fields.
SOURCE = '''
from __future__ import annotations
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

def function(seen, unseen, *rest, **more):
    """seen: its meaning; rest: too."""

@cache
def cached(unseen):
    """Nothing."""

@dataclass
class Record:
    """x: length."""
    x: float
    y: float

    def method(self, z, x):
        """Nothing."""

    @classmethod
    def made(cls, w):
        """Nothing."""

class Pair(NamedTuple):
    """first: length."""
    first: float
    second: float

class Plain:
    """a: number."""
    def __init__(self, a, b):
        pass
    def _private(self, c):
        pass
'''


def test_what_is_not_documented_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The test above can fail: for functions, methods, constructors and fields."""
    module = ModuleType("half_documented")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    exec(SOURCE, vars(module))
    assert list(undocumented(module)) == [
        "function: unseen",
        "function: more",
        "cached: unseen",
        "Record: y",
        "Record.method: z",
        "Record.made: w",
        "Pair: second",
        "Plain: b",
    ]
