"""The trace of a simulation: what it says of the states is what they are."""

from __future__ import annotations

import numpy as np
import pytest
from event_scenes import spheres


def test_traced_states_are_those_after_each_event() -> None:
    gas = spheres(cells=2, packing=0.3)
    gas.run(until=1.0)
    states, trace = gas.traced_states(), gas.trace()
    assert len(states) == len(trace) > 20
    side = gas.model.lengths[0]
    last = {}
    for (time, *who), after in zip(trace, states, strict=True):
        gap = after[1, :3] - after[0, :3]
        gap -= side * np.round(gap / side)
        assert np.linalg.norm(gap) == pytest.approx(1.0, abs=1e-13)
        assert (after[1, 3:6] - after[0, 3:6]) @ gap > 0
        for i, state in zip(who, after, strict=True):
            last[i] = time, state
    state = gas.state()
    for i, (time, after) in last.items():
        assert state.velocities[i] == pytest.approx(after[3:6], abs=0)
        assert state.positions[i] == pytest.approx(after[:3] + after[3:6] * (1.0 - time), abs=1e-13)


def test_states_are_there_only_if_traced() -> None:
    with pytest.raises(ValueError, match="trace=True"):
        spheres(cells=2, trace=False).traced_states()
