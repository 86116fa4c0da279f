"""The HTML report of a synthetic record: complete, self-contained, escaped, reproducible, and with enough contrast."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import pytest
import synthetic

from crosscheck.checks import all_checks
from crosscheck.checks.stepping.oscillator import CHECKS
from crosscheck.errors import UsageError
from crosscheck.record import FILE, Record, read
from crosscheck.report import figures, html, pictures
from crosscheck.runner import select
from crosscheck.verdict import SENSITIVITY


@pytest.fixture(scope="module", autouse=True)
def _checks():
    """The record is joined with the checks of one module, whatever others there are."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(html, "all_checks", lambda: CHECKS)
        yield


@pytest.fixture(scope="module")
def lines(tmp_path_factory):
    return read(synthetic.write(tmp_path_factory.mktemp("run")))


@pytest.fixture(scope="module")
def text(lines):
    return html.render(lines, "a run")


class Collector(HTMLParser):
    """Tags with their attributes, and the visible text, of a page whose tags match; cells and rows need no end."""

    VOID = frozenset({"meta", "input", "br", "link", "img"})

    def __init__(self, text):
        super().__init__()
        self.tags, self.words, self.open = [], [], []
        self.feed(text)
        self.close()

    #: What ends a cell or a row whose own end is left out: the next cell, row, or end of the group.
    ENDED_BY = {"td": {"td", "th", "tr", "tbody", "thead"}, "tr": {"tr", "tbody", "thead"}}
    ENDED_BY["th"] = ENDED_BY["td"]

    def end_open_cells(self, tag):
        while self.open and tag in self.ENDED_BY.get(self.open[-1], ()):
            self.open.pop()

    def handle_starttag(self, tag, attributes):
        self.end_open_cells(tag)
        self.tags.append((tag, dict(attributes)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        if tag != self.open[-1]:
            self.end_open_cells(tag)
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_is_written_beside_the_record(tmp_path):
    path = html.write_report(synthetic.write(tmp_path))
    assert path == tmp_path / "report.html"
    assert path.stat().st_size < 3e6


def test_no_record_is_a_usage_error(tmp_path):
    with pytest.raises(UsageError, match=r"no record\.jsonl"):
        html.write_report(tmp_path)


def test_an_empty_record_gives_a_report():
    assert "The record is empty" in html.render([], "nothing")


def test_tags_match_and_ids_are_unique(text):
    page = Collector(text)
    assert page.open == []
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    anchors = {a["href"][1:] for _, a in page.tags if a.get("href", "").startswith("#")}
    assert anchors <= set(ids)


def test_loads_nothing(text):
    page = Collector(text)
    for tag, attributes in page.tags:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base")
        assert "src" not in attributes
        assert tag == "a" or not re.match("https?:", attributes.get("href") or "")
    assert not re.search(r"@import|url\((?!#)", text)


def test_escapes_what_the_record_says(text):
    assert "<script>alert" not in text
    assert "CPU <b>of" not in text
    assert text.count("<script>") == 1
    assert synthetic.HOSTILE.partition("\x1b")[0] in "".join(Collector(text).words)


def test_shows_every_verdict(text, lines):
    page = Collector(text)
    rows = [a["data-engine"] for tag, a in page.tags if tag == "tbody" and "data-engine" in a]
    assert len(rows) == len(lines)
    words = "\n".join(page.words)
    for line in lines:
        assert line["check"].partition("/")[2] in words
        assert line["variant"] in words


def test_errors_then_failures_then_the_inconclusive_come_before_passes(text):
    first = [text.index(f'<article class="card {outcome}">') for outcome in ("error", "fail", "inconclusive")]
    assert first == sorted(first)
    assert first[-1] < text.index('id="work-precision"') < text.index('data-outcome="pass"')


def test_last_lines_of_an_error_are_shown(text):
    assert "killed by signal 11" in text
    assert "Traceback (most recent call last)" in text


def test_skips_are_collapsed_with_their_reason(text):
    assert "<details><summary>3: Mine: no lattice gases</summary>" in text


def test_states_where_it_comes_from(text):
    for fact in ("Linux x86_64", "numpy 2.4.6", "--seed 7", "crosscheck run"):
        assert fact in text


def test_the_same_record_gives_the_same_bytes(text, lines):
    assert html.render(lines, "a run") == text


def test_many_verdicts_and_figures_stay_small(tmp_path, monkeypatch):
    """Six times the record, more than 300 verdicts and 40 figures; equal figures are drawn once."""
    drawn = {}
    draw = figures.draw

    def draw_once(panel, *more):
        if panel.title not in drawn:
            drawn[panel.title] = draw(panel, *more)
        return drawn[panel.title]

    monkeypatch.setattr(figures, "draw", draw_once)
    record = Record(tmp_path, synthetic.PROVENANCE)
    for copy in range(6):
        for verdict in synthetic.verdicts():
            group, _, rest = verdict.check.partition("/")
            record.append(replace(verdict, check=f"{group}/{copy}-{rest}"))
    text = html.render(read(tmp_path), "large")
    assert text.count("<figure>") >= 40
    assert text.count("<tbody data-outcome") >= 300
    assert len(text.encode()) < 3e6


def test_a_check_of_this_version_comes_with_its_texts(text):
    check = next(check for check in CHECKS if check.name == "stepping/oscillator-damped")
    page = "".join(Collector(text).words)
    for part in (check.title, check.criterion, re.sub("</?su[bp]>", "", check.equation)):
        assert part in page


def test_an_unknown_check_is_shown_as_it_was_recorded(text):
    assert "events/gone" in text
    assert "This version has no check of this name" in text


# -- several judgements --------------------------------------------------------------------------------


def rows(text, variant):
    """The row of a verdict in the table of its check, and the one below it."""
    parts = re.split("<tbody data-outcome", text)
    (part,) = (one for one in parts if f'<tr><th scope="row">{variant}<' in one)
    return part.partition("</tbody>\n</table></div>")[0]


def words(markup):
    return " ".join(" ".join(Collector(markup).words).split())


def judgements(text, variant):
    """The cells of all judgements that the verdict opens to."""
    table = re.search(r'<table class="all">.*?</table>', rows(text, variant), re.DOTALL)[0]
    body = table[table.index("<tbody>") :]
    return [
        [words(f"<b>{cell.partition('>')[2]}</b>") for cell in re.split("<t[hd]", row)[1:]]
        for row in body.partition("</tbody>")[0].split("<tr>")[1:]
    ]


def test_a_verdict_opens_to_all_its_judgements_in_the_order_of_the_record(text):
    assert judgements(text, "faulty") == [
        ["particles that overlap at the start control", "pass", "0", "≤ 0.5", "0 tol.", "1", "bound [1]"],
        ["share of fast particles", "fail", "0.02", "≥ 0.04", "2 tol.", "0.5", "bound [1]"],
        ["pressure of 64 disks", "fail", "1.500(10)", "1", "50 σ", "0.05", "statistical [2]"],
        ["temperature", "pass", "0.7", "≤ 1.4", "0.5 tol.", "0.5", "bound [3]"],
        ["mean free path", "pass", "0.031", "≤ 0.062", "0.5 tol.", "0.5", "bound [3]"],
    ]


def test_opening_needs_no_script_and_is_marked_where_it_decides(text):
    folded = rows(text, "faulty")
    assert folded.count("<details>") == 1
    assert "<b>pressure</b>" in folded
    assert "<script" not in folded
    assert " open" not in folded


@pytest.mark.parametrize(
    ("variant", "seen"),
    [
        ("faulty", "faulty refimpl fail 1.500(10) 1 50 σ 0.05 0.31 s 12345 pressure , one of 5 judgements, 2 red."),
        ("right", "right refimpl pass 1.020(10) 1 2 σ 0.05 0.31 s 12345 pressure , one of 5 judgements."),
    ],
)
def test_a_closed_verdict_shows_the_judgement_that_decides(text, variant, seen):
    closed = rows(text, variant).partition("</summary>")[0] + "</summary></details></tbody>"
    assert words("<tbody data-outcome" + closed) == f"{seen} a box of 1234 disks"


def test_the_number_of_a_criterion_is_that_of_its_reason(text):
    section = re.search(r'<section class="check" id="(\S+)">\s*<h3>events/several</h3>.*?</section>', text, re.DOTALL)
    reasons = {
        number: words(reason)
        for number, reason in re.findall(
            rf'<li id="k{section[1][1:].partition("-")[0]}-(\d)">(.*?)</li>', section[0], re.DOTALL
        )
    }
    expected = {
        "1": "bound : made up: the start",
        "2": "statistical : blocking;",
        "3": "bound : made up: the heat bath",
    }
    for number, reason in expected.items():
        assert reasons[number].startswith(reason)
    assert len(reasons) == 3
    assert section[0].count("made up: the start") == 1
    assert section[0].count("blocking;") == 1


def test_a_card_lists_every_red_judgement_with_its_reason(text):
    card = re.search(r'<article class="card fail">\s*<h3>[^\n]*events/several.*?</article>', text, re.DOTALL)[0]
    seen = words(card)
    assert seen.index("pressure: measured 1.500(10) , expected 1 , deviation 50 σ") < seen.index(
        "share of fast particles"
    )
    assert "expected ≥ 0.04 , deviation 2 tol." in seen
    assert "2 of 5 judgements are red" in seen
    assert "mean free path" not in seen
    assert seen.count("made up: the start") == 1


def test_one_judgement_has_nothing_to_open(text):
    assert "<details>" not in rows(text, "disks")


def test_the_numbers_are_explained(text):
    page = " ".join("".join(Collector(text).words).split())
    for part in (SENSITIVITY, "≤ at most, ≥ at least", "set-up is as meant", "red above 1"):
        assert part in page


# -- records of other versions and machines ------------------------------------------------------------

OLD = {
    "schema": 1,
    "check": "stepping/oscillator-damped-full/euler",
    "engine": "refimpl",
    "outcome": "pass",
    "quantity": "largest error",
    "measured": 1.0,
    "uncertainty": None,
    "expected": 4.0,
    "expected_uncertainty": None,
    "deviation": 0.25,
    "deviation_unit": "tolerance",
    "sensitivity": 4.0,
    "criterion": {"kind": "bound", "tolerance": 4.0, "why": "made up"},
    "note": "a note",
    "figures": [],
    "message": "",
    "cost": {"seconds": 1.0},
    "time": "2026-01-01T00:00:00+00:00",
    "provenance": synthetic.PROVENANCE,
}


def rendered(tmp_path, *changes):
    (tmp_path / FILE).write_text("".join(json.dumps(OLD | one) + "\n" for one in changes))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(html, "scores", list)  # those that come with the suite have commands and diffs too
        return html.render(read(tmp_path), "old")


def repeats(text):
    """The commands of the page: of all, and of each check."""
    return [words(part) for part in re.findall(r"<(?:pre tabindex|dd><code).*?</(?:pre|dd)>", text, re.DOTALL)]


def test_an_old_record_is_shown_with_the_texts_and_the_command_of_the_check_that_took_its_place(tmp_path):
    text = rendered(tmp_path, {})
    (check,) = (check for check in CHECKS if check.name == "stepping/oscillator-damped")
    assert check.title in words(text)
    assert "largest error" in words(text)
    assert re.search(r"euler refimpl pass 1 ≤ 4 0.25 tol. 0.75 1 s – a note", words(text))
    command = "crosscheck run stepping/oscillator-damped --tier full --engine refimpl --seed 7"
    assert repeats(text) == [command] * 3


def test_checks_that_are_gone_have_no_command(tmp_path):
    text = rendered(tmp_path, {"check": "events/gone/x"})
    assert repeats(text) == []
    assert "1 verdict of checks that this version does not have" in words(text)
    both = rendered(tmp_path, {"check": "events/gone/x"}, {"check": "stepping/oscillator-damped/euler"})
    assert repeats(both) == ["crosscheck run stepping/oscillator-damped --engine refimpl --seed 7"] * 3


def test_engines_that_are_not_here_are_named_and_no_file_of_a_record_is_loaded(tmp_path):
    loaded = tmp_path / "loaded"
    (tmp_path / "my.py").write_text(f"open({str(loaded)!r}, 'w')")
    case = {"check": "stepping/oscillator-damped/euler"}
    text = rendered(tmp_path, case, case | {"engine": "gone"}, case | {"engine": f"{tmp_path}/my.py:Mine"})
    assert "needs gone, not installed" in words(text)
    assert f"--engine refimpl --engine {tmp_path}/my.py:Mine --engine gone --seed 7" in repeats(text)[1]
    assert not loaded.exists()


def test_a_run_within_a_budget_is_repeated_by_its_own_command(lines):
    """No tier holds small cases and others; small ones alone have one."""
    command = "crosscheck run --engine refimpl --budget 60"

    def of_tiers(*tiers):
        provenance = lines[0]["provenance"] | {"command": command}
        given = zip(lines, tiers, strict=False)
        return html.render([line | {"tier": tier, "provenance": provenance} for line, tier in given], "new")

    assert repeats(of_tiers("small", "quick"))[0] == command
    assert "--tier small" in repeats(of_tiers("small", "small"))[0]
    assert "--tier" not in repeats(of_tiers("quick", "quick"))[0]


def test_what_there_was_no_time_for_is_one_reason(lines):
    skipped = [
        line
        | {
            "outcome": "skip",
            "judgements": [],
            "worst": None,
            "message": f"left out by --budget: predicted {seconds} s",
        }
        for line, seconds in zip(lines, (3, 40), strict=False)
    ]
    text = words(html.render(skipped, "new"))
    assert "2: left out by --budget" in text
    assert "predicted 40 s" in text


def test_a_whole_group_is_repeated_by_its_name(tmp_path, monkeypatch):
    monkeypatch.setattr(html, "all_checks", all_checks)
    names = sorted({case.check for case in select([], "quick", ["rebound"])})
    stepping = [name for name in names if name.startswith("stepping/")]
    assert len(names) > len(stepping)
    command = "--engine rebound --seed 7"
    text = rendered(tmp_path, *({"check": f"{name}/x", "engine": "rebound"} for name in stepping))
    assert repeats(text)[0] == f"crosscheck run 'stepping/*' {command}"
    text = rendered(tmp_path, *({"check": f"{name}/x", "engine": "rebound"} for name in names))
    assert repeats(text)[0] == f"crosscheck run {command}"


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("doi:10.1103/PhysRev.159.98.", '<a href="https://doi.org/10.1103/PhysRev.159.98" rel="noreferrer">'),
        ("see https://example.org/a_b, p. 3", '<a href="https://example.org/a_b" rel="noreferrer">'),
        ("<i>", "&lt;i&gt;"),
        ('https://example.org/"onclick="x', '<a href="https://example.org/" rel="noreferrer">'),
    ],
)
def test_links(given, expected):
    assert expected in html._links(given)


