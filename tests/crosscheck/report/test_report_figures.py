"""Figures: what is merged on one set of axes, how curves are told apart, and that no point is lost."""

import math
import re

import pytest

from crosscheck.report import figures


def line(variant, engine, *series, title="error", scale="log"):
    """A line of a record with one figure."""
    curves = [{"label": label, "x": x, "y": y, "error": None, "theory": theory} for label, x, y, theory in series]
    figure = {"title": title, "x_label": "dt", "y_label": "error", "x_scale": scale, "y_scale": scale, "series": curves}
    return {"check": f"group/check/{variant}", "engine": engine, "figures": [figure]}


def variant(one):
    return one["check"].rpartition("/")[2]


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
    assert set(re.findall(r'class="s (k\d+ e\d+)"', drawing.svg)) == {"k0 e0", "k0 e1"}
    assert set(re.findall(r"stroke: (var\(--c\d\))", drawing.svg)) == {"var(--c0)"}


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
    assert figures._power(value) == text


def test_labels_are_escaped():
    _, drawing = draw([line("a", "refimpl", ("<b>", X, X, False), title='a "<b>"')])
    assert "<b>" not in drawing.svg
