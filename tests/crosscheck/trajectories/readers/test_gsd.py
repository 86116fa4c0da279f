"""GSD by HOOMD's own package, with its defaults and changes of N; and with what programs log in 64 bits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gsd.fl
import gsd.hoomd
import numpy as np
import pytest
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Source
from crosscheck.trajectories.reading import open_results

BOX = [5.0, 6, 7, 0.5, 0, -0.25]
EDGES = [[5, 0, 0], [3, 6, 0], [0, -1.75, 7]]


def opened(path: Path) -> Source:
    found = open_results(path)
    assert isinstance(found, Source)
    return found


def write(path: Path, numbers: list[int], precision: str = "single", **columns: Any) -> None:
    """Frames with so many particles each; columns: of `gsd.hoomd`, as a function of the frame's number."""
    with gsd.hoomd.open(str(path), "w", precision=precision) as file:
        for k, number in enumerate(numbers):
            frame = gsd.hoomd.Frame()
            frame.configuration.step, frame.configuration.box = 100 * k, BOX
            frame.particles.N = number
            for name, of_frame in columns.items():
                setattr(frame.particles, name, of_frame(k))
            file.append(frame)


def positions(number: int, k: int) -> NDArray[np.float32]:
    return np.random.default_rng(k).uniform(-2, 2, (number, 3)).astype(np.float32)


@pytest.mark.parametrize("precision", ["single", "double"])
def test_what_hoomd_states(tmp_path: Path, precision: str) -> None:
    images = [np.full((4, 3), k, dtype=np.int32) for k in range(3)]
    write(
        tmp_path / "a.gsd",
        [4, 4, 4],
        precision,
        position=lambda k: positions(4, k),
        velocity=lambda k: positions(4, 10 + k),
        image=lambda k: images[k],
        types=lambda _: ["A", "Bee"],
        typeid=lambda _: [0, 1, 1, 0],
        mass=lambda _: [1, 2.5, 1, 1],
        diameter=lambda _: [0.5, 1, 1, 1],
    )
    source = opened(tmp_path / "a.gsd")
    assert source.steps is not None
    assert source.steps.tolist() == source.times.tolist() == [0, 100, 200]
    assert source.units.time == "step"
    assert source.wrapping == "unwrapped"
    assert source.rounding["velocities"] == (SINGLE if precision == "single" else DOUBLE)
    for k, frame in enumerate(source.frames()):
        true = positions(4, k).astype(np.float64) + k * np.sum(EDGES, axis=0)
        assert (np.abs(frame.positions - true) <= source.rounding["positions"].of(true)).all()
        assert np.array_equal(frame.velocities, positions(4, 10 + k))
        assert frame.types is not None
        assert frame.types.tolist() == ["A", "Bee", "Bee", "A"]
        assert frame.masses is not None
        assert frame.masses.tolist() == [1, 2.5, 1, 1]
        assert frame.diameters is not None
        assert frame.diameters.tolist() == [0.5, 1, 1, 1]
        assert frame.box is not None
        assert frame.box.vectors.tolist() == EDGES
        assert frame.box.lower.tolist() == [-4, -2.125, -3.5]


def test_what_a_file_does_not_state_is_not_a_default(tmp_path: Path) -> None:
    write(tmp_path / "a.gsd", [3, 3], position=lambda k: positions(3, k))
    source = opened(tmp_path / "a.gsd")
    frame = source.read(1)
    assert frame.velocities is frame.masses is frame.diameters is frame.types is None
    assert source.wrapping == "wrapped"
    assert "it states no velocities and no masses: HOOMD's defaults are not compared." in source.remarks


def test_defaults_hold_in_frames_that_leave_out_what_others_have(tmp_path: Path) -> None:
    write(
        tmp_path / "a.gsd",
        [3, 3, 5],
        position=lambda k: positions((3, 3, 5)[k], k),
        velocity=lambda k: positions(3, k) if k == 1 else None,
        mass=lambda k: [2, 3, 4] if k == 0 else None,
        typeid=lambda k: [0, 1, 0] if k == 0 else None,
        types=lambda _: ["A", "B"],
    )
    first, second, third = opened(tmp_path / "a.gsd").frames()
    assert first.velocities is not None
    assert not first.velocities.any()
    assert np.array_equal(second.velocities, positions(3, 1))
    assert second.masses is not None
    assert second.masses.tolist() == [2, 3, 4]  # of frame 0
    assert third.masses is not None
    assert third.masses.tolist() == [1] * 5  # other particles: HOOMD's default
    assert third.types is not None
    assert third.types.tolist() == ["A"] * 5
    assert third.ids.tolist() == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("names", [("positions", "velocities", "angular_velocities", "masses"), None])
