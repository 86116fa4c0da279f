"""An inspection as one offline HTML page: what is red first, then figures, and every judgement with its reason."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from crosscheck.figure import Histogram
from crosscheck.files import naming
from crosscheck.inspect.inspection import Inspection
from crosscheck.inspect.setting import TAKEN
from crosscheck.report import figures
from crosscheck.report.pages import templates
from crosscheck.text import printable
from crosscheck.verdict import SENSITIVITY, Outcome

#: Worst first.
_OUTCOMES: tuple[Outcome, ...] = ("fail", "inconclusive", "pass")


def write_page(inspection: Inspection, path: Path) -> None:
    """Writes the page of an inspection. inspection: what is told. path: of the file."""
    page = render(inspection)
    with naming(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(printable(page, keep="\n\t"), encoding="utf-8")


def render(inspection: Inspection) -> str:
    """The page as HTML; the same inspection gives the same text. inspection: what is told."""
    setting = inspection.setting
    counts = Counter(one.outcome for one in inspection.judgements)
    rows = [
        (one, [(judgement, judgement.as_record()) for judgement in one.told.judgements]) for one in inspection.found
    ]
    return (
        templates()
        .get_template("inspection.html.j2")
        .render(
            name=setting.source.path.name,
            facts=_facts(inspection),
            tally=[(outcome, counts[outcome]) for outcome in _OUTCOMES if counts[outcome]],
            rows=rows,
            worst=[
                (one, judgement, record)
                for outcome in ("fail", "inconclusive")
                for one, judged in rows
                for judgement, record in judged
                if judgement.outcome == outcome
            ],
            drawings=_drawings(inspection),
            meaning_of_sensitivity=SENSITIVITY,
        )
    )


def _facts(inspection: Inspection) -> list[tuple[str, str]]:
    setting = inspection.setting
    source = setting.source
    facts = [
        ("File", f"{source.path}: {source.format}"),
        ("Frames", f"{len(source)} of {len(setting.first.ids)} particles"),
        ("Taken to be", TAKEN[setting.ensemble]),
    ]
    if setting.scene is not None:
        facts.append(("Scene", setting.scene.name))
    facts += [("Remark", remark) for remark in (*source.remarks, *setting.remarks)]
    facts.append(
        (
            "False alarms",
            f"red of a right trajectory with the probability {inspection.false_alarms:.1g}, of all together",
        )
    )
    return facts


def _drawings(inspection: Inspection) -> list[figures.Drawing]:
    panels = [
        figures.Panel(
            one.title,
            one.x_label,
            one.y_label,
            one.x_scale,
            one.y_scale,
            tuple(
                figures.Curve(
                    curve.label,
                    "",
                    tuple(curve.x),
                    tuple(curve.y),
                    None if curve.error is None else tuple(curve.error),
                    curve.theory,
                    isinstance(curve, Histogram),
                )
                for curve in one.series
            ),
        )
        for one in inspection.figures
    ]
    return [figures.draw(panel, figures.curve_numbers([panel]), f"i{k}") for k, panel in enumerate(panels)]
