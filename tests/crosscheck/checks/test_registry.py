"""Every check is whole: named, described, cited, and with a planted fault that still matches its source."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import refimpl
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.engines.registry import OWN, engine_class
from crosscheck.faults import Fault

SOURCE = Path(refimpl.__path__[0])
GROUPS = ("stepping", "events", "lattice", "granular", "performance", "extreme")
each_check = pytest.mark.parametrize("check", all_checks(), ids=lambda check: check.name)
FAULTS = [(check, variant, fault) for check in all_checks() for variant, fault in check.faults]
each_fault = pytest.mark.parametrize(
    ("check", "variant", "fault"), FAULTS, ids=[f"{c.name}/{f.name}" for c, _, f in FAULTS]
)


def test_names_are_unique_and_sorted() -> None:
    names = [check.name for check in all_checks()]
    assert names == sorted(set(names))


@each_check
def test_check_is_whole(check: Check) -> None:
    """Named, described, with engines that have variants, and with a fault."""
    assert re.fullmatch(rf"({'|'.join(GROUPS)})(/[a-z0-9][a-z0-9._-]*)+", check.name)
    for text in (check.title, check.equation, check.criterion, check.citation):
        assert text.strip()
        assert "\n" not in text
    assert check.tier in ("quick", "full")
    assert check.engines
    assert set(check.engines) <= set(OWN)
    of_engines = [check.variants(engine, engine_class(engine).schemes) for engine in check.engines]
    assert any(of_engines)
    # `crosscheck show` and the report find a check from the name of a case
    names = {other.name for other in all_checks()}
    for variants in of_engines:
        assert len(set(variants)) == len(variants)
        # a case's name is a pattern that matches itself, and a word on the command line
        assert not any(set(variant) & set(" *?[]\n") for variant in variants)
        assert not names & {f"{check.name}/{variant}" for variant in variants}
    assert check.faults


@each_fault
def test_fault_is_whole(check: Check, variant: str, fault: Fault) -> None:
    """It occurs once in its file, compiles, and is seen by a variant of refimpl."""
    text = (SOURCE / fault.file).read_text(encoding="utf-8")
    assert text.count(fault.old) == 1
    assert fault.new != fault.old
    assert fault.name
    assert fault.breaks
    compile(text.replace(fault.old, fault.new), fault.file, "exec")
    assert "refimpl" in check.engines
    assert variant in check.variants("refimpl", engine_class("refimpl").schemes)


def test_one_name_is_one_fault() -> None:
    known: dict[str, Fault] = {}
    for _, _, fault in FAULTS:
        assert known.setdefault(fault.name, fault) == fault
