"""One self-contained HTML file from a record: failures first, then each check with figures, numbers and sources."""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.engines.registry import engine_names, engine_order
from crosscheck.errors import UsageError
from crosscheck.files import naming
from crosscheck.record import Line, case_name, deciding, is_left_out, read, worst_judgement
from crosscheck.report import figures, ladder_figure, ladders, pictures
from crosscheck.report.catches import scores, together
from crosscheck.report.extreme import matrix
from crosscheck.report.pages import templates
from crosscheck.runner import select
from crosscheck.status import false_alarms
from crosscheck.text import printable
from crosscheck.verdict import LEFT_OUT, SENSITIVITY

FILE = "report.html"
#: Worst first: the order of everything in the report.
OUTCOMES = ("error", "fail", "inconclusive", "skip", "pass")
#: Checks whose names begin so share a chapter of their own, and the colours of their curves.
WORK_PRECISION = "performance/work-precision"
#: What the names of verdicts on scenes of a user's own begin with.
OF_SCENES = "simulate/"
#: How an older version ended the name of a check that is now the full tier of another.
_OLD_FULL = "-full"


@dataclass(frozen=True)
class Criterion:
    """A criterion of a section.

    number: in the section, from 1. kind: of `crosscheck.verdict`. why: its reason, for the reader. cases: the verdicts
    that are judged by it.
    """

    number: int
    kind: str
    why: str
    cases: list[str] = field(default_factory=list)


@dataclass
class Section:
    """A check with its verdicts.

    name: of the check. check: None if this version has none of that name. After an older version, whose name of a check
    ended in "-full", it is the check without that ending. anchor: the section's id in the page. lines: its verdicts.
    drawings: its figures. climbs: its cases of error against run time.
    """

    name: str
    check: Check | None
    anchor: str
    lines: list[Line] = field(default_factory=list)
    drawings: list[figures.Drawing] = field(default_factory=list)
    climbs: list[ladders.Case] = field(default_factory=list)

    @property
    def outcomes(self) -> list[tuple[str, int]]:
        """Outcomes and how often they occur, the worst first."""
        return _tally(self.lines)

    @property
    def worst(self) -> str:
        """The worst outcome."""
        return min((line["outcome"] for line in self.lines), key=OUTCOMES.index)

    @cached_property
    def quantities(self) -> list[str]:
        """The quantities that are judged, each once."""
        return list(dict.fromkeys(one["quantity"] for line in self.lines for one in line["judgements"]))

    @cached_property
    def _criteria(self) -> dict[tuple[str, str], Criterion]:
        """By kind and reason; numbered in the order in which the section shows them."""
        found: dict[tuple[str, str], Criterion] = {}
        for line in self.lines:
            case = f"{self.variant(line)} [{line['engine']}]"
            for one in line["judgements"]:
                key = one["criterion"]["kind"], one["criterion"]["why"]
                criterion = found.setdefault(key, Criterion(len(found) + 1, *key))
                if case not in criterion.cases[-1:]:
                    criterion.cases.append(case)
        return found

    @property
    def criteria(self) -> list[Criterion]:
        """The criteria, in the order of their numbers."""
        return list(self._criteria.values())

    def criterion(self, judgement: dict[str, Any]) -> Criterion:
        """The criterion of a judgement of this section; KeyError if it has none such.

        judgement: as the record keeps it.
        """
        return self._criteria[judgement["criterion"]["kind"], judgement["criterion"]["why"]]

    def criteria_of(self, judgements: list[dict[str, Any]]) -> list[Criterion]:
        """The criteria of some judgements of this section, each once.

        judgements: as the record keeps them.
        """
        return list({criterion.number: criterion for criterion in map(self.criterion, judgements)}.values())

    def variant(self, line: Line) -> str:
        """The variant of a line, or the check's name where there is none.

        line: of the record.
        """
        return str(line["variant"] or line["check"])

    @property
    def short(self) -> str:
        """What the ids of the criteria begin with: they are linked to from every judgement."""
        return "k" + self.anchor.partition("-")[0][1:]

    @property
    def of_a_scene(self) -> bool:
        """Whether it judges a scene of a user's own, see docs/simulate.md."""
        return self.name.startswith(OF_SCENES)

    @property
    def repeat(self) -> str:
        """The command line that runs this check again; "" if this version does not have it."""
        if self.check is None:
            return ""
        engines = sorted({line["engine"] for line in self.lines}, key=engine_order)
        return _run([self.check.name], _tier(self.lines), engines, self.lines[0]["provenance"].get("seed", 0))


