"""Figures of a report: inline SVG that takes the colours of the page, the same bytes for the same record.

Colour and dashes tell the curve (a scheme), the marker tells the engine: filled for the first, open and larger for
the others, which stay visible around it where engines agree. The legend is HTML, so that it stays readable on a
phone. Points that are not finite, or that do not fit on the axis, are drawn at its edge as a cross. A histogram is an
outline of its bins, filled where it is alone, with its marker at their centres where there are several engines.
"""

from __future__ import annotations

import io
import math
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from crosscheck.engines.registry import engine_names, engine_order
from crosscheck.painter import LARGEST
from crosscheck.record import Line, case_name
from crosscheck.text import printable

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

#: Colours of the curves on a light and on a dark page: each stands out from its background by 3:1 or more, and from its
#: neighbours in lightness too, for readers who see fewer hues. The template turns them into the CSS
#: variables --c0, --c1, ...
PALETTE: tuple[tuple[str, str], ...] = (
    ("#0067a8", "#58b4f0"),
    ("#d04f00", "#ff9a52"),
    ("#00846a", "#35cba4"),
    ("#a8327f", "#f29fd0"),
    ("#8f6c00", "#efd04f"),
    ("#3a2a8c", "#a99cff"),
)
#: Dash patterns in units of the line width; a curve takes the next one when the colours are used up.
DASHES: tuple[tuple[float, ...], ...] = ((), (5.0, 2.0), (1.2, 1.4))
THEORY_DASHES: tuple[tuple[float, ...], ...] = ((5.0, 3.0), (1.5, 2.0), (8.0, 2.0, 1.5, 2.0))
#: matplotlib's marker -> its outline in the legend, about the origin.
MARKERS: dict[str, str] = {
    "o": '<circle r="3.4"/>',
    "s": '<rect x="-3" y="-3" width="6" height="6"/>',
    "^": '<path d="M0-3.8 3.6 3-3.6 3z"/>',
    "D": '<path d="M0-4.2 3.4 0 0 4.2-3.4 0z"/>',
    "v": '<path d="M0 3.8 3.6-3-3.6-3z"/>',
    "p": '<path d="M0-3.8 3.6-1.2 2.2 3.1-2.2 3.1-3.6-1.2z"/>',
    "<": '<path d="M-3.8 0 3 3.6 3-3.6z"/>',
    ">": '<path d="M3.8 0-3 3.6-3-3.6z"/>',
}
#: Samples of a curve and of a histogram in the legend.
_LINE, _STEPS = "M-15 0H15", "M-13 5V1H-5V-4H4V-1H13V5"
# stand-ins for the colours of the page, which matplotlib does not know
_INK, _GRID = "#010203", "#070809"
WIDTH, _HEIGHT, _TALL = 440, 300, 370
#: More curves than this get the tall axes.
_CROWD = 8
#: More curves than this get few markers: there are many beside each other.
_THRONG = 40
#: A logarithmic axis shows at most so many decades; what lies outside counts as off the scale.
_DECADES = 24
_DECADES_WITH_MINOR_TICKS = 4
_MARKED = 60


@dataclass(frozen=True)
class Curve:
    """One series of one verdict.

    name: what the legend calls it, the same for all engines. engine: its name. x, y: the points; bins: x holds the
    edges of a histogram, one more than y. error: standard errors of y, or None. theory: whether it is what is expected.
    """

    name: str
    engine: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    error: tuple[float, ...] | None
    theory: bool
    bins: bool

    @property
    def points(self) -> list[tuple[float, float]]:
        """(x, y), of a histogram at the centres of its bins."""
        x = [0.5 * (a + b) for a, b in pairwise(self.x)] if self.bins else self.x
        return list(zip(x, self.y, strict=True))

    def outline(self, base: float) -> tuple[list[float], list[float]]:
        """The corners of a histogram that stands on `base`.

        base: in the units of y. Gives x and y of the corners.
        """
        x = [edge for edge in self.x for _ in range(2)]
        return x, [base, *(height for height in self.y for _ in range(2)), base]


