"""Figures: what is merged on one set of axes, how curves are told apart, and that no point is lost."""

import math
import re

import pytest

from crosscheck.engines.registry import engine_names
from crosscheck.report import figures
from crosscheck.text import printable

#: Engines are numbered in the order of the installed ones.
LAMMPS = engine_names().index("lammps")


def line(variant, engine, *series, title="error", scale="log"):
    """A line of a record with one figure."""
    curves = [{"label": label, "x": x, "y": y, "error": None, "theory": theory} for label, x, y, theory in series]
    figure = {"title": title, "x_label": "dt", "y_label": "error", "x_scale": scale, "y_scale": scale, "series": curves}
    return {"check": "group/check", "variant": variant, "engine": engine, "figures": [figure]}


def variant(one):
    return one["variant"]


def draw(lines):
    (panel,) = figures.panels(lines, variant)
    return panel, figures.draw(panel, figures.curve_numbers([panel]), "p")


X = [0.01, 0.1]


def test_figures_with_one_title_share_their_axes():
    lines = [line("verlet", "refimpl", ("verlet", X, X, False)), line("euler", "lammps", ("euler", X, X, False))]
    panel, drawing = draw(lines)
    assert [curve.name for curve in panel.curves] == ["euler", "verlet"]
    assert [key.text for key in drawing.curves] == ["euler", "verlet"]
    assert [key.text for key in drawing.engines] == ["refimpl", "lammps"]


def test_one_scheme_on_two_engines_has_one_colour_and_two_markers():
    lines = [line("verlet", engine, ("verlet", X, X, False)) for engine in ("refimpl", "lammps")]
    _, drawing = draw(lines)
    assert [key.text for key in drawing.curves] == ["verlet"]
    assert set(re.findall(r'class="s (k\d+ e\d+)"', drawing.svg)) == {"k0 e0", f"k0 e{LAMMPS}"}
    assert set(re.findall(r"stroke:(var\(--c\d\))", drawing.svg)) == {"var(--c0)"}


def test_equal_labels_get_the_variant():
    panel, _ = draw([line(v, "refimpl", ("measured", X, X, False)) for v in ("e=0.1", "e=0.5")])
    assert [curve.name for curve in panel.curves] == ["measured, e=0.1", "measured, e=0.5"]


def test_equal_theory_is_drawn_once_and_different_theory_is_told_apart():
    lines = [line(v, "refimpl", ("exact", X, X, True)) for v in ("a", "b")]
    lines.append(line("c", "refimpl", ("exact", X, [1.0, 2.0], True)))
    panel, drawing = draw(lines)
    assert [curve.name for curve in panel.curves] == ["exact", "exact, c"]
    assert drawing.curves[0].group == "t0"
    assert drawing.engines == []


@pytest.mark.parametrize("bad", [None, 1e200, 0.0, -1.0])
def test_a_point_that_cannot_be_drawn_is_marked_at_the_edge(bad):
    _, drawing = draw([line("euler", "refimpl", ("euler", [0.01, 0.1, 1.0], [1e-3, 1e-2, bad], False))])
    assert drawing.failed == 1


def test_a_figure_of_failed_points_only_is_drawn():
    _, drawing = draw([line("euler", "refimpl", ("euler", X, [None, None], False))])
    assert drawing.failed == 2


def test_a_runaway_point_does_not_flatten_the_others():
    y = [10.0**-k for k in range(10)] + [1e100]
    panel, drawing = draw([line("euler", "refimpl", ("euler", [1.0 * k for k in range(1, 12)], y, False))])
    assert drawing.failed == 1
    assert panel.curves[0].y[-1] == 1e100


def test_constant_and_single_values_have_axes():
    _, drawing = draw([line("a", "refimpl", ("a", [1.0], [0.0], False), scale="linear")])
    assert drawing.failed == 0


def test_long_series_become_short_paths():
    x = [0.001 * i for i in range(20000)]
    _, drawing = draw([line("a", "refimpl", ("a", x, [math.sin(v) for v in x], False), scale="linear")])
    assert len(drawing.svg) < 40_000


