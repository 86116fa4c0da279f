"""What kernels are declared with, so that one text runs compiled and as plain Python.

numba compiles nothing where the environment variable NUMBA_DISABLE_JIT is set: its decorators then return the functions
as they are. For small scenes that is quicker than compiling. What numba's decorators leave open is here: choice by
type, instructions of the processor that Python has no word for, and divisions by zero. Results are the same to the last
bit where no kernel fuses or reorders (`x ** 2` is a product in compiled code, a call of pow() in Python: write x * x).

    @dispatched()
    def area(shape):
        raise TypeError("not a shape")

    @implements(area, Circle)
    def _circle(shape):
        return math.pi * shape.radius**2
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import numpy as np
from numba import config, njit
from numba.extending import intrinsic, overload

Function = TypeVar("Function", bound=Callable[..., Any])

#: Whether kernels run as plain Python.
INTERPRETED = bool(config.DISABLE_JIT)  # type: ignore[attr-defined]
if INTERPRETED:  # once for the process: setting it at each call of a kernel took a third of the time of short ones
    np.seterr(all="ignore")

_implementations: dict[Callable[..., Any], dict[type, Callable[..., Any]]] = {}


def compiled(**options: Any) -> Callable[[Function], Function]:
    """`numba.njit`, with divisions by zero that give an infinity. In plain Python too numpy does not warn of any.

    options: of `numba.njit`.
    """
    if not INTERPRETED:
        return njit(error_model="numpy", **options)
    # a kernel without the lock may run in a thread of its own, where numpy has its settings of the start
    return np.errstate(all="ignore") if options.get("nogil") else lambda function: function


def instruction(plain: Function, **options: Any) -> Callable[[Callable[..., Any]], Function]:
    """`numba.extending.intrinsic`: the decorated function writes the instructions that a compiled caller executes.

    plain: does the same in plain Python, for callers that are not compiled. options: of `numba.extending.intrinsic`.
    """

    def decorate(code: Callable[..., Any]) -> Any:
        if INTERPRETED:
            return plain
        return intrinsic(**options)(code) if options else intrinsic(code)

    return decorate


def dispatched(**options: Any) -> Callable[[Function], Function]:
    """Makes the decorated function, `f(record, ...)`, act by the class of `record`; its own body is the default.

    In plain Python the choice is made at run time, in a kernel at compile time. A record is a `typing.NamedTuple`.
    options: numba's options for compiling the implementations.
    """

    def decorate(function: Function) -> Function:
        table: dict[type, Callable[..., Any]] = {}

        @wraps(function)
        def call(record: Any, *arguments: Any) -> Any:
            return table.get(type(record), function)(record, *arguments)

        @overload(call, strict=False, jit_options=options)  # type: ignore[arg-type]
        def _choose(record: Any, *arguments: Any) -> Callable[..., Any]:
            record_class: Any = getattr(record, "instance_class", None)
            return table.get(record_class, function)

        _implementations[call] = table
        return call  # type: ignore[return-value]

    return decorate


def implements(function: Callable[..., Any], record_class: type) -> Callable[[Function], Function]:
    """Registers the decorated function as what `function`, a dispatched one, does for records of `record_class`.

    The decorated function must be plain Python that numba can compile (it may call jitted kernels), with the argument
    names of `function`.
    """

    def register(implementation: Function) -> Function:
        _implementations[function][record_class] = implementation
        return implementation

    return register
