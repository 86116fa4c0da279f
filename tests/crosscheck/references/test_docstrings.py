"""Docstrings of the references: every argument and field is named, every error raised, and a source is given."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Iterator
from types import ModuleType
from typing import Any, NamedTuple

import pytest

from crosscheck import references

MODULES = [
    importlib.import_module(m.name)
    for m in pkgutil.walk_packages(references.__path__, "crosscheck.references.")
    if not m.ispkg  # a package hands on what its modules define
]

#: A surname and, before the next bracket closes, a year: "Haff, J. Fluid Mech. 134, 401 (1983)", "(Haff 1983)".
CITATION = re.compile(r"\b[A-Z][a-z]{2,}\b[^()]{0,200}?[ (](18|19|20)\d\d\)")
DERIVATION = re.compile(r"\b[Dd]erivation\b|\b[Dd]erived\b")


class Documented(NamedTuple):
    """One public function, method or class. text: its docstring with that of its class. names: what it must name."""

    module: ModuleType
    name: str
    member: Any
    text: str
    names: tuple[str, ...]


def parameters(function: Any) -> tuple[str, ...]:
    return tuple(name for name in inspect.signature(function).parameters if name not in ("self", "cls"))


def documented() -> Iterator[Documented]:
    for module in MODULES:
        for name, member in vars(module).items():
            if name.startswith("_") or getattr(member, "__module__", None) != module.__name__:
                continue
            member = inspect.unwrap(member)
            if inspect.isfunction(member):
                yield Documented(module, name, member, member.__doc__ or "", parameters(member))
            elif inspect.isclass(member):
                own = member.__doc__ or ""
                yield Documented(module, name, None, own, tuple(inspect.get_annotations(member)))
                for attribute, value in vars(member).items():
                    method = value.fget if isinstance(value, property) else inspect.unwrap(value)
                    if not attribute.startswith("_") and inspect.isfunction(method):
                        text = f"{method.__doc__ or ''}\n{own}"
                        yield Documented(module, f"{name}.{attribute}", method, text, parameters(method))


PUBLIC = [pytest.param(one, id=f"{one.module.__name__.rpartition('.')[2]}-{one.name}") for one in documented()]


def unnamed(text: str, names: tuple[str, ...]) -> list[str]:
    """The names that do not occur in the text as words."""
    return [name for name in names if not re.search(rf"\b{re.escape(name)}\b", text)]


def cites(text: str) -> bool:
    flat = " ".join(text.split())
    return bool(CITATION.search(flat) or DERIVATION.search(flat))


def raised(function: Any) -> set[str]:
    """The names of the exceptions that the function itself raises."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    calls = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call)]
    return {call.func.id for call in calls if isinstance(call.func, ast.Name)}


@pytest.mark.parametrize("one", PUBLIC)
def test_every_argument_and_field_is_named(one: Documented) -> None:
    assert one.text.strip()
    assert unnamed(one.text, one.names) == []


@pytest.mark.parametrize("one", PUBLIC)
def test_a_source_is_given(one: Documented) -> None:
    assert cites(one.text) or cites(one.module.__doc__ or "")


@pytest.mark.parametrize("one", PUBLIC)
def test_every_error_that_is_raised_is_named(one: Documented) -> None:
    if one.member is not None:
        assert unnamed(one.text, tuple(raised(one.member))) == []


def test_all_modules_and_kinds_of_members_are_found() -> None:
    names = {(one.module.__name__.rpartition(".")[2], one.name) for one in documented()}
    assert {
        ("kepler", "precession"),
        ("lattice_models", "states"),  # behind a cache
        ("lattice_models", "Velocities.cartesian"),  # property of a dataclass
        ("floors", "Visit"),
        ("soft_impact", "HookeImpact.overlap"),
    } <= names
    assert len({module for module, _ in names}) == len(MODULES)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("P. K. Haff, J. Fluid Mech. 134, 401 (1983)", True),
        ("linear theory (van Noije and Ernst 1998)", True),
        ("By derivation: the roots of the quadratic equation.", True),
        ("The drift after 1998 steps.", False),
        ("Some value, from 0 to 2000; see Theory of Simple Liquids.", False),
        ("", False),
    ],
)
def test_what_counts_as_a_source(text: str, expected: bool) -> None:
    assert cites(text) is expected


def test_a_name_within_another_word_does_not_count() -> None:
    assert unnamed("rate: of collisions. mass_below: shares.", ("rate", "mass", "at")) == ["mass", "at"]
