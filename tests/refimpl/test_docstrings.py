"""Every public function and class of `refimpl` says what each of its arguments, or fields, is.

Public: no leading underscore, defined in the module, and the module is not one of the kernels. What an argument of many
functions is, the module's docstring may say once.
"""

from __future__ import annotations

import inspect
import pkgutil
import re
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest

import refimpl

MODULES = [
    import_module(found.name)
    for found in pkgutil.walk_packages(refimpl.__path__, "refimpl.")
    if "kernels" not in found.name.split(".")
]


def plain(member: Any) -> Any:
    """The Python function behind a compiled one."""
    return getattr(member, "py_func", member)


def public(module: ModuleType) -> Iterator[tuple[str, Any, str]]:
    """Name, object, and the texts that may name its arguments: its own, its class's and its module's docstring."""
    shared = module.__doc__ or ""
    for name, member in vars(module).items():
        member = plain(member)
        if name.startswith("_") or getattr(member, "__module__", None) != module.__name__:
            continue
        own = (member.__doc__ if inspect.isclass(member) else inspect.getdoc(member)) or ""
        if inspect.isfunction(member) or inspect.isclass(member):
            yield name, member, f"{own}\n{shared}" if own else ""
        if inspect.isclass(member):
            for label, attribute in vars(member).items():
                inner = getattr(attribute, "func", getattr(attribute, "fget", attribute))
                if not label.startswith("_") and inspect.isfunction(inner):
                    text = inspect.getdoc(getattr(member, label)) or inspect.getdoc(inner) or ""
                    yield f"{name}.{label}", inner, "\n".join([text, own, shared])


MEMBERS = [
    pytest.param(member, text, id=f"{module.__name__}.{name}")
    for module in MODULES
    for name, member, text in public(module)
]


def names_of(member: Any) -> list[str]:
    """Of all arguments of a call; fields of a record."""
    fields = getattr(member, "_fields", None)
    if fields is not None:
        return list(fields)
    try:
        return [name for name in inspect.signature(member).parameters if name != "self"]
    except ValueError:  # a class without a constructor of its own
        return []


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__)
def test_every_module_says_what_it_is(module: ModuleType) -> None:
    assert module.__doc__


@pytest.mark.parametrize(("member", "text"), MEMBERS)
def test_every_argument_is_named(member: Any, text: str) -> None:
    assert text.strip()
    missing = [name for name in names_of(member) if not re.search(rf"\b{name}\b", text)]
    assert not missing


def test_the_walk_finds_the_public_names() -> None:
    found = {param.id for param in MEMBERS}
    expected = {
        "refimpl.stepping.integrate.integrate",
        "refimpl.stepping.forces.generic.accelerate",
        "refimpl.stepping.forces.gravity.plain_acceleration",
        "refimpl.events.rules.random_uniform",
        "refimpl.events.simulation.Simulation.run",
        "refimpl.lattice.gas.LatticeGas.populations",
        "refimpl.lattice.velocities.VelocitySet.image",
    }
    assert expected <= found