def test_equations_may_have_indices_but_no_other_tags():
    assert html._equation("r<sub>0</sub> < 1 <script>") == "r<sub>0</sub> &lt; 1 &lt;script&gt;"


def test_figures_are_xml_without_a_colour_of_their_own(text):
    drawings = re.findall(r"<svg xmlns.*?</svg>", text, flags=re.DOTALL)
    assert len(drawings) == text.count("<figure>") > 6
    for drawing in drawings:
        ET.fromstring(drawing)
        assert not re.search(r"#[0-9a-fA-F]{6}", drawing)


def _variables(text, block):
    return dict(re.findall(r"--([a-z0-9]+):(#[0-9a-f]{6})", block.search(text)[1]))


LIGHT = re.compile(r":root\{(.*?)\}", re.DOTALL)
DARK = re.compile(r"prefers-color-scheme:dark\)\{:root\{(.*?)\}", re.DOTALL)


def _luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def _contrast(a, b):
    high, low = sorted((_luminance(a), _luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_contrast_meets_wcag_aa(text, theme):
    colours = _variables(text, theme)
    for name in ("ink", "quiet", "link", "pass", "fail", "error", "inconclusive", "skip"):
        for ground in ("paper", "panel"):
            assert _contrast(colours[name], colours[ground]) >= 4.5, (name, ground)
    for number in range(len(figures.PALETTE)):
        assert _contrast(colours[f"c{number}"], colours["paper"]) >= 3, number
    # particles are told from the page by their outlines, whatever their colour
    assert _contrast(colours["ring"], colours["paper"]) >= 3


def test_the_lightness_of_the_colour_map_rises_all_along():
    lightness = [_luminance(colour) for colour in pictures.colours()]
    assert len(lightness) == pictures.LEVELS
    assert all(a < b for a, b in pairwise(lightness))
