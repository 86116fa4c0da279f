"""The page of an inspection: what is red comes first, hostile names do no harm, and every judgement is there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from inspected import PLANTED, flying

from crosscheck.inspect.inspection import inspect_trajectory
from crosscheck.inspect.page import render, write_page
from crosscheck.inspect.setting import Options

HOSTILE = "<script>alert('x')</script>&.xyz"


def page(**changes: object) -> str:
    run = PLANTED.ornstein_uhlenbeck(1, frames=80)
    run = run._replace(velocities=run.velocities * np.array([1.0, 1.5, 1.0]))
    return render(
        inspect_trajectory(replace(PLANTED.source_of(run), path=Path(HOSTILE)), None, Options(ensemble="nvt"))
    )


def test_what_is_red_comes_first_then_figures_then_all_of_it() -> None:
    text = page()
    red, figures, judgements, unsaid = (
        text.index(f"<h2>{title}</h2>") for title in ("Red or open", "Figures", "Judgements", "Cannot be said")
    )
    assert red < text.index("temperature along y over the mean") < figures < judgements < unsaid
    for title in (
        "Speeds",
        "Energies",
        "Change of the momentum",
        "Kinetic temperature",
        "Radial distribution function",
    ):
        assert f"<figcaption>{title}</figcaption>" in text
    assert text.count("<figure>") == text.count("<figcaption>") == 5
    assert "angular momentum</b>: it is conserved in open space" in text


def test_names_of_files_are_text() -> None:
    text = page()
    assert "<script>" not in text
    assert "&lt;script&gt;" in text


def test_nothing_red_is_said() -> None:
    text = render(inspect_trajectory(flying(frames=30), None, Options(ensemble="none")))
    assert "Nothing is red." in text
    assert "Red or open" not in text


def test_the_same_inspection_gives_the_same_page(tmp_path: Path) -> None:
    inspection = inspect_trajectory(flying(frames=30))
    write_page(inspection, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert text == render(inspection) or text.splitlines() == render(inspection).splitlines()
    for svg in text.split("<svg")[1:]:
        ElementTree.fromstring("<svg" + svg.split("</svg>")[0] + "</svg>")
