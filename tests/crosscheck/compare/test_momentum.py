"""One run that keeps its momentum, and one that does not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from pairs_of_runs import gap

from crosscheck.compare.growth import EPSILON
from crosscheck.compare.momentum import momentum_parting

SCALE, FILES = 8.0, 1e-12


def gaps(first: Sequence[float], second: Sequence[float], **known: Any) -> list[Any]:
    """Frames whose total momenta along y are these."""
    return [
        gap(0.5 * k, momentum=((1.0, a, 0.0), (1.0, b, 0.0)), momentum_rounding=FILES, momentum_scale=SCALE)._replace(
            **known
        )
        for k, (a, b) in enumerate(zip(first, second, strict=True))
    ]


def allowed(steps: float, arithmetic: str = "double") -> float:
    return 2 * FILES + EPSILON[arithmetic] * SCALE * steps


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("second", [False, True])
def test_a_kick_of_one_run_is_found_at_its_frame(second: bool, sign: float) -> None:
    kept, kicked = [0.0] * 5, [0.0, 0.0, 0.0, sign * 1e-6, sign * 1e-6]
    found = momentum_parting(gaps(kept, kicked) if second else gaps(kicked, kept), [0, 10, 20, 30, 40], "double")
    assert found is not None
    assert found.frame == 3
    assert found.expected == pytest.approx(allowed(30), rel=1e-9, abs=0)


def test_rounding_grows_with_the_number_of_steps_and_the_digits_of_the_arithmetic() -> None:
    for arithmetic in ("double", "single"):
        most = allowed(400, arithmetic)
        for share, frame in ((0.99, None), (1.01, 2)):
            steps = [7, 107, 407]
            found = momentum_parting(gaps([0.0] * 3, [0.0, 0.0, share * most]), steps, arithmetic)
            assert (None if found is None else found.frame) == frame
    # without steps, a thousand from frame to frame
    found = momentum_parting(gaps([0.0] * 3, [0.0, 0.0, 1.01 * allowed(2000)]), None, "double")
    assert found is not None
    assert found.expected == pytest.approx(allowed(2000), rel=1e-9, abs=0)
    assert momentum_parting(gaps([0.0] * 3, [0.0, 0.0, 0.99 * allowed(2000)]), None, "double") is None


def test_nothing_is_said_where_both_lose_it_together_or_none_does() -> None:
    lost = [0.0, 0.0, 1.0]
    assert momentum_parting(gaps(lost, lost), None, "double") is None
    assert momentum_parting(gaps([0.0] * 3, [0.0] * 3), None, "double") is None
    assert momentum_parting(gaps([0.0, 1.0, 1.0], lost), None, "double") is not None
    assert momentum_parting(gaps([0.0] * 3, lost, momentum=None), None, "double") is None
    # a total that differs and is kept
    assert momentum_parting(gaps([0.0] * 3, [0.5] * 3), None, "double") is None
