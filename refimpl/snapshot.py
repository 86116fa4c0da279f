"""The state of a simulation as arrays by name, and back: enough to go on later with the same bits.

A state is nested tuples, records (`NamedTuple`) and mappings of arrays, numbers, texts and None. It is read off the
records themselves, so that a new field, or another type of an array, needs no change here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]

#: Bytes to which arrays that are made anew are aligned: a cache line.
_LINE = 64


def snapshot(state: Any) -> Arrays:
    """Copies of all arrays and numbers in `state`, by their dotted names, as "force.neighbours.order".

    state: as in the module's text. An array that occurs twice is there once, by its first name; None is not there.
    TypeError, with the name, for anything else.
    """
    found: Arrays = {}
    seen: set[int] = set()
    for name, value in _leaves("", state):
        if isinstance(value, np.ndarray):
            if id(value) in seen:
                continue
            seen.add(id(value))
        found[name] = np.array(value)
    return found


def restore(like: Any, arrays: Mapping[str, NDArray[Any]], growing: Collection[str] = ()) -> Any:
    """A state built as `like`, with the values of `arrays`.

    like: a state of the same simulation. Its arrays are filled in place, so that whoever shares one with it sees the
    change. arrays: of `snapshot`. growing: names of arrays, and of what contains arrays, that may be larger than those
    of `like`; these are then made anew. ValueError that names an array which is missing or has no place, or has another
    type or shape.
    """
    names = dict(_leaves("", like))
    filled: dict[int, Any] = {}
    left = set(arrays)
    values: dict[str, Any] = {}
    for name, old in names.items():
        if isinstance(old, np.ndarray) and id(old) in filled:
            values[name] = filled[id(old)]
            continue
        if name not in arrays:
            raise ValueError(f"array {name} is missing")
        left.discard(name)
        values[name] = _restored(name, old, arrays[name], any(_within(name, one) for one in growing))
        if isinstance(old, np.ndarray):
            filled[id(old)] = values[name]
    if left:
        raise ValueError(f"array {min(left)} has no place")
    return _rebuilt("", like, values)


def _within(name: str, whole: str) -> bool:
    return name == whole or name.startswith(f"{whole}.")


def _restored(name: str, old: Any, new: NDArray[Any], grows: bool) -> Any:
    wanted = np.asarray(old)
    if new.dtype.kind != wanted.dtype.kind or (wanted.dtype.kind != "U" and new.dtype != wanted.dtype):
        raise ValueError(f"array {name} has the type {new.dtype}, not {wanted.dtype}")
    larger = new.ndim == wanted.ndim and all(m >= n for m, n in zip(new.shape, wanted.shape, strict=True))
    if new.shape != wanted.shape and not (grows and larger):
        raise ValueError(f"array {name} has the shape {new.shape}, not {wanted.shape}")
    if not isinstance(old, np.ndarray):
        return type(old)(new[()])
    if new.shape != old.shape:
        raw = np.zeros(new.nbytes + _LINE, np.uint8)
        start = -raw.ctypes.data % _LINE
        old = raw[start : start + new.nbytes].view(new.dtype).reshape(new.shape)
    old[...] = new
    return old


def _inner(state: Any) -> Iterator[tuple[str, Any]] | None:
    """Names and values of what a tuple, record or mapping holds; None for anything else."""
    if isinstance(state, Mapping):
        return iter(state.items())
    if isinstance(state, tuple):
        return zip(getattr(state, "_fields", map(str, range(len(state)))), state, strict=True)
    return None


def _leaves(name: str, state: Any) -> Iterator[tuple[str, Any]]:
    inner = _inner(state)
    if inner is not None:
        for key, value in inner:
            yield from _leaves(f"{name}.{key}" if name else key, value)
    elif state is not None:
        if not isinstance(state, np.ndarray | np.generic | bool | int | float | str):
            raise TypeError(f"{name} is a {type(state).__name__}, which a snapshot cannot hold")
        yield name, state


def _rebuilt(name: str, like: Any, values: Mapping[str, Any]) -> Any:
    inner = _inner(like)
    if inner is None:
        return None if like is None else values[name]
    parts = {key: _rebuilt(f"{name}.{key}" if name else key, value, values) for key, value in inner}
    if isinstance(like, Mapping):
        return parts
    return type(like)(*parts.values()) if hasattr(like, "_fields") else tuple(parts.values())