@dataclass(frozen=True)
class Panel:
    """One set of axes with the curves of all verdicts whose figures have this title.

    title: of the figure. x_label, y_label: with the units. x_scale, y_scale: "linear" or "log". curves: in the order of
    the record.
    """

    title: str
    x_label: str
    y_label: str
    x_scale: str
    y_scale: str
    curves: tuple[Curve, ...]

    @property
    def engines(self) -> list[str]:
        """The engines that have a curve here, in the order of the report."""
        return sorted({curve.engine for curve in self.curves if not curve.theory}, key=engine_order)


@dataclass(frozen=True)
class Key:
    """One entry of a legend.

    text: what it says. group: the class of its curves in the SVG. sample: of its line or marker, as SVG.
    """

    text: str
    group: str
    sample: str


@dataclass(frozen=True)
class Drawing:
    """One figure as the page shows it.

    title: its caption. svg: the figure. curves, engines: the entries of its legend. failed: number of points drawn at
    the edge. remarks: what else the reader must know, a sentence each.
    """

    title: str
    svg: str
    curves: list[Key]
    engines: list[Key]
    failed: int = 0
    remarks: list[str] = field(default_factory=list)


# -- from the record to panels -------------------------------------------------------------------------------


def panels(lines: Iterable[Line], variant: Callable[[Line], str]) -> list[Panel]:
    """The curves of the verdicts of one check, merged by title, in the order of their first appearance.

    lines: of the record. variant: gives the name of the variant of a line.
    """
    merged: dict[str, tuple[dict[str, Any], list[tuple[Line, dict[str, Any]]]]] = {}
    for line in sorted(lines, key=lambda line: (case_name(line), engine_order(line["engine"]))):
        for figure in line.get("figures") or ():
            if figure.get("snapshot") or figure.get("map") or figure.get("ladder"):
                continue
            _, series = merged.setdefault(figure["title"], (figure, []))
            series += [(line, one) for one in figure["series"]]
    return [
        Panel(
            figure["title"],
            figure["x_label"],
            figure["y_label"],
            figure["x_scale"],
            figure["y_scale"],
            _curves(series, variant),
        )
        for figure, series in merged.values()
    ]


def _curves(series: list[tuple[Line, dict[str, Any]]], variant: Callable[[Line], str]) -> tuple[Curve, ...]:
    """Curves with names that tell them apart: the label, with the variant where that is not enough; theory once."""
    uses = Counter((line["engine"], one["label"]) for line, one in series if not one["theory"])
    ambiguous = {label for (_, label), number in uses.items() if number > 1}
    curves: list[Curve] = []
    for line, one in series:
        label, theory = one["label"], bool(one["theory"])
        known = [curve for curve in curves if curve.theory and curve.name == label] if theory else []
        x, y, error = _numbers(one["x"]), _numbers(one["y"]), one.get("error")
        if any(_same(curve.x, x) and _same(curve.y, y) for curve in known):
            continue
        if label in ambiguous or known:
            label = qualified(label, variant(line))
        error = None if error is None else _numbers(error)
        curves.append(Curve(label, line["engine"], x, y, error, theory, bool(one.get("bins"))))
    return tuple(curves)


def qualified(label: str, variant: str) -> str:
    """The label with its variant, "label, variant", but for the case that one of them is a word of the other.

    label: of a curve or a picture. variant: of its verdict.
    """
    if variant in re.split(r"[\s,:]+", label):
        return label
    return variant if label in re.split(r"[\s,:]+", variant) else f"{label}, {variant}"


def _numbers(values: Sequence[float | None]) -> tuple[float, ...]:
    """The record writes null for what is not finite; so does here NaN for what no axis can hold."""
    return tuple(math.nan if v is None or not abs(v) < LARGEST else float(v) for v in values)


