"""List of all TOML tables of the scene language, derived from the fields of the models."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple, get_args, get_origin

from crosscheck.scene.parts import Part

#: Place holders in the path of a table: the key of a table of tables, and the index of an array of tables.
ANY_KEY, ANY_INDEX = "*", "#"


class Table(NamedTuple):
    """A table and its place in a scene.

    path: names from the scene down, () for the scene itself; a table with `kind` has the kind for its last name. title:
    as it is written in a scene file. part: its model.
    """

    path: tuple[str, ...]
    title: str
    part: type[Part]

    def matches(self, place: tuple[int | str, ...]) -> bool:
        """Whether `place`, that of a validation error, as ("lattice_gas", "obstacles", 0), is this table."""
        return len(place) == len(self.path) and all(
            name in (ANY_KEY, found) or (name == ANY_INDEX and isinstance(found, int))
            for name, found in zip(self.path, place, strict=True)
        )


@cache
def tables(scene: type[Part]) -> tuple[Table, ...]:
    """All tables of a scene: itself first, and each table before those within it. scene: its model."""
    return (Table((), "", scene), *_below(scene, (), ""))


def _below(part: type[Part], path: tuple[str, ...], name: str) -> Iterator[Table]:
    for word, field in part.model_fields.items():
        dotted = f"{name}.{word}" if name else word
        for below, suffix, inner in _parts(field.annotation):
            inner_path, inner_name = (*path, word, *below), dotted + suffix
            title = f"[[{inner_name}]]" if below[-1:] == (ANY_INDEX,) else f"[{inner_name}]"
            if "kind" in inner.model_fields:
                (kind,) = get_args(inner.model_fields["kind"].annotation)
                inner_path, title = (*inner_path, kind), f'{title} kind = "{kind}"'
            yield Table(inner_path, title, inner)
            yield from _below(inner, inner_path, inner_name)


def _parts(annotation: Any) -> Iterator[tuple[tuple[str, ...], str, type[Part]]]:
    """The models within the type of a field, each with what its path and its dotted name add to those of the field."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        yield (), "", annotation
        return
    arguments = get_args(annotation)
    if get_origin(annotation) is dict:
        for below, suffix, part in _parts(arguments[1]):
            yield (ANY_KEY, *below), f'."x-"{suffix}', part
    elif get_origin(annotation) is tuple:
        for below, suffix, part in _parts(arguments[0]):
            yield (ANY_INDEX, *below), suffix, part
    else:
        for argument in arguments:
            yield from _parts(argument)
