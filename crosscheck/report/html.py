"""One self-contained HTML file from a record: what failed first, then per check a figure, numbers and their sources."""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from crosscheck import painter
from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.engines.registry import engine_order
from crosscheck.errors import UsageError
from crosscheck.record import Line, case_name, read
from crosscheck.report import figures, numbers, pictures
from crosscheck.runner import select

FILE = "report.html"
#: Worst first: the order of everything in the report.
OUTCOMES = ("error", "fail", "inconclusive", "skip", "pass")
WORK_PRECISION = "performance/work-precision"


@dataclass
class Section:
    """A check with its verdicts. check: None if this version has none of that name."""

    name: str
    check: Check | None
    anchor: str
    lines: list[Line] = field(default_factory=list)
    drawings: list[figures.Drawing] = field(default_factory=list)

    @property
    def outcomes(self) -> list[tuple[str, int]]:
        return _tally(self.lines)

    @property
    def worst(self) -> str:
        return min((line["outcome"] for line in self.lines), key=OUTCOMES.index)

    @property
    def quantities(self) -> list[str]:
        return list(dict.fromkeys(one["quantity"] for line in self.lines for one in line["judgements"]))

    @property
    def tolerances(self) -> list[tuple[str, str, list[str]]]:
        """(kind, why, variants) of the criteria, equal ones together."""
        found: dict[tuple[str, str], list[str]] = defaultdict(list)
        for line in self.lines:
            for one in line["judgements"]:
                key = one["criterion"]["kind"].replace("_", " "), one["criterion"]["why"]
                found[key].append(f"{self.variant(line)} [{line['engine']}]")
        return [(kind, why, names) for (kind, why), names in found.items()]

    def variant(self, line: Line) -> str:
        """The variant, or the check's name where there is none."""
        return str(line["variant"] or line["check"])


def write_report(directory: Path) -> Path:
    """Writes `directory/report.html` from the record in it, and returns its path. UsageError if there is no record."""
    lines = read(directory)
    path = directory / FILE
    path.write_text(render(lines, directory.resolve().name), encoding="utf-8")
    return path


def render(lines: list[Line], title: str) -> str:
    """The report as text; the same lines give the same text."""
    import jinja2

    sections = _sections(lines)
    precision = [section for section in sections if _is_work_precision(section.name)]
    others = [section for section in sections if not _is_work_precision(section.name)]
    for number, group in enumerate([precision, *([section] for section in others)]):
        _draw(group, f"f{number}")
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(
        measured=numbers.measured,
        expected=numbers.expected,
        deviation=numbers.deviation,
        sensitivity=numbers.sensitivity,
        seconds=numbers.seconds,
        number=numbers.count,
        equation=_equation,
        links=_links,
        svg=Markup,
    )
    by_outcome = defaultdict(list)
    for section in sections:
        for line in section.lines:
            by_outcome[line["outcome"]].append((section, line))
    return environment.get_template("template.html.j2").render(
        name=title,
        palette=figures.PALETTE,
        colour_map=painter.colours(),
        lines=lines,
        by_outcome=by_outcome,
        tally=_tally(lines),
        engines=_table(lines, lambda line: line["engine"], engine_order),
        groups=_table(lines, lambda line: line["check"].partition("/")[0], str),
        skips=_skips(by_outcome["skip"]),
        precision=precision,
        sections=others,
        contents=_by_group(others),
        origins=_origins(lines),
        command=_command(lines, sections),
        repeat=_repeat,
        dates=sorted(line["time"] for line in lines)[:: max(1, len(lines) - 1)],
        cost=sum(line["cost"].get("seconds") or 0.0 for line in lines),
    )


# -- verdicts, sorted ----------------------------------------------------------------------------------------


def _is_work_precision(name: str) -> bool:
    return name == WORK_PRECISION or name.startswith(WORK_PRECISION + "/")


def _sections(lines: list[Line]) -> list[Section]:
    """One per check in the record, in the order of names; in each the worst verdicts first."""
    checks = {check.name: check for check in all_checks()}
    found: dict[str, Section] = {}
    for line in sorted(lines, key=_rank):
        check = line["check"]
        if check not in found:
            found[check] = Section(check, checks.get(check), "")
        found[check].lines.append(line)
    sections = sorted(found.values(), key=lambda section: section.name)
    for number, section in enumerate(sections, 1):
        section.anchor = f"c{number}-" + re.sub(r"[^a-z0-9]+", "-", section.name.lower()).strip("-")
    return sections


def _rank(line: Line) -> tuple[Any, ...]:
    return OUTCOMES.index(line["outcome"]), case_name(line), engine_order(line["engine"])


def _tally(lines: Iterable[Line]) -> list[tuple[str, int]]:
    """(outcome, number), worst first, those that occur."""
    counts = Counter(line["outcome"] for line in lines)
    return [(outcome, counts[outcome]) for outcome in OUTCOMES if counts[outcome]]


