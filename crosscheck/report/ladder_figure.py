"""The large figure of error against cost: an SVG that is written here, for its labels stand at the ends of its lines.

Colour tells the family of methods, the marker tells the engine. Failed runs are crosses at the upper edge, and the
front of what no other run beats is drawn beneath the lines. Labels are moved apart, and joined to their ends by thin
lines.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from markupsafe import escape

from crosscheck.engines.registry import engine_names, engine_order
from crosscheck.report.figures import MARKERS, PALETTE, tick_text
from crosscheck.report.ladders import Case, Climb, Point
from crosscheck.text import printable

WIDTH, HEIGHT = 1000, 600
_LEFT, _RIGHT, _TOP, _BOTTOM = 74, 230, 22, 54
#: Height of a line of labels; characters of the longest.
_LINE, _LONGEST = 14.0, 34
#: Errors below this are drawn at it: rounding.
_LEAST = 1e-16
#: Bars that are shorter than this are hidden by the marker.
_SHORT = 5.0


class Axis(NamedTuple):
    """A logarithmic axis. low, high: its ends. start, end: their places in the figure."""

    low: float
    high: float
    start: float
    end: float

    def place(self, value: float) -> float:
        """The place of a value, at most that of an end."""
        share = math.log(min(max(value, self.low), self.high) / self.low) / math.log(self.high / self.low)
        return self.start + share * (self.end - self.start)

    @property
    def ticks(self) -> list[float]:
        """Powers of ten within the axis, every second or third of many, with 2 and 5 times them where there are few."""
        first, last = math.floor(math.log10(self.low)), math.ceil(math.log10(self.high))
        every = max(1, math.ceil((last - first) / 9))
        factors = (1.0, 2.0, 5.0) if last - first <= 3 else (1.0,)
        places = [factor * 10.0**k for k in range(first, last + 1) if k % every == 0 for factor in factors]
        return [place for place in places if self.low <= place <= self.high]


class Style(NamedTuple):
    """What colours and markers stand for on a page. families: one colour each. engines: one marker each."""

    families: list[str]
    engines: list[str]

    def colour(self, family: str) -> str:
        """The colour of a family."""
        return f"var(--c{self.families.index(family) % len(PALETTE)})"

    def shape(self, engine: str) -> str:
        """The outline of an engine's marker, about the origin."""
        return list(MARKERS.values())[self.engines.index(engine) % len(MARKERS)]

    def fill(self, engine: str, colour: str) -> str:
        """Filled for the first engine, open for the others, which stay visible around it."""
        return colour if self.engines.index(engine) == 0 else "var(--paper)"

    def size(self, engine: str) -> int:
        """Width of an engine's marker."""
        return 11 if self.engines.index(engine) == 0 else 13

    def groups(self, climb: Climb) -> str:
        """The classes of the curve of a method, `climb`, by which the legend finds it."""
        family = self.families.index(climb.family)
        return f"s f{family} e{self.engines.index(climb.engine)} s{family % len(PALETTE)}"

    def marker(self, climb: Climb) -> str:
        """The id of the marker of a method, `climb`."""
        return f"m{self.families.index(climb.family)}-{self.engines.index(climb.engine)}"


def style_of(cases: Iterable[Case]) -> Style:
    """The style of a page with these cases: the installed engines first, in their order."""
    climbs = [climb for case in cases for climb in case.climbs]
    installed = engine_names()
    others = sorted({climb.engine for climb in climbs} - set(installed))
    return Style(sorted({climb.family for climb in climbs}), [*installed, *others])


def draw(case: Case, style: Style, *, by_count: bool = False) -> str:
    """The figure of a case as SVG; "" if it has no run to draw.

    case: with its ladders. style: of the page. by_count: over what was counted in place of the CPU time; methods that
    were not counted are left out.
    """
    cost: Callable[[Point], float] = (lambda point: point.count) if by_count else (lambda point: point.cpu)
    climbs = [climb for climb in case.climbs if any(point.good and cost(point) > 0 for point in climb.points)]
    if not climbs:
        return ""
    x = _axis([cost(point) for climb in climbs for point in climb.points if cost(point) > 0], _LEFT, WIDTH - _RIGHT)
    y = _axis([max(point.error, _LEAST) for climb in climbs for point in climb.good], HEIGHT - _BOTTOM, _TOP)
    label = climbs[0].count_label if by_count else "CPU time of a run/s"
    title = f"{case.title}: {case.unit} against {label}"
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(printable(title))}" class="large">',
        _frame(x, y, label, case.unit),
        "" if by_count else _front(case, x, y),
        _curves(climbs, style, x, y, cost),
        "</svg>",
    ]
    return "\n".join(filter(None, parts))