def test_what_is_logged_in_64_bits_comes_first(tmp_path: Path, names: tuple[str, ...] | None) -> None:
    exact = np.random.default_rng(1).normal(size=(3, 3, 4, 3)) * 20
    keys = names or ("position", "velocity", "angular_velocity", "mass")
    with gsd.fl.open(str(tmp_path / "a.gsd"), "w", "a test", "hoomd", [1, 4]) as file:
        for k in range(3):
            file.write_chunk("configuration/step", np.array([10 * k], dtype=np.uint64))
            file.write_chunk("particles/N", np.array([4], dtype=np.uint32))
            file.write_chunk("particles/position", np.zeros((4, 3), dtype=np.float32))
            file.write_chunk("particles/image", np.ones((4, 3), dtype=np.int32))
            file.write_chunk("log/time", np.array([0.1 * k], dtype=np.float64 if names else np.float32))
            for key, values in zip(keys, exact, strict=False):
                file.write_chunk(f"log/particles/{key}", values[k])
            if k == 0:
                file.write_chunk("configuration/box", np.array([9, 9, 9, 0, 0, 0], dtype=np.float32))
                file.write_chunk(f"log/particles/{keys[3]}", np.array([1.1, 2.2, 3.3, 4.4]))
                file.write_chunk("log/particles/radius", np.array([0.1, 0.2, 0.3, 0.4]))
                file.write_chunk("log/cell", np.array([5.1, 0, 7.1]))
            file.end_frame()
    source = opened(tmp_path / "a.gsd")
    assert source.times.tolist() == [0, 0.1, 0.2]
    assert set(source.rounding.values()) == {DOUBLE}
    assert source.wrapping == "unwrapped"
    for k, frame in enumerate(source.frames()):
        assert np.array_equal(frame.positions, exact[0, k])
        assert np.array_equal(frame.velocities, exact[1, k])
        assert np.array_equal(frame.spins, exact[2, k])
        assert frame.masses is not None
        assert frame.masses.tolist() == [1.1, 2.2, 3.3, 4.4]
        assert frame.diameters is not None
        assert frame.diameters.tolist() == [0.2, 0.4, 0.6, 0.8]
        assert frame.box is not None
        assert frame.box.vectors.tolist() == [[5.1, 0, 0], [0, 0, 0], [0, 0, 7.1]]
        assert frame.box.lower.tolist() == [0, 0, 0]
        assert frame.box.periodic.tolist() == [True, False, True]
        assert not frame.box.stated


def test_a_log_of_frame_0_is_not_taken_for_another_frame(tmp_path: Path) -> None:
    with gsd.hoomd.open(str(tmp_path / "a.gsd"), "w") as file:
        for k in range(2):
            frame = gsd.hoomd.Frame()
            frame.particles.N, frame.particles.position = 3, positions(3, k)
            if k == 0:
                frame.log["particles/position"] = np.ones((3, 3))
            file.append(frame)
    source = opened(tmp_path / "a.gsd")
    assert source.read(0).positions.tolist() == [[1, 1, 1]] * 3
    assert np.array_equal(source.read(1).positions, positions(3, 1))
    assert source.rounding["positions"] == SINGLE


def test_what_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    write(tmp_path / "a.gsd", [3, 3], position=lambda k: positions(3, k))
    data = (tmp_path / "a.gsd").read_bytes()
    for share in (0.9, 0.5, 0.01):
        (tmp_path / "cut.gsd").write_bytes(data[: int(share * len(data))])
        with pytest.raises(UsageError, match=r"cut\.gsd: cannot be read as GSD") as caught:
            opened(tmp_path / "cut.gsd")
        assert "\n" not in str(caught.value)
    write(tmp_path / "b.gsd", [3], mass=lambda _: [1, 2, 3])
    with pytest.raises(UsageError, match="it has no positions"):
        opened(tmp_path / "b.gsd")
    write(tmp_path / "c.gsd", [])
    with pytest.raises(UsageError, match="there is no frame"):
        opened(tmp_path / "c.gsd")
