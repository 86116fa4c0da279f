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

from contextlib import AbstractContextManager, nullcontext
from typing import Any, TypeAlias

import numpy as np

from refimpl.compilation import dispatched

#: A record of parameters and work arrays; what it can do is registered, so no protocol describes it.
Force: TypeAlias = Any

#: `status` values of a force, read by the step loop after every evaluation.
GOOD = 0
NEEDS_CAPACITY = 1  # a work array is too small: `enlarge` the force and repeat the step
DIVERGED = 2  # a coordinate is not finite, has leapt (`kernels.neighbours`), or is on the wrong side of a wall


@dispatched()
def accelerate(force: Force, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Acceleration f(r, v)/m of every coordinate, shape (N*d,)."""
    raise NotImplementedError("this force has no acceleration")


@dispatched()
def kinetic_energy(force: Force, v: np.ndarray) -> float:
    """Total kinetic energy K = sum m v^2 / 2, with the masses that the force holds."""
    raise NotImplementedError("this force holds no masses")


@dispatched()
def energy_and_virial(force: Force, r: np.ndarray) -> tuple[float, float]:
    """Total potential energy U, and virial W = sum over pairs of r_ij . F_ij; the pressure is (2 K + W)/(d V)."""
    raise NotImplementedError("this force has no potential energy")


@dispatched()
def derivatives(force: Force, r: np.ndarray, v: np.ndarray, count: int) -> np.ndarray:
    """The first `count` time derivatives r_3, r_4, ... of the coordinates, shape (count, N*d); by default zeros."""
    return np.zeros((count, r.size))


@dispatched()
def status(force: Force) -> int:
    """GOOD, NEEDS_CAPACITY or DIVERGED: the outcome of the last evaluation."""
    return GOOD


@dispatched()
def enlarge(force: Force) -> Force:
    """The same force with larger work arrays, after `status` was NEEDS_CAPACITY. Called from Python only."""
    raise NotImplementedError("this force has no work arrays")


@dispatched()
def periods(force: Force) -> np.ndarray | None:
    """Periods of the coordinates, (N*d,), 0 for one without; None if none has one. Called from Python only."""
    return None


@dispatched()
def bodies_in_registers(force: Force, count: int) -> int:
    """How many bodies `count` coordinates are, if `in_registers` takes them; 0 if it does not. From Python only."""
    return 0


@dispatched()
def in_registers(force: Force, bodies: tuple[int, ...]) -> Force:
    """The force on coordinates that are kept in registers (`kernels.registers`), with the same bits: in kernels only.

    bodies: a tuple of the length that `bodies_in_registers` returned.
    """
    return force


@dispatched()
def team(force: Force) -> AbstractContextManager[None]:
    """While it lasts, the force's threads help with its evaluations; by default there are none. From Python only."""
    return nullcontext()


@dispatched()
def operations(force: Force) -> dict[str, int]:
    """What was done so far, by name, of what is counted: `evaluations` of the accelerations that succeeded;
    `pair_tests`, distances of pairs computed by them; `list_builds` and `list_prunings`, and `list_tests`, distances
    computed by these. Called from Python only."""
    return {}


@dispatched()
def renew(force: Force) -> None:
    """Lets the next evaluation find its pairs anew, as the first one did.

    The order of a neighbour list, hence that of summation, depends on where the list was made. Called before the step
    to each recorded state, so that a run that starts there has the same list, and the same bits; and where coordinates
    have been moved by whole periods.
    """