def _same(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return len(a) == len(b) and all(p == q or (p != p and q != q) for p, q in zip(a, b, strict=True))


def curve_numbers(group: Iterable[Panel]) -> dict[str, int]:
    """Name -> number, which fixes colour and dashes: the same scheme looks the same in all panels of a group.

    group: the panels.
    """
    names = {curve.name for panel in group for curve in panel.curves if not curve.theory}
    return {name: number for number, name in enumerate(sorted(names))}


def _markers(group: Iterable[str]) -> dict[str, str]:
    installed = engine_names()
    others = sorted(set(group) - set(installed))
    return {engine: list(MARKERS)[i % len(MARKERS)] for i, engine in enumerate((*installed, *others))}


# -- from a panel to SVG -------------------------------------------------------------------------------------


def draw(panel: Panel, numbers: dict[str, int], prefix: str) -> Drawing:
    """The panel as SVG.

    panel: what to draw. numbers: of `curve_numbers`. prefix: makes its ids unique in the page.
    """
    markers = _markers(panel.engines)
    height = _TALL if len(panel.curves) > _CROWD else _HEIGHT
    with style():
        figure = sheet(height)
        # margins that hold two lines of either label: a layout engine would double the time
        figure.subplots_adjust(left=84 / WIDTH, right=1 - 12 / WIDTH, bottom=58 / height, top=1 - 12 / height)
        axes = figure.add_subplot(facecolor="none")
        _prepare(axes, panel)
        failed = _plot(axes, panel, numbers, markers)
        svg = to_svg(figure, panel.title, prefix)
    curves, engines = _legend(panel, numbers, markers)
    return Drawing(panel.title, svg, curves, engines, failed)


def style() -> AbstractContextManager[None]:
    """The settings under which a figure is made and written."""
    import matplotlib

    settings: Any = {
        "text.parse_math": False,  # labels are drawn as they are written, "$" too
        "svg.fonttype": "none",
        "svg.hashsalt": "crosscheck",
        "font.family": "DejaVu Sans",
        "font.size": 11,
        "axes.edgecolor": _INK,
        "axes.labelcolor": _INK,
        "axes.linewidth": 0.8,
        "text.color": _INK,
        "xtick.color": _INK,
        "ytick.color": _INK,
        "path.simplify_threshold": 0.3,
    }
    return matplotlib.rc_context(settings)


def sheet(height: float) -> Figure:
    """An empty figure of the width of the page.

    height: in units of the SVG, as `WIDTH`.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH / 72, height / 72), facecolor="none")
    FigureCanvasSVG(figure)
    return figure


def to_svg(figure: Figure, title: str, prefix: str) -> str:
    """The figure as SVG that can stand within a page.

    figure: made and written under `style`. title: what screen readers say. prefix: makes its ids unique in the page.
    """
    file = io.StringIO()
    nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # the page's own font shows them
        figure.savefig(file, format="svg", metadata=nothing)
    return _inline(file.getvalue(), title, round(72 * figure.get_figheight()), prefix)


def _prepare(axes: Axes, panel: Panel) -> None:
    """Labels, scales, limits that hold every finite point, ticks."""
    import textwrap

    axes.set_xlabel(textwrap.fill(printable(panel.x_label), 56))
    axes.set_ylabel(textwrap.fill(printable(panel.y_label), 38))
    axes.grid(True, color=_GRID, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    x = [value for curve in panel.curves for value in curve.x]
    y = [value for curve in panel.curves for value in curve.y]
    for curve in panel.curves:
        if curve.error is not None:
            y += [v + s * e for v, e in zip(curve.y, curve.error, strict=True) for s in (-1, 1)]
    axes.set_xscale(panel.x_scale)
    axes.set_yscale(panel.y_scale)
    axes.set_xlim(_ticks_and_limits(axes.xaxis, panel.x_scale, x))
    low, high = _ticks_and_limits(axes.yaxis, panel.y_scale, y)
    if panel.y_scale == "linear" and any(curve.bins for curve in panel.curves):
        # bars stand on zero; no error bar makes room below it
        low = min(low, 0.0) if any(value < 0 for curve in panel.curves for value in curve.y) else 0.0
        high = max(high, 0.0)
    axes.set_ylim(low, high)
    for axis, scale in ((axes.xaxis, panel.x_scale), (axes.yaxis, panel.y_scale)):
        if scale == "log":
            _minor_ticks(axes, axis)


def _minor_ticks(axes: Axes, axis: Axis) -> None:
    """Minor ticks of a short logarithmic axis, as the markers of one line.

    Ticks of matplotlib's own are an object with lines and labels each, and took a fourth of the time of a page.
    """
    import matplotlib
    from matplotlib.lines import Line2D
    from matplotlib.markers import TICKDOWN, TICKLEFT, MarkerStyle
    from matplotlib.ticker import LogLocator

    low, high = sorted(axis.get_view_interval())
    if math.log10(high / low) >= _DECADES_WITH_MINOR_TICKS:
        return
    places = [place for place in LogLocator(subs="all", numticks=100).tick_values(low, high) if low <= place <= high]
    horizontal, edge = axis is axes.xaxis, [0.0] * len(places)
    axes.add_line(
        Line2D(
            *((places, edge) if horizontal else (edge, places)),
            transform=axes.get_xaxis_transform() if horizontal else axes.get_yaxis_transform(),
            marker=MarkerStyle(TICKDOWN if horizontal else TICKLEFT),
            markersize=matplotlib.rcParams["xtick.minor.size"],
            markeredgewidth=matplotlib.rcParams["xtick.minor.width"],
            color=_INK,
            linestyle="none",
            clip_on=False,
            zorder=2.01,
        )
    )


def _ticks_and_limits(axis: Axis, scale: str, values: list[float]) -> tuple[float, float]:
    """Sets the ticks and returns the limits, with a margin of 4 %."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

    if scale == "log":
        logs = sorted(math.log10(value) for value in values if value > 0)
        low, high = (logs[0], logs[-1]) if logs else (0.0, 1.0)
        if high - low > _DECADES:
            # the limits follow the median of the points, not a few far ones
            low = max(low, logs[len(logs) // 2] - _DECADES / 2)
            high = min(high, low + _DECADES)
        margin = 0.04 * (high - low) or 0.3
        decades = high - low
        axis.set_major_locator(LogLocator(subs=(1.0,) if decades > 2 else (1.0, 2.0, 5.0), numticks=7))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: tick_text(value)))
        return 10 ** (low - margin), 10 ** (high + margin)
    finite = [value for value in values if math.isfinite(value)] or [0.0, 1.0]
    low, high = min(finite), max(finite)
    margin = 0.04 * (high - low) or 0.5 * abs(high) or 0.5
    axis.set_major_locator(MaxNLocator(6))
    return low - margin, high + margin


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def tick_text(value: float) -> str:
    """A tick of a logarithmic axis at `value`, as plain text: 0.01, 10⁻⁵, 2×10⁶."""
    mantissa, _, exponent = f"{value:.2e}".partition("e")
    if -2 <= int(exponent) <= 3:
        return f"{value:g}"
    head = mantissa.rstrip("0").rstrip(".")
    power = "10" + str(int(exponent)).translate(_SUPERSCRIPTS)
    return power if head == "1" else f"{head}×{power}"


def _plot(axes: Axes, panel: Panel, numbers: dict[str, int], markers: dict[str, str]) -> int:
    """Draws the curves; returns how many points are drawn at the edge."""
    several = len(panel.engines) > 1
    theories = [curve for curve in panel.curves if curve.theory]
    alone = sum(curve.bins and not curve.theory for curve in panel.curves) == 1
    floor = axes.get_ylim()[0]
    base = floor if panel.y_scale == "log" else 0.0
    failed = 0
    for curve in panel.curves:
        if curve.theory:
            place = theories.index(curve)
            dashes = THEORY_DASHES[place % len(THEORY_DASHES)]
            x, y = curve.outline(base) if curve.bins else (curve.x, curve.y)
            axes.plot(x, y, color=_INK, linewidth=0.9, dashes=dashes, gid=f"t{place}", zorder=2.2)
            continue
        number = numbers[curve.name]
        colour = PALETTE[number % len(PALETTE)][0]
        cycle = number // len(PALETTE)
        gid = f"k{number}-e{list(markers).index(curve.engine)}"
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        # a bar that ends below the axis, as an empty one on a log scale does, is drawn where it is
        inside = [left <= x <= right and y <= top and (curve.bins or bottom <= y) for x, y in curve.points]
        x = [x if good else math.nan for (x, _), good in zip(curve.points, inside, strict=True)]
        y = [y if good else math.nan for (_, y), good in zip(curve.points, inside, strict=True)]
        many = len(x) > _MARKED
        joined = not curve.bins and (many or curve.error is None or not theories)
        if curve.bins:
            corners = curve.outline(base)
            axes.plot(*corners, color=colour, linewidth=1.2, linestyle=(0, DASHES[cycle % len(DASHES)]), gid=gid)
            if alone:
                axes.fill_between(*corners, base, color=colour, alpha=0.22, linewidth=0, gid=gid)
        axes.plot(
            x,
            y,
            color=colour,
            linewidth=1.4,
            linestyle=(0, DASHES[cycle % len(DASHES)]) if joined else "none",
            marker=markers[curve.engine] if several or not (many or curve.bins) else "none",
            markevery=len(x) // (3 if len(panel.curves) > _THRONG else 12) if many else None,
            markersize=4.2 if curve.engine == panel.engines[0] else 6.5,
            markerfacecolor=colour if curve.engine == panel.engines[0] else "none",
            markeredgewidth=1.1,
            gid=gid,
        )
        if curve.error is not None:
            bars = axes.errorbar(x, y, curve.error, fmt="none", ecolor=colour, elinewidth=0.9)
            for bar in bars.lines[2]:
                bar.set_gid(gid)
        edge = [_edge(axes, px, py) for (px, py), good in zip(curve.points, inside, strict=True) if not good]
        if edge:
            across, up = zip(*edge, strict=True)
            axes.plot(
                across, up, "x", color=colour, markersize=6.5, markeredgewidth=1.6, gid=gid, clip_on=False,
                transform=axes.transAxes,
            )  # fmt: skip
            failed += len(edge)
    return failed


def _edge(axes: Axes, x: float, y: float) -> tuple[float, float]:
    """Where a point that cannot be drawn is marked, in fractions of the axes: not finite counts as too large."""
    return _fraction(axes.get_xlim(), axes.get_xscale(), x), _fraction(axes.get_ylim(), axes.get_yscale(), y)


def _fraction(limits: tuple[float, float], scale: str, value: float) -> float:
    low, high = limits
    if math.isnan(value) or value >= high:
        return 1.0
    if value <= low:
        return 0.0
    if scale == "log":
        return math.log(value / low) / math.log(high / low)
    return (value - low) / (high - low)


# -- from matplotlib's SVG to the page's ---------------------------------------------------------------------


def _inline(svg: str, title: str, height: int, prefix: str) -> str:
    """Strips what an inline picture does not need, rounds coordinates, and swaps in the colours of the page."""
    from markupsafe import escape

    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg, flags=re.DOTALL)
    svg = re.sub(
        r"<svg[^>]*>",
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'aria-label="{escape(title)}">',
        svg,
        count=1,
    )
    svg = svg.replace("xlink:href", "href")
    used = set(re.findall(r"url\(#([^)]+)\)|href=\"#([^\"]+)\"", svg))
    needed = {name for pair in used for name in pair if name}

    short = {name: f"{prefix}-{number}" for number, name in enumerate(sorted(needed))}

    def identity(match: re.Match[str]) -> str:
        name = match[1]
        if name in needed:
            return f' id="{short[name]}"'
        if re.fullmatch(r"k\d+-e\d+|t\d+", name):
            return f' class="s {name.replace("-", " ")}"'
        return ""

    svg = re.sub(r' id="([^"]*)"', identity, svg)
    svg = re.sub(r'(url\(#|href="#)([^)"]+)', lambda m: m[1] + short[m[2]], svg)
    svg = re.sub(r' (?:d|x|y|transform|width|height)="[^"]*"', lambda m: _rounded(m[0]), svg)
    svg = re.sub(r"font: ([\d.]+px) 'DejaVu Sans'[^;\"]*", r"font-size: \1", svg)
    svg = svg.replace(_INK, "currentColor").replace(_GRID, "var(--grid)")
    for number, (light, _) in enumerate(PALETTE):
        svg = svg.replace(light, f"var(--c{number})")
    svg = re.sub(r"<defs>\s*<style[^>]*>.*?</style>\s*</defs>", "", svg, flags=re.DOTALL)
    return _compact(re.sub(r"\s*\n\s*", "\n", svg).strip())


