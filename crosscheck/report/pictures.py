"""Pictures of particles and of fields, to one scale on both axes, with a colour bar: inline SVG like the curves.

Which particles are drawn, and in which colour, is decided in `crosscheck.painter`. Frame and ticks are matplotlib's;
the content is written here, in tenths of a unit of the SVG. A particle is a stroke of no length with a round cap, 12
bytes where a circle takes 36. A field is an image of a pixel a cell.
"""

from __future__ import annotations

import base64
import math
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from crosscheck.engines.registry import engine_order
from crosscheck.painter import (
    LEVELS,
    PLAIN,
    Extent,
    Limits,
    beyond,
    bounds,
    colour_limits,
    colours,
    level_of,
    limits_of,
    many,
    number,
    outlines,
    paint,
    radii,
)
from crosscheck.record import Line, case_name
from crosscheck.report.figures import WIDTH, Drawing, qualified, sheet, style, to_svg
from crosscheck.report.numbers import plain, to_tolerance
from crosscheck.text import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# room for the labels about the picture, and the largest and smallest height of picture and colour bar, in SVG units
_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 86, 14, 47
_HIGHEST, _LOWEST = 420, 90
_GAP, _BAR = 9, 11
#: Free space about the container, and the share of it that particles may add to it.
_MARGIN, _OVERHANG = 0.02, 0.1
#: The longest arrow in spacings of their grid, the opening and the length of its head in SVG units.
_ARROW, _HEAD_ANGLE, _HEAD = 1.4, 0.45, 3.5


@dataclass(frozen=True)
class Picture:
    """A snapshot or a map of one verdict, as the record has it; the other one is None.

    title: the caption. x_label, y_label: of the axes, with the units. snapshot: of particles. map: of a field.
    """

    title: str
    x_label: str
    y_label: str
    snapshot: dict[str, Any] | None
    map: dict[str, Any] | None


def pictures(lines: Iterable[Line], variant: Callable[[Line], str]) -> list[Picture]:
    """Snapshots and maps of the verdicts of one check; captions that would be equal get the variant or the engine.

    lines: of the record. variant: gives the name of the variant of a line.
    """
    ordered = sorted(lines, key=lambda line: (case_name(line), engine_order(line["engine"])))
    found = [
        (line, figure)
        for line in ordered
        for figure in line.get("figures") or ()
        if figure.get("snapshot") or figure.get("map")
    ]
    variants: dict[str, set[str]] = defaultdict(set)
    engines: dict[str, set[str]] = defaultdict(set)
    for line, figure in found:
        variants[figure["title"]].add(variant(line))
        engines[figure["title"]].add(line["engine"])
    made = []
    for line, figure in found:
        title = caption = figure["title"]
        if len(variants[title]) > 1:
            caption = qualified(caption, variant(line))
        if len(engines[title]) > 1:
            caption = f"{caption} [{line['engine']}]"
        snapshot, field = figure.get("snapshot"), figure.get("map")
        made.append(Picture(caption, figure["x_label"], figure["y_label"], snapshot, field))
    return made


def draw(picture: Picture, prefix: str) -> Drawing:
    """The picture as SVG.

    picture: what to draw. prefix: makes its ids unique in the page.
    """
    if picture.snapshot is not None:
        return _draw_snapshot(picture, picture.snapshot, prefix)
    assert picture.map is not None
    return _draw_map(picture, picture.map, prefix)


# -- layout --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Layout:
    """Where the picture lies in the SVG.

    view: what is seen, in units of the scene. scale: SVG units in a unit of the scene. left, top: the corner of the
    picture in the SVG. bar: whether it has a colour bar.
    """

    view: Extent
    scale: float
    left: float
    top: float
    bar: bool

    @property
    def width(self) -> float:
        """Width of the picture, in SVG units."""
        return (self.view[1] - self.view[0]) * self.scale

    @property
    def height(self) -> float:
        """Height of the picture, in SVG units."""
        return (self.view[3] - self.view[2]) * self.scale

    @property
    def area(self) -> float:
        """Height of the picture, or of the colour bar where that is more."""
        return max(self.height, _LOWEST)

    @property
    def total(self) -> int:
        """Height of all, labels included."""
        return math.ceil(_TOP + self.area + _BOTTOM)

    def at(self, x: float, y: float) -> tuple[int, int]:
        """A point in tenths of an SVG unit.

        x, y: in units of the scene.
        """
        left, _, _, top = self.view
        return round(10 * (self.left + (x - left) * self.scale)), round(10 * (self.top + (top - y) * self.scale))


