"""Pictures of particles and of fields, to one scale on both axes, with a colour bar: inline SVG like the curves.

Frame and ticks are matplotlib's; the content is written here, in tenths of a unit of the SVG. A particle is a stroke of
no length with a round cap, 12 bytes where a circle takes 36. A field is an image of a pixel a cell. The colour map is
viridis: perceptually uniform, and in lightness alone monotonic, for those who see fewer hues.
"""

from __future__ import annotations

import base64
import math
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from crosscheck.engines.registry import engine_order
from crosscheck.record import Line, case_name
from crosscheck.report.figures import LARGEST, WIDTH, Drawing, qualified, sheet, style, to_svg
from crosscheck.report.numbers import plain, to_tolerance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Steps of the colour map; the template turns them into CSS variables --m0, --m1, ...
LEVELS = 64
# room for the labels about the picture, and the largest and smallest height of picture and colour bar, in SVG units
_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 86, 14, 47
_HIGHEST, _LOWEST = 420, 90
_GAP, _BAR = 9, 11
#: Free space about the container, and the share of it that particles may add to it.
_MARGIN, _OVERHANG = 0.02, 0.1
#: Drawn no smaller than this, outlined above it, and with an outline of at most so much, in SVG units.
_SMALLEST, _OUTLINED, _OUTLINE = 0.5, 0.8, 0.6
#: The longest arrow in spacings of their grid, the opening and the length of its head in SVG units.
_ARROW, _HEAD_ANGLE, _HEAD = 1.4, 0.45, 3.5

Limits = tuple[float, float]


@dataclass(frozen=True)
class Picture:
    """A snapshot or a map (the other one is None) of one verdict, as the record has it, with its caption."""

    title: str
    x_label: str
    y_label: str
    snapshot: dict[str, Any] | None
    map: dict[str, Any] | None