def _compact(svg: str) -> str:
    """The same drawing in fewer bytes: a page has thousands of markers and points.

    The style of the markers of a curve is said once, circles are circles in place of eight curves, and paths have no
    spaces that do not separate numbers.
    """
    svg = svg.replace("stroke-dasharray: ; stroke-dashoffset: 0; ", "").replace("font-family: 'DejaVu Sans'; ", "")
    svg = re.sub(r' transform="rotate\(-?0 [^)]*\)"', "", svg)
    svg = re.sub(r'<path( id="[^"]*")? d="M 0 ([\d.]+)\n(?:C [^z]*?){8}z\n?"', _circle, svg)
    svg = re.sub(r"(<g[^>]*)>\n((?:<use [^>]*/>\n)+)</g>", _one_style, svg)
    svg = _with_dots(svg)
    svg = re.sub(r' d="[^"]*"', lambda m: re.sub(r"\s*([MLCQHVzZ])\s*|\n", r"\1", m[0][4:-1]).join((' d="', '"')), svg)
    svg = re.sub(r'style="[^"]*"', lambda m: m[0].replace(": ", ":").replace("; ", ";"), svg)
    for style, name in _CLASSES.items():
        svg = svg.replace(f'style="{style}"', f'class="{name}"')
    # grid lines end where the axes do
    svg = re.sub(r' clip-path="[^"]*" class="gl"', ' class="gl"', svg)
    return _without_bare_groups(re.sub(r">\n<", "><", svg))


