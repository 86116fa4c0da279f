"""The list of all tables of the scene language, derived from the models."""

from __future__ import annotations

import pytest

from crosscheck.scene import Explicit, Face, Friction, Obstacle, Scene, Wave
from crosscheck.scene.parts import Interaction, Part, SceneEntries
from crosscheck.scene.tables import tables


@pytest.mark.parametrize(
    ("place", "title", "part"),
    [
        ((), "", Scene),
        (("box", "faces", "y+"), '[box.faces."x-"]', Face),
        (("box", "faces", "y+", "friction"), '[box.faces."x-".friction]', Friction),
        (("lattice_gas", "obstacles", 3), "[[lattice_gas.obstacles]]", Obstacle),
        (("initial", "explicit"), '[initial] kind = "explicit"', Explicit),
        (("initial", "occupations", "waves", 0), "[[initial.waves]]", Wave),
    ],
)
def test_the_table_at_a_place(place: tuple[int | str, ...], title: str, part: type[Part]) -> None:
    (table,) = (table for table in tables(Scene) if table.matches(place))
    assert (table.title, table.part) == (title, part)


@pytest.mark.parametrize("place", [("boxes",), ("lattice_gas", "obstacles", "3"), ("box", "faces"), ("initial",)])
def test_no_table_at_a_place(place: tuple[str, ...]) -> None:
    assert not any(table.matches(place) for table in tables(Scene))


def test_every_model_of_a_table_is_found_once_per_place() -> None:
    def models(part: type[Part]) -> set[type[Part]]:
        return {part}.union(*(models(below) for below in part.__subclasses__()))

    declared = {part for part in models(Part) if part.__module__ == "crosscheck.scene.parts"} - {
        Part,
        Interaction,
        SceneEntries,
    }
    assert {table.part for table in tables(Scene)} == declared | {Scene}
    paths = [table.path for table in tables(Scene)]
    assert len(set(paths)) == len(paths)
