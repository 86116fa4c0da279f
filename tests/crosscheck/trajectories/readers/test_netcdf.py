"""NetCDF as LAMMPS and AMBER write it, in all its formats, and files that end early, which its library does not see."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pytest
from MDAnalysis import Universe
from MDAnalysis.coordinates.TRJ import NCDFWriter
from numpy.typing import NDArray
from truth import positions_of

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Source
from crosscheck.trajectories.reading import open_results

#: CDF-1, CDF-2 (AMBER), CDF-5 (LAMMPS), HDF5.
FORMATS = ("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4")
NUMBER, FRAMES = 7, 4
POSITIONS = np.random.default_rng(1).normal(size=(FRAMES, NUMBER, 3))
VELOCITIES = np.random.default_rng(2).normal(size=(FRAMES, NUMBER, 3))


def opened(path: Path, topology: Path | None = None) -> Source:
    found = open_results(path, topology)
    assert isinstance(found, Source)
    return found


def write(
    path: Path,
    form: str = FORMATS[2],
    real: str = "f4",
    unit: str = "lj",
    more: dict[str, NDArray[np.generic]] | None = None,
) -> list[NDArray[np.int64]]:
    """As `dump netcdf` of LAMMPS does: particles in any order, steps as times, and dt as their factor. Returns the
    order of each frame."""
    orders = [np.random.default_rng(k).permutation(NUMBER) for k in range(FRAMES)]
    with netCDF4.Dataset(path, "w", format=form) as file:
        file.set_auto_maskandscale(False)
        for name, size in (("frame", None), ("atom", NUMBER), ("spatial", 3), ("cell_spatial", 3), ("label", 10)):
            file.createDimension(name, size)
        file.setncatts({"Conventions": "AMBER", "ConventionVersion": "1.0", "program": "LAMMPS", "odd": "a"})
        time = file.createVariable("time", real, ("frame",))
        time.setncatts({"units": unit, "scale_factor": np.float32(0.005)})
        file.createVariable("spatial", "S1", ("spatial",))[:] = list("xyz")
        variables = {"cell_origin": [-1.0, 0, 0], "cell_lengths": [5.0, 6, 0], "cell_angles": [90.0, 90, 90]}
        for name in variables:
            file.createVariable(name, real, ("frame", "cell_spatial")).units = unit
        file.createVariable("id", "i4", ("frame", "atom"))
        file.createVariable("type", "i2", ("frame", "atom"))
        for name in ("coordinates", "velocities"):
            file.createVariable(name, real, ("frame", "atom", "spatial")).units = unit
        for name, values in (more or {}).items():
            file.createVariable(name, values.dtype, ("frame", "atom"))
        file.set_auto_maskandscale(False)
        for k, order in enumerate(orders):
            time[k] = 100 * k
            for name, row in variables.items():
                file[name][k] = row
            file["id"][k], file["type"][k] = order + 1, order % 2 + 1
            file["coordinates"][k], file["velocities"][k] = POSITIONS[k, order], VELOCITIES[k, order]
            for name, values in (more or {}).items():
                file[name][k] = values[k, order]
    return orders


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("real", ["f4", "f8"])
def test_what_lammps_writes(tmp_path: Path, form: str, real: str) -> None:
    write(tmp_path / "a.nc", form, real)
    source = opened(tmp_path / "a.nc")
    exact = np.float32 if real == "f4" else np.float64
    assert np.array_equal(positions_of(source), POSITIONS.astype(exact))
    assert source.rounding["positions"] == (SINGLE if real == "f4" else DOUBLE)
    assert source.units == ("sigma", "tau", "sigma/tau")
    assert source.times.tolist() == [0, 0.5, 1, 1.5]
    assert source.steps is not None
    assert source.steps.tolist() == [0, 100, 200, 300]
    frame = source.read(3)
    assert np.array_equal(frame.velocities, VELOCITIES[3].astype(exact))
    assert frame.types is not None
    assert frame.types.tolist() == [1, 2, 1, 2, 1, 2, 1]
    assert frame.box is not None
    assert frame.box.lower.tolist() == [-1, 0, 0]
    assert frame.box.vectors.tolist() == [[5, 0, 0], [0, 6, 0], [0, 0, 0]]
    assert frame.box.periodic.tolist() == [True, True, False]
    assert frame.box.stated
    assert source.wrapping == "wrapped"
    assert source.remarks == ()


def test_images_sizes_masses_and_lost_particles(tmp_path: Path) -> None:
    images = np.random.default_rng(3).integers(-2, 3, (3, FRAMES, NUMBER), dtype=np.int32)
    more: dict[str, NDArray[np.generic]] = dict(zip(("ix", "iy", "iz"), images, strict=True))
    more |= {"mass": np.full((FRAMES, NUMBER), 2.5), "radius": np.full((FRAMES, NUMBER), 0.25)}
    orders = write(tmp_path / "a.nc", real="f8", unit="angstrom", more=more)
    with netCDF4.Dataset(tmp_path / "a.nc", "a") as file:
        file["id"][2, 4] = netCDF4.default_fillvals["i4"]
    source = opened(tmp_path / "a.nc")
    assert source.wrapping == "unwrapped"
    moved = POSITIONS + np.moveaxis(images, 0, -1) * [5, 6, 0]
    assert np.array_equal(source.read(1).positions, moved[1])
    frame = source.read(2)
    assert orders[2][4] + 1 not in frame.ids
    assert len(frame.ids) == NUMBER - 1
    assert frame.masses is not None
    assert set(frame.masses) == {2.5}
    assert frame.diameters is not None
    assert set(frame.diameters) == {0.5}
    assert source.units.length == "Angstrom"


def test_what_mdanalysis_and_amber_write(tmp_path: Path) -> None:
    universe = Universe.empty(NUMBER, trajectory=True, velocities=True)
    with NCDFWriter(str(tmp_path / "a.ncdf"), NUMBER, velocities=True) as file:
        for k in range(FRAMES):
            universe.atoms.positions, universe.atoms.velocities = POSITIONS[k], VELOCITIES[k]
            universe.trajectory.ts.time, universe.dimensions = 0.4 * k, [10, 11, 12, 90, 90, 60]
            file.write(universe)
    (tmp_path / "names.xyz").write_text(f"{NUMBER}\n\n" + "Ar 0 0 0\n" * NUMBER)
    source = opened(tmp_path / "a.ncdf", tmp_path / "names.xyz")
    assert np.array_equal(positions_of(source), POSITIONS.astype(np.float32))
    assert source.times.tolist() == pytest.approx([0, 0.4, 0.8, 1.2], rel=1e-15)
    assert source.units == ("Angstrom", "ps", "Angstrom/ps")
    assert source.steps is None
    frame = source.read(1)
    assert np.array_equal(frame.velocities, VELOCITIES[1].astype(np.float32))
    assert frame.types is not None
    assert set(frame.types) == {"Ar"}
    assert frame.box is not None
    assert np.allclose(frame.box.vectors, [[10, 0, 0], [5.5, 11 * 0.75**0.5, 0], [0, 0, 12]], rtol=1e-15)


def test_a_factor_and_a_restart_of_amber(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "a.nc", "w", format=FORMATS[1]) as file:
        file.createDimension("atom", NUMBER)
        file.createDimension("spatial", 3)
        file.set_auto_maskandscale(False)
        file.createVariable("time", "f8", ())[...] = 12.5
        file["time"].units = "picosecond"
        file.createVariable("coordinates", "f8", ("atom", "spatial"))[:] = POSITIONS[0]
        velocities = file.createVariable("velocities", "f8", ("atom", "spatial"))
        velocities.setncatts({"units": "angstrom/picosecond", "scale_factor": 20.455})
        velocities.set_auto_maskandscale(False)
        velocities[:] = VELOCITIES[0]
    source = opened(tmp_path / "a.nc")
    assert source.times.tolist() == [12.5]
    frame = source.read(0)
    assert np.array_equal(frame.positions, POSITIONS[0])
    assert np.array_equal(frame.velocities, VELOCITIES[0] * 20.455)
    assert source.rounding["velocities"].relative == 2 * DOUBLE.relative
    assert frame.box is None


@pytest.mark.parametrize("form", FORMATS[:3])
def test_every_prefix_of_a_file_is_its_whole_frames(tmp_path: Path, form: str) -> None:
    """The library returns zeros for what is missing."""
    write(tmp_path / "a.nc", form)
    whole = positions_of(opened(tmp_path / "a.nc"))
    data = (tmp_path / "a.nc").read_bytes()
    step = 4 + 3 * 12 + NUMBER * 4 + -(-NUMBER * 2 // 4) * 4 + 2 * NUMBER * 12
    start = len(data) - FRAMES * step
    for end in [start - 1, start, *(start + k * step + more for k in range(1, FRAMES + 1) for more in (-1, 0))]:
        (tmp_path / "cut.nc").write_bytes(data[:end])
        count = (end - start) // step
        if count <= 0:
            with pytest.raises(UsageError, match=r"cut\.nc: cannot be read as NetCDF"):
                opened(tmp_path / "cut.nc")
            continue
        source = opened(tmp_path / "cut.nc")
        assert np.array_equal(positions_of(source), whole[:count])
        assert bool(source.remarks) == (count < FRAMES)


@pytest.mark.parametrize(
    ("form", "size", "message"),
    [
        (FORMATS[2], 3, "cannot be read as NetCDF"),
        (FORMATS[2], 100, "cannot be read as NetCDF"),
        (FORMATS[3], 4000, "cannot be read as NetCDF"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, form: str, size: int, message: str) -> None:
    write(tmp_path / "a.nc", form)
    (tmp_path / "cut.nc").write_bytes((tmp_path / "a.nc").read_bytes()[:size])
    with pytest.raises(UsageError, match=message) as caught:
        opened(tmp_path / "cut.nc")
    assert "\n" not in str(caught.value)
    with netCDF4.Dataset(tmp_path / "b.nc", "w", format=form) as file:
        file.createDimension("frame", None)
    with pytest.raises(UsageError, match="there is no variable unwrapped_coordinates"):
        opened(tmp_path / "b.nc")