#: Styles that every figure has many times, and the classes of the style sheet that say the same.
_CLASSES = {
    "fill:none;stroke:var(--grid);stroke-width:0.5;stroke-linecap:square": "gl",
    "fill:currentColor;stroke:currentColor;stroke-width:0.8": "tk",
    "font-size:11px;text-anchor:middle;fill:currentColor": "tm",
    "font-size:11px;text-anchor:end;fill:currentColor": "te",
}


def _without_bare_groups(svg: str) -> str:
    """The drawing without groups that have no attribute, which mean nothing."""
    kept: list[str] = []
    bare: list[bool] = []
    for number, part in enumerate(re.split(r"(<g(?: [^>]*[^/>])?>|</g>)", svg)):
        if number % 2 == 0:  # between the tags
            kept.append(part)
        elif part == "</g>":
            kept.extend([] if bare.pop() else [part])
        else:
            bare.append(part == "<g>")
            kept.extend([] if bare[-1] else [part])
    return "".join(kept)


def _circle(match: re.Match[str]) -> str:
    """A circle about the origin in place of its path."""
    return f'<circle{match[1] or ""} r="{match[2]}"'


def _one_style(match: re.Match[str]) -> str:
    """A group of markers whose common style is that of the group."""
    styles = set(re.findall(r' style="([^"]*)"', match[2]))
    if len(styles) != 1 or " style=" in match[1]:
        return match[0]
    (style,) = styles
    markers = match[2].replace(f' style="{style}"', "")
    return f'{match[1]} style="{style}">\n{markers}</g>'


