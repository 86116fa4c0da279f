"""Dense samples tell a right engine from one that looks at the nearest image alone, also with a trace."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from crosscheck.runner import Case, close_pools, judge, select
from crosscheck.verdict import Verdict

ENGINES = Path(__file__).parents[3] / "support" / "nearest_image.py"


@pytest.fixture(scope="module", autouse=True)
def workers() -> Iterator[None]:
    yield
    close_pools()


def verdict(name: str, check: str, variant: str) -> Verdict:
    return judge(Case(check, variant, f"{ENGINES}:{name}", False), 0)


@pytest.mark.parametrize("variant", ["small-2d", "small-3d", "unlike"])
def test_an_engine_that_looks_at_all_images_passes(variant: str) -> None:
    found = verdict("AllImages", "events/audit-samples", variant)
    assert found.outcome == "pass", found.message


@pytest.mark.parametrize("variant", ["small-2d", "small-3d"])
def test_the_nearest_image_alone_is_red(variant: str) -> None:
    found = verdict("NearestImage", "events/audit-samples", variant)
    assert found.outcome == "fail"
    assert found.findings is not None
    (missed,) = (one for one in found.findings.judgements if one.quantity.startswith("missed events"))
    assert missed.outcome == "fail"
    assert "overlap" in missed.note


def test_spheres_that_overlap_in_a_sample_are_a_failure_that_names_the_pair_and_the_time() -> None:
    found = verdict("Overlapping", "events/audit-samples", "gas-2d")
    assert found.outcome == "fail", found.message
    assert found.findings is not None
    worst = found.findings.judgements[0]
    assert worst.quantity == "intervals in which something happened that is no event"
    assert re.search(r"t = 3: particles 0 and 1 overlap: their centres are 0.35\d* apart", worst.note), worst.note


def test_variants_are_those_whose_words_the_engine_declares() -> None:
    cases = select(["events/audit-samples"], "quick", [f"{ENGINES}:AllImages"])
    assert [case.variant for case in cases] == ["small-2d", "small-3d", "gas-2d", "gas-3d", "inelastic", "unlike"]


def test_with_a_trace_rows_lose_what_the_engine_does_not_declare() -> None:
    good = verdict("Traced", "events/audit", "rows-0")
    assert good.outcome == "pass", good.message
    assert good.findings is not None
    assert int(good.findings.note.split()[0]) >= 5
    assert verdict("TracedNearestImage", "events/audit", "rows-0").outcome == "fail"