@cache
def colours() -> tuple[str, ...]:
    """The colour map, from the lowest value to the highest."""
    import matplotlib
    from matplotlib.colors import to_hex

    return tuple(to_hex(colour) for colour in matplotlib.colormaps["viridis"](range(0, 256, 256 // LEVELS)))


def pictures(lines: Iterable[Line], variant: Callable[[Line], str]) -> list[Picture]:
    """Snapshots and maps of the verdicts of one check; captions that would be equal get the variant or the engine."""
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
    """The picture as SVG. prefix: makes its ids unique in the page."""
    if picture.snapshot is not None:
        return _draw_snapshot(picture, picture.snapshot, prefix)
    assert picture.map is not None
    return _draw_map(picture, picture.map, prefix)


# -- frame ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Frame:
    """Where what is seen (left, right, bottom, top, in units of the scene) lies in the SVG; scale: SVG units a unit."""

    view: tuple[float, float, float, float]
    scale: float
    left: float
    top: float
    bar: bool

    @property
    def width(self) -> float:
        return (self.view[1] - self.view[0]) * self.scale

    @property
    def height(self) -> float:
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
        """A point in tenths of an SVG unit."""
        left, _, _, top = self.view
        return round(10 * (self.left + (x - left) * self.scale)), round(10 * (self.top + (top - y) * self.scale))

    def holds(self, x: float, y: float) -> bool:
        left, right, bottom, top = self.view
        return left <= x <= right and bottom <= y <= top

    def edge(self, x: float, y: float) -> tuple[int, int]:
        """The nearest point of the frame: not finite counts as too large."""
        left, right, bottom, top = self.view
        return self.at(min(max(x, left), right) if x == x else right, min(max(y, bottom), top) if y == y else top)


def _bounds(container: dict[str, Any]) -> tuple[float, float, float, float]:
    """left, right, bottom, top."""
    if container["shape"] == "drum":
        x, y, radius = container["x"], container["y"], container["radius"]
        return x - radius, x + radius, y - radius, y + radius
    return container["left"], container["right"], container["bottom"], container["top"]


def _frame(container: dict[str, Any], overhang: float, bar: bool) -> Frame:
    """The container with a margin that holds `overhang` if that is not too much, as large as the page lets it be."""
    left, right, bottom, top = _bounds(container)
    size = max(right - left, top - bottom)
    margin = _MARGIN * size + min(overhang, _OVERHANG * size)
    view = left - margin, right + margin, bottom - margin, top + margin
    room = WIDTH - _LEFT - (_RIGHT if bar else 12)
    scale = min(room / (view[1] - view[0]), _HIGHEST / (view[3] - view[2]))
    height = (view[3] - view[2]) * scale
    return Frame(view, scale, _LEFT, _TOP + max(0.0, _LOWEST - height) / 2, bar)


def _axes(picture: Picture, frame: Frame, limits: Limits | None, label: str) -> Figure:
    """Ticks and labels of the picture and of the colour bar."""
    import textwrap

    figure = sheet(frame.total)
    left, right, bottom, top = frame.view
    axes = _add(figure, frame, frame.left, frame.top, frame.width, frame.height)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    _ticks(axes, "x", left, right, frame.width / 60)
    _ticks(axes, "y", bottom, top, frame.height / 45)
    axes.set_xlabel(textwrap.fill(picture.x_label, max(16, round(frame.width / 6))))
    axes.set_ylabel(textwrap.fill(picture.y_label, max(16, round(frame.area / 6))), labelpad=2)
    axes.spines[["top", "right", "left", "bottom"]].set_visible(False)
    if limits is not None:
        bar = _add(figure, frame, frame.left + frame.width + _GAP, _TOP, _BAR, frame.area)
        bar.set_ylim(*limits)
        bar.set_xticks([])
        _ticks(bar, "y", *limits, frame.area / 45)
        bar.yaxis.tick_right()
        bar.yaxis.set_label_position("right")
        bar.set_ylabel(textwrap.fill(label, max(16, round(frame.area / 6))), labelpad=5)
        bar.spines[["top", "right", "left", "bottom"]].set_visible(False)
    return figure


def _add(figure: Figure, frame: Frame, left: float, top: float, width: float, height: float) -> Axes:
    total = frame.total
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


def _number(value: float | None) -> float:
    """The record writes null for what is not finite; so does here NaN for what no axis can hold."""
    return math.nan if value is None or not abs(value) < LARGEST else float(value)


def _limits(given: Sequence[float] | None, values: list[float]) -> Limits | None:
    """Ends of the colour scale; None without a value to colour."""
    finite = [value for value in values if math.isfinite(value)]
    if not finite:
        return None
    if given is not None:
        return given[0], given[1]
    low, high = min(finite), max(finite)
    if low == high:
        around = 0.5 * abs(low) or 0.5
        return low - around, high + around
    return low, high


def _level(value: float, limits: Limits) -> int:
    low, high = limits
    if not low < value < high:
        return LEVELS - 1 if value >= high else 0
    return min(LEVELS - 1, math.floor(LEVELS * ((value - low) / (high - low))))


def _beyond(values: list[float], limits: Limits | None) -> tuple[int, int]:
    """How many values lie below and above the colour scale."""
    if limits is None:
        return 0, 0
    return sum(value < limits[0] for value in values), sum(value > limits[1] for value in values)


def _colour_bar(frame: Frame, beyond: tuple[int, int]) -> str:
    """The colours from bottom to top, with a tip where values lie beyond that end."""
    left, top = round(10 * (frame.left + frame.width + _GAP)), 10 * _TOP
    width, height = 10 * _BAR, round(10 * frame.area)
    content = _image([[level] for level in range(LEVELS)], left, top, width, height)
    tips = ((beyond[0], top + height, 80, 0), (beyond[1], top, -80, LEVELS - 1))
    for number, y, tip, level in tips:
        if number:
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


def _container(container: dict[str, Any], frame: Frame) -> str:
    """Walls as thick lines, other sides dashed."""
    if container["shape"] == "drum":
        x, y = frame.at(container["x"], container["y"])
        radius = round(10 * container["radius"] * frame.scale)
        return f'<circle cx="{x}" cy="{y}" r="{radius}" stroke="currentColor" stroke-width="20"/>'
    left, right, bottom, top = _bounds(container)
    corners = {
        "left": (left, bottom, left, top),
        "right": (right, bottom, right, top),
        "bottom": (left, bottom, right, bottom),
        "top": (left, top, right, top),
    }
    walls, others = "", ""
    for side, (x0, y0, x1, y1) in corners.items():
        path = "M{} {}L{} {}".format(*frame.at(x0, y0), *frame.at(x1, y1))
        if side in container["walls"]:
            walls += path
        else:
            others += path
    drawn = f'<path d="{walls}" stroke="currentColor" stroke-width="20" stroke-linecap="square"/>' if walls else ""
    if others:
        drawn += f'<path d="{others}" stroke="currentColor" stroke-width="8" stroke-dasharray="50 40"/>'
    return drawn


def _compose(frame: Frame, picture: Picture, limits: Limits | None, label: str, content: str, prefix: str) -> str:
    """The content under the frame with its ticks."""
    with style():
        svg = to_svg(_axes(picture, frame, limits, label), picture.title, prefix)
    end = svg.index(">") + 1
    return f'{svg[:end]}\n<g transform="scale(.1)" fill="none">{content}</g>{svg[end:]}'


def _draw_snapshot(picture: Picture, snapshot: dict[str, Any], prefix: str) -> Drawing:
    x, y = [_number(v) for v in snapshot["x"]], [_number(v) for v in snapshot["y"]]
    radius = snapshot["radius"]
    radii = [_number(r) for r in radius] if isinstance(radius, list) else [_number(radius)] * len(x)
    values = [_number(v) for v in snapshot["value"] or ()]
    limits = _limits(snapshot["limits"], values)
    largest = max((r for r in radii if math.isfinite(r)), default=0.0)
    frame = _frame(snapshot["container"], largest, limits is not None)
    beyond = _beyond(values, limits)

    rings: dict[int, str] = defaultdict(str)
    disks: dict[tuple[int, int], str] = defaultdict(str)
    crosses, small, blank = "", 0, 0
    for i, place in enumerate(zip(x, y, strict=True)):
        if not frame.holds(*place):
            crosses += "M{} {}m-35-35l70 70m0-70l-70 70".format(*frame.edge(*place))
            continue
        true = radii[i] * frame.scale
        small += not true >= _SMALLEST
        drawn = true if true >= _SMALLEST else _SMALLEST
        outline = min(_OUTLINE, 0.25 * drawn) if drawn >= _OUTLINED else 0.0
        point = "M{} {}h0".format(*frame.at(*place))
        if outline:
            rings[round(20 * drawn)] += point
        coloured = limits is not None and math.isfinite(values[i])
        blank += bool(values) and not coloured
        level = _level(values[i], limits) if limits is not None and coloured else -1
        disks[level, round(20 * (drawn - outline))] += point

    content = _container(snapshot["container"], frame)
    content += '<g stroke-linecap="round" style="stroke:var(--ring)">'
    content += "".join(f'<path d="{d}" stroke-width="{w}"/>' for w, d in sorted(rings.items()))
    for (level, width), path in sorted(disks.items()):
        paint = "var(--c0)" if not values else "var(--paper)" if level < 0 else f"var(--m{level})"
        content += f'<path d="{path}" style="stroke:{paint}" stroke-width="{width}"/>'
    content += "</g>"
    if crosses:
        content += f'<path d="{crosses}" stroke="currentColor" stroke-width="16"/>'
    if limits is not None:
        content += _colour_bar(frame, beyond)
    svg = _compose(frame, picture, limits, snapshot["value_label"], content, prefix)

    remarks = [] if x else ["No particles."]
    lost = crosses.count("l70 70")
    if lost:
        remarks.append(f"× at the edge: {_many(lost, 'particle')} outside the picture or not finite.")
    if blank:
        remarks.append(f"{_many(blank, 'particle')} without a value: not filled.")
    if small:
        remarks.append("Particles are drawn larger than they are.")
    return Drawing(picture.title, svg, [], [], remarks=remarks + _outliers(beyond, snapshot["limits"]))


def _draw_map(picture: Picture, field: dict[str, Any], prefix: str) -> Drawing:
    rows = [[_number(v) for v in row] for row in field["values"]]
    values = [value for row in rows for value in row]
    limits = _limits(field["limits"], values)
    frame = _frame(field["container"], 0.0, limits is not None)
    beyond = _beyond(values, limits)
    left, right, bottom, top = _bounds(field["container"])
    content = ""
    if limits is not None:
        levels = [[_level(v, limits) if math.isfinite(v) else None for v in row] for row in rows]
        (x0, y0), (x1, y1) = frame.at(left, top), frame.at(right, bottom)
        content += _image(levels, x0, y0, x1 - x0, y1 - y0)
    content += _container(field["container"], frame)
    remarks = [] if limits is not None else ["No cell has a value."]
    if field["arrows"]:
        path, longest = _arrows(field["arrows"], (left, right, bottom, top), frame)
        if path:
            # light about dark: seen on every colour of the map and on either page
            content += (
                f'<defs><path id="{prefix}-arrows" d="{path}"/></defs>'
                f'<g stroke-linecap="round" stroke-linejoin="round">'
                f'<use href="#{prefix}-arrows" style="stroke:white" stroke-width="26"/>'
                f'<use href="#{prefix}-arrows" style="stroke:black" stroke-width="11"/></g>'
            )
        remarks.append(f"Arrows: {field['arrow_label'] or 'vector field'}; the longest is {plain(longest, 3)}.")
    if limits is not None:
        content += _colour_bar(frame, beyond)
    svg = _compose(frame, picture, limits, field["value_label"], content, prefix)
    blank = sum(not math.isfinite(value) for value in values)
    if blank and limits is not None and field["container"]["shape"] == "box":
        remarks.append(f"{_many(blank, 'blank cell')}: no value.")
    return Drawing(picture.title, svg, [], [], remarks=remarks + _outliers(beyond, field["limits"]))


def _arrows(arrows: list[list[list[float | None]]], bounds: tuple[float, ...], frame: Frame) -> tuple[str, float]:
    """The path of all arrows, each about the middle of its cell, and the largest length in units of the field."""
    left, right, bottom, top = bounds
    vectors = [
        (row, column, _number(u), _number(v))
        for row, (us, vs) in enumerate(zip(*arrows, strict=True))
        for column, (u, v) in enumerate(zip(us, vs, strict=True))
    ]
    vectors = [one for one in vectors if math.isfinite(math.hypot(*one[2:]))]
    longest = max((math.hypot(u, v) for _, _, u, v in vectors), default=0.0)
    if not longest:
        return "", longest
    wide, high = (right - left) / len(arrows[0][0]), (top - bottom) / len(arrows[0])
    reach = 10 * _ARROW * min(wide, high) * frame.scale
    path = ""
    for row, column, u, v in vectors:
        dx, dy = reach * (u / longest), -reach * (v / longest)
        length = math.hypot(dx, dy)
        if length < 10:
            continue
        x, y = frame.at(left + (column + 0.5) * wide, bottom + (row + 0.5) * high)
        path += f"M{x - round(dx / 2)} {y - round(dy / 2)}l{round(dx)} {round(dy)}"
        head, angle = min(10 * _HEAD, 0.45 * length), math.atan2(-dy, -dx)
        barbs = [
            (round(head * math.cos(angle + s)), round(head * math.sin(angle + s))) for s in (-_HEAD_ANGLE, _HEAD_ANGLE)
        ]
        (ax, ay), (bx, by) = barbs
        path += f"l{ax} {ay}m{-ax} {-ay}l{bx} {by}"
    return path, longest


def _many(number: int, what: str) -> str:
    return f"{number} {what}{'s' if number > 1 else ''}"


def _outliers(beyond: tuple[int, int], limits: Sequence[float] | None) -> list[str]:
    """What is said of values off the colour scale."""
    if not sum(beyond) or limits is None:
        return []
    below, above = beyond
    return [f"Off the colour scale: {below} below, {above} above."]
