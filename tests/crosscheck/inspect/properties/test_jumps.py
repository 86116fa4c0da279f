"""Displacements that neither speeds nor the other particles explain."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import PLANTED, flying, judged, said

from crosscheck.trajectories.memory import in_memory

NAME = "jumps"


def run(seed: int = 1) -> object:
    return PLANTED.ornstein_uhlenbeck(seed, frames=200, dt=0.1)


def test_a_particle_that_jumps_once_is_named_with_or_without_velocities() -> None:
    changed = PLANTED._hop(run(), np.random.default_rng(1))
    for one in (changed, changed._replace(velocities=None)):
        (found,) = judged(PLANTED.source_of(one), NAME)
        assert found.outcome == "fail"
        assert "particle 6 moves by" in found.note
        assert "to frame 10" in found.note


def test_a_jump_of_the_length_that_is_stated_is_red_and_half_of_it_is_not() -> None:
    right = run()
    (found,) = judged(PLANTED.source_of(right), NAME)
    assert found.outcome == "pass"
    least = float(found.note.split("a jump of ")[1].split(" ")[0])
    for share, outcome in ((1.5, "fail"), (0.4, "pass")):
        x = right.positions.copy()
        x[101:, 8, 1] += share * least
        (found,) = judged(PLANTED.source_of(right._replace(positions=x, sides=1e3 * right.sides)), NAME)
        assert found.outcome == outcome


def test_a_jump_by_an_edge_of_an_unwrapped_file_names_its_particle() -> None:
    (found,) = judged(PLANTED.source_of(PLANTED._leap(run(), np.random.default_rng(1))), NAME)
    assert found.outcome == "fail"
    assert "particle 6 moves by" in found.note
    assert "to frame 100" in found.note


def test_heavy_particles_are_slow_and_light_ones_make_no_jumps() -> None:
    """Without velocities, displacements are compared times m^(1/2)."""
    rng = np.random.default_rng(2)
    masses = np.where(np.arange(200) < 198, 400.0, 1.0)
    steps = rng.normal(size=(150, 200, 3)) / masses[:, None] ** 0.5
    steps[70, 0] = 1.0  # a heavy one goes as far as a light one may
    for given, particle in ((masses, 1), (np.ones(200), None)):
        source = in_memory("walk", np.arange(150.0), np.cumsum(steps, axis=0), masses=given)
        (found,) = judged(source, NAME)
        assert (found.outcome == "fail") == (particle is not None)
        assert particle is None or f"particle {particle} moves" in found.note


def test_in_driven_motion_speeds_are_asked_for() -> None:
    source = flying(velocities=None)
    assert "without velocities" in said(source, NAME, ensemble="none")
    assert "without velocities" in said(flying(velocities=None, number=5), NAME)
    assert judged(PLANTED.source_of(run()), NAME, ensemble="none")[0].outcome == "pass"


@pytest.mark.parametrize("frames", [5, 20])
def test_few_intervals_do_not_tell(frames: int) -> None:
    assert "fewer than 20 intervals" in said(flying(frames=frames), NAME)
