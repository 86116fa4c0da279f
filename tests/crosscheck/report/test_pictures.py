"""Snapshots and maps: true to scale, small, complete whatever the numbers,."""

import base64
import io
import json
import math
import random
import re
import xml.etree.ElementTree as ET

import matplotlib.image
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck import painter
from crosscheck.figure import FieldMap, Figure, Frame, RoundFrame, Series, Snapshot
from crosscheck.report import figures, pictures
from crosscheck.verdict import Verdict, findings, round_off

BOX = Frame(0.0, 10.0, 0.0, 5.0)


def line(content, variant="a", engine="refimpl", title="picture"):
    """The line of a record with one picture."""
    kind = "snapshot" if isinstance(content, Snapshot) else "map"
    figure = Figure(title, "x / σ", "y / σ", **{kind: content})
    judgement = round_off("error", 0.0, 1.0, "none", figures=(figure,))
    record = Verdict("group/check", variant, engine, "pass", findings(judgement), "").as_record()
    return json.loads(json.dumps(record, allow_nan=False))


def variant(one):
    return one["variant"]


def draw(content):
    (picture,) = pictures.pictures([line(content)], variant)
    drawing = pictures.draw(picture, "p")
    ET.fromstring(drawing.svg)
    return drawing


def strokes(svg):
    """(x, y, diameter, colour or None for an outline) of the particles, in tenths of a unit of the SVG."""
    found = []
    for path, rest in re.findall(r'<path d="((?:M\d+ \d+h0)+)"([^>]*)/>', svg):
        paint = re.search(r"stroke:var\(--(\w+)\)", rest)
        width = int(re.search(r'stroke-width="(\d+)"', rest)[1])
        found += [(int(x), int(y), width, paint and paint[1]) for x, y in re.findall(r"M(\d+) (\d+)h0", path)]
    return found


def image(svg):
    """The picture of a map as the RGBA values of its cells, rows from the top down."""
    data = re.search(r'href="data:image/png;base64,([^"]+)"', svg)[1]
    return matplotlib.image.imread(io.BytesIO(base64.b64decode(data)), format="png")


def rgb(level):
    return [int(painter.colours()[level][i : i + 2], 16) / 255 for i in (1, 3, 5)]


# -- snapshots -----------------------------------------------------------------------------------------------


def test_particles_and_walls_are_on_one_scale():
    svg = draw(Snapshot([2.0, 8.0], [1.0, 3.0], 0.5, BOX, [0.0, 1.0], "speed")).svg
    left, bottom, top = map(int, re.search(r"M(\d+) (\d+)L\1 (\d+)", svg).groups())
    scale = (bottom - top) / 5.0
    disks = {colour: (x, y) for x, y, _, colour in strokes(svg) if colour}
    for colour, (x, y) in {"m0": (2.0, 1.0), f"m{painter.LEVELS - 1}": (8.0, 3.0)}.items():
        # a tenth of a unit is the resolution of both
        assert disks[colour] == pytest.approx((left + x * scale, bottom - y * scale), abs=2)
    outer = max(width for *_, width, colour in strokes(svg) if colour is None)
    assert outer == pytest.approx(2 * 0.5 * scale, abs=2)


def test_a_drum_is_a_circle_about_its_centre():
    svg = draw(Snapshot([3.0], [-1.0], 1.0, RoundFrame(3.0, -1.0, 4.0))).svg
    x, y, radius = map(int, re.search(r'<circle cx="(\d+)" cy="(\d+)" r="(\d+)"', svg).groups())
    (disk,) = [one for one in strokes(svg) if one[3] is None]
    assert disk[:2] == (x, y)
    assert disk[2] == pytest.approx(2 * radius / 4, abs=2)


def test_sides_without_a_wall_are_dashed():
    assert "dasharray" not in draw(Snapshot([], [], 1.0, BOX)).svg
    svg = draw(Snapshot([], [], 1.0, Frame(0, 1, 0, 1, ("left", "bottom", "right")))).svg
    assert re.search(r'<path d="M\d+ \d+L\d+ \d+"[^>]*dasharray', svg)


