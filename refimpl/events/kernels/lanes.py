"""Eight doubles at once: the arithmetic of a prediction, for eight partners of a particle.

The type is LLVM's `<8 x double>`: one AVX-512 register, and whatever the processor has where that is narrower. Every
operation rounds on its own, as scalar code does, and none is fused or reordered: the results are those of the scalar
formulas to the last bit, on any processor.

Where kernels run as plain Python, such a value is a numpy array of eight doubles, or one of numpy's scalars where all
lanes are equal: numpy repeats it, and that takes half as long. What a function here needs as an array, it says.
"""

from __future__ import annotations

import operator
from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import models, register_model

from refimpl import vectors
from refimpl.compilation import instruction
from refimpl.vectors import register_operator

#: Doubles of a value.
WIDTH = 8

_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(32)
_LANES, _MASK = ir.VectorType(_DOUBLE, WIDTH), ir.VectorType(ir.IntType(1), WIDTH)
_UNDEFINED = ir.Constant(_LANES, ir.Undefined)
#: In plain Python: the lower half of a number.
_LOWER = np.int64(0xFFFFFFFF)
#: In plain Python: eight truth values as they lie in memory, and the integer of these bits.
_BITS = {bytes(bits >> lane & 1 for lane in range(WIDTH)): bits for bits in range(1 << WIDTH)}


class LanesType(types.Type):  # type: ignore[misc]
    """`WIDTH` doubles."""

    def __init__(self) -> None:
        super().__init__(name=f"exact_float64x{WIDTH}")


class ChoiceType(types.Type):  # type: ignore[misc]
    """`WIDTH` truth values."""

    def __init__(self) -> None:
        super().__init__(name=f"exact_boolx{WIDTH}")


lanes, choice = LanesType(), ChoiceType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, _LANES)


@register_model(ChoiceType)
class _ChoiceModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, _MASK)


register_operator(operator.add, lanes, lanes, lambda build, a, b: build.fadd(a, b))
register_operator(operator.sub, lanes, lanes, lambda build, a, b: build.fsub(a, b))
register_operator(operator.mul, lanes, lanes, lambda build, a, b: build.fmul(a, b))
register_operator(operator.truediv, lanes, lanes, lambda build, a, b: build.fdiv(a, b))
register_operator(operator.lt, lanes, choice, lambda build, a, b: build.fcmp_ordered("<", a, b))
register_operator(operator.le, lanes, choice, lambda build, a, b: build.fcmp_ordered("<=", a, b))
register_operator(operator.eq, lanes, choice, lambda build, a, b: build.fcmp_ordered("==", a, b))
register_operator(operator.and_, choice, choice, lambda build, a, b: build.and_(a, b))


@instruction(np.float64)
def splat(context, x):  # type: ignore[no-untyped-def]
    """The scalar `x` in every lane."""
    if not isinstance(x, types.Float):
        return None
    return lanes(types.float64), lambda context, builder, signature, arguments: vectors.splat(
        builder, arguments[0], WIDTH
    )


@instruction(np.where)
def where(context, condition, x, y):  # type: ignore[no-untyped-def]
    """Lane by lane: `x` if `condition` else `y`."""
    if not (condition == choice and x == lanes and y == lanes):
        return None
    return lanes(condition, x, y), lambda context, builder, signature, arguments: builder.select(*arguments)


@instruction(np.sqrt)
def square_root(context, x):  # type: ignore[no-untyped-def]
    """Square root of every lane, correctly rounded."""
    if x != lanes:
        return None
    return lanes(x), lambda context, builder, signature, arguments: vectors.square_root(builder, arguments[0])


@instruction(lambda condition: _BITS[condition.tobytes()])
def bits_of(context, condition):  # type: ignore[no-untyped-def]
    """The truth values as the bits of an integer, the first lane lowest. In plain Python they must be an array."""
    if condition != choice:
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.zext(builder.bitcast(arguments[0], ir.IntType(WIDTH)), ir.IntType(64))

    return types.int64(condition), generate


@instruction(lambda bits: int(bits & -bits).bit_length() - 1)
def lowest_bit(context, bits):  # type: ignore[no-untyped-def]
    """The number of the lowest bit of an integer that is not 0."""
    if not isinstance(bits, types.Integer):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(context.cast(builder, arguments[0], signature.args[0], types.int64), ir.IntType(1)(1))

    return types.int64(bits), generate


@instruction(lambda x: float(np.minimum.reduce(x)))
def least(context, x):  # type: ignore[no-untyped-def]
    """The least of the lanes, of which none is a NaN. In plain Python they must be an array."""
    if x != lanes:
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        best = arguments[0]
        for half in (4, 2, 1):
            order = ir.Constant(ir.VectorType(_INDEX, WIDTH), [lane ^ half for lane in range(WIDTH)])
            other = builder.shuffle_vector(best, _UNDEFINED, order)
            best = builder.select(builder.fcmp_ordered("<", best, other), best, other)
        return builder.extract_element(best, _INDEX(0))

    return types.float64(x), generate