def _with_dots(svg: str) -> str:
    """The drawing with filled circles as paths of points with round ends, as wide as they are."""
    radii = dict(re.findall(r'<circle id="([^"]+)" r="([\d.]+)"', svg))

    def dots(match: re.Match[str]) -> str:
        kinds = set(re.findall(r'href="#([^"]+)"', match[2]))
        colours = re.findall(r"(?:fill|stroke): (var\(--c\d\));", match[1])
        edge = re.search(r"stroke-width: ([\d.]+)", match[1])
        filled = "fill-opacity" not in match[1] and len(colours) == 2 and colours[0] == colours[1]
        if not filled or edge is None or len(kinds) != 1 or not kinds <= radii.keys():
            return match[0]
        path = "".join(f"M{x} {y}h0" for x, y in re.findall(r'x="([^"]*)" y="([^"]*)"', match[2]))
        clip = re.search(r' clip-path="[^"]*"', match[1])
        width = 2 * float(radii[kinds.pop()]) + float(edge[1])
        style = f"fill: none; stroke: {colours[0]}; stroke-linecap: round; stroke-width: {width:.1f}"
        return f'<path d="{path}"{clip[0] if clip else ""} style="{style}"/>'

    svg = re.sub(r"(<g[^>]*)>\n((?:<use [^>]*/>\n)+)</g>", dots, svg)
    for name in radii:
        if f'"#{name}"' not in svg:
            svg = re.sub(rf'<defs>\n<circle id="{name}"[^>]*/>\n</defs>\n', "", svg)
    return svg


