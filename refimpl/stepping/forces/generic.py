"""The functions of a force that an integrator calls, each implemented in the module of the force.

A force is a `typing.NamedTuple`: a plain record of parameters and work arrays. Each function here dispatches on its
class: in plain Python at run time, in a numba kernel at compile time. A `None` field is an absent feature: numba prunes
its branch from a function that gets the field as an argument (not as an attribute), so implementations unpack the
record and hand the fields on. `force`, the first argument of all, is such a record; r and v are its flat coordinates
and velocities; all units are those of the force's parameters.

State arrays are flat: `r` and `v` have shape `(N * d,)`, particle after particle. Flat arrays compile about three
times faster than two-dimensional ones, and a scheme that works on coordinates needs no shape.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numba.extending import overload

Implementation = TypeVar("Implementation", bound=Callable[..., Any])
#: A record of parameters and work arrays; what it can do is registered, so no protocol describes it.
Force: TypeAlias = Any

#: `status` values of a force, read by the step loop after every evaluation.
GOOD = 0
NEEDS_CAPACITY = 1  # a work array is too small: `enlarge` the force and repeat the step
DIVERGED = 2  # a coordinate is not finite, has leapt (`kernels.neighbours`), or is on the wrong side of a wall

_implementations: dict[Callable[..., Any], dict[type, Callable[..., Any]]] = {}
_defaults: dict[Callable[..., Any], Callable[..., Any]] = {}


def _dispatched(function: Implementation) -> Implementation:
    """Makes `function(force, ...)` dispatch on the class of `force`; its own body is the default."""
    table: dict[type, Callable[..., Any]] = {}

    @wraps(function)
    def call(force: Any, *arguments: Any) -> Any:
        return table.get(type(force), function)(force, *arguments)

    _implementations[call] = table
    _defaults[call] = function
    return call  # type: ignore[return-value]


def implements(function: Callable[..., Any], force_class: type) -> Callable[[Implementation], Implementation]:
    """Registers the decorated function as what `function`, one of this module, does for forces of `force_class`.

    The decorated function must be plain Python that numba can compile (it may call jitted kernels), with the argument
    names of `function`.
    """

    def register(implementation: Implementation) -> Implementation:
        _implementations[function][force_class] = implementation
        return implementation

    return register


def _compiled_implementation(function: Callable[..., Any], force: Any) -> Callable[..., Any] | None:
    force_class: Any = getattr(force, "instance_class", None)
    return _implementations[function].get(force_class, _defaults[function])


@_dispatched
def accelerate(force: Force, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Acceleration f(r, v)/m of every coordinate, shape (N*d,)."""
    raise NotImplementedError("this force has no acceleration")


@_dispatched
def potential_energy(force: Force, r: np.ndarray) -> float:
    """Total potential energy U(r)."""
    raise NotImplementedError("this force has no potential energy")


@_dispatched
def kinetic_energy(force: Force, v: np.ndarray) -> float:
    """Total kinetic energy K = sum m v^2 / 2, with the masses that the force holds."""
    raise NotImplementedError("this force holds no masses")


@_dispatched
def virial(force: Force, r: np.ndarray) -> float:
    """Virial W = sum over pairs of r_ij . F_ij; the pressure is (2 K + W)/(d V)."""
    raise NotImplementedError("this force has no virial")


@_dispatched
def energy_and_virial(force: Force, r: np.ndarray) -> tuple[float, float]:
    """U(r) and W(r) together; a force that finds both in one pass over its pairs implements this itself."""
    return potential_energy(force, r), virial(force, r)


@_dispatched
def derivatives(force: Force, r: np.ndarray, v: np.ndarray, count: int) -> np.ndarray:
    """The first `count` time derivatives r_3, r_4, ... of the coordinates, shape (count, N*d); by default zeros."""
    return np.zeros((count, r.size))


@_dispatched
def status(force: Force) -> int:
    """GOOD, NEEDS_CAPACITY or DIVERGED: the outcome of the last evaluation."""
    return GOOD


@_dispatched
def enlarge(force: Force) -> Force:
    """The same force with larger work arrays, after `status` was NEEDS_CAPACITY. Called from Python only."""
    raise NotImplementedError("this force has no work arrays")


@_dispatched
def periods(force: Force) -> np.ndarray | None:
    """Periods of the coordinates, (N*d,), 0 for one without; None if none has one. Called from Python only."""
    return None


@_dispatched
def renew(force: Force) -> None:
    """Lets the next evaluation find its pairs anew, as the first one did.

    The order of a neighbour list, hence that of summation, depends on where the list was made. Called before the step
    to each recorded state, so that a run that starts there has the same list, and the same bits; and where coordinates
    have been moved by whole periods.
    """


@overload(accelerate, inline="never", strict=False)
def _accelerate(force: Any, r: Any, v: Any) -> Any:
    return _compiled_implementation(accelerate, force)


@overload(potential_energy, inline="never", strict=False)
def _potential_energy(force: Any, r: Any) -> Any:
    return _compiled_implementation(potential_energy, force)


@overload(kinetic_energy, inline="never", strict=False)
def _kinetic_energy(force: Any, v: Any) -> Any:
    return _compiled_implementation(kinetic_energy, force)


@overload(virial, inline="never", strict=False)
def _virial(force: Any, r: Any) -> Any:
    return _compiled_implementation(virial, force)


@overload(energy_and_virial, inline="never", strict=False)
def _energy_and_virial(force: Any, r: Any) -> Any:
    return _compiled_implementation(energy_and_virial, force)


@overload(derivatives, inline="never", strict=False)
def _derivatives(force: Any, r: Any, v: Any, count: Any) -> Any:
    return _compiled_implementation(derivatives, force)


@overload(status, inline="never", strict=False)
def _status(force: Any) -> Any:
    return _compiled_implementation(status, force)


@overload(renew, inline="never", strict=False)
def _renew(force: Any) -> Any:
    return _compiled_implementation(renew, force)