def _plain_store(array: Any, row: int, place: int, x: Any) -> None:
    array[row, place : place + WIDTH] = x


@instruction(_plain_store)
def store(context, array, row, place, x):  # type: ignore[no-untyped-def]
    """`array[row, place : place + WIDTH] = x` of a contiguous float64 matrix."""
    if not (_is_matrix(array) and x == lanes):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        matrix, row, place = _matrix(context, builder, signature, arguments)
        columns = cgutils.unpack_tuple(builder, matrix.shape, 2)[1]
        pointer = builder.gep(matrix.data, [builder.add(builder.mul(row, columns), place)])
        builder.store(arguments[3], builder.bitcast(pointer, _LANES.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, row, place, x), generate


def _is_matrix(array: Any) -> bool:
    return isinstance(array, types.Array) and array.dtype == types.float64 and array.layout == "C" and array.ndim == 2


def _matrix(context: Any, builder: Any, signature: Any, arguments: Any) -> tuple[Any, Any, Any]:
    """The matrix of the first argument, and two integers, the second and third one."""
    matrix = context.make_array(signature.args[0])(context, builder, value=arguments[0])
    one, other = (context.cast(builder, arguments[k], signature.args[k], types.intp) for k in (1, 2))
    return matrix, one, other


def _plain_columns(rows: Any, numbers: Any, place: int, shift: int) -> Any:
    which = numbers[place : place + WIDTH]
    which = which >> np.int64(shift) if shift else which
    return rows.take(which & _LOWER, axis=0).T


@instruction(_plain_columns)
def columns(context, rows, numbers, place, shift):  # type: ignore[no-untyped-def]
    """The eight columns of eight rows of a matrix (N, 8), each a value of eight lanes.

    numbers: int64, of the rows, from `place` on, each in 32 bits from the bit `shift` on. rows: contiguous float64.
    """
    if not (_is_matrix(rows) and isinstance(numbers, types.Array) and numbers.dtype == types.int64):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        matrix = context.make_array(signature.args[0])(context, builder, value=arguments[0])
        listed = context.make_array(signature.args[1])(context, builder, value=arguments[1])
        place, shift = (context.cast(builder, arguments[k], signature.args[k], types.intp) for k in (2, 3))
        whole, mask = ir.IntType(64), ir.IntType(64)(0xFFFFFFFF)
        lines = []
        for lane in range(WIDTH):
            number = builder.load(builder.gep(listed.data, [builder.add(place, whole(lane))]))
            number = builder.and_(builder.lshr(number, shift), mask)
            pointer = builder.gep(matrix.data, [builder.shl(number, whole(3))])
            lines.append(builder.load(builder.bitcast(pointer, _LANES.as_pointer()), align=8))
        found = _transposed(builder, lines)
        return context.make_tuple(builder, signature.return_type, found)

    return types.UniTuple(lanes, WIDTH)(rows, numbers, place, shift), generate


def _transposed(builder: Any, lines: list[Any]) -> list[Any]:
    """The columns of eight rows: in three steps, of blocks of one, two and four lanes."""

    def pick(a: Any, b: Any, order: list[int]) -> Any:
        return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, WIDTH), order))

    for size in (1, 2, 4):
        # of two rows `size` apart, one takes the even blocks of both, the other the odd ones
        even = [lane + (WIDTH - size if lane & size else 0) for lane in range(WIDTH)]
        odd = [lane + (WIDTH if lane & size else size) for lane in range(WIDTH)]
        new = list(lines)
        for k in range(WIDTH):
            if not k & size:
                new[k], new[k | size] = pick(lines[k], lines[k | size], even), pick(lines[k], lines[k | size], odd)
        lines = new
    return lines


def _plain_elements(array: Any, numbers: Any, place: int) -> Any:
    return array.take(numbers[place : place + WIDTH] & _LOWER)


@instruction(_plain_elements)
def elements(context, array, numbers, place):  # type: ignore[no-untyped-def]
    """`array[numbers[place : place + WIDTH]]` of a contiguous float64 array; numbers: int64, in their lower 32 bits."""
    if not (isinstance(array, types.Array) and array.dtype == types.float64 and array.ndim == 1):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(signature.args[0])(context, builder, value=arguments[0])
        listed = context.make_array(signature.args[1])(context, builder, value=arguments[1])
        place = context.cast(builder, arguments[2], signature.args[2], types.intp)
        whole, found = ir.IntType(64), _UNDEFINED
        for lane in range(WIDTH):
            number = builder.load(builder.gep(listed.data, [builder.add(place, whole(lane))]))
            number = builder.and_(number, whole(0xFFFFFFFF))
            found = builder.insert_element(found, builder.load(builder.gep(source.data, [number])), _INDEX(lane))
        return found

    return lanes(array, numbers, place), generate