def test_seventeen_schemes_look_different():
    lines = [line(f"s{i:02}", "refimpl", (f"s{i:02}", X, X, False)) for i in range(17)]
    _, drawing = draw(lines)
    assert len({key.sample for key in drawing.curves}) == 17


@pytest.mark.parametrize(
    ("value", "text"), [(1e-5, "10⁻⁵"), (0.01, "0.01"), (1.0, "1"), (1000.0, "1000"), (2e6, "2×10⁶"), (1e12, "10¹²")]
)
def test_ticks_are_plain_text(value, text):
    assert figures.tick_text(value) == text


def test_labels_are_escaped():
    _, drawing = draw([line("a", "refimpl", ("<b>", X, X, False), title='a "<b>"')])
    assert "<b>" not in drawing.svg


def histogram(engine, edges, heights, theory=False, scale="linear", label="speeds"):
    one = line("a", engine, (label, edges, heights, theory), scale=scale)
    one["figures"][0]["x_scale"] = "linear"
    one["figures"][0]["series"][0]["bins"] = True
    return one


EDGES, HEIGHTS = [0.0, 1.0, 2.0, 4.0], [0.2, 0.5, 0.1]


def test_a_histogram_is_the_outline_of_its_bins():
    panel, drawing = draw([histogram("refimpl", EDGES, HEIGHTS)])
    (curve,) = panel.curves
    assert curve.points == [(0.5, 0.2), (1.5, 0.5), (3.0, 0.1)]
    x, y = curve.outline(0.0)
    assert x == [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 4.0, 4.0]
    assert y == [0.0, 0.2, 0.2, 0.5, 0.5, 0.1, 0.1, 0.0]
    assert drawing.failed == 0
    assert "fill-opacity:0.22" in drawing.svg


def test_histograms_of_two_engines_are_told_apart_by_markers_and_not_filled():
    _, drawing = draw([histogram(engine, EDGES, HEIGHTS) for engine in ("refimpl", "lammps")])
    assert [key.text for key in drawing.engines] == ["refimpl", "lammps"]
    for engine in ("e0", f"e{LAMMPS}"):
        assert re.search(f'class="s k0 {engine}"', drawing.svg)
    assert "fill-opacity:0.22" not in drawing.svg


def test_an_expected_histogram_is_theory():
    _, drawing = draw([histogram("refimpl", EDGES, HEIGHTS), histogram("refimpl", EDGES, HEIGHTS, True, label="exact")])
    assert [key.group for key in drawing.curves] == ["k0", "t0"]


@pytest.mark.parametrize(("scale", "height", "failed"), [("log", 0.0, 0), ("log", None, 1), ("linear", None, 1)])
def test_an_empty_bin_is_no_failure_and_one_that_is_not_finite_is(scale, height, failed):
    _, drawing = draw([histogram("refimpl", EDGES, [0.2, height, 0.1], scale=scale)])
    assert drawing.failed == failed


@pytest.mark.parametrize("heights", [[None] * 3, [0.0] * 3, [-1.0, -2.0, -1.0], [-1.0, 2.0, 0.0]])
@pytest.mark.parametrize("scale", ["linear", "log"])
def test_odd_histograms_are_drawn(heights, scale):
    draw([histogram("refimpl", EDGES, heights, scale=scale), histogram("refimpl", [0.0], [], scale=scale)])
    draw([histogram("refimpl", [None, 1.0, 2.0, 3.0], heights, scale=scale)])


@pytest.mark.parametrize("label", ["$\\foo$", "a $ b_c$ and \\", "\x1b[31m", "\ud800"])
def test_labels_are_drawn_as_they_are_written(label):
    one = line(label, "refimpl", (label, X, X, False))
    one["figures"][0] |= {"x_label": label, "y_label": label}
    _, drawing = draw([one])
    assert drawing.svg.count(printable(label)) == 2
    assert drawing.svg.encode()
