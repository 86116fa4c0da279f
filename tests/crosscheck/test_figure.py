"""What a figure holds: kept short in the record, told apart there, and refused where it does not fit together."""

import dataclasses
import json
import math

import pytest

from crosscheck.figure import FieldMap, Figure, Frame, Histogram, RoundFrame, Series, Snapshot
from crosscheck.report import figures

BOX = Frame(0.0, 10.0, 0.0, 5.0)


def test_numbers_are_kept_short():
    field = FieldMap([[math.pi]], BOX, "T", arrows=([[math.e]], [[1e-9 * math.pi]]))
    assert field.values == [[3.142]]
    assert field.arrows == ([[2.718]], [[3.142e-9]])
    snapshot = Snapshot([math.pi], [100 / 7], [math.e / 10], BOX, [1e5 * math.pi], "T")
    assert (snapshot.x, snapshot.y, snapshot.radius, snapshot.value) == ([3.142], [14.286], [0.2718], [314200.0])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Snapshot([1.0], [], 0.5, BOX), "1 particles"),
        (lambda: Snapshot([1.0], [1.0], [0.5, 0.5], BOX), "1 particles"),
        (lambda: Snapshot([1.0], [1.0], 0.5, BOX, [], "T"), "1 particles"),
        (lambda: Snapshot([], [], 0.5, BOX, [], "T", (1.0, 1.0)), "colour scale"),
        (lambda: FieldMap([[1.0], [1.0, 2.0]], BOX, "T"), "equally long"),
        (lambda: FieldMap([], BOX, "T", arrows=([[1.0]], [[1.0, 2.0]])), "differ"),
        (lambda: FieldMap([], BOX, "T", (0.0, math.inf)), "colour scale"),
        (lambda: Frame(1.0, 0.0, 0.0, 1.0), "no inside"),
        (lambda: Frame(0.0, math.inf, 0.0, 1.0), "finite"),
        (lambda: RoundFrame(0.0, 0.0, 0.0), "radius"),
        (lambda: Histogram("a", [1.0, 2.0], [1.0, 2.0]), "do not match"),
        (lambda: Series("a", [1.0, 2.0], [1.0]), "do not match"),
        (lambda: Series("a", [1.0], [1.0], []), "do not match"),
        (
            lambda: Figure("a", "", "", series=(Series("a", [], []),), map=FieldMap([], BOX, "T")),
            "more than one",
        ),
    ],
)
def test_what_does_not_fit_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_a_histogram_and_its_error_bars_have_one_number_a_bin():
    assert Histogram("a", [0.0, 1.0, 3.0], [1.0, 2.0], [0.1, 0.2]).theory is False
    with pytest.raises(ValueError, match="do not match"):
        Histogram("a", [0.0, 1.0, 3.0], [1.0, 2.0], [0.1, 0.2, 0.3])


@pytest.mark.parametrize("old", [True, False])
def test_the_report_knows_a_histogram_from_a_curve_in_new_and_old_records(old):
    """In older records every curve has the key "bins"; now only histograms do."""
    figure = Figure("t", "x", "y", series=(Histogram("a", [0.0, 1.0, 3.0], [1.0, 2.0]), Series("b", [0.0], [1.0])))
    record = json.loads(json.dumps(dataclasses.asdict(figure)))
    if old:
        record["series"][1]["bins"] = False
    line = {"check": "group/check", "variant": "a", "engine": "refimpl", "figures": [record]}
    (panel,) = figures.panels([line], lambda line: "a")
    assert [(curve.name, curve.bins) for curve in panel.curves] == [("a", True), ("b", False)]
