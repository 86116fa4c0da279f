"""What an engine declares that it can do, and what a scene asks of it.

A scene is made of *words*: the entries of its tables by their dotted names, `hard_spheres.friction`,
`box.boundaries=hard`, `method.contact.law=hooke`. They are read off the scene's models, so that a new entry of the
scene language is a new word, which no engine has declared: it never reaches an engine that has not heard of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_args, get_origin

from crosscheck.scene import Method, Scene
from crosscheck.scene.observables import TABLE
from crosscheck.scene.parts import Part

#: Entries that every engine meets through `Scene.initial_state`, `lengths`, `samples`, `steps` and `asked`, or that the
#: suite itself acts on.
_THROUGH_THE_SCENE = {
    "name",
    "duration",
    "species",
    "seed",
    "masses",
    "box",
    "box.lengths",
    "box.density",
    "box.packing_fraction",
    "box.boundaries",
    "initial",
    "lennard_jones.tail_corrections",
    "method",
    "output",
}


@dataclass(frozen=True)
class Capability:
    """Scenes of one interaction that an engine can run, with schemes of one kind.

    interaction: the table of the scene. words: those that such a scene may use, beside what every scene has (see
    `words`). observables: what can be measured: names of `scene.observables.TABLE`. schemes: those that serve; empty:
    all of the engine whose kind is `kind`.
    """

    interaction: str
    kind: str
    words: frozenset[str]
    observables: frozenset[str]
    schemes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        unknown = sorted(self.observables - set(TABLE))
        if unknown:
            raise ValueError(f"capability for [{self.interaction}]: there is no observable {', '.join(unknown)}")


def capability(
    interaction: str, kind: str, *, words: str, observables: str, schemes: tuple[str, ...] = ()
) -> Capability:
    """A `Capability` whose words and observables are given in one text each, apart by spaces."""
    return Capability(interaction, kind, frozenset(words.split()), frozenset(observables.split()), schemes)


#: An engine or its class, `Engine` of the protocol, which builds on this module.
Declared = Any


def words(scene: Scene, method: Method | None = None) -> frozenset[str]:
    """The words of a scene, and of the method's contact.

    An entry at its default is no word, but for a choice among names, which is `entry=choice`. "entry[]": one value for
    each species, and "masses[]": unlike masses. Entries that have no default belong to their table.
    """
    found = set(_walk(scene, ""))
    found.discard(scene.interaction)
    found.add(f"dimension={scene.dimension}")
    if scene.box is not None:
        found |= {f"box.boundaries={boundary}" for boundary in scene.boundaries}
    if not isinstance(scene.masses, float):
        found |= {"masses[]"} if len(set(scene.masses)) > 1 else set()
        found |= {"masses=0"} if 0.0 in scene.masses else set()
    if scene.output.collisions is not None:
        found.add("output.collisions")
    if scene.output.fields is not None and scene.lattice_gas is None:
        found.add("output.fields")
    if method is not None and method.contact is not None:
        found |= {"method.contact", *_walk(method.contact, "method.contact.")}
    return frozenset(found)


def _walk(part: Part, path: str) -> Iterator[str]:
    for name, field in type(part).model_fields.items():
        entry, value = f"{path}{name}", getattr(part, name)
        if entry in ("initial", "output", "method", "masses"):
            continue
        named = entry not in _THROUGH_THE_SCENE
        if isinstance(value, Part):
            if named:
                yield entry
            yield from _walk(value, f"{entry}.")
        elif isinstance(value, dict) or (isinstance(value, tuple) and value and isinstance(value[0], Part)):
            yield entry
            for one in value.values() if isinstance(value, dict) else value:
                yield from _walk(one, f"{entry}.")
        elif not named or field.is_required() or value is None:
            continue
        elif isinstance(value, str):
            yield f"{entry}={value}"
        elif value != field.default:
            many = isinstance(value, tuple) and _or_one(field.annotation)
            if many and len(value) == 1:
                if value[0] != field.default:
                    yield entry
            else:
                yield f"{entry}[]" if many else entry


def _or_one(annotation: Any) -> bool:
    """The entry takes one value, or a tuple of them."""
    forms = [form for form in get_args(annotation) if form is not type(None)]
    return any(get_origin(form) is tuple for form in forms) and any(get_origin(form) is not tuple for form in forms)


def measured(scene: Scene) -> frozenset[str]:
    """Observables that an engine must measure for this scene: what can be derived is replaced by what it needs."""
    names: set[str] = set()
    for name, row in scene.asked().items():
        if row.derive is not None:
            names.update(row.needs)
        elif row.refusable and row.asked != "fields":
            names.add(name)
    return frozenset(names)


def refusal(engine: Declared, scene: Scene, method: Method) -> str | None:
    """None, or why an engine that declares these capabilities is not given this scene."""
    claims = engine.schemes.get(method.scheme)
    if claims is None:
        return f"no scheme '{method.scheme}'; it has {', '.join(engine.schemes)}"
    fitting = [one for one in _offered(engine, method.scheme, claims) if one.interaction == scene.interaction]
    if not fitting:
        able = sorted({f"[{one.interaction}]" for one in _offered(engine, method.scheme, claims)})
        return f"its scheme '{method.scheme}' is for {' and '.join(able) or 'nothing'}, not for [{scene.interaction}]"
    lacking = [sorted(words(scene, method) - one.words) + sorted(measured(scene) - one.observables) for one in fitting]
    least = min(lacking, key=len)
    return f"it declares no {', no '.join(least)} for [{scene.interaction}]" if least else None


def _offered(engine: Declared, scheme: str, claims: Any) -> list[Capability]:
    return [one for one in engine.capabilities if (scheme in one.schemes if one.schemes else one.kind == claims.kind)]


@dataclass(frozen=True)
class Needs:
    """What a check asks of an engine: scenes of this interaction, moved by schemes of one of these kinds.

    words, observables: those without which no variant of the check can be run. schemes: names that the engine must
    have. promises: what the engine must have promised of itself, `Engine.promises`: a speed is judged where it is
    claimed.
    """

    interaction: str
    kinds: tuple[str, ...] = ("stepping",)
    words: frozenset[str] = frozenset()
    observables: frozenset[str] = frozenset()
    schemes: tuple[str, ...] = ()
    promises: tuple[str, ...] = ()


def lacks(engine: Declared, needs: Needs) -> str | None:
    """None, or what of the needs of a check the engine does not declare."""
    absent = [scheme for scheme in needs.schemes if scheme not in engine.schemes]
    if absent:
        return f"no scheme {', '.join(absent)}"
    unkept = [promise for promise in needs.promises if promise not in getattr(engine, "promises", ())]
    if unkept:
        return f"does not promise {', '.join(unkept)}"
    fitting = [one for one in engine.capabilities if one.interaction == needs.interaction and one.kind in needs.kinds]
    if not fitting:
        return f"no {' or '.join(needs.kinds)} scheme for [{needs.interaction}]"
    lacking = [sorted(needs.words - one.words) + sorted(needs.observables - one.observables) for one in fitting]
    least = min(lacking, key=len)
    return f"no {', no '.join(least)}" if least else None


def scheme_of(engine: Declared, interaction: str, kind: str) -> str | None:
    """The engine's first scheme of this kind that serves the interaction; None without one."""
    for name, claims in engine.schemes.items():
        if claims.kind == kind and any(one.interaction == interaction for one in _offered(engine, name, claims)):
            return str(name)
    return None
