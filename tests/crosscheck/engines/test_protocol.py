"""What runs cost, added up: what was not counted stays unknown."""

from __future__ import annotations

from crosscheck.engines.protocol import Cost


def test_costs_add_up_the_peak_is_the_largest_and_unknown_stays_unknown() -> None:
    total = Cost()
    total.add(Cost(wall=1.5, steps=10, peak_bytes=7, pair_tests=100))
    total.add(Cost(wall=0.5, steps=5, peak_bytes=3, pair_tests=20, predictions=0))
    total.add(Cost(events=2))
    assert total == Cost(wall=2.0, steps=15, peak_bytes=7, events=2, pair_tests=120, predictions=0)
    assert total.list_builds is None
    assert "list_builds" not in total.known()
    assert total.known()["predictions"] == 0