def _layout(container: dict[str, Any], overhang: float, bar: bool) -> Layout:
    """The container with a margin that holds `overhang` if that is not too much, as large as the page lets it be."""
    left, right, bottom, top = bounds(container)
    size = max(right - left, top - bottom)
    margin = _MARGIN * size + min(overhang, _OVERHANG * size)
    view = Extent(left - margin, right + margin, bottom - margin, top + margin)
    room = WIDTH - _LEFT - (_RIGHT if bar else 12)
    scale = min(room / (view.right - view.left), _HIGHEST / (view.top - view.bottom))
    height = (view.top - view.bottom) * scale
    return Layout(view, scale, _LEFT, _TOP + max(0.0, _LOWEST - height) / 2, bar)


def _axes(picture: Picture, layout: Layout, limits: Limits | None, label: str) -> Figure:
    """Ticks and labels of the picture and of the colour bar."""
    import textwrap

    figure = sheet(layout.total)
    left, right, bottom, top = layout.view
    axes = _add(figure, layout, layout.left, layout.top, layout.width, layout.height)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    _ticks(axes, "x", left, right, layout.width / 60)
    _ticks(axes, "y", bottom, top, layout.height / 45)
    axes.set_xlabel(textwrap.fill(printable(picture.x_label), max(16, round(layout.width / 6))))
    axes.set_ylabel(textwrap.fill(printable(picture.y_label), max(16, round(layout.area / 6))), labelpad=2)
    axes.spines[["top", "right", "left", "bottom"]].set_visible(False)
    if limits is not None:
        bar = _add(figure, layout, layout.left + layout.width + _GAP, _TOP, _BAR, layout.area)
        bar.set_ylim(*limits)
        bar.set_xticks([])
        _ticks(bar, "y", *limits, layout.area / 45)
        bar.yaxis.tick_right()
        bar.yaxis.set_label_position("right")
        bar.set_ylabel(textwrap.fill(printable(label), max(16, round(layout.area / 6))), labelpad=5)
        bar.spines[["top", "right", "left", "bottom"]].set_visible(False)
    return figure


def _add(figure: Figure, layout: Layout, left: float, top: float, width: float, height: float) -> Axes:
    total = layout.total
    return figure.add_axes((left / WIDTH, 1 - (top + height) / total, width / WIDTH, height / total), facecolor="none")


