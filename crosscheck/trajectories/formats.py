"""The formats in which a trajectory is written: a file each in `writers/`, found by being there.

To add one: a file `writers/<name>.py` with its record, `FORMAT`; its name is that of the file.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from crosscheck.engines.protocol import Run
from crosscheck.errors import UsageError
from crosscheck.scene import Method, Scene
from crosscheck.text import shortened
from crosscheck.trajectories import writers
from crosscheck.trajectories.trajectory import Trajectory, trajectory_of

#: What `simulate` writes if nobody says otherwise.
DEFAULT = ("extxyz",)


@dataclass(frozen=True)
class Format:
    """A file format of trajectories.

    suffix: of its files, without the dot. write(path, trajectory): writes the file; None: `simulate` writes this
    trajectory anyway, as a part of another file. holds: which of `QUANTITIES` it can hold; the writer gets no others.
    package: what must be installed to write it; None: nothing more.
    """

    suffix: str
    write: Callable[[Path, Trajectory], None] | None
    holds: tuple[str, ...] = ()
    package: str | None = None


@cache
def formats() -> dict[str, Format]:
    """Every format by its name."""
    return {name: importlib.import_module(f"{writers.__name__}.{name}").FORMAT for name in writers.names()}


def check_formats(names: Sequence[str], scene: Scene) -> None:
    """UsageError unless a run of this scene can be written in these formats.

    names: of formats, as `--format` takes them. scene: what is to be run.
    """
    for name in names:
        if name not in formats():
            raise UsageError(f"--format {shortened(name)}: unknown; take {', '.join(formats())}")
        package = formats()[name].package
        if package is not None and importlib.util.find_spec(package) is None:
            raise UsageError(f"--format {name}: the package {package} is missing: pip install {package}")
    if not names or scene.output.trajectory:
        return
    if scene.lattice_gas is not None:
        raise UsageError(
            f"--format {names[0]}: scene {scene.name} is a lattice gas, whose particles have no trajectories: "
            "leave out --format"
        )
    sampled = scene.output.interval is not None or scene.output.collisions is not None
    raise UsageError(
        f"--format {names[0]}: scene {scene.name} records no trajectory: set output.trajectory = true"
        + ("" if sampled else ", and output.interval")
    )


def write_trajectories(
    directory: Path,
    name: str,
    scene: Scene,
    run: Run,
    method: Method | None = None,
    names: Sequence[str] = DEFAULT,
) -> list[Path]:
    """Writes the trajectory of a run; returns the paths of the files, none for a run without a trajectory.

    Of a run that diverged or stopped, the samples before are written. directory: of the files. name: part of their
    names, trajectory-name.suffix. scene: what was run. run: what the engine returned. method: of the run; None: that of
    the scene. names: of the formats, each written once.
    """
    trajectory = trajectory_of(scene, run, method)
    if trajectory is None:
        return []
    paths = []
    for form in map(formats().__getitem__, dict.fromkeys(names)):
        if form.write is None:
            continue
        path = directory / f"trajectory-{name}.{form.suffix}"
        held = {quantity: values for quantity, values in trajectory.more.items() if quantity in form.holds}
        form.write(path, replace(trajectory, more=held))
        paths.append(path)
    return paths