def _rounded(text: str) -> str:
    """Its numbers to a tenth of a unit: a seventh of a pixel on the page."""
    return re.sub(r"-?\d+\.\d+", lambda m: f"{round(float(m[0]), 1) + 0.0:.1f}".removesuffix(".0"), text)


# -- legend --------------------------------------------------------------------------------------------------


def _legend(panel: Panel, numbers: dict[str, int], markers: dict[str, str]) -> tuple[list[Key], list[Key]]:
    """Entries for the curves and, where there are several, for the engines."""
    several = len(panel.engines) > 1
    curves: list[Key] = []
    first = {curve.name: curve for curve in reversed(panel.curves) if not curve.theory}
    for name in sorted(first, key=numbers.__getitem__):
        number = numbers[name]
        cycle = number // len(PALETTE) % len(DASHES)
        colour = f"var(--c{number % len(PALETTE)})"
        line = _stroke(colour, 1.8, DASHES[cycle], _STEPS if first[name].bins else _LINE)
        if not several and not first[name].bins and len(first[name].x) <= _MARKED:
            line += _marker(markers[first[name].engine], colour, colour)
        curves.append(Key(name, f"k{number}", _sample(line)))
    theories = [curve for curve in panel.curves if curve.theory]
    for place, curve in enumerate(theories):
        dashes = THEORY_DASHES[place % len(THEORY_DASHES)]
        line = _stroke("currentColor", 1.1, dashes, _STEPS if curve.bins else _LINE)
        curves.append(Key(curve.name, f"t{place}", _sample(line)))
    engines = [
        Key(
            engine,
            f"e{place}",
            _sample(_marker(marker, "currentColor", "currentColor" if engine == panel.engines[0] else "none"), 12),
        )
        for place, (engine, marker) in enumerate(markers.items())
        if engine in panel.engines
    ]
    return curves, engines if several else []


def _sample(content: str, width: int = 30) -> str:
    return f'<svg viewBox="{-width // 2} -6 {width} 12" width="{width}" height="12" aria-hidden="true">{content}</svg>'


def _stroke(colour: str, width: float, dashes: tuple[float, ...], path: str) -> str:
    pattern = f' stroke-dasharray="{" ".join(f"{d * width:.1f}" for d in dashes)}"' if dashes else ""
    return f'<path d="{path}" style="stroke:{colour}" stroke-width="{width}"{pattern}/>'


def _marker(marker: str, edge: str, face: str) -> str:
    return f'<g style="fill:{face};stroke:{edge}" stroke-width="1.2">{MARKERS[marker]}</g>'
