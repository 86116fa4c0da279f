"""A comparison as JSON: every field is what was found."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from pairs_of_runs import from_state, liquid, run, trajectory

from crosscheck.compare.tables import compare_tables
from crosscheck.compare.trajectories import Comparison, compare_trajectories
from crosscheck.compare.written import SCHEMA, document, schema, table_document
from crosscheck.trajectories.frames import DOUBLE, Series


@pytest.fixture(scope="module")
def found() -> Comparison:
    """A particle of a liquid is displaced by 1e-12."""
    scene = liquid()
    start = scene.own_start()
    positions = start.positions.copy()
    positions[17, 0] += 1e-12
    other = run(from_state(scene, positions, start.velocities))
    return compare_trajectories(trajectory(scene, run(scene), "one"), trajectory(scene, other, "two"))


def test_the_document_says_what_was_found(found: Comparison) -> None:
    told = document(found, "chaos")
    jsonschema.validate(told, schema(), cls=jsonschema.Draft202012Validator)
    plain = {
        "schema": SCHEMA, "first": "one", "second": "two", "mode": "chaos", "verdict": "chaos_only", "status": 0,
        "clock": "time", "particles": 32, "setup": [], "remarks": [], "sentence": found.sentence,
    }  # fmt: skip
    assert {name: told[name] for name in plain} == plain
    assert found.beyond is not None
    assert told["first_beyond"] == {
        "frame": 0, "time": 0.0, "step": 0, "quantity": "positions", "particle": 18, "axis": 0,
        "first": found.beyond.first, "second": found.beyond.second, "rounding": found.beyond.rounding,
    }  # fmt: skip
    assert told["first_bits"] == told["first_beyond"]
    assert found.growth is not None
    assert found.line is not None
    law = found.growth.law
    assert law is not None
    assert told["growth"] == {
        "kind": "chaos", "rate": law.rate, "rate_error": law.error, "start": law.start, "start_factor": law.factor,
        "limit": law.limit, "horizon": law.horizon, "parting": None, "expected": None,
    }  # fmt: skip
    assert len(told["frames"]) == 121
    gap, point = found.gaps[60], told["frames"][60]
    assert point == {
        "time": pytest.approx(6.0), "step": 1200, "rms": gap.rms["positions"], "largest": gap.largest["positions"],
        "particle": gap.farthest["positions"], "floor": gap.floor["positions"], "line": found.line[60],
        "kinetic": list(gap.kinetic),
    }  # fmt: skip


def test_runs_that_part_have_their_frame_and_no_law(found: Comparison) -> None:
    parted = compare_trajectories(
        *(trajectory(liquid(), run(liquid(), dt), name, dt=dt) for name, dt in (("one", 0.005), ("two", 0.0025)))
    )
    growth = document(parted, "chaos")["growth"]
    assert parted.growth is not None
    assert parted.growth.parting is not None
    assert (growth["parting"], growth["expected"]) == tuple(parted.growth.parting)
    if parted.growth.law is None:
        assert growth["rate"] is growth["limit"] is None
    same = document(compare_trajectories(*[trajectory(liquid(), run(liquid()), "one")] * 2), "exact")
    assert same["growth"] is same["first_bits"] is same["statistics"] is None


def test_what_is_not_finite_is_null(found: Comparison) -> None:
    gaps = [found.gaps[0]._replace(kinetic=(math.inf, math.nan)), *found.gaps[1:]]
    values: dict[str, Any] = {name: getattr(found, name) for name in Comparison.__dataclass_fields__}
    assert document(Comparison(**values | {"gaps": gaps}), "chaos")["frames"][0]["kinetic"] == [None, None]


def test_tables_have_their_cells(tmp_path: Path) -> None:
    columns = {"energy": np.arange(40.0)}
    one, other = (
        Series(Path(name), "CSV", np.arange(40.0), {"energy": columns["energy"] + more}, {"energy": DOUBLE})
        for name, more in (("one", 0.0), ("two", 1.0))
    )
    told = table_document(compare_tables(one, other), "exact")
    assert (told["schema"], told["mode"], told["status"], told["first"], told["second"]) == (
        1,
        "exact",
        1,
        "one",
        "two",
    )
    assert told["verdict"] == compare_tables(one, other).classed
    assert told["bits"]["first"] == 0.0
    assert told["bits"]["second"] == 1.0
    assert table_document(compare_tables(one, one), "exact")["status"] == 0
