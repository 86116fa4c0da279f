"""What an engine declares that it can do, and what a scene asks of it.

A scene is made of *words*: the entries of its tables by their dotted names, `hard_spheres.friction`,
`box.boundaries=hard`, `method.contact.law=hooke`. They are read off the scene's models, so that a new entry of the
scene language is a new word. No engine that was written before declares it, so scenes with it are refused for them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any, get_args, get_origin

from crosscheck.scene import Method, Scene
from crosscheck.scene.observables import TABLE
from crosscheck.scene.parts import Part

#: Entries that engines need not declare: what they mean reaches every engine by the methods of `Scene` (initial_state,
#: lengths, samples, steps, asked), or the suite itself acts on them.
_NOT_DECLARED = {
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

    interaction: name of the table, as "gravity". kind: of the schemes, see `crosscheck.engines.protocol.Kind`. words:
    those that such a scene may use, see the function `words`. observables: what the engine measures, names of
    `scene.observables.TABLE`. schemes: names of the schemes that can run these scenes; empty: all that are of this
    kind. ValueError for an observable that is not in the table.
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
    """A `Capability` from texts.

    words, observables: names separated by white space. interaction, kind, schemes, ValueError: as in `Capability`.
    """
    return Capability(interaction, kind, frozenset(words.split()), frozenset(observables.split()), schemes)


#: An engine or its class. `Any`, since the protocol `Engine` is in a module that imports this one.
Declared = Any


def words(scene: Scene, method: Method | None = None) -> frozenset[str]:
    """The words that `scene` uses, and those of `method` beside scheme and step; method None: the scene's alone.

    An entry is a word where its value differs from its default: `gravity.softening`. An entry whose value is one of
    several names is always a word, `entry=choice`: `box.boundaries=hard`. `entry[]`: one value per species; `masses[]`:
    masses that differ; `masses=0`: a mass of 0. An entry without a default is no word of its own: whoever declares its
    table can read it.
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
    if method is not None and method.threads is not None:
        found.add("method.threads")
    if method is not None and method.compensated:
        found.add("method.compensated")
    if method is not None and method.contact is not None:
        found |= {"method.contact", *_walk(method.contact, "method.contact.")}
    return frozenset(found)


def _walk(part: Part, path: str) -> Iterator[str]:
    """The words of a table and of those within it. path: what their names start with."""
    for name, field in type(part).model_fields.items():
        entry, value = f"{path}{name}", getattr(part, name)
        if entry in ("initial", "output", "method", "masses"):
            continue
        named = entry not in _NOT_DECLARED
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
            per_species = isinstance(value, tuple) and _takes_one_or_many(field.annotation)
            if per_species and len(value) == 1:
                if value[0] != field.default:
                    yield entry
            else:
                yield f"{entry}[]" if per_species else entry


def _takes_one_or_many(annotation: Any) -> bool:
    """Whether an entry of this type takes one value as well as a tuple of values."""
    forms = [form for form in get_args(annotation) if form is not type(None)]
    return any(get_origin(form) is tuple for form in forms) and any(get_origin(form) is not tuple for form in forms)


def measured(scene: Scene) -> frozenset[str]:
    """Names of the observables that an engine must measure for `scene`.

    An observable that the suite derives from others is replaced by these.
    """
    names: set[str] = set()
    for name, row in scene.asked().items():
        if row.derive is not None:
            names.update(row.needs)
        elif row.refusable and row.asked != "fields":
            names.add(name)
    return frozenset(names)


def refusal(engine: Declared, scene: Scene, method: Method) -> str | None:
    """None, or why the suite does not give this scene to this engine.

    engine: an engine or its class. scene: what to run. method: its scheme must be one of the engine's.
    """
    claims = engine.schemes.get(method.scheme)
    if claims is None:
        return f"no scheme '{method.scheme}'; it has {', '.join(engine.schemes)}"
    candidates = [one for one in _offered(engine, method.scheme, claims) if one.interaction == scene.interaction]
    if not candidates:
        able = sorted({f"[{one.interaction}]" for one in _offered(engine, method.scheme, claims)})
        return f"its scheme '{method.scheme}' is for {' and '.join(able) or 'nothing'}, not for [{scene.interaction}]"
    absent = [
        sorted(words(scene, method) - one.words) + sorted(measured(scene) - one.observables) for one in candidates
    ]
    fewest = min(absent, key=len)
    return f"it declares no {', no '.join(fewest)} for [{scene.interaction}]" if fewest else None


