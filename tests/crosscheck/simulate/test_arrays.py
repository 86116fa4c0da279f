"""Arrays of a run in files: all of them, with their coordinates, to the same bits; a new observable needs no code."""

import csv
import json

import numpy as np
import pytest
from hard_disks import EVENTS, disks
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.engines.protocol import Run, shapes
from crosscheck.scene import Box, Cylinder, Explicit, Face, Gravity, Method, Output, Scene
from crosscheck.scene.observables import TABLE, Observable
from crosscheck.simulate import arrays
from crosscheck.simulate.arrays import write_arrays, write_places
from crosscheck.simulate.observables import Result, observables, places, write_csv, write_observables
from crosscheck.simulate.run import load, shipped_scenes


def read(path):
    """Columns of a CSV file."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def drawn(scene, samples=3):
    """A run with random numbers in all arrays that the scene asks for."""
    generator = np.random.default_rng(7)
    run = Run({name: generator.normal(size=shape) for name, shape in shapes(scene, samples).items()})
    run["time"] = np.arange(samples) / 3
    return run


def small(name):
    """A shipped scene with all observables that it can ask for."""
    scene = load(name)
    if scene.lattice_gas is not None:
        gas = scene.lattice_gas.model_copy(update={"columns": 64, "rows": 8, "obstacles": (), "force": 0.1})
        output = Output(interval=10, observables=("populations", "force_impulse", "sites"), fields=(4, 2))
        return scene.changed(lattice_gas=gas, output=output)
    if scene.hard_spheres is not None and scene.box is not None:
        cells = (2, 3, 2)[: scene.dimension]
        return scene.changed(output=scene.output.model_copy(update={"fields": cells, "trajectory": True}))
    forces = scene.hard_spheres is None
    return scene.changed(output=scene.output.model_copy(update={"forces": forces, "trajectory": True}))


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_array_of_every_shipped_scene_reads_back(tmp_path, name):
    scene = small(name)
    run = drawn(scene)
    result = Result("refimpl", "1", run, observables(scene, run))
    with np.load(write_arrays(tmp_path / "arrays.npz", scene, scene.method, result)) as found:
        about = json.loads(str(found["about"]))
        for key, values in run.items():
            assert found[key].tobytes() == values.tobytes()
            row = about["arrays"][key]
            assert (tuple(row["axes"]), row["unit"]) == (TABLE[key].axes, TABLE[key].unit)
    columns = {}
    for path in write_places(tmp_path, "refimpl", scene, scene.method, result)[0]:
        columns |= {(path.name, column): values for column, values in read(path).items()}
    written = np.concatenate(list(columns.values()))
    for key, values in run.items():
        if TABLE[key].asked != "trajectory" and places(key) not in ((), ("sample",)):
            assert np.isin(values, written).all(), key


def test_coordinates_and_columns_of_fields(tmp_path):
    scene = disks(box=Box(lengths=(6.0, 5.0)), output=Output(interval=1.0, fields=(3, 2)))
    run = drawn(scene)
    paths, _ = write_places(tmp_path, "e", scene, EVENTS, Result("e", "1", run, {}))
    assert [path.name for path in paths] == ["particles-e.csv", "fields-e.csv"]
    table = read(paths[1])
    assert table["x"].tolist() == [1, 1, 3, 3, 5, 5]
    assert table["y"].tolist() == [1.25, 3.75] * 3
    assert table["x_low"].tolist() == [0, 0, 2, 2, 4, 4]
    assert table["y_high"].tolist() == [2.5, 5] * 3
    for i in range(3):
        for j in range(2):
            cell = 2 * i + j
            assert table["field_mass"][cell] == run["field_mass"][i, j]
            assert table["field_momentum.y"][cell] == run["field_momentum"][i, j, 1]
            # flux of momentum along x through the faces that cut the axis y
            assert table["field_flux_momentum.y.x"][cell] == run["field_flux_momentum"][1, i, j, 0]
            assert table["field_flux_energy.y"][cell] == run["field_flux_energy"][1, i, j]
    text = paths[1].read_text()
    assert "# field_mass: mass in each cell, integrated over the run, since the start (unit: mass time)\n" in text
    assert "# density = field_mass/(cell volume, duration) (unit: mass/length^d)\n" in text


def test_populations_by_time_and_block(tmp_path):
    scene = small("sound-wave-hpp")
    run = drawn(scene)
    paths, _ = write_places(tmp_path, "e", scene, scene.method, Result("e", "1", run, {}))
    tables = {path.name: read(path) for path in paths}
    assert set(tables) == {"blocks-e.csv", "rows-e.csv", "sites-e.csv"}
    blocks = tables["blocks-e.csv"]
    assert blocks["time"].tolist() == np.repeat(run["time"], 8).tolist()
    assert blocks["x"].tolist() == np.tile(np.repeat([8.0, 24, 40, 56], 2), 3).tolist()
    assert blocks["populations[2]"].tolist() == run["populations"][..., 2].ravel().tolist()
    assert "velocities of the channels: [0] [1.0, 0.0]" in (tmp_path / "blocks-e.csv").read_text()
    assert tables["rows-e.csv"]["force_impulse"].tolist() == run["force_impulse"].ravel().tolist()
    assert tables["sites-e.csv"]["column"].tolist() == list(range(64)) * 8


def test_forces_and_species_of_particles(tmp_path):
    scene = Scene(
        name="two",
        dimension=2,
        duration=1.0,
        gravity=Gravity(),
        masses=(1.0, 2.0),
        species=(1, 0),
        initial=Explicit(positions=((0.0, 0.0), (1.0, 0.0))),
        output=Output(forces=True),
    )
    run = drawn(scene)
    (path,), _ = write_places(tmp_path, "e", scene, Method(scheme="verlet", dt=0.1), Result("e", "1", run, {}))
    table = read(path)
    assert table["mass"].tolist() == [1, 2]
    assert table["species"].tolist() == [1, 0]
    assert table["forces.y"].tolist() == run["forces"][:, 1].tolist()


def test_the_npz_file_names_faces_and_operations(tmp_path):
    scene = disks(
        box=Box(lengths=(6.0, 6.0), boundaries=("open", "open"), cylinder=Cylinder(radius=3.0)),
        output=Output(interval=1.0, observables=("wall_impulse", "operation_counts")),
        initial=Explicit(positions=((3.0, 3.0),)),
    )
    result = Result("e", "1", drawn(scene), {})
    with np.load(write_arrays(tmp_path / "a.npz", scene, EVENTS, result)) as found:
        assert found["face"].tolist() == ["x-", "x+", "y-", "y+", "cylinder"]
        assert len(found["operation"]) == found["operation_counts"].shape[1]
        assert found["axis"].tolist() == ["x", "y"]


def test_a_table_that_is_too_long_is_left_to_the_npz_file(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays, "MOST_ROWS", 5)
    scene = disks(output=Output(interval=1.0, fields=(3, 2)))
    paths, remark = write_places(tmp_path, "e", scene, EVENTS, Result("e", "1", drawn(scene), {}))
    assert [path.name for path in paths] == ["particles-e.csv"]
    assert "fields-e.csv would have 6 rows" in remark


def test_an_observable_on_new_places_is_written(tmp_path, monkeypatch):
    """A row of the table is enough: here a number for each particle at each sample, and one for each face and cell."""
    ages = Observable("ages", "hard_spheres", ("sample", "particle"), "time", "since the last collision")
    strain = Observable("strain", "hard_spheres", ("face", "grid", "spin"), "none", "of cells", asked="fields")
    for row in (ages, strain):
        monkeypatch.setitem(TABLE, row.name, row)
    scene = disks(
        box=Box(lengths=(6.0, 5.0), boundaries=("hard", "periodic"), faces={"x+": Face(open=True)}),
        output=Output(interval=1.0, fields=(2, 1)),
    )
    run = drawn(scene)
    run["ages"], run["strain"] = np.arange(9.0).reshape(3, 3), np.arange(8.0).reshape(4, 2, 1, 1)
    paths, _ = write_places(tmp_path, "e", scene, EVENTS, Result("e", "1", run, {}))
    tables = {path.name: read(path) for path in paths}
    assert tables["sample-particle-e.csv"]["ages"].tolist() == list(range(9))
    assert tables["fields-e.csv"]["strain[x-].z"].tolist() == [0, 1]  # the other faces are not there
    with np.load(write_arrays(tmp_path / "a.npz", scene, EVENTS, Result("e", "1", run, {}))) as found:
        assert found["ages"].tolist() == run["ages"].tolist()


FLOATS = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True, width=64)


@given(st.lists(st.tuples(FLOATS, FLOATS), min_size=1, max_size=20))
def test_every_number_of_a_csv_file_reads_back_to_the_same_bits(tmp_path_factory, rows):
    values = np.array(rows)
    path = tmp_path_factory.mktemp("csv") / "table.csv"
    table = read(write_csv(path, ["two columns"], {"a": values[:, 0], "b": values[:, 1]}))
    for k, name in enumerate("ab"):
        same = (table[name] == values[:, k]) | (np.isnan(table[name]) & np.isnan(values[:, k]))
        assert same.all()
        assert (np.signbit(table[name]) == np.signbit(values[:, k]))[~np.isnan(values[:, k])].all()


def test_observables_in_files_read_back(tmp_path):
    scene = disks(output=Output(interval=1.0, observables=("kinetic_energy", "collisions")))
    run = drawn(scene)
    table = observables(scene, run)
    path = write_observables(tmp_path / "o.csv", scene, EVENTS, Result("e", "1", run, table))
    assert {name: values.tobytes() for name, values in read(path).items()} == {
        name: values.tobytes() for name, values in table.items()
    }


def test_a_name_with_line_breaks_stays_a_comment(tmp_path):
    path = write_csv(tmp_path / "t.csv", ["one\ntime,energy\r\n1,2"], {"time": np.zeros(1)})
    assert path.read_text().splitlines() == ["# one\\ntime,energy\\r\\n1,2", "time", "0.0"]


def test_the_events_of_a_trace_are_rows_of_a_file(tmp_path):
    scene = disks(output=Output(trace=True))
    run = drawn(scene)
    run |= {name: np.ones(shape) for name, shape in shapes(scene, 3, 4).items() if name.startswith("event_")}
    result = Result("refimpl", "1", run, observables(scene, run))
    paths, remark = write_places(tmp_path, "one", scene, EVENTS, result)
    assert not remark
    found = read(next(path for path in paths if path.name == "events-one.csv"))
    assert found["event"].tolist() == [0, 1, 2, 3]
    assert {"event_times", "event_partners[0]", "event_positions[1].y", "event_velocities[0].x"} <= set(found)
