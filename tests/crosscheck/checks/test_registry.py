"""Every check is whole: in its group's folder, named, described, cited, with a fault that matches its source."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import refimpl
from crosscheck import checks
from crosscheck.checks import all_checks
from crosscheck.checks.base import TIERS, Check, Variant
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.faults import Fault
from crosscheck.runner import unmatched

SOURCE = Path(refimpl.__path__[0])
GROUPS = ("stepping", "events", "lattice", "granular", "performance", "extreme")
#: Longest file and longest function of the checks' folders, in lines.
FILE, FUNCTION = 500, 80
MODULES = [one.name for one in pkgutil.walk_packages(checks.__path__, f"{checks.__name__}.") if not one.ispkg]
FILES = sorted(Path(checks.__path__[0]).rglob("*.py"))
each_check = pytest.mark.parametrize("check", all_checks(), ids=lambda check: check.name)
each_file = pytest.mark.parametrize("file", FILES, ids=lambda file: "/".join(file.parts[-2:]))
FAULTS = [(check, variant, fault) for check in all_checks() for variant, fault in check.faults]
each_fault = pytest.mark.parametrize(
    ("check", "variant", "fault"), FAULTS, ids=[f"{c.name}/{f.name}" for c, _, f in FAULTS]
)


def offers(check: Check) -> dict[str, tuple[Variant, ...]]:
    """The variants of a check by the engines that it judges."""
    classes = {name: engine_class(name) for name in engine_names()}
    return {
        name: check.offered(engine.schemes)
        for name, engine in classes.items()
        if unmatched(check, name, engine) is None
    }


def test_names_are_unique_and_sorted() -> None:
    names = [check.name for check in all_checks()]
    assert names == sorted(set(names))


@pytest.mark.parametrize("name", MODULES)
def test_a_check_lies_in_the_folder_of_its_group(name: str) -> None:
    folder = name.removeprefix(f"{checks.__name__}.").rpartition(".")[0]
    for check in getattr(importlib.import_module(name), "CHECKS", ()):
        assert check.name.partition("/")[0] == folder


@each_file
def test_files_and_functions_are_short(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    assert len(text.splitlines()) < FILE
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    assert [one.name for one in functions if (one.end_lineno or 0) - one.lineno + 1 >= FUNCTION] == []


@each_check
def test_check_is_whole(check: Check) -> None:
    """Named, described, with engines that have variants, and with a fault if it judges refimpl, where faults are."""
    assert re.fullmatch(rf"({'|'.join(GROUPS)})(/[a-z0-9][a-z0-9._-]*)+", check.name)
    for text in (check.title, check.equation, check.criterion, check.citation):
        assert text.strip()
        assert "\n" not in text
    of_engines = offers(check)
    assert any(of_engines.values())
    # `crosscheck show` and the report find a check from the name of a case
    names = {other.name for other in all_checks()}
    for variants in of_engines.values():
        assert all(variant.tier in TIERS for variant in variants)
        own = [variant.name for variant in variants]
        # a small variant stands for a larger one, and no other does
        larger = {variant.name for variant in variants if variant.tier != "small"}
        assert all(
            variant.instead in larger if variant.tier == "small" else not variant.instead for variant in variants
        )
        assert {variant.name for variant in variants if variant.tier == "small"} <= {name for name, _ in check.faults}
        assert len(set(own)) == len(own)
        # a case's name is a pattern that matches itself, and a word on the command line
        assert not any(set(name) & set(" *?[]\n") for name in own)
        assert not names & {f"{check.name}/{name}" for name in own}
    assert check.faults or not of_engines.get("refimpl")


@each_fault
def test_fault_is_whole(check: Check, variant: str, fault: Fault) -> None:
    """It occurs once in its file, compiles, and is seen by a variant of refimpl."""
    text = (SOURCE / fault.file).read_text(encoding="utf-8")
    assert text.count(fault.old) == 1
    assert fault.new != fault.old
    assert fault.name
    assert fault.breaks
    compile(text.replace(fault.old, fault.new), fault.file, "exec")
    assert variant in [one.name for one in offers(check)["refimpl"]]


def test_one_name_is_one_fault() -> None:
    known: dict[str, Fault] = {}
    for _, _, fault in FAULTS:
        assert known.setdefault(fault.name, fault) == fault


@each_file
def test_means_of_series_are_judged_whole(file: Path) -> None:
    """`statistical(..., samples=mean)`: with their number alone, nobody would ask whether the series drifts."""
    names = {node.attr for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Attribute)}
    assert "independent" not in names