def test_no_particles_is_said():
    drawing = draw(Snapshot([], [], 0.5, BOX, [], "speed"))
    assert drawing.remarks == ["No particles."]
    assert "speed" not in drawing.svg


def test_lost_particles_are_marked_at_the_edge_and_counted():
    drawing = draw(Snapshot([1.0, 400.0, math.nan], [1.0, 2.0, math.inf], 0.5, BOX))
    assert len([one for one in strokes(drawing.svg) if one[3]]) == 1
    assert drawing.svg.count("l70 70") == 2
    assert "2 particles outside" in drawing.remarks[0]


def test_values_off_the_scale_get_the_colour_of_its_end_and_those_not_finite_none():
    drawing = draw(Snapshot([1, 2, 3, 4], [1.0] * 4, 0.3, BOX, [-5.0, 0.5, 9.0, math.nan], "speed", (0.0, 1.0)))
    middle = painter.LEVELS // 2
    assert [one[3] for one in sorted(strokes(drawing.svg)) if one[3]] == [
        "m0", f"m{middle}", f"m{painter.LEVELS - 1}", "paper",
    ]  # fmt: skip
    assert drawing.remarks == ["1 particle without a value: not filled.", "Off the colour scale: 1 below, 1 above."]


def test_equal_values_have_a_colour_bar():
    assert "m32" in {one[3] for one in strokes(draw(Snapshot([1, 2], [1, 1], 0.3, BOX, [3.0, 3.0], "T")).svg)}


def test_particles_too_small_to_be_seen_are_drawn_larger():
    assert "Particles are drawn larger than they are." in draw(Snapshot([1.0], [1.0], 1e-9, BOX)).remarks


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_three_thousand_particles_stay_small(spread):
    rng = random.Random(1)
    x, y, value = ([rng.random() * size for _ in range(3000)] for size in (40, 120, 3.0))
    radius = [0.4 + spread * rng.random() for _ in x] if spread else 0.4
    snapshot = Snapshot(x, y, radius, Frame(0, 40, 0, 120), value, "speed")
    assert len(draw(snapshot).svg) < 150_000
    assert len(json.dumps(line(snapshot))) < 110_000


wild = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(wild, wild, wild, wild), max_size=6))
def test_every_particle_is_drawn_somewhere(particles):
    x, y, radius, value = (list(column) for column in zip(*particles, strict=True)) if particles else ([],) * 4
    drawing = draw(Snapshot(x, y, radius, BOX, value, "speed"))
    assert len([one for one in strokes(drawing.svg) if one[3]]) + drawing.svg.count("l70 70") == len(x)


# -- maps ----------------------------------------------------------------------------------------------------


def test_a_map_is_an_image_with_the_first_row_at_the_bottom():
    drawing = draw(FieldMap([[0.0, 1.0, math.nan], [2.0, 3.0, 4.0]], BOX, "density"))
    cells = image(drawing.svg)
    assert cells.shape == (2, 3, 4)
    assert cells[1, 0] == pytest.approx([*rgb(0), 1.0], abs=1e-6)
    assert cells[0, 2] == pytest.approx([*rgb(painter.LEVELS - 1), 1.0], abs=1e-6)
    assert cells[1, 2, 3] == 0.0
    assert drawing.remarks == ["1 blank cell: no value."]


def test_a_map_spans_its_container():
    svg = draw(FieldMap([[0.0, 1.0]], BOX, "density")).svg
    x, y, width, height = map(int, re.search(r'<image x="(\d+)" y="(\d+)" width="(\d+)" height="(\d+)"', svg).groups())
    assert f"M{x} {y + height}L{x} {y}M" in svg
    assert width / height == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("values", [[], [[]], [[math.nan, math.inf]]])
