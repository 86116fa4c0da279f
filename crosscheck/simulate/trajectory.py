"""Trajectories of a run as files: the table of formats, and their writers.

To add a format: one record of `FORMATS`, with its writer, in this file.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crosscheck.engines.protocol import Run
from crosscheck.scene import Floats, Scene


@dataclass(frozen=True)
class Trajectory:
    """N particles in space at S times, up to the last sample that is finite.

    The vectors of a scene of fewer dimensions are completed with zeros; in the plane, rotation is about z. Units are
    the scene's own.

    time: (S,), time. positions: (S, N, 3), length, not wrapped into the box. cell: sides of the box, (3,), length; 0
    along axes without a box. periodic: which axes are, (3,). masses: (N,), mass. species: (N,), or None if the scene
    has no species. more: name -> (S, N, 3) vectors or (N,) constants, those of `QUANTITIES` that the run recorded.
    """

    time: Floats
    positions: Floats
    cell: Floats
    periodic: NDArray[np.bool_]
    masses: Floats
    species: NDArray[np.int64] | None
    more: dict[str, Floats]


#: What a format may hold beside positions, times, cell, masses and species: vectors of each particle at each time, and
#: the radii of hard spheres.
QUANTITIES = ("velocities", "radius", "angular_velocities")


@dataclass(frozen=True)
class Format:
    """A file format of trajectories.

    suffix: of its files, without the dot; its name at the same time. write(path, trajectory): writes the file. holds:
    which of `QUANTITIES` it can hold; the writer gets no others.
    """

    suffix: str
    write: Callable[[Path, Trajectory], None]
    holds: tuple[str, ...]


def write_trajectories(directory: Path, name: str, scene: Scene, run: Run) -> list[Path]:
    """Writes the trajectory of a run in every format; returns the paths, none for a run without a trajectory.

    Of a run that diverged or stopped, the samples before are written. directory: of the files. name: part of their
    names, trajectory-name.suffix. scene: what was run. run: what the engine returned.
    """
    trajectory = trajectory_of(scene, run)
    if trajectory is None:
        return []
    paths = []
    for form in FORMATS:
        path = directory / f"trajectory-{name}.{form.suffix}"
        held = {name: values for name, values in trajectory.more.items() if name in form.holds}
        form.write(path, replace(trajectory, more=held))
        paths.append(path)
    return paths


def trajectory_of(scene: Scene, run: Run) -> Trajectory | None:
    """The trajectory that `run`, a run of `scene`, recorded; None if it recorded none."""
    positions, velocities = run.get("positions"), run.get("velocities")
    spins = run.get("angular_velocities")
    if positions is None:
        return None
    state = scene.own_start()
    cell, periodic = np.zeros(3), np.zeros(3, dtype=bool)
    if state.lengths is not None:
        cell[: scene.dimension] = state.lengths
        periodic[: scene.dimension] = [boundary == "periodic" for boundary in scene.boundaries]
    good = _good_samples(positions if velocities is None else np.concatenate([positions, velocities], axis=2))
    more: dict[str, Floats] = {}
    if velocities is not None:
        more["velocities"] = in_space(velocities[:good])
    if state.diameters is not None:
        more["radius"] = state.diameters / 2
    if spins is not None:
        more["angular_velocities"] = np.pad(spins[:good], ((0, 0), (0, 0), (3 - spins.shape[2], 0)))
    return Trajectory(run["time"][:good], in_space(positions[:good]), cell, periodic, state.masses, state.species, more)


def _good_samples(samples: Floats) -> int:
    """Number of samples, of (S, N, k), before the first one with a number that is not finite."""
    good = np.isfinite(samples).all(axis=(1, 2))
    return good.size if good.all() else int(np.argmin(good))


def in_space(vectors: Floats) -> Floats:
    """The vectors, (..., d), completed with zeros to (..., 3)."""
    return np.pad(vectors, ((0, 0),) * (vectors.ndim - 1) + ((0, 3 - vectors.shape[-1]),))


# -- writers -------------------------------------------------------------------------------------------------


def write_extxyz(path: Path, trajectory: Trajectory) -> None:
    """Writes a trajectory to `path` as extended XYZ, which ASE and OVITO read; positions are not wrapped.

    Every number is the shortest decimal that reads back to the same bits: ASE's own writer keeps eight decimals.

    trajectory: what to write. Species 0, 1, ... are named H, He, ...; without species the particles are called X.
    Velocities are also written as momenta, which is what ASE reads.
    """
    number = len(trajectory.masses)
    names = _symbols(trajectory)
    lattice = ""
    if trajectory.cell.any():
        lattice = f'Lattice="{" ".join(_decimals(np.diag(trajectory.cell).ravel()))}" '
    around = " ".join("T" if one else "F" for one in trajectory.periodic)
    with path.open("w", encoding="utf-8") as file:
        for sample, time in enumerate(trajectory.time):
            columns = {"pos": trajectory.positions[sample], "masses": trajectory.masses}
            for name, values in trajectory.more.items():
                now = values if values.ndim == 1 else values[sample]
                if name == "velocities":
                    columns["momenta"] = now * trajectory.masses[:, None]
                columns[name] = now
            table = np.column_stack([values.reshape(number, -1) for values in columns.values()])
            widths = [f"{name}:R:{values.size // number}" for name, values in columns.items()]
            properties = ":".join(["species:S:1", *widths])
            file.write(f'{number}\n{lattice}Properties={properties} time={float(time)!r} pbc="{around}"\n')
            file.writelines(f"{name} {' '.join(_decimals(row))}\n" for name, row in zip(names, table, strict=True))


def _decimals(values: Floats) -> list[str]:
    """The shortest decimals that read back to the same doubles."""
    return list(map(repr, values.tolist()))


def _symbols(trajectory: Trajectory) -> list[str]:
    from ase.data import chemical_symbols

    if trajectory.species is None:
        return ["X"] * len(trajectory.masses)
    return [chemical_symbols[one + 1] for one in trajectory.species]


#: Every format in which `simulate` writes a trajectory.
FORMATS = (Format("extxyz", write_extxyz, holds=("velocities", "radius", "angular_velocities")),)
