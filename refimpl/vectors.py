"""LLVM's vectors of doubles: what the kernels' own vector types are made of, whatever their lanes and their rounding.

`builder` is llvmlite's, at the place where an instruction of a kernel is written.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import llvmlite.ir as ir
from numba.core import cgutils
from numba.extending import lower_builtin, type_callable

DOUBLE = ir.DoubleType()
INDEX = ir.IntType(32)


def lane_everywhere(builder: Any, vector: Any, lane: int) -> Any:
    """The vector with one lane of another in every lane."""
    lanes = vector.type.count
    return builder.shuffle_vector(vector, vector, ir.Constant(ir.VectorType(INDEX, lanes), [lane] * lanes))


def splat(builder: Any, number: Any, lanes: int) -> Any:
    """The double `number` in every lane of a vector."""
    undefined = ir.Constant(ir.VectorType(DOUBLE, lanes), ir.Undefined)
    return lane_everywhere(builder, builder.insert_element(undefined, number, INDEX(0)), 0)


def square_root(builder: Any, x: Any) -> Any:
    """Square root of every lane of the vector `x`, correctly rounded."""
    name = f"llvm.sqrt.v{x.type.count}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, ir.FunctionType(x.type, [x.type]), name), [x])


def register_operator(
    operation: Callable[..., Any], operand: Any, result: Any, emit: Callable[[Any, Any, Any], Any]
) -> None:
    """Gives `operation(operand, operand) -> result` to numba, as the instruction that `emit(builder, a, b)` writes.

    operation: of the module `operator`. operand, result: numba's types.
    """

    @type_callable(operation)
    def _type(context: Any) -> Any:
        def typer(a: Any, b: Any) -> Any:
            return result if a == operand and b == operand else None

        return typer

    @lower_builtin(operation, type(operand), type(operand))  # type: ignore[untyped-decorator]
    def _lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return emit(builder, *arguments)