def test_a_map_without_values_is_drawn(values):
    assert draw(FieldMap(values, RoundFrame(0, 0, 1), "density")).remarks == ["No cell has a value."]


def test_arrows_point_where_the_field_does():
    u, v = [[3.0, 0.0, math.nan]], [[4.0, -2.5, 1.0]]
    drawing = draw(FieldMap([[1.0]], Frame(0, 3, 0, 1), "T", arrows=(u, v), arrow_label="flow"))
    shafts = [tuple(map(int, one)) for one in re.findall(r"M-?\d+ -?\d+l(-?\d+) (-?\d+)l", drawing.svg)]
    assert len(shafts) == 2
    assert math.hypot(*shafts[0]) == pytest.approx(2 * math.hypot(*shafts[1]), rel=0.01)
    assert math.atan2(-shafts[0][1], shafts[0][0]) == pytest.approx(math.atan2(4, 3), abs=0.01)
    assert shafts[1][0] == 0
    assert shafts[1][1] > 0
    assert drawing.remarks == ["Arrows: flow; the longest is 5."]


def test_lines_over_a_map_are_on_its_scale_and_broken_beside_it():
    edge = Series("edge", [0.0, 1.0, 2.0, math.nan, 1.0, 3.0], [0.0, 0.5, 99.0, 0.5, 0.0, 1.0])
    drawing = draw(FieldMap([[1.0]], Frame(0, 3, 0, 1), "T", lines=(edge,)))
    path = re.search(r'id="p-lines" d="([^"]*)"', drawing.svg)[1]
    points = [(pen, int(x), int(y)) for pen, x, y in re.findall(r"([ML])(-?\d+) (-?\d+)", path)]
    assert "".join(pen for pen, *_ in points) == "MLML"
    (_, x0, y0), (_, x1, y1), (_, x2, y2), (_, x3, y3) = points
    assert (y0, y0 - y1) == (y2, pytest.approx((y2 - y3) / 2, abs=1))
    assert x2 == x1
    assert x3 - x0 == pytest.approx(3 * (x1 - x0), abs=2)
    assert drawing.remarks == ["Line: edge."]


@pytest.mark.parametrize("u", [[], [[]], [[0.0]], [[math.nan]]])
def test_a_field_at_rest_has_no_arrows(u):
    assert "arrows" not in draw(FieldMap([[1.0]], BOX, "T", arrows=(u, u))).svg


@settings(max_examples=25, deadline=None)
@given(st.lists(st.lists(wild, min_size=3, max_size=3), max_size=4))
def test_every_map_is_drawn(values):
    drawing = draw(FieldMap(values, BOX, "T", arrows=(values, values)))
    levels = np.isfinite(values) & (np.abs(values) < figures.LARGEST) if values else np.zeros((0, 3), bool)
    if levels.any():
        assert np.array_equal(image(drawing.svg)[::-1, :, 3] > 0, levels)


# -- record and page -----------------------------------------------------------------------------------------


def test_pictures_are_no_curves_and_curves_no_pictures():
    snapshot = line(Snapshot([], [], 0.5, BOX))
    curves = {"title": "a", "x_label": "", "y_label": "", "x_scale": "linear", "y_scale": "linear", "series": []}
    old = {"check": "group/check", "variant": "a", "engine": "refimpl", "figures": [curves]}
    assert figures.panels([snapshot], variant) == []
    assert pictures.pictures([old, {**old, "figures": None}], variant) == []
    assert len(figures.panels([old], variant)) == 1


def test_pictures_of_one_title_are_told_apart():
    field = FieldMap([[1.0]], BOX, "T")
    checks = [("a", "refimpl"), ("b", "refimpl"), ("b", "lammps")]
    found = pictures.pictures([line(field, *one) for one in checks], variant)
    assert [one.title for one in found] == ["picture, a [refimpl]", "picture, b [refimpl]", "picture, b [lammps]"]
    assert [one.title for one in pictures.pictures([line(field)], variant)] == ["picture"]