def _table(lines: list[Line], label: Any, order: Any) -> list[tuple[str, dict[str, int], float]]:
    """(label, number of each outcome, seconds) of the lines of each label."""
    rows: dict[str, list[Line]] = defaultdict(list)
    for line in lines:
        rows[label(line)].append(line)
    return [
        (
            key,
            Counter(line["outcome"] for line in rows[key]),
            sum(line["cost"].get("seconds") or 0.0 for line in rows[key]),
        )
        for key in sorted(rows, key=order)
    ]


def _skips(skipped: list[tuple[Section, Line]]) -> list[tuple[str, list[str]]]:
    """(reason, cases)."""
    reasons: dict[str, list[str]] = defaultdict(list)
    for _, line in skipped:
        reasons[line["message"] or "no reason given"].append(f"{case_name(line)} [{line['engine']}]")
    return list(reasons.items())


def _by_group(sections: list[Section]) -> list[tuple[str, list[Section]]]:
    groups: dict[str, list[Section]] = defaultdict(list)
    for section in sections:
        groups[section.name.partition("/")[0]].append(section)
    return list(groups.items())


# -- figures -------------------------------------------------------------------------------------------------


def _draw(group: list[Section], prefix: str) -> None:
    """Draws the figures of some checks, in which the same curve gets the same colour; pictures come after curves."""
    panels = [(section, panel) for section in group for panel in figures.panels(section.lines, section.variant)]
    styles = figures.curve_numbers(panel for _, panel in panels)
    for number, (section, panel) in enumerate(panels):
        section.drawings.append(figures.draw(panel, styles, f"{prefix}-{number}"))
    images = [(section, one) for section in group for one in pictures.pictures(section.lines, section.variant)]
    for number, (section, picture) in enumerate(images, len(panels)):
        section.drawings.append(pictures.draw(picture, f"{prefix}-{number}"))


# -- where it comes from -------------------------------------------------------------------------------------


def _origins(lines: list[Line]) -> list[tuple[dict[str, Any], int]]:
    """(provenance, number of verdicts), the most frequent first: a resumed run can have several."""
    texts = Counter(json.dumps(line["provenance"], sort_keys=True) for line in lines)
    return [(json.loads(text), number) for text, number in texts.most_common()]


def _command(lines: list[Line], sections: list[Section]) -> str:
    """The command line that runs the same checks again, with names of groups where all of a group has run."""
    ran = {section.name for section in sections if section.check is not None}
    engines = sorted({line["engine"] for line in lines}, key=engine_order)
    full = any(_tier(section) == "full" for section in sections)
    try:
        offered = {case.check for case in select([], "full" if full else "quick", engines)}
    except UsageError:  # an engine that is not here any more
        offered = set()
    patterns: list[str] = []
    if not offered or not offered <= ran:
        for group in sorted({name.partition("/")[0] for name in ran}):
            some = {name for name in ran if name.startswith(group + "/")}
            whole = bool(offered) and {name for name in offered if name.startswith(group + "/")} <= some
            patterns += [f"{group}/*"] if whole else sorted(some)
    seeds = Counter(line["provenance"].get("seed", 0) for line in lines)
    return _run(patterns, "full" if full else "quick", engines, seeds.most_common(1)[0][0] if seeds else 0)


def _tier(section: Section) -> str:
    """The tier that contains all its cases."""
    return "full" if any(line["tier"] == "full" for line in section.lines) else "quick"


def _repeat(section: Section) -> str:
    """The command line for one check."""
    engines = sorted({line["engine"] for line in section.lines}, key=engine_order)
    return _run([section.name], _tier(section), engines, section.lines[0]["provenance"].get("seed", 0))


def _run(patterns: list[str], tier: str, engines: list[str], seed: int) -> str:
    words = ["crosscheck", "run", *patterns]
    words += ["--tier", tier] if tier != "quick" else []
    for engine in engines:
        words += ["--engine", engine]
    return shlex.join([*words, "--seed", str(seed)])


# -- text ----------------------------------------------------------------------------------------------------


def _equation(text: str) -> Markup:
    """The text as it is; of HTML only the tags for indices, powers and italics work."""
    return Markup(re.sub(r"&lt;(/?(?:sub|sup|i|b))&gt;", r"<\1>", str(escape(text))))


_ADDRESS = re.compile(r"(?P<url>https?://[^\s<>\"')]*[\w/])|(?:doi:\s*)?(?P<doi>10\.\d{4,9}/[^\s<>\"';,]*[\w)])")


def _links(text: str) -> Markup:
    """Text with its web addresses and DOIs as links."""
    out, last = Markup(""), 0
    for match in _ADDRESS.finditer(text):
        address = match["url"] or f"https://doi.org/{match['doi']}"
        out += escape(text[last : match.start()])
        out += Markup('<a href="{}" rel="noreferrer">{}</a>').format(address, match[0])
        last = match.end()
    return out + escape(text[last:])
