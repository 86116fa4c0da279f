"""H5MD: elements at their own steps, fixed or in time, in one to three dimensions, and what MDAnalysis writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from MDAnalysis import Universe, Writer
from truth import positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Source
from crosscheck.trajectories.reading import open_results

POSITIONS = np.random.default_rng(1).uniform(0, 5, (5, 4, 3))


def opened(path: Path) -> Source:
    found = open_results(path)
    assert isinstance(found, Source)
    return found


def element(group: Any, name: str, values: Any, steps: Any, interval: float = 0.1) -> Any:
    """An element in time at these steps."""
    found = group.create_group(name)
    found["value"] = values
    found["step"], found["time"] = np.asarray(steps), np.asarray(steps) * interval
    return found


def group_in(file: Any, boundary: tuple[str, ...] = ("periodic",) * 3, edges: Any = (5.0, 6, 7)) -> Any:
    group = file.create_group("particles/all")
    box = group.create_group("box")
    box.attrs["dimension"], box.attrs["boundary"] = len(boundary), [one.encode() for one in boundary]
    if edges is not None:
        box["edges"] = np.array(edges)
    return group


def test_everything_that_a_file_may_state(tmp_path: Path) -> None:
    images = np.random.default_rng(2).integers(-2, 3, (5, 4, 3))
    with h5py.File(tmp_path / "a.h5md", "w") as file:
        group = group_in(file, ("periodic", "periodic", "none"))
        position = group.create_group("position")
        position["value"] = POSITIONS
        position["step"], position["time"] = 20, 0.1  # constant intervals
        position["step"].attrs["offset"], position["time"].attrs["offset"] = 100, 0.5
        position["value"].attrs["unit"], position["time"].attrs["unit"] = "nm", "ps"
        for name, values in (("image", images), ("id", np.array([[9, 3, 5, 4]] * 5)), ("velocity", 2 * POSITIONS)):
            other = group.create_group(name)
            other["value"], other["step"], other["time"] = values, position["step"], position["time"]
        group["velocity/value"].attrs["unit"] = "nm ps-1"
        kinds = h5py.enum_dtype({"Ar": 0, "Kr": 1}, basetype="i")
        group.create_dataset("species", data=[0, 1, 1, 0], dtype=kinds)
        group["mass"] = np.array([1.0, 2, 3, 4], dtype=np.float32)
    source = opened(tmp_path / "a.h5md")
    assert source.units == ("nm", "ps", "nm/ps")
    assert source.times.tolist() == pytest.approx([0.5, 0.6, 0.7, 0.8, 0.9])
    assert source.steps is not None
    assert source.steps.tolist() == [100, 120, 140, 160, 180]
    assert source.wrapping == "unwrapped"
    assert source.rounding["masses"] == SINGLE
    assert source.remarks == ()
    order = [1, 3, 2, 0]
    for k, frame in enumerate(source.frames()):
        assert frame.ids.tolist() == [3, 4, 5, 9]
        assert np.array_equal(frame.positions, (POSITIONS[k] + images[k] * [5, 6, 7])[order])
        assert np.array_equal(frame.velocities, 2 * POSITIONS[k, order])
        assert frame.types is not None
        assert frame.types.tolist() == ["Kr", "Ar", "Kr", "Ar"]
        assert frame.masses is not None
        assert frame.masses.tolist() == [2, 4, 3, 1]
        assert frame.box is not None
        assert frame.box.periodic.tolist() == [True, True, False]
        assert frame.box.stated


def test_elements_are_matched_by_their_steps(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        group = group_in(file, edges=None)
        element(group["box"], "edges", [[5.0, 6, 7], [6.0, 7, 8]], [0, 30])
        element(group, "position", POSITIONS, [0, 10, 20, 30, 40])
        element(group, "velocity", POSITIONS[[0, 2, 4]].astype(np.float32), [0, 20, 40])
        element(group, "mass", np.ones((1, 4)), [0])
    source = opened(tmp_path / "a.h5")
    frames = list(source.frames())
    assert [frame.velocities is None for frame in frames] == [False, True, False, True, False]
    assert np.array_equal(frames[2].velocities, POSITIONS[2].astype(np.float32))
    assert [frame.box.vectors[0, 0] for frame in frames if frame.box is not None] == [5, 5, 5, 6, 6]
    assert source.wrapping == "wrapped"
    assert source.rounding["positions"] == DOUBLE
    assert source.rounding["velocities"] == SINGLE
    assert source.remarks == ("velocity is there in 3 of 5 frames.", "mass is there in 1 of 5 frames.")


@pytest.mark.parametrize("fill", [-1, 7])
def test_particles_that_are_not_there_are_left_out(tmp_path: Path, fill: int) -> None:
    with h5py.File(tmp_path / "a.h5md", "w") as file:
        group = group_in(file)
        element(group, "position", POSITIONS[:2], [0, 10])
        numbers = group.create_group("id")
        numbers.create_dataset("value", data=[[0, 1, 2, fill], [2, fill, fill, 1]], fillvalue=fill)
        numbers["step"] = group["position/step"]
    first, second = opened(tmp_path / "a.h5md").frames()
    assert first.ids.tolist() == [0, 1, 2]
    assert second.ids.tolist() == [1, 2]
    assert np.array_equal(second.positions, POSITIONS[1, [3, 0]])


@pytest.mark.parametrize("dimension", [1, 2])
def test_fewer_dimensions_are_completed_with_zeros(tmp_path: Path, dimension: int) -> None:
    with h5py.File(tmp_path / "a.h5md", "w") as file:
        group = group_in(file, ("periodic",) * dimension, np.diag([5.0, 6])[:dimension, :dimension])
        element(group, "position", POSITIONS[..., :dimension], range(5))
    frame = opened(tmp_path / "a.h5md").read(4)
    assert np.array_equal(frame.positions[:, :dimension], POSITIONS[4, :, :dimension])
    assert not frame.positions[:, dimension:].any()
    assert frame.box is not None
    assert np.diag(frame.box.vectors).tolist() == [5, 6 * (dimension > 1), 0]
    assert frame.box.periodic.tolist() == [True, dimension > 1, False]


def test_what_mdanalysis_writes(tmp_path: Path) -> None:
    universe = Universe.empty(4, trajectory=True, velocities=True)
    with Writer(str(tmp_path / "a.h5md"), 4, positions=True, velocities=True, convert_units=False) as file:
        for k in range(5):
            universe.atoms.positions, universe.atoms.velocities = POSITIONS[k], -POSITIONS[k]
            universe.trajectory.ts.time, universe.dimensions = 0.8 * k, [5, 6, 7, 90, 90, 60]
            file.write(universe)
    source = opened(tmp_path / "a.h5md")
    assert np.array_equal(positions_of(source), POSITIONS.astype(np.float32))
    assert source.times.tolist() == [0, 0.8, 1.6, 2.4, 3.2]
    assert source.rounding["positions"] == SINGLE
    frame = source.read(1)
    assert np.array_equal(frame.velocities, -POSITIONS[1].astype(np.float32))
    assert frame.box is not None
    assert np.allclose(frame.box.vectors, [[5, 0, 0], [3, 27**0.5, 0], [0, 0, 7]], rtol=1e-7)


def test_of_several_groups_the_first_is_read(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5md", "w") as file:
        for name in ("solute", "solvent"):
            element(file.create_group(f"particles/{name}"), "position", POSITIONS, range(5))
    source = opened(tmp_path / "a.h5md")
    assert source.remarks == ("of its groups of particles solute, solvent, the first is read.",)
    assert source.wrapping == "unwrapped"
    assert source.read(0).box is None


def test_what_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5md", "w") as file:
        file.create_group("particles/all")["position"] = POSITIONS[0]
    with pytest.raises(UsageError, match="there is no particles/<group>/position/value"):
        opened(tmp_path / "a.h5md")
    with h5py.File(tmp_path / "b.h5md", "w") as file:
        element(file.create_group("particles/all"), "position", POSITIONS, range(3))
    with pytest.raises(UsageError, match="position has fewer steps or times than values"):
        opened(tmp_path / "b.h5md")
    data = (tmp_path / "b.h5md").read_bytes()
    (tmp_path / "cut.h5md").write_bytes(data[: len(data) // 2])
    with pytest.raises(UsageError, match=r"cut\.h5md: cannot be read as H5MD") as caught:
        opened(tmp_path / "cut.h5md")
    assert "\n" not in str(caught.value)
