"""Explicit SIMD for numba kernels: a value type of `WIDTH` doubles, its arithmetic, loads, stores and selection.

The type is LLVM's `<8 x double>`: one AVX-512 register, and whatever the processor has where that is narrower (two
AVX registers, four SSE2 or NEON ones): slower there, never wrong. Multiplication and addition carry LLVM's `contract`
flag, so that they fuse into one instruction with a single rounding where the processor has one; nothing else is
relaxed, and division and square root are exact to half a unit in the last place.

Loads and stores do not check bounds, and do not know negative indices: the caller must see to both. Everything is a
module-level function without compiled code of its own, so that kernels which use it are found in numba's cache by every
process. (A change of this file does not make those caches stale: touch the kernels' files too.)

Where kernels run as plain Python, a vector is a numpy array of `WIDTH` doubles, or one of numpy's scalars where all
lanes are equal: numpy repeats it, and that takes half as long. Nothing is fused there: results differ from the compiled
ones by rounding.
"""

from __future__ import annotations

import operator
from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba import types
from numba.extending import models, register_model

from refimpl import vectors
from refimpl.compilation import instruction
from refimpl.vectors import register_operator

#: Lanes of a vector.
WIDTH = 8

_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, WIDTH)
_MASK = ir.VectorType(ir.IntType(1), WIDTH)
_INDEX = ir.IntType(32)
#: In plain Python: the numbers of the lanes.
_NUMBERS = np.arange(WIDTH, dtype=np.float64)
_NUMBERS.setflags(write=False)


class VectorType(types.Type):  # type: ignore[misc]
    """`WIDTH` doubles."""

    def __init__(self) -> None:
        super().__init__(name=f"float64x{WIDTH}")


class MaskType(types.Type):  # type: ignore[misc]
    """`WIDTH` truth values."""

    def __init__(self) -> None:
        super().__init__(name=f"boolx{WIDTH}")


vector = VectorType()
mask = MaskType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, _VECTOR)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, _MASK)


_CONTRACT = ("contract",)
register_operator(operator.add, vector, vector, lambda build, a, b: build.fadd(a, b, flags=_CONTRACT))
register_operator(operator.sub, vector, vector, lambda build, a, b: build.fsub(a, b, flags=_CONTRACT))
register_operator(operator.mul, vector, vector, lambda build, a, b: build.fmul(a, b, flags=_CONTRACT))
register_operator(operator.truediv, vector, vector, lambda build, a, b: build.fdiv(a, b))
register_operator(operator.lt, vector, mask, lambda build, a, b: build.fcmp_ordered("<", a, b))
register_operator(operator.eq, vector, mask, lambda build, a, b: build.fcmp_ordered("==", a, b))


def _element(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Pointer to `array[i]`, the first two arguments."""
    array = context.make_array(signature.args[0])(context, builder, value=arguments[0])
    index = context.cast(builder, arguments[1], signature.args[1], types.intp)
    return builder.gep(array.data, [index])


def _is_doubles(array: Any) -> bool:
    return isinstance(array, types.Array) and array.dtype == types.float64 and array.layout == "C"


@instruction(np.float64)
def splat(context, x):  # type: ignore[no-untyped-def]
    """The scalar `x` in every lane."""
    if not isinstance(x, types.Float):
        return None
    return vector(types.float64), lambda context, builder, signature, arguments: vectors.splat(
        builder, arguments[0], WIDTH
    )


@instruction(lambda: np.zeros(WIDTH))
def zeros(context):  # type: ignore[no-untyped-def]
    """0.0 in every lane."""
    return vector(), lambda context, builder, signature, arguments: ir.Constant(_VECTOR, [0.0] * WIDTH)


@instruction(lambda: _NUMBERS)
def lanes(context):  # type: ignore[no-untyped-def]
    """The lane numbers 0.0, 1.0, ..."""
    numbers = [float(lane) for lane in range(WIDTH)]
    return vector(), lambda context, builder, signature, arguments: ir.Constant(_VECTOR, numbers)


@instruction(lambda array, i: array[i : i + WIDTH].copy())
def load(context, array, i):  # type: ignore[no-untyped-def]
    """`array[i : i + WIDTH]` of a contiguous float64 array."""
    if not (_is_doubles(array) and isinstance(i, types.Integer)):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = _element(context, builder, signature, arguments)
        return builder.load(builder.bitcast(pointer, _VECTOR.as_pointer()), align=8)

    return vector(array, i), generate


@instruction(lambda array, i: array[i])
def load_splat(context, array, i):  # type: ignore[no-untyped-def]
    """`array[i]` of a contiguous float64 array, in every lane."""
    if not (_is_doubles(array) and isinstance(i, types.Integer)):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return vectors.splat(builder, builder.load(_element(context, builder, signature, arguments)), WIDTH)

    return vector(array, i), generate


def _plain_store(array: Any, i: int, x: Any) -> None:
    array[i : i + WIDTH] = x


@instruction(_plain_store)
def store(context, array, i, x):  # type: ignore[no-untyped-def]
    """`array[i : i + WIDTH] = x` for a contiguous float64 array."""
    if not (_is_doubles(array) and isinstance(i, types.Integer) and x == vector):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = _element(context, builder, signature, arguments)
        builder.store(arguments[2], builder.bitcast(pointer, _VECTOR.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, i, x), generate


@instruction(np.where)
def where(context, condition, x, y):  # type: ignore[no-untyped-def]
    """Lane by lane: `x` if `condition` else `y`."""
    if not (condition == mask and x == vector and y == vector):
        return None
    return vector(condition, x, y), lambda context, builder, signature, arguments: builder.select(*arguments)


@instruction(lambda condition: 1 in condition.tobytes())
def any_lane(context, condition):  # type: ignore[no-untyped-def]
    """True if any lane is."""
    if condition != mask:
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = ir.IntType(WIDTH)
        return builder.icmp_unsigned("!=", builder.bitcast(arguments[0], bits), bits(0))

    return types.boolean(condition), generate


@instruction(np.sqrt)
def square_root(context, x):  # type: ignore[no-untyped-def]
    """Square root of every lane, correctly rounded."""
    if x != vector:
        return None
    return vector(x), lambda context, builder, signature, arguments: vectors.square_root(builder, arguments[0])


def _plain_total(x: Any) -> float:
    while len(x) > 1:
        x = x[::2] + x[1::2]
    return float(x[0])


@instruction(_plain_total)
def total(context, x):  # type: ignore[no-untyped-def]
    """Sum of the lanes, always added in the same order: neighbours first."""
    if x != vector:
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        terms = [builder.extract_element(arguments[0], _INDEX(lane)) for lane in range(WIDTH)]
        while len(terms) > 1:
            terms = [builder.fadd(a, b) for a, b in zip(terms[::2], terms[1::2], strict=True)]
        return terms[0]

    return types.float64(x), generate
