"""The large figure: labels do not overlap, failed runs are crosses, ids and classes fit the legend."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.report.ladder_figure import Axis, apart, draw, legend, marker_definitions, style_of
from crosscheck.report.ladders import Case, Climb, Point


def climb(engine: str, label: str, *, failed: int = 0, family: str = "symplectic") -> Climb:
    points = tuple(
        Point(0.1 / n, n**-2, 0.1 * n**-2, 1e-3 * n, 0.9e-3 * n, 2e-3 * n, 100.0 * n, "diverged" if k < failed else "")
        for k, n in enumerate((1.0, 2.0, 4.0, 8.0, 16.0, 32.0))
    )
    return Climb(engine, label, family, "dt", points, "evaluations of the force", "c/x", "")


CASE = Case(
    "an <orbit>",
    "largest error/a",
    "c",
    "c1",
    [
        climb("refimpl", "verlet", failed=2),
        climb("scipy", "RK45", family="chooses its steps"),
        climb("mine.py:Mine", "<verlet>"),
        *(climb("refimpl", f"scheme{k}") for k in range(20)),
    ],
)
STYLE = style_of([CASE])


@given(places=st.lists(st.floats(0, 500), min_size=1, max_size=40), gap=st.floats(1, 30))
def test_labels_keep_apart(places: list[float], gap: float) -> None:
    places.sort()
    moved = apart(places, gap, 0.0, 600.0)
    room = min(gap, 600.0 / max(len(places) - 1, 1))
    assert len(moved) == len(places)
    assert (np.diff(moved) >= room - 1e-6).all()
    assert min(moved) >= -1e-6
    assert max(moved) <= 600.0 + 1e-6


@given(low=st.floats(1e-15, 1.0), decades=st.floats(0.2, 14.0))
def test_every_axis_has_a_few_ticks(low: float, decades: float) -> None:
    axis = Axis(low, low * 10**decades, 0.0, 100.0)
    assert 0 < len(axis.ticks) <= 11 or decades < 0.4
    assert all(axis.low <= tick <= axis.high for tick in axis.ticks)
    assert axis.place(axis.low) == 0.0
    assert axis.place(axis.high) == pytest.approx(100.0)


def test_places_that_are_apart_stay() -> None:
    assert apart([10.0, 100.0, 300.0], 14.0, 0.0, 600.0) == pytest.approx([10.0, 100.0, 300.0])


@pytest.mark.parametrize("by_count", [False, True])
def test_the_figure_is_xml_and_names_every_method_once(by_count: bool) -> None:
    svg = draw(CASE, STYLE, by_count=by_count)
    root = ElementTree.fromstring(svg)
    labels = [text.text for text in root.iter("text") if text.text and ", " in text.text]
    assert sorted(labels) == sorted(one.name for one in CASE.climbs)
    assert svg.count("l8 8m0-8l-8 8") == 2  # a cross for each failed run
    assert "nan" not in svg


def test_markers_and_legend_belong_to_the_curves() -> None:
    svg, definitions = draw(CASE, STYLE), marker_definitions(STYLE)
    assert set(re.findall(r"url\(#([^)]+)\)", svg)) <= set(re.findall(r'id="([^"]+)"', definitions))
    classes = {name for text in re.findall(r'class="s ([^"]+)"', svg) for name in text.split()}
    # s0, s1 ... are the classes of colours
    assert {group for group, _, _ in legend(CASE, STYLE)} == {name for name in classes if name[0] != "s"}


def test_the_front_is_drawn_over_time_alone() -> None:
    assert 'class="front"' in draw(CASE, STYLE)
    assert 'class="front"' not in draw(CASE, STYLE, by_count=True)


def test_a_case_without_a_good_run_has_no_figure() -> None:
    assert draw(Case("t", "u", "c", "c1", [climb("refimpl", "verlet", failed=6)]), STYLE) == ""


def test_figures_are_small() -> None:
    assert len(draw(CASE, STYLE)) < 16_000