def marker_definitions(style: Style) -> str:
    """The markers of all figures of a page, by family and engine, as one hidden SVG; style: of the page."""
    shapes = "".join(
        f'<marker id="m{i}-{j}" viewBox="-6 -6 12 12" markerWidth="{style.size(engine)}" '
        f'markerHeight="{style.size(engine)}" markerUnits="userSpaceOnUse">'
        f'<g style="fill:{style.fill(engine, style.colour(family))};stroke:{style.colour(family)}" stroke-width="1.3">'
        f"{style.shape(engine)}</g></marker>"
        for i, family in enumerate(style.families)
        for j, engine in enumerate(style.engines)
    )
    return f'<svg width="0" height="0" style="position:absolute" aria-hidden="true"><defs>{shapes}</defs></svg>'


def legend(case: Case, style: Style) -> list[tuple[str, str, str]]:
    """Entries (class of its curves, sample as SVG, text): the families of the case, then its engines.

    case: with its ladders. style: of the page.
    """
    entries = []
    for family in case.families:
        line = f'<path d="M-12 0H12" style="stroke:{style.colour(family)}" stroke-width="3"/>'
        entries.append((f"f{style.families.index(family)}", line, family))
    for engine in case.engines:
        face = style.fill(engine, "currentColor")
        shape = f'<g style="fill:{face};stroke:currentColor" stroke-width="1.2">{style.shape(engine)}</g>'
        entries.append((f"e{style.engines.index(engine)}", shape, engine))
    return [
        (group, f'<svg viewBox="-14 -6 28 12" width="28" height="12" aria-hidden="true">{sample}</svg>', text)
        for group, sample, text in entries
    ]


# -- parts ---------------------------------------------------------------------------------------------------


def _axis(values: Iterable[float], start: float, end: float) -> Axis:
    found = [value for value in values if 0 < value < math.inf]
    low, high = min(found), max(found)
    margin = max(1.25, (high / low) ** 0.02)
    return Axis(low / margin, high * margin, start, end)


def _frame(x: Axis, y: Axis, x_label: str, y_label: str) -> str:
    lines, texts = [], []
    for value in x.ticks:
        at = x.place(value)
        lines.append(f"M{at:.1f} {_TOP}V{HEIGHT - _BOTTOM}")
        texts.append(f'<text x="{at:.1f}" y="{HEIGHT - _BOTTOM + 18}" text-anchor="middle">{tick_text(value)}</text>')
    for value in y.ticks:
        at = y.place(value)
        lines.append(f"M{_LEFT} {at:.1f}H{WIDTH - _RIGHT}")
        texts.append(f'<text x="{_LEFT - 8}" y="{at + 4:.1f}" text-anchor="end">{tick_text(value)}</text>')
    middle = (_TOP + HEIGHT - _BOTTOM) / 2
    return (
        f'<path d="{"".join(lines)}" style="stroke:var(--grid)" fill="none"/>'
        f'<path d="M{_LEFT} {_TOP}V{HEIGHT - _BOTTOM}H{WIDTH - _RIGHT}" stroke="currentColor" fill="none"/>'
        f'<g fill="currentColor" font-size="12.5">{"".join(texts)}'
        f'<text x="{(_LEFT + WIDTH - _RIGHT) / 2}" y="{HEIGHT - 12}" text-anchor="middle">{escape(printable(x_label))}'
        f'</text><text transform="translate(16 {middle}) rotate(-90)" text-anchor="middle">'
        f"{escape(printable(y_label))}</text></g>"
    )


def _front(case: Case, x: Axis, y: Axis) -> str:
    """The front as a broad band of steps: what has been reached by a cost stays reached."""
    path = ""
    for _, point in case.front:
        across, up = x.place(point.cpu), y.place(max(point.error, _LEAST))
        path += f"H{across:.1f}V{up:.1f}" if path else f"M{across:.1f} {up:.1f}"
    return f'<path class="front" d="{path}H{x.end:.1f}"/>' if path else ""


