"""Images of a periodic box: wrapped, wrapped from time to time, not wrapped; and what is wrong in each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from inspected import cube, flying, judged, said

from crosscheck.trajectories.frames import Box

NAME = "images of the box"


def drifting(frames: int = 200, seed: int = 1) -> np.ndarray:
    """Positions of particles that leave the box: a walk of 0.05 a frame."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0, 5, (1, 20, 3)) + np.cumsum(0.05 * rng.normal(size=(frames, 20, 3)), axis=0)


def outcome(positions: np.ndarray, **more: Any) -> str:
    source = flying(frames=len(positions), positions=positions, velocities=None, **more)
    found = [one.outcome for one in judged(source, NAME)]
    return "fail" if "fail" in found else "pass" if found else said(source, NAME)


@pytest.mark.parametrize("wrapping", ["wrapped", "unwrapped"])
def test_positions_that_go_on(wrapping: str) -> None:
    """Some formats do not say whether they are wrapped: the positions do."""
    assert outcome(drifting(), wrapping=wrapping) == "pass"


def test_wrapped_positions() -> None:
    assert outcome(drifting() % 5.0, wrapping="wrapped") == "pass"
    assert "all positions are inside" in said(
        flying(frames=200, positions=drifting() % 5.0, velocities=None, wrapping="wrapped"), NAME
    )


def test_positions_that_are_wrapped_now_and_then() -> None:
    """Every tenth frame, as by codes that do so with their lists of neighbours."""
    x = drifting()
    images = np.floor(x / 5.0)
    lazy = x - 5.0 * images[np.arange(len(x)) // 10 * 10]
    assert (lazy < 0).any()
    assert outcome(lazy, wrapping="wrapped") == "pass"


def test_a_wrong_image_in_a_wrapped_file() -> None:
    x = drifting() % 5.0
    x[100, np.argmin(np.abs(x[100, :, 1] - 2.5)), 1] += 5.0
    assert outcome(x, wrapping="wrapped") == "fail"


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_image_flag_that_is_wrong_once_or_from_some_frame_on(axis: int) -> None:
    for frames in (slice(80, 81), slice(80, None)):
        x = drifting()
        x[frames, 4, axis] -= 5.0
        assert outcome(x, wrapping="unwrapped") == "fail"
        (one,) = judged(flying(frames=200, positions=x, velocities=None), NAME)
        assert f"along {'xyz'[axis]} to frame 80" in one.note
        assert "particle 5 moves" in one.note
        assert one.measured == (1 if frames.stop is None else 2)  # there, and back


def test_wrapped_positions_in_a_file_that_says_it_is_not() -> None:
    assert outcome(drifting() % 5.0, wrapping="unwrapped") == "fail"


def test_far_flights_between_frames_are_not_taken_for_images() -> None:
    far = flying(frames=60, times=np.arange(60.0) * 3).velocities[0] * 3.0 * np.arange(60)[:, None, None]
    assert "particles go far between frames" in outcome(far, wrapping="unwrapped")
    v = np.broadcast_to(np.array([100.0, 0.0, 0.0]), (60, 20, 3)) + np.array(flying().velocities)
    v[:, 1:, 0] -= 100.0  # one particle is faster than half an edge an interval, and its velocity says so
    x = np.array(flying().positions[0]) + v * (0.03 * np.arange(60))[:, None, None]
    source = flying(positions=x, velocities=v, times=0.03 * np.arange(60))
    assert [one.outcome for one in judged(source, NAME)] == ["pass"]


def test_a_skewed_box_and_one_without_periods() -> None:
    edges = np.array([[5.0, 0, 0], [2.0, 5.0, 0], [0, 1.0, 5.0]])
    skewed = Box(edges, np.array([1.0, -2.0, 0.0]), np.ones(3, dtype=bool))
    x = drifting()
    inside = x - skewed.lower
    inside = inside - np.floor(inside @ np.linalg.inv(skewed.vectors)) @ skewed.vectors + skewed.lower
    assert outcome(inside, wrapping="wrapped", box=skewed) == "pass"
    middle = np.argmin(np.linalg.norm(inside[90] - skewed.lower - skewed.vectors.sum(axis=0) / 2, axis=1))
    inside[90, middle] += skewed.vectors[1] + skewed.vectors[0]
    assert outcome(inside, wrapping="wrapped", box=skewed) == "fail"
    walls = cube()._replace(periodic=np.zeros(3, dtype=bool))
    assert "no axis of a box is periodic" in outcome(x, box=walls)
