"""Arrays of `simulate`: every number to the last bit, a row at a time, forwards and backwards."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scene_files import DISKS, FLUID, TURNING, changed, load

from crosscheck.engines.protocol import Run
from crosscheck.errors import UsageError
from crosscheck.scene import Method
from crosscheck.simulate.arrays import write_arrays
from crosscheck.simulate.observables import Result
from crosscheck.trajectories.frames import DOUBLE, Series, Source
from crosscheck.trajectories.reading import open_results


def written(path: Path, table: dict[str, Any], method: Method, samples: int = 4, **more: Any) -> Run:
    """A run with random numbers in its arrays, as `simulate` writes it."""
    scene = load(path.parent, changed(table, "output", {"interval": 0.25, "trajectory": True}))
    rng = np.random.default_rng(3)
    shape = (samples, scene.number, scene.dimension)
    run = Run(time=np.arange(samples) * 0.25, positions=rng.normal(size=shape), velocities=rng.normal(size=shape))
    if scene.spin_dimension:
        run["angular_velocities"] = rng.normal(size=(*shape[:2], scene.spin_dimension))
    for name, value in more.items():
        setattr(run, name, value)
    write_arrays(path, scene, method, Result("refimpl", "1", run, {}))
    return run


def opened(path: Path) -> Source:
    found = open_results(path)
    assert isinstance(found, Source)
    return found


def test_a_fluid_in_space(tmp_path: Path) -> None:
    table = changed(changed(FLUID, "masses", [1.0, 1.0, 2.0, 2.0]), "species", [0, 0, 1, 1])
    run = written(tmp_path / "a.npz", table, Method(scheme="velocity_verlet", dt=0.005))
    source = opened(tmp_path / "a.npz")
    assert source.times.tolist() == [0, 0.25, 0.5, 0.75]
    assert source.steps is not None
    assert source.steps.tolist() == [0, 50, 100, 150]
    assert source.wrapping == "unwrapped"
    assert set(source.rounding.values()) == {DOUBLE}
    for k in (0, 3, 1, 1, 2):
        frame = source.read(k)
        assert np.array_equal(frame.positions, run["positions"][k])
        assert np.array_equal(frame.velocities, run["velocities"][k])
        assert frame.ids.tolist() == [1, 2, 3, 4]
        assert frame.masses is not None
        assert frame.masses.tolist() == [1, 1, 2, 2]
        assert frame.types is not None
        assert frame.types.tolist() == [0, 0, 1, 1]
        assert frame.box is not None
        assert frame.box.vectors.tolist() == np.diag([5.0, 5, 5]).tolist()
        assert frame.box.periodic.all()


def test_disks_that_rotate_in_the_plane(tmp_path: Path) -> None:
    run = written(tmp_path / "a.npz", TURNING, Method(scheme="event_driven"))
    source = opened(tmp_path / "a.npz")
    frame = source.read(3)
    assert source.steps is None
    assert np.array_equal(frame.positions[:, :2], run["positions"][3])
    assert not frame.positions[:, 2].any()
    assert frame.spins is not None
    assert np.array_equal(frame.spins[:, 2:], run["angular_velocities"][3])
    assert not frame.spins[:, :2].any()
    assert frame.diameters is not None
    assert frame.diameters.tolist() == [1, 1]
    assert frame.box is not None
    assert frame.box.periodic.tolist() == [True, False, False]
    assert frame.box.stated


def test_samples_after_the_end_of_a_run_are_left_out(tmp_path: Path) -> None:
    run = written(tmp_path / "a.npz", DISKS, Method(scheme="event_driven"), stopped="too many events")
    run["positions"][2:] = np.nan
    scene = load(tmp_path, DISKS)
    write_arrays(tmp_path / "a.npz", scene, Method(scheme="event_driven"), Result("refimpl", "1", run, {}))
    source = opened(tmp_path / "a.npz")
    assert source.times.tolist() == [0, 0.25]
    assert source.remarks == ("the run stopped: too many events.",)


def test_a_run_without_positions_is_a_table(tmp_path: Path) -> None:
    scene = load(tmp_path, changed(FLUID, "output", {"interval": 0.5, "observables": ["kinetic_energy"]}))
    run = Run(time=np.array([0, 0.5, 1]), kinetic_energy=np.array([1.0, 2, 3]))
    write_arrays(tmp_path / "a.npz", scene, Method(scheme="leapfrog", dt=0.1), Result("refimpl", "1", run, {}))
    found = open_results(tmp_path / "a.npz")
    assert isinstance(found, Series)
    assert found.time.tolist() == [0, 0.5, 1]
    assert found.columns["kinetic_energy"].tolist() == [1, 2, 3]


def test_what_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    written(tmp_path / "a.npz", FLUID, Method(scheme="leapfrog", dt=0.1))
    data = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(data[: len(data) // 2])
    np.savez(tmp_path / "other.npz", positions=np.zeros((2, 3)))
    for name, message in (("cut", "cannot be read as arrays of simulate"), ("other", "it has no entries 'about'")):
        with pytest.raises(UsageError, match=message) as caught:
            opened(tmp_path / f"{name}.npz")
        assert "\n" not in str(caught.value)
        assert f"{name}.npz" in str(caught.value)