def write_report(directory: Path) -> Path:
    """Writes `directory/report.html` and returns its path.

    directory: of a run, with its record. UsageError if there is none.
    """
    lines = read(directory)
    path = directory / FILE
    page = render(lines, directory.resolve().name)
    # names of files may hold bytes that are not UTF-8, and the output of engines anything
    with naming(path):
        path.write_text(printable(page, keep="\n\t"), encoding="utf-8")
    return path


def render(lines: list[Line], title: str) -> str:
    """The report as HTML; the same lines give the same text.

    lines: of the record. title: of the page.
    """
    sections = _sections(lines)
    precision = [section for section in sections if _is_work_precision(section.name)]
    others = [section for section in sections if not _is_work_precision(section.name)]
    for number, group in enumerate([precision, *([section] for section in others)]):
        _draw(group, f"f{number}")
    for section in sections:
        section.climbs = ladders.cases(section.name, section.anchor, section.lines)
    climbs = [case for section in sections for case in section.climbs]
    style = ladder_figure.style_of(climbs)
    environment = templates()
    environment.filters.update(
        kind=_kind,
        deciding=deciding,
        remark=_remark,
        worst_judgement=worst_judgement,
        equation=_equation,
        links=_links,
        large=lambda case, by_count=False: Markup(ladder_figure.draw(case, style, by_count=by_count)),
        keys=lambda case: ladder_figure.legend(case, style),
        power=ladders.power,
    )
    by_outcome = defaultdict(list)
    for section in sections:
        for line in section.lines:
            by_outcome[line["outcome"]].append((section, line))
    page = environment.get_template("template.html.j2").render(
        name=title,
        lines=lines,
        by_outcome=by_outcome,
        tally=_tally(lines),
        engines=_table(lines, lambda line: line["engine"], engine_order),
        groups=_table(lines, lambda line: line["check"].partition("/")[0], str),
        skips=_skips(by_outcome["skip"]),
        precision=precision,
        climbs=ladders.overview(climbs),
        targets=ladders.TARGETS,
        markers=Markup(ladder_figure.marker_definitions(style)),
        matrix=matrix(lines),
        scores=scores(),
        together=together({one.check.name: one.check for one in sections if one.check is not None}.values()),
        sections=others,
        contents=_by_group(others),
        origins=_origins(lines),
        command=_command(lines, sections),
        absent=_absent(lines),
        unknown=sum(len(one.lines) for one in sections if one.check is None and not one.of_a_scene),
        meaning_of_sensitivity=SENSITIVITY,
        false_alarms=false_alarms(lines),
        dates=sorted(line["time"] for line in lines)[:: max(1, len(lines) - 1)],
        cost=sum(line["cost"].get("seconds") or 0.0 for line in lines),
    )
    return _without_optional_tags(page)


def _without_optional_tags(page: str) -> str:
    """The page without ends of cells and rows that HTML lets out: of the tables of a full run, a tenth."""
    page = re.sub(r"</t[dh]>\s*(?=<t[dh][ >]|</tr>)", "", page)
    return re.sub(r"</tr>\s*(?=<tr[ >]|</tbody>|</thead>)", "", page)


# -- verdicts, sorted ----------------------------------------------------------------------------------------


def _is_work_precision(name: str) -> bool:
    return name.startswith(WORK_PRECISION)