def _curves(climbs: Sequence[Climb], style: Style, x: Axis, y: Axis, cost: Callable[[Point], float]) -> str:
    """The curves, each in one group with its label, which stands right of the axes and is joined to its last run."""
    ends = []
    for climb in climbs:
        last = [point for point in climb.good if cost(point) > 0][-1]
        ends.append((y.place(max(last.error, _LEAST)), x.place(cost(last)), climb))
    ends.sort(key=lambda one: (one[0], one[1], engine_order(one[2].engine), one[2].label))
    heights = apart([end[0] for end in ends], _LINE, _TOP + 4, HEIGHT - 8)
    parts = []
    for (up, across, climb), height in zip(ends, heights, strict=True):
        name, at = printable(climb.name), WIDTH - _RIGHT + 16
        short = name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…"
        parts.append(
            f'<g class="{style.groups(climb)}">'
            f'<path d="M{across + 6:.0f} {up:.0f}L{at - 10} {height:.0f}H{at - 3}" class="leader"/>'
            f"{_curve(climb, style, x, y, cost)}"
            f'<text x="{at}" y="{height + 4:.0f}">{escape(short)}</text></g>'
        )
    return f'<g fill="none" stroke-width="1.6" font-size="12">{"".join(parts)}</g>'


def _curve(climb: Climb, style: Style, x: Axis, y: Axis, cost: Callable[[Point], float]) -> str:
    """Lines through the runs that can be compared, their bars, and crosses for the others."""
    marker = style.marker(climb)
    pieces: list[list[str]] = [[]]
    bars, crosses = "", ""
    for point in climb.points:
        if not cost(point) > 0:
            continue
        across = x.place(cost(point))
        if not point.good:
            crosses += f"M{across - 4:.0f} {_TOP - 4}l8 8m0-8l-8 8"
            pieces.append([])
            continue
        up = y.place(max(point.error, _LEAST))
        pieces[-1].append(f"{across:.1f},{up:.1f}")
        bars += _bars(point, x, y, across, up, timed=cost(point) == point.cpu)
    lines = "".join(
        f'<polyline points="{" ".join(piece)}" style="marker:url(#{marker})"/>' for piece in pieces if piece
    )
    thin = f'<path d="{bars}" stroke-width="1"/>' if bars else ""
    return thin + (f'<path d="{crosses}"/>' if crosses else "") + lines


def _bars(point: Point, x: Axis, y: Axis, across: float, up: float, *, timed: bool) -> str:
    """Bars of the CPU time's range and of the error's uncertainty, where they are longer than the marker."""
    path = ""
    if timed:
        left, right = x.place(point.low), x.place(point.high)
        if right - left > 2 * _SHORT:
            path += f"M{left:.0f} {up:.0f}H{right:.0f}"
    if point.uncertainty > 0:
        top = y.place(point.error + point.uncertainty)
        # an error that may be nothing but this has no lower end
        bottom = y.place(point.error - point.uncertainty) if point.error > point.uncertainty else up
        if bottom - top > 2 * _SHORT:
            path += f"M{across:.0f} {top:.0f}V{bottom:.0f}"
    return path


def apart(places: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """The places moved as little as possible, so that neighbours are `gap` apart, within low and high.

    places: rising. Neighbours that would overlap form a block about their mean (pool of adjacent violators). Where all
    of them do not fit, the gap is made smaller.
    """
    number = len(places)
    gap = min(gap, (high - low) / max(number - 1, 1))
    blocks: list[tuple[float, int]] = []  # the mean of (place - own offset), and how many
    for k, place in enumerate(places):
        mean, size = place - k * gap, 1
        while blocks and blocks[-1][0] > mean:
            before, many = blocks.pop()
            mean, size = (before * many + mean * size) / (many + size), many + size
        blocks.append((mean, size))
    moved = [mean for mean, size in blocks for _ in range(size)]
    highest = high - (number - 1) * gap
    return [min(max(mean, low), highest) + k * gap for k, mean in enumerate(moved)]