def _offered(engine: Declared, scheme: str, claims: Any) -> list[Capability]:
    """The capabilities of the engine that this scheme, with these claims, has."""
    return [one for one in engine.capabilities if (scheme in one.schemes if one.schemes else one.kind == claims.kind)]


@dataclass(frozen=True)
class Needs:
    """What a check asks of an engine.

    interaction, kinds: scenes of this interaction, moved by schemes of one of these kinds. words, observables: those
    without which no variant of the check can be run. schemes: names of schemes that the engine must have. promises:
    names that the engine's attribute `promises` must hold; "speed": its speed may be judged; "interpretable": where the
    environment has NUMBA_DISABLE_JIT, it runs as plain Python, for scenes too small to be worth a compilation;
    "operations": it counts them exactly, in `Cost`; "restarts": it goes on with the same bits, see
    `protocol.Restartable`; "remarks_on_order": it remarks on events at one time whose order decides what follows;
    "remarks_on_contacts": it remarks on soft contacts of less than ten steps, and on restitutions that have no use;
    "impulses_after_steps": its searches for collisions do what `crosscheck.references.collision_steps` says;
    "springs_turned_at_walls": tangential springs at walls are turned first, see `crosscheck.references.soft_grains`;
    "cut_to_the_scene": it is `refimpl`, whose compiled loops have no trace of what a scene does not have.
    """

    interaction: str
    kinds: tuple[str, ...] = ("stepping",)
    words: frozenset[str] = frozenset()
    observables: frozenset[str] = frozenset()
    schemes: tuple[str, ...] = ()
    promises: tuple[str, ...] = ()


def lacks(engine: Declared, needs: Needs, waived: Collection[str] = ()) -> str | None:
    """None, or which of the needs of a check the engine (or its class) does not declare.

    waived: promises that are not asked for.
    """
    absent = [scheme for scheme in needs.schemes if scheme not in engine.schemes]
    if absent:
        return f"no scheme {', '.join(absent)}"
    promised = {*getattr(engine, "promises", ()), *waived}
    unpromised = [promise for promise in needs.promises if promise not in promised]
    if unpromised:
        return f"does not promise {', '.join(unpromised)}"
    candidates = [
        one for one in engine.capabilities if one.interaction == needs.interaction and one.kind in needs.kinds
    ]
    if not candidates:
        return f"no {' or '.join(needs.kinds)} scheme for [{needs.interaction}]"
    lacking = [sorted(needs.words - one.words) + sorted(needs.observables - one.observables) for one in candidates]
    fewest = min(lacking, key=len)
    return f"no {', no '.join(fewest)}" if fewest else None


def schemes_for(engine: Declared, interaction: str, kind: str) -> list[str]:
    """Names of the schemes of this kind with which the engine (or its class) runs the interaction, in its order."""
    return [
        str(name)
        for name, claims in engine.schemes.items()
        if claims.kind == kind and any(one.interaction == interaction for one in _offered(engine, name, claims))
    ]


def scheme_of(engine: Declared, interaction: str, kind: str) -> str | None:
    """Name of the first scheme of this kind with which the engine (or its class) runs the interaction; None: none."""
    return next(iter(schemes_for(engine, interaction, kind)), None)


def measured_by(engine: Declared, interaction: str, scheme: str) -> frozenset[str]:
    """What the engine (or its class) measures of scenes of an interaction with a scheme: names of observables."""
    offered = _offered(engine, scheme, engine.schemes[scheme])
    return frozenset().union(*(one.observables for one in offered if one.interaction == interaction))
