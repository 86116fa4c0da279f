"""Which runs `simulate` makes: each engine with the method that is its own, or that of the scene."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from crosscheck.engines.capabilities import scheme_of
from crosscheck.engines.protocol import Engine, Kind
from crosscheck.engines.registry import engine_class
from crosscheck.errors import UsageError
from crosscheck.scene import Method, Scene
from crosscheck.scene.messages import explain
from crosscheck.simulate.files import clean, file_labels
from crosscheck.text import shortened

#: Kinds of schemes in the order in which one is proposed.
_KINDS: tuple[Kind, ...] = ("event_driven", "lattice", "stepping", "adaptive", "collision_search")


@dataclass(frozen=True)
class Planned:
    """A run that is to be made.

    engine: its name, or path.py:Class. label: of the run, part of the names of its files; no two runs have the same.
    scene: with the run's own method. method: that method.
    """

    engine: str
    label: str
    scene: Scene
    method: Method


def planned(scene: Scene, engines: Sequence[str], texts: Sequence[str] = ()) -> list[Planned]:
    """The runs of a scene, in the order of the engines: one of each, and one for each method where it has several.

    scene: gives the method of engines without one of their own. engines: names, or path.py:Class. texts: methods as
    they are written on the command line, "engine:key=value,..." for one engine, "key=value,..." for all that have none
    of their own. The keys are those of [method], "contact.stiffness" those of [method.contact]; without a scheme they
    change entries of the scene's method.

    UsageError for an engine that is named twice or not at all, for a method that is not valid, for a run without a
    method, and for a method that an engine has twice.
    """
    if len(set(map(_identity, engines))) < len(engines):
        raise UsageError(
            f"--engine: {', '.join(engines)}: name each engine once; for several methods of one engine, give --method "
            f"{engines[0]}:scheme=... for each of them"
        )
    own, common = _assigned(engines, texts)
    if common and all(own.values()):
        raise UsageError(
            f"--method {shortened(common[0][0])}: every engine has a method of its own: remove one of them"
        )
    labels = file_labels(engines)
    plan: list[Planned] = []
    for engine in engines:
        given = own[engine] or common
        methods = [_read(text, entries, scene) for text, entries in given] or [_of_scene(scene, engine)]
        names = _labels(labels[engine], methods)
        for k, (name, method) in enumerate(zip(names, methods, strict=True)):
            if method in methods[:k]:
                raise UsageError(f"--method {given[k][0]}: {engine} has this method twice: remove one of them")
            if name.casefold() in {one.label.casefold() for one in plan}:  # of long ones, the end is the same
                name = f"{len(plan) + 1}-{name}"
            plan.append(Planned(engine, name, scene.model_copy(update={"method": method}), method))
    return plan


def _identity(engine: str) -> str:
    """The same text for two spellings of one engine."""
    return str(Path(engine).resolve()) if ".py:" in engine else engine


#: A method as it was written, and its entries.
_Given = tuple[str, str]


def _assigned(engines: Sequence[str], texts: Sequence[str]) -> tuple[dict[str, list[_Given]], list[_Given]]:
    """The methods of each engine, and those of all; each whole, and without the name of the engine."""
    own: dict[str, list[_Given]] = {engine: [] for engine in engines}
    common: list[_Given] = []
    for text in texts:
        head, _, _ = text.partition("=")
        if ":" not in head:
            common.append((text, text))
            continue
        name = head.rpartition(":")[0]
        found = next((engine for engine in engines if _identity(engine) == _identity(name)), None)
        if found is None:
            raise UsageError(
                f"--method {shortened(text)}: engine {shortened(name)} takes no part, only {', '.join(engines)}: add "
                f"--engine {shortened(name)}, or mend the name"
            )
        own[found].append((text, text[len(name) + 1 :]))
    return own, common


def _read(text: str, entries: str, scene: Scene) -> Method:
    """The method with these entries. text: all that was given, for messages."""
    where = f"--method {shortened(text, 200)}"
    table: dict[str, Any] = {}
    for entry in entries.split(","):
        key, equals, value = entry.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise UsageError(
                f"{where}: '{shortened(entry)}' is not key=value: give, say, scheme=velocity_verlet,dt=0.005"
            )
        *tables, last = key.strip().split(".")
        inner = table
        for name in tables:
            inner = inner.setdefault(name, {})
            if not isinstance(inner, dict):
                raise UsageError(f"{where}: '{shortened(name)}' is a value and a table: remove one of them")
        if last in inner:
            raise UsageError(f"{where}: '{shortened(key.strip())}' is there twice: remove one of them")
        inner[last] = _value(value.strip())
    if "scheme" not in table and scene.method is not None:
        of_scene = json.loads(scene.method.model_dump_json(exclude_none=True))
        contact = {**of_scene.get("contact", {}), **table.get("contact", {})}
        table = {**of_scene, **table, **({"contact": contact} if contact else {})}
    try:
        return Method.model_validate_json(json.dumps(table))
    except ValidationError as error:
        raise UsageError(explain(error, where, Method)) from None


def _value(text: str) -> str | int | float | bool:
    """A value as TOML has it; a text may be without quotes."""
    try:
        value = tomllib.loads(f"x = {text}")["x"]
    except ValueError:
        return text
    return value if isinstance(value, str | int | float | bool) else text


def _labels(engine: str, methods: Sequence[Method]) -> list[str]:
    """The label of each run of an engine: its own, or where it has several methods, with what tells them apart."""
    if len(methods) == 1:
        return [engine]
    entries = [_flat(json.loads(method.model_dump_json(exclude_none=True))) for method in methods]
    keys = dict.fromkeys(key for one in entries for key in one if key != "scheme")
    telling = [key for key in keys if len({one.get(key) for one in entries}) > 1]
    return [
        clean("-".join([engine, one["scheme"], *(f"{key}{one[key]}" for key in telling if key in one)]))
        for one in entries
    ]


def _flat(table: dict[str, Any], path: str = "") -> dict[str, str]:
    """Entries by dotted names, as texts."""
    found: dict[str, str] = {}
    for key, value in table.items():
        found |= _flat(value, f"{path}{key}.") if isinstance(value, dict) else {f"{path}{key}": str(value)}
    return found


def _of_scene(scene: Scene, engine: str) -> Method:
    """The scene's own method; UsageError, with an example of one, if it has none."""
    if scene.method is not None:
        return scene.method
    example = 'scheme and dt, as in scheme = "velocity_verlet", dt = 0.005'
    if scene.hard_spheres is not None:
        example = 'scheme = "event_driven"'
    elif scene.lattice_gas is not None:
        example = 'scheme = "lattice_planes"'
    raise UsageError(f"scene {scene.name}: add [method] with {example}, or give --method {_proposed(scene, engine)}")


