"""Restart files: a run goes on from one with the same bits as a run without a break. See docs/restart.md."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crosscheck.engines.soft_spheres import resolved
from crosscheck.engines.workers.states import HEADER
from crosscheck.errors import UsageError
from crosscheck.scene import Method, Scene
from crosscheck.trajectories.frames import first_line

#: What the header says that the file is, and the version of its layout.
FORMAT, VERSION = "crosscheck restart", 1
#: Entries of a scene in which the two runs may differ.
_FREE = ("name", "duration", "output", "initial", "method")
#: Entries of the header, and their types.
_ENTRIES: dict[str, type | tuple[type, ...]] = {
    "format": str, "version": int, "engine": str, "engine_version": str, "method": dict, "time": (int, float),
    "scene": dict, "initial": dict,
}  # fmt: skip


@dataclass(frozen=True)
class Restart:
    """A restart file that has been read.

    path: of the file. engine, engine_version: who wrote it. method: scheme, dt and contact, as JSON. time: since the
    very first start, in units of the scene. scene: entries that are part of the physics, as JSON. initial: those of the
    initial state of the very first run.
    """

    path: Path
    engine: str
    engine_version: str
    method: dict[str, Any]
    time: float
    scene: dict[str, Any]
    initial: dict[str, Any]


def read_restart(path: Path) -> Restart:
    """The header of a restart file, after a check of all its sums. path: of the file.

    UsageError, of one line, if it cannot be read, is damaged, is no restart file, or has another version.
    """
    try:
        if not path.is_file():
            raise OSError("there is no such file" if not path.exists() else "it is not a regular file")
        with zipfile.ZipFile(path) as file:
            damaged = file.testzip()
            if damaged is not None:
                raise ValueError(f"{damaged} is damaged")
            header = json.loads(file.read(HEADER))
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise ValueError(f"its {HEADER} does not say that it is one")
    except (OSError, ValueError, KeyError, EOFError, RecursionError, NotImplementedError, zipfile.BadZipFile) as error:
        raise UsageError(f"{path}: not a whole restart file ({first_line(error)})") from None
    if header.get("version") != VERSION:
        raise UsageError(f"{path}: its layout has the version {header.get('version')!r}, this program reads {VERSION}")
    for name, kind in _ENTRIES.items():
        if not isinstance(header.get(name), kind):
            raise UsageError(f"{path}: {HEADER}: '{name}' is missing or of another type")
    return Restart(path, **{name: header[name] for name in Restart.__dataclass_fields__ if name != "path"})


def going_on(restart: Restart, scene: Scene, method: Method, engines: Sequence[str]) -> Scene:
    """The scene that goes on from a restart file: with the initial state of the very first run.

    restart: the file. scene, method: what is to run. engines: their names. UsageError if another engine, method or
    scene wrote it; name, duration, output and initial state may differ.
    """
    if list(engines) != [restart.engine]:
        raise UsageError(
            f"{restart.path}: was written by engine {restart.engine}, and is of no use to {', '.join(engines)}: "
            f"give --engine {restart.engine} alone"
        )
    for what, there, here in (
        ("method", restart.method, _method(scene, method)),
        ("scene", restart.scene, _physics(scene)),
    ):
        difference = next(_differences(there, here), None)
        if difference is not None:
            raise UsageError(f"{restart.path}: was written with another {what}: {difference}")
    table = json.loads(scene.to_json())
    return Scene.from_json(json.dumps({**table, "initial": restart.initial}), f"{restart.path}: initial")


def check_version(restart: Restart, version: str) -> None:
    """UsageError if another version of the engine wrote the file. restart: the file. version: of the engine."""
    if restart.engine_version != version:
        raise UsageError(
            f"{restart.path}: was written by {restart.engine} {restart.engine_version}, this is {version}: another "
            "version need not give the same bits; run the first part again"
        )


def _method(scene: Scene, method: Method) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(resolved(scene, method).model_dump_json(exclude_defaults=True))
    return found


def _physics(scene: Scene) -> dict[str, Any]:
    """Entries that decide how the state goes on, as JSON."""
    table: dict[str, Any] = json.loads(scene.to_json())
    fields = table.get("output", {}).get("fields")
    for name in _FREE:
        table.pop(name, None)
    if scene.lattice_gas is not None:
        table["lattice_gas"].pop("reversals", None)
    elif fields is not None:
        table["output.fields"] = fields  # of hard spheres, they decide the cells of the event-driven algorithm
    return table


def _differences(there: Any, here: Any, path: str = "") -> Iterator[str]:
    """Where two JSON values differ, as "box.lengths is [1.0] there, [2.0] here"."""
    if isinstance(there, dict) and isinstance(here, dict):
        for name in sorted({*there, *here}):
            yield from _differences(there.get(name), here.get(name), f"{path}.{name}" if path else name)
    elif there != here:
        yield f"{path} is {_shortened(there)} there, {_shortened(here)} here"


def _shortened(value: Any) -> str:
    text = "absent" if value is None else json.dumps(value)
    return text if len(text) <= 40 else f"{text[:40]} ..."


def write_restart(path: Path, state: Path, scene: Scene, method: Method, engine: tuple[str, str], time: float) -> None:
    """Writes a restart file, in one move: there is never half of one.

    path: of the file. state: file with the arrays of the state, see `Restartable`; it is left as it is. scene, method:
    what was run, the scene with the initial state of the very first run. engine: name and version. time: of the state
    since the very first start, in units of the scene.
    """
    header = {
        "format": FORMAT,
        "version": VERSION,
        "engine": engine[0],
        "engine_version": engine[1],
        "method": _method(scene, method),
        "time": time,
        "scene": _physics(scene),
        "initial": json.loads(scene.to_json())["initial"],
    }
    part = path.with_name(f".{path.name}.part")
    try:
        shutil.copyfile(state, part)
        with zipfile.ZipFile(part, "a") as archive:
            archive.writestr(HEADER, json.dumps(header, indent=1))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
