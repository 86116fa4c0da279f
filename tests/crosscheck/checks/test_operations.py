"""Counts against known ones: what is not counted is red, and other engines are not held to the numbers of refimpl."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.operations import as_known, at_most, counted, exactly
from crosscheck.engines.protocol import Cost


def laboratory(engine: str) -> Any:
    return SimpleNamespace(engine=engine)


@pytest.mark.parametrize(("count", "outcome"), [(1000, "pass"), (1049, "pass"), (1051, "fail"), (949, "fail")])
def test_known_numbers_hold_within_five_percent(count: int, outcome: str) -> None:
    (judged,) = as_known(laboratory("refimpl"), Cost(pair_tests=count), {"pair_tests": 1000})
    assert judged.outcome == outcome


def test_numbers_of_refimpl_are_its_own() -> None:
    assert as_known(laboratory("lammps"), Cost(pair_tests=1), {"pair_tests": 1000}) == []


def test_what_is_not_counted_is_red() -> None:
    count = counted(Cost(), "pair_tests")
    assert np.isnan(count)
    assert exactly("tests", count, 5).outcome == "fail"
    assert at_most("tests", count, 5, "a reason").outcome == "fail"
    assert as_known(laboratory("refimpl"), Cost(), {"pair_tests": 5})[0].outcome == "fail"


def test_exact_means_not_one_more() -> None:
    assert exactly("tests", 5, 5).outcome == "pass"
    assert exactly("tests", 6, 5).outcome == "fail"
