"""benchmarks/page.py: what is kept of the numbers, and the page that is made of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from benchmark_modules import benchmark_named

PAGE = benchmark_named("page")


@pytest.fixture
def measured() -> dict[str, Any]:
    """A file of pytest-benchmark with the two sides of one race, as far as it is read."""

    def benchmark(side: str, seconds: float, turns: list[float]) -> dict[str, Any]:
        return {
            "group": "gravity, N = 3",
            "fullname": f"stepping/bench_gravity.py::bench_gravity[gravity, N = 3: {side}]",
            "stats": {
                "median": seconds,
                "min": 0.9 * seconds,
                "max": 1.1 * seconds,
                "rounds": 3,
                "data": [seconds] * 3,
            },
            "extra_info": {
                "side": side,
                "unit": "pairs",
                "elapsed": False,
                "note": "skin 0.3" if side == "other" else "",
                "counters": {"steps": 43, "evaluations": 44, "events": 0},
                "work": 129.0,
                "rate": 129.0 / seconds,
                "ratio": {"of": "ours", "median": sorted(turns)[1], "turns": turns},
                "compile_seconds": 0.1,
                "peak_bytes": 1000,
            },
        }

    return {
        "machine_info": {"node": "a-secret-name", "card": {"processor": "some"}},
        "commit_info": {"id": "abc"},
        "datetime": "2026-01-02T03:04:05+00:00",
        "benchmarks": [benchmark("ours", 0.5, [1.0, 1.0, 1.0]), benchmark("other", 1.25, [2.4, 2.5, 2.7])],
    }


def test_a_row_a_side_with_rate_and_ratio(measured: dict[str, Any]) -> None:
    text = PAGE.page(PAGE.kept(measured))
    rows = [line for line in text.splitlines() if "pairs" in line and line.startswith("|")]
    assert rows == [
        "| gravity, N = 3 | ours | 258 pairs | 1 | 129 pairs: steps 43, evaluations 44 |",
        "|  | other, skin 0.3 | 103 pairs | **2.5** (2.4 to 2.7) | 129 pairs: steps 43, evaluations 44 |",
    ]
    assert "| machine | 2026-01-02 |" in text
    assert "| processor | some |" in text


def test_no_names_of_machines_are_kept(measured: dict[str, Any]) -> None:
    assert "secret" not in json.dumps(PAGE.kept(measured))


def test_what_was_kept_gives_the_same_page(measured: dict[str, Any]) -> None:
    results = PAGE.kept(measured)
    again = PAGE.kept(json.loads(json.dumps(results)))
    assert again == results


def test_a_file_without_a_chapter_is_refused(measured: dict[str, Any]) -> None:
    measured["benchmarks"][0]["fullname"] = "bench_other.py::bench_other[x]"
    with pytest.raises(ValueError, match=r"without a chapter: bench_other\.py"):
        PAGE.page(PAGE.kept(measured))


def test_chapters_and_files_are_the_same() -> None:
    here = Path(PAGE.__file__).parent
    assert {file.relative_to(here).as_posix() for file in here.rglob("bench_*.py")} == set(PAGE._CHAPTERS)


def test_the_page_is_that_of_the_numbers_that_were_kept() -> None:
    """After a change: python benchmarks/page.py benchmarks/results.json."""
    assert PAGE.PAGE.read_text(encoding="utf-8") == PAGE.page(json.loads(PAGE.KEPT.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("number", "text"), [(0.0, "0"), (0.5, "0.5"), (43, "43"), (1234.5, "1234"), (12345.0, "1.23e4"), (3e-4, "3.00e-4")]
)
def test_quantities_have_three_digits(number: float, text: str) -> None:
    assert PAGE._quantity(number) == text
