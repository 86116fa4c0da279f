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
def test_check_is_named_and_described(check: Check) -> None:
    assert re.fullmatch(rf"({'|'.join(GROUPS)})(/[a-z0-9][a-z0-9._-]*)+", check.name)
    for text in (check.title, check.equation, check.criterion, check.citation):
        assert text.strip()
        assert "\n" not in text
    assert check.tier in ("quick", "full")


@each_check
def test_check_has_engines_with_variants(check: Check) -> None:
    assert check.engines
    assert set(check.engines) <= set(OWN)
    assert any(check.variants(engine, engine_class(engine).schemes) for engine in check.engines)
    for engine in check.engines:
        variants = check.variants(engine, engine_class(engine).schemes)
        assert len(set(variants)) == len(variants)
        # a case's name is a pattern that matches itself, and a word on the command line
        assert not any(set(variant) & set(" *?[]\n") for variant in variants)


@each_check
def test_no_variant_has_the_name_of_another_check(check: Check) -> None:
    # `crosscheck show` and the report find a check from the name of a case
    names = {other.name for other in all_checks()}
    for engine in check.engines:
        assert not names & {f"{check.name}/{v}" for v in check.variants(engine, engine_class(engine).schemes)}


@each_check
def test_check_has_a_fault(check: Check) -> None:
    assert check.faults


@each_fault
def test_fault_occurs_once_in_its_file(check: Check, variant: str, fault: Fault) -> None:
    assert (SOURCE / fault.file).read_text(encoding="utf-8").count(fault.old) == 1
    assert fault.new != fault.old
    assert fault.name
    assert fault.breaks


@each_fault
def test_fault_compiles(check: Check, variant: str, fault: Fault) -> None:
    text = (SOURCE / fault.file).read_text(encoding="utf-8")
    compile(text.replace(fault.old, fault.new), fault.file, "exec")


@each_fault
def test_fault_is_seen_by_a_variant_of_refimpl(check: Check, variant: str, fault: Fault) -> None:
    assert "refimpl" in check.engines
    assert variant in check.variants("refimpl", engine_class("refimpl").schemes)


def test_one_name_is_one_fault() -> None:
    known: dict[str, Fault] = {}
    for _, _, fault in FAULTS:
        assert known.setdefault(fault.name, fault) == fault
