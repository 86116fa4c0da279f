"""The rows of features: scenes that are valid, with all pairs of features but those that exclude each other."""

from __future__ import annotations

import pytest

from crosscheck.checks.events.audit_rows import FACTORS, row_scene, rows, valid
from crosscheck.engines.capabilities import words


def test_every_level_of_every_feature_occurs() -> None:
    table, _ = rows()
    for name, levels in FACTORS.items():
        assert {row[name] for row in table} == set(levels), name


def test_every_row_is_a_scene_that_uses_its_features() -> None:
    table, _ = rows()
    used = set()
    for number, row in enumerate(table):
        assert valid(row)
        scene = row_scene(row, number)
        scene.initial_state()
        assert scene.dimension == int(row["dimension"])
        assert scene.hard_spheres is not None
        assert (scene.hard_spheres.well is None) == (row["well"] == "none")
        assert (scene.acceleration is None) == (row["field"] == "none")
        assert scene.output.trace
        used |= words(scene)
    for word in ("box.cylinder.angular_velocity", "box.faces.temperature", "hard_spheres.fixed", "output.fields"):
        assert word in used


@pytest.mark.parametrize("pair", sorted(rows()[1]))
def test_pairs_that_never_occur_exclude_each_other(pair: tuple[tuple[str, str], tuple[str, str]]) -> None:
    """No row of the table becomes valid with both: it would need a feature that the pair forbids."""
    given = dict(pair)
    table, _ = rows()
    assert not any(valid(row | given) for row in table)


def test_the_same_row_is_always_the_same_scene() -> None:
    table, _ = rows()
    assert row_scene(table[3], 3) == row_scene(table[3], 3)
