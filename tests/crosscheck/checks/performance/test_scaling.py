"""Laws of growth with a term for memory, cycles through it, and what a queue that scans would be judged."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.performance.memory import cycle
from crosscheck.checks.performance.scaling import _comparisons, _evidence, _no_growth, _Queue
from crosscheck.statistics import model_comparison

SIZES = tuple(2**k for k in range(8, 18))
N = np.array(SIZES, dtype=float)
#: Seconds of a step through memory: three caches, and memory beyond.
MEMORY = 1e-9 * np.select([N < 1e3, N < 1e4, N < 6e4], [2.0, 4.0, 15.0], 100.0)


@given(st.integers(2, 200), st.integers(0, 5))
def test_a_cycle_goes_through_all_lines(lines: int, seed: int) -> None:
    following, place, seen = cycle(lines, seed), 0, set()
    for _ in range(lines):
        seen.add(place)
        place = int(following[place])
    assert (place, len(seen)) == (0, lines)
    assert all(line % 8 == 0 for line in seen)


@pytest.mark.parametrize(("power", "best"), [(0.0, "constant"), (0.5, "sqrt N"), (1.0, "N")])
def test_growth_is_told_from_what_memory_costs(power: float, best: str) -> None:
    """A time that jumps where caches end is none that grows with N."""
    times = 1e-6 + 20 * MEMORY + (3e-6 * (N / N[-1]) ** power if power else 0.0)
    times *= 1 + 0.005 * np.random.default_rng(1).normal(size=N.size)
    fits = model_comparison(N, times, 0.01 * times, beside=MEMORY)
    laws = ("constant", "log N", "sqrt N", "N")
    assert min(laws, key=lambda law: fits[law].bic) == best
    assert fits[best].coefficients[-1] == pytest.approx(20, rel=0.1)


def test_without_its_term_memory_looks_like_growth() -> None:
    times = 1e-6 + 20 * MEMORY
    fits = model_comparison(N, times, 0.01 * times)
    assert fits["constant"].bic > fits["log N"].bic


@pytest.mark.parametrize(("growth", "outcome"), [(lambda n: 2 + 1.4 * np.log(n), "pass"), (lambda n: 0.01 * n, "fail")])
def test_comparisons_of_a_tree_and_of_a_scan(growth, outcome: str) -> None:  # type: ignore[no-untyped-def]
    errors = np.full(N.size, 0.02)
    costs = growth(N) + 0.02 * np.random.default_rng(2).normal(size=N.size)
    assert _comparisons(_Queue("event_driven", SIZES, "log N"), costs, errors).outcome == outcome


@pytest.mark.parametrize(("factor", "outcome"), [(1.0, "pass"), (1.1, "pass"), (1.6, "fail")])
def test_numbers_may_change_by_how_cells_fit(factor: float, outcome: str) -> None:
    values = np.array([50.0, 48.0, 50.0 * factor])
    assert _no_growth("predictions", (256, 1024, 4096), values, np.full(3, 0.01)).outcome == outcome


def test_what_is_never_done_does_not_grow() -> None:
    assert _no_growth("list moves", (256, 1024), np.zeros(2), np.zeros(2)).outcome == "pass"


@pytest.mark.parametrize(("scan", "grows"), [(0.0, False), (1e-9, True)])
def test_an_event_that_looks_at_all_particles_is_told_from_memory(scan: float, grows: bool) -> None:
    times = 7e-7 + 20 * MEMORY + scan * N
    times *= 1 + 0.03 * np.random.default_rng(3).normal(size=N.size)
    assert (_evidence(N, times, MEMORY)[2] > 10) is grows
