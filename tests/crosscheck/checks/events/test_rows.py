"""The time of a collapse is read off what an engine says."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events.rows import reported_time
from crosscheck.engines.protocol import Run


@pytest.mark.parametrize(
    ("text", "time"),
    [
        ("inelastic collapse of particles 3 and 7 at t = 1.25", 1.25),
        ("inelastic collapse of particle 0 with a wall at t = 1.5e-07", 1.5e-7),
        ("", np.nan),
        ("inelastic collapse at t = 3.0", np.nan),
    ],
)
def test_reported_time(text: str, time: float) -> None:
    np.testing.assert_equal(reported_time(Run(stopped=text)), time)