def mend(scene: Scene, engine: str, method: Method) -> str:
    """What to give to an engine that cannot run a scene for want of the scheme; "" if that is not the reason.

    scene: what was to be run. engine: its name. method: that it does not have, or not for such a scene.
    """
    found = engine_class(engine)
    claims = found.schemes.get(method.scheme)
    if claims is not None and scheme_of(found, scene.interaction, claims.kind) is not None:
        return ""
    if all(scheme_of(found, scene.interaction, kind) is None for kind in _KINDS):
        return ""
    return f": give it a method of its own, as --method {_proposed(scene, engine)}"


def _proposed(scene: Scene, engine: str) -> str:
    """A method of an engine, for a scene, as an example of what may be given."""
    found: type[Engine] = engine_class(engine)
    schemes = ((kind, scheme_of(found, scene.interaction, kind)) for kind in _KINDS)
    kind, scheme = next(((kind, scheme) for kind, scheme in schemes if scheme is not None), ("stepping", "..."))
    entries = [f"scheme={scheme}"]
    if kind in ("stepping", "collision_search"):
        if scene.hard_spheres is not None and kind == "stepping":
            entries += ["contact.duration=0.01", "contact.resolution=0.02"]
        else:
            entries.append(f"dt={(scene.output.interval or scene.duration or 1.0) / 100:.6g}")
    elif kind == "adaptive":
        entries.append("tolerance=1e-9")
    return f"{engine}:{','.join(entries)}"
