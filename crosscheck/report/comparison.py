"""The page of a comparison of two trajectories: where they part, and whether rounding and chaos explain it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from crosscheck import figure
from crosscheck.compare.differences import VECTORS
from crosscheck.compare.outcome import Mode, later, status
from crosscheck.compare.trajectories import Comparison, Neighbourhood
from crosscheck.files import naming
from crosscheck.report import figures, pictures
from crosscheck.report.pages import templates
from crosscheck.text import printable

#: What the page says of each exit status.
_OUTCOMES = {0: "pass", 1: "fail", 3: "inconclusive"}


def write_page(found: Comparison, mode: Mode, path: Path) -> Path:
    """Writes the page of a comparison as one HTML file; returns its path.

    found: the comparison. mode: the standard that was asked for. path: of the file.
    """
    with naming(path):
        path.write_text(printable(render(found, mode), keep="\n\t"), encoding="utf-8")
    return path


def render(found: Comparison, mode: Mode) -> str:
    """The page of a comparison, HTML; the same comparison gives the same text. found, mode: as for `write_page`."""
    drawings = [_separation(found)]
    if all(value is not None for gap in found.gaps for value in gap.kinetic):
        drawings.append(_energies(found))
    if found.neighbourhood is not None:
        drawings += _places(found.neighbourhood, found)
    law = None if found.growth is None else found.growth.law
    return (
        templates()
        .get_template("comparison.html.j2")
        .render(
            found=found,
            mode=mode,
            outcome=_OUTCOMES[int(status(found.classed, mode))],
            drawings=drawings,
            axes="xyz",
            vectors=VECTORS,
            law=law,
            horizon="" if law is None else later(found.clock, law.horizon),
        )
    )


def _separation(found: Comparison) -> figures.Drawing:
    """Separation against time on a log scale, with rounding of the files, and what rounding and chaos explain."""
    times = [gap.time for gap in found.gaps]

    def curve(name: str, values: Sequence[float], theory: bool = False) -> figures.Curve:
        shown = [(t, v) for t, v in zip(times, values, strict=True) if v > 0 and math.isfinite(v)]
        x, y = zip(*shown, strict=True) if shown else ((), ())
        return figures.Curve(name, "refimpl", tuple(x), tuple(y), None, theory, False)

    curves = [
        curve("root mean square of all particles", [gap.rms.get("positions", 0.0) for gap in found.gaps]),
        curve("farthest particle", [gap.largest.get("positions", 0.0) for gap in found.gaps]),
        curve("rounding of the files", [gap.floor.get("positions", 0.0) for gap in found.gaps], theory=True),
    ]
    if found.line is not None:
        most = found.separation.spacing
        curves.append(
            curve("what rounding and chaos explain", [v if v < most else math.nan for v in found.line], theory=True)
        )
    parting = None if found.growth is None else found.growth.parting
    if parting is not None and found.growth is not None and found.growth.kind in ("early", "jump"):
        expected = [parting.expected if k == parting.frame else math.nan for k in range(len(times))]
        curves.append(curve("the most that they explain where the runs part", expected))
    panel = figures.Panel(
        "Distance of a particle from itself", _time(found), "distance", "linear", "log", tuple(curves)
    )
    return figures.draw(panel, figures.curve_numbers([panel]), "s")


def _energies(found: Comparison) -> figures.Drawing:
    times = tuple(gap.time for gap in found.gaps)
    curves = tuple(
        figures.Curve(
            name, "refimpl", times, tuple(float(gap.kinetic[side] or 0.0) for gap in found.gaps), None, False, False
        )
        for side, name in enumerate(("first", "second"))
    )
    panel = figures.Panel("Mean kinetic energy of a particle", _time(found), "energy", "linear", "linear", curves)
    return figures.draw(panel, figures.curve_numbers([panel]), "e")


def _time(found: Comparison) -> str:
    return {"time": "time", "step": "time step", "order": "number of the frame"}[found.clock]


def _places(place: Neighbourhood, found: Comparison) -> list[figures.Drawing]:
    """The particles around the one that is farthest from itself, coloured by how far each is, along two planes."""
    apart = np.linalg.norm(place.second - place.first, axis=1)
    with np.errstate(divide="ignore"):
        values = [float(value) for value in np.log10(apart)]
    extent = float(np.abs(place.first).max()) + 1.5 * place.radius
    drawings = []
    planes = [(0, 1), (0, 2)] if np.ptp(place.first[:, 2]) > 0 else [(0, 1)]
    for one, other in planes:
        names = "xyz"[one], "xyz"[other]
        snapshot = figure.Snapshot(
            x=[float(v) for v in place.first[:, one]],
            y=[float(v) for v in place.first[:, other]],
            radius=place.radius,
            container=figure.Frame(-extent, extent, -extent, extent, walls=()),
            value=values,
            value_label="log10 of the distance from itself",
        )
        title = f"Around particle {place.particle} at {found.when(place.pair)}, {names[0]} and {names[1]} from it"
        drawings.append(pictures.draw(pictures.Picture(title, *names, asdict(snapshot), None), f"n{other}"))
    return drawings