def _sections(lines: list[Line]) -> list[Section]:
    """One per check in the record, in the order of names; in each the worst verdicts first."""
    checks = {check.name: check for check in all_checks()}
    found: dict[str, Section] = {}
    for line in sorted(lines, key=_rank):
        check = line["check"]
        if check not in found:
            found[check] = Section(check, checks.get(check) or checks.get(check.removesuffix(_OLD_FULL)), "")
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
        reason, case = line["message"] or "no reason given", f"{case_name(line)} [{line['engine']}]"
        if is_left_out(line):
            reason, case = LEFT_OUT, f"{case}: {reason.removeprefix(LEFT_OUT).removeprefix(': ')}"
        reasons[reason].append(case)
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
    absent = {"versions": {}, "cpu": "unknown CPU", "cores": "unknown", "system": "unknown system"}
    texts = Counter(json.dumps(absent | line["provenance"], sort_keys=True) for line in lines)
    return [(json.loads(text), number) for text, number in texts.most_common()]


def _command(lines: list[Line], sections: list[Section]) -> str:
    """The command line that runs the same checks again, with names of groups where all of a group has run.

    "" if this version has none of them. Of a run within a budget, which mixes tiers as no other does, its own command.
    """
    if {"small"} < {line["tier"] for line in lines}:
        return str(lines[-1]["provenance"].get("command", ""))
    known = [section for section in sections if section.check is not None]
    if lines and not known:
        of_scenes = [line for line in lines if line["check"].startswith(OF_SCENES)]
        return str(of_scenes[-1]["provenance"].get("command", "")) if len(of_scenes) == len(lines) else ""
    ran = {section.check.name for section in known if section.check is not None}
    engines = sorted({line["engine"] for line in lines}, key=engine_order)
    tier = _tier(line for section in known for line in section.lines)
    offered = _offered(tier, engines)
    patterns: list[str] = []
    if not offered or not offered <= ran:
        for group in sorted({name.partition("/")[0] for name in ran}):
            some = {name for name in ran if name.startswith(group + "/")}
            whole = bool(offered) and {name for name in offered if name.startswith(group + "/")} <= some
            patterns += [f"{group}/*"] if whole else sorted(some)
    seeds = Counter(line["provenance"].get("seed", 0) for line in lines)
    return _run(patterns, tier, engines, seeds.most_common(1)[0][0] if seeds else 0)


def _offered(tier: str, engines: list[str]) -> set[str]:
    """Names of the checks of the installed ones of these engines. Code that a record names is not loaded for that."""
    installed = [engine for engine in engines if engine in engine_names()]
    try:
        return {case.check for case in select([], tier, installed)}
    except UsageError:  # none is installed, or nothing fits
        return set()


def _absent(lines: list[Line]) -> list[str]:
    """Engines by name, not by file, that are not installed where the report is made.

    Runs of a scene of a user's own go by labels of their own, as "refimpl-leapfrog".
    """
    of_checks = (line["engine"] for line in lines if not line["check"].startswith(OF_SCENES))
    named = {engine for engine in of_checks if ".py:" not in engine}
    return sorted(named - set(engine_names()))


def _tier(lines: Iterable[Line]) -> str:
    """The tier that contains all these cases; of those of the small tier, if there are others, not."""
    tiers = {line["tier"] for line in lines}
    return "full" if "full" in tiers else "small" if tiers == {"small"} else "quick"


def _run(patterns: list[str], tier: str, engines: list[str], seed: int) -> str:
    words = ["crosscheck", "run", *patterns]
    words += ["--tier", tier] if tier != "quick" else []
    for engine in engines:
        words += ["--engine", engine]
    return shlex.join([*words, "--seed", str(seed)])


# -- text ----------------------------------------------------------------------------------------------------


def _kind(kind: str) -> str:
    """The kind of a criterion, in words."""
    return kind.replace("_", " ")


def _remark(line: Line) -> str:
    """What is said of a whole verdict; with one judgement also what is said of that."""
    alone = [one["note"] for one in line["judgements"]] if len(line["judgements"]) == 1 else []
    return "; ".join(dict.fromkeys(filter(None, [*alone, line["note"]]))) or str(line["message"].partition("\n")[0])


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