def _ticks(axes: Axes, which: str, low: float, high: float, room: float) -> None:
    """At most `room` intervals, with the digits that tell their ends apart."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    axis = axes.xaxis if which == "x" else axes.yaxis
    span = high - low
    axis.set_major_locator(MaxNLocator(min(6, max(1, int(room))), steps=(1, 2, 2.5, 5, 10)))
    axis.set_major_formatter(
        FuncFormatter(lambda value, _: to_tolerance(value if abs(value) > 1e-9 * span else 0.0, 0.1 * span))
    )


# -- colours -------------------------------------------------------------------------------------------------


def _colour_bar(layout: Layout, outside: tuple[int, int]) -> str:
    """The colours from bottom to top, with a tip where values lie beyond that end."""
    left, top = round(10 * (layout.left + layout.width + _GAP)), 10 * _TOP
    width, height = 10 * _BAR, round(10 * layout.area)
    content = _image([[level] for level in range(LEVELS)], left, top, width, height)
    tips = ((outside[0], top + height, 80, 0), (outside[1], top, -80, LEVELS - 1))
    for count, y, tip, level in tips:
        if count:
            content += f'<path d="M{left} {y}h{width}l{-width // 2} {tip}z" style="fill:var(--m{level})"/>'
    return content + f'<path d="M{left} {top}h{width}v{height}h{-width}z" stroke="currentColor" stroke-width="6"/>'


def _image(levels: list[list[int | None]], x: int, y: int, width: int, height: int) -> str:
    """Rows of colours from the bottom up, None for blank, as an image."""
    data = base64.b64encode(_png(levels[::-1])).decode()
    return (
        f'<image x="{x}" y="{y}" width="{width}" height="{height}" preserveAspectRatio="none" '
        f'style="image-rendering:pixelated" href="data:image/png;base64,{data}"/>'
    )


def _png(rows: list[list[int | None]]) -> bytes:
    """A PNG with the colour map as its palette, to which it adds a transparent entry. (W3C, PNG, 3rd ed., 2025)"""
    palette = b"".join(bytes.fromhex(colour[1:]) for colour in colours()) + b"\0\0\0"
    pixels = b"".join(b"\0" + bytes(LEVELS if level is None else level for level in row) for row in rows)

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    # 8 bits a pixel, indexed colours, no interlacing
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 3, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        (
            chunk(b"IHDR", header),
            chunk(b"PLTE", palette),
            chunk(b"tRNS", b"\xff" * LEVELS + b"\0"),
            chunk(b"IDAT", zlib.compress(pixels, 9)),
            chunk(b"IEND", b""),
        )
    )


# -- content -------------------------------------------------------------------------------------------------


def _container(container: dict[str, Any], layout: Layout) -> str:
    """Walls as thick lines, other sides dashed."""
    lines = outlines(container)
    if lines.circle is not None:
        x, y = layout.at(*lines.circle[:2])
        radius = round(10 * lines.circle[2] * layout.scale)
        return f'<circle cx="{x}" cy="{y}" r="{radius}" stroke="currentColor" stroke-width="20"/>'
    walls, sides = (
        "".join("M{} {}L{} {}".format(*layout.at(x0, y0), *layout.at(x1, y1)) for x0, y0, x1, y1 in segments)
        for segments in (lines.walls, lines.sides)
    )
    drawn = f'<path d="{walls}" stroke="currentColor" stroke-width="20" stroke-linecap="square"/>' if walls else ""
    if sides:
        drawn += f'<path d="{sides}" stroke="currentColor" stroke-width="8" stroke-dasharray="50 40"/>'
    return drawn


def _compose(layout: Layout, picture: Picture, limits: Limits | None, label: str, content: str, prefix: str) -> str:
    """The content under the frame with its ticks."""
    with style():
        svg = to_svg(_axes(picture, layout, limits, label), picture.title, prefix)
    end = svg.index(">") + 1
    return f'{svg[:end]}\n<g transform="scale(.1)" fill="none">{content}</g>{svg[end:]}'


def _draw_snapshot(picture: Picture, snapshot: dict[str, Any], prefix: str) -> Drawing:
    largest = max((radius for radius in radii(snapshot) if math.isfinite(radius)), default=0.0)
    layout = _layout(snapshot["container"], largest, colour_limits(snapshot) is not None)
    painting = paint(snapshot, layout.view, layout.scale)

    rings: dict[int, str] = defaultdict(str)
    disks: dict[tuple[int, int], str] = defaultdict(str)
    for disk in painting.disks:
        radius = disk.radius * layout.scale
        point = "M{} {}h0".format(*layout.at(disk.x, disk.y))
        if disk.outline:
            rings[round(20 * radius)] += point
        disks[disk.level, round(20 * (radius - disk.outline))] += point
    content = _container(snapshot["container"], layout)
    content += '<g stroke-linecap="round" style="stroke:var(--ring)">'
    content += "".join(f'<path d="{d}" stroke-width="{w}"/>' for w, d in sorted(rings.items()))
    for (level, width), path in sorted(disks.items()):
        colour = "var(--c0)" if level == PLAIN else "var(--paper)" if level < 0 else f"var(--m{level})"
        content += f'<path d="{path}" style="stroke:{colour}" stroke-width="{width}"/>'
    content += "</g>"
    if painting.lost:
        crosses = "".join("M{} {}m-35-35l70 70m0-70l-70 70".format(*layout.at(*place)) for place in painting.lost)
        content += f'<path d="{crosses}" stroke="currentColor" stroke-width="16"/>'
    if painting.limits is not None:
        content += _colour_bar(layout, painting.beyond)
    svg = _compose(layout, picture, painting.limits, snapshot["value_label"], content, prefix)

    remarks = [] if snapshot["x"] else ["No particles."]
    remarks += painting.lost_remarks
    if painting.blank:
        remarks.append(f"{many(painting.blank, 'particle')} without a value: not filled.")
    if painting.enlarged:
        remarks.append("Particles are drawn larger than they are.")
    return Drawing(picture.title, svg, [], [], remarks=remarks + _outliers(painting.beyond, snapshot["limits"]))


def _draw_map(picture: Picture, field: dict[str, Any], prefix: str) -> Drawing:
    rows = [[number(v) for v in row] for row in field["values"]]
    values = [value for row in rows for value in row]
    limits = limits_of(field["limits"], values)
    layout = _layout(field["container"], 0.0, limits is not None)
    outside = beyond(values, limits)
    left, right, bottom, top = bounds(field["container"])
    content = ""
    if limits is not None:
        levels = [[level_of(v, limits) if math.isfinite(v) else None for v in row] for row in rows]
        (x0, y0), (x1, y1) = layout.at(left, top), layout.at(right, bottom)
        content += _image(levels, x0, y0, x1 - x0, y1 - y0)
    content += _container(field["container"], layout)
    remarks = [] if limits is not None else ["No cell has a value."]
    if field["arrows"]:
        path, longest = _arrows(field["arrows"], (left, right, bottom, top), layout)
        if path:
            # light about dark: seen on every colour of the map and on either page
            content += (
                f'<defs><path id="{prefix}-arrows" d="{path}"/></defs>'
                f'<g stroke-linecap="round" stroke-linejoin="round">'
                f'<use href="#{prefix}-arrows" style="stroke:white" stroke-width="26"/>'
                f'<use href="#{prefix}-arrows" style="stroke:black" stroke-width="11"/></g>'
            )
        remarks.append(f"Arrows: {field['arrow_label'] or 'vector field'}; the longest is {plain(longest, 3)}.")
    if field.get("lines"):
        content += _lines(field["lines"], layout, prefix)
        remarks.append(f"Line: {', '.join(dict.fromkeys(line['label'] for line in field['lines']))}.")
    if limits is not None:
        content += _colour_bar(layout, outside)
    svg = _compose(layout, picture, limits, field["value_label"], content, prefix)
    blank = sum(not math.isfinite(value) for value in values)
    if blank and limits is not None and field["container"]["shape"] == "box":
        remarks.append(f"{many(blank, 'blank cell')}: no value.")
    return Drawing(picture.title, svg, [], [], remarks=remarks + _outliers(outside, field["limits"]))


def _arrows(arrows: list[list[list[float | None]]], bounds: tuple[float, ...], layout: Layout) -> tuple[str, float]:
    """The path of all arrows, each about the middle of its cell, and the largest length in units of the field."""
    left, right, bottom, top = bounds
    vectors = [
        (row, column, number(u), number(v))
        for row, (us, vs) in enumerate(zip(*arrows, strict=True))
        for column, (u, v) in enumerate(zip(us, vs, strict=True))
    ]
    vectors = [one for one in vectors if math.isfinite(math.hypot(*one[2:]))]
    longest = max((math.hypot(u, v) for _, _, u, v in vectors), default=0.0)
    if not longest:
        return "", longest
    wide, high = (right - left) / len(arrows[0][0]), (top - bottom) / len(arrows[0])
    reach = 10 * _ARROW * min(wide, high) * layout.scale
    path = ""
    for row, column, u, v in vectors:
        dx, dy = reach * (u / longest), -reach * (v / longest)
        length = math.hypot(dx, dy)
        if length < 10:
            continue
        x, y = layout.at(left + (column + 0.5) * wide, bottom + (row + 0.5) * high)
        path += f"M{x - round(dx / 2)} {y - round(dy / 2)}l{round(dx)} {round(dy)}"
        head, angle = min(10 * _HEAD, 0.45 * length), math.atan2(-dy, -dx)
        barbs = [
            (round(head * math.cos(angle + s)), round(head * math.sin(angle + s))) for s in (-_HEAD_ANGLE, _HEAD_ANGLE)
        ]
        (ax, ay), (bx, by) = barbs
        path += f"l{ax} {ay}m{-ax} {-ay}l{bx} {by}"
    return path, longest


def _lines(lines: list[dict[str, Any]], layout: Layout, prefix: str) -> str:
    """Curves over a map, broken where a point is not on it, light about dark: seen on every colour of it."""
    path, (left, right, bottom, top) = "", layout.view
    for line in lines:
        pen = "M"
        for x, y in zip(map(number, line["x"]), map(number, line["y"]), strict=True):
            if not (left <= x <= right and bottom <= y <= top):
                pen = "M"
                continue
            path += "{}{} {}".format(pen, *layout.at(x, y))
            pen = "L"
    return (
        f'<defs><path id="{prefix}-lines" d="{path}" fill="none"/></defs><g stroke-linejoin="round">'
        f'<use href="#{prefix}-lines" style="stroke:white" stroke-width="34"/>'
        f'<use href="#{prefix}-lines" style="stroke:black" stroke-width="14"/></g>'
    )


def _outliers(outside: tuple[int, int], limits: Sequence[float] | None) -> list[str]:
    """What is said of values off the colour scale."""
    if not sum(outside) or limits is None:
        return []
    below, above = outside
    return [f"Off the colour scale: {below} below, {above} above."]
