"""What is seen of particles: periodic copies, particles that are lost, sizes, colours."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck import painter
from crosscheck.figure import Frame, RoundFrame, Snapshot
from crosscheck.painter import Extent

VIEW = Extent(0.0, 10.0, 0.0, 5.0)


def paint(x, y, radius=0.5, value=None, periods=(0.0, 0.0), limits=None, scale=30.0):
    snapshot = Snapshot(x, y, radius, Frame(0.0, 10.0, 0.0, 5.0), value, "speed", limits)
    return painter.paint(dataclasses.asdict(snapshot), VIEW, scale, periods)


def test_a_disk_over_a_periodic_corner_is_seen_at_all_four():
    painting = paint([9.8], [0.1], periods=(10.0, 5.0))
    places = sorted((round(disk.x, 9), round(disk.y, 9)) for disk in painting.disks)
    assert places == [(-0.2, 0.1), (-0.2, 5.1), (9.8, 0.1), (9.8, 5.1)]
    assert len(paint([9.8], [0.1], periods=(10.0, 0.0)).disks) == 2
    assert len(paint([9.8], [0.1]).disks) == 1
    assert len(paint([5.0], [2.5], periods=(10.0, 5.0)).disks) == 1


def test_a_large_disk_is_seen_on_both_sides():
    assert len(paint([5.0], [2.5], radius=6.0, periods=(10.0, 0.0)).disks) == 3


def test_lost_particles_are_at_the_nearest_edge():
    painting = paint([-3.0, math.nan, 4.0], [2.0, 1.0, -math.inf])
    assert painting.disks == []
    # what the record cannot hold, as an infinite coordinate, counts as too large
    assert painting.lost == [(0.0, 2.0), (10.0, 1.0), (4.0, 5.0)]
    assert "3 particles" in painting.lost_remarks[0]
    assert paint([1.0], [1.0]).lost_remarks == []


def test_small_particles_are_enlarged_and_large_ones_outlined():
    painting = paint([1.0, 2.0, 3.0], [1.0] * 3, [1e-6, 0.02, 0.5])
    assert [disk.radius for disk in painting.disks] == [0.5 / 30, 0.02, 0.5]
    assert [disk.outline for disk in painting.disks] == [0.0, 0.0, 0.6]
    assert painting.enlarged == 1


def test_particles_without_a_value_are_told_from_plain_ones():
    painting = paint([1.0, 2.0, 3.0], [1.0] * 3, value=[0.0, math.nan, 4.0])
    assert [disk.level for disk in painting.disks] == [0, painter.BLANK, painter.LEVELS - 1]
    assert (painting.blank, painting.limits, painting.beyond) == (1, (0.0, 4.0), (0, 0))
    assert [disk.level for disk in paint([1.0], [1.0]).disks] == [painter.PLAIN]
    assert paint([1.0, 2.0], [1.0] * 2, value=[0.0, 9.0], limits=(1.0, 3.0)).beyond == (1, 1)


@given(st.floats(-2.0, 3.0), st.floats(-1.0, 0.5), st.floats(0.6, 2.0))
def test_levels_rise_with_the_value(value, low, high):
    level = painter.level_of(value, (low, high))
    assert 0 <= level < painter.LEVELS
    assert painter.level_of(value - 0.1, (low, high)) <= level


def test_levels_have_equal_widths():
    last = painter.LEVELS - 1
    assert [painter.level_of(v, (0.0, 64.0)) for v in (-1.0, 0.0, 0.9, 1.0, 62.9, 63.0, 64.0, 99.0)] == [
        0, 0, 0, 1, last - 1, last, last, last,
    ]  # fmt: skip


def test_lines_of_containers():
    box = painter.outlines(dataclasses.asdict(Frame(0.0, 2.0, 0.0, 1.0, ("left", "bottom"))))
    assert box.walls == [(0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 2.0, 0.0)]
    assert box.sides == [(2.0, 0.0, 2.0, 1.0), (0.0, 1.0, 2.0, 1.0)]
    drum = dataclasses.asdict(RoundFrame(1.0, 2.0, 3.0))
    assert painter.outlines(drum).circle == (1.0, 2.0, 3.0)
    assert painter.bounds(drum) == pytest.approx((-2.0, 4.0, -1.0, 5.0))
