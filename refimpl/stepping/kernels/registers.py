"""Coordinates of a few bodies as one value, which compiled code keeps in registers where it would allocate arrays.

A step of two bodies takes some fifty operations, and the arrays that a scheme makes on its way cost five times as much.
The type `Coordinates` is a vector of LLVM for each axis, with a lane for each body, and has the arithmetic that the
schemes use: sum and difference, a number times coordinates, coordinates over a number. So the same text of a scheme
compiles for arrays and for this type. Each operation rounds as that on the elements of an array does, and none is
fused: results are the same to the last bit.

How many bodies and axes there are is part of the type, and a loop is compiled for each. The numbers travel as lengths
of tuples, `axes` and `bodies`, whose elements nobody reads.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.extending import intrinsic, lower_builtin, models, overload, register_model, type_callable

from refimpl.vectors import DOUBLE, INDEX, splat

#: Coordinates that fit: those of 16 bodies in space.
MOST = 48

#: Makes an instruction that only compiled code can execute. (By its type hints a caller would pass `context` too.)
compiled_only: Any = intrinsic


class Coordinates(types.Type):  # type: ignore[misc]
    """Coordinates of `bodies` bodies along `axes` axes. Lanes beyond the last body repeat it."""

    def __init__(self, axes: int, bodies: int) -> None:
        self.axes, self.bodies = axes, bodies
        self.lanes = max(2, 1 << (bodies - 1).bit_length())
        super().__init__(name=f"coordinates({axes} x {bodies})")

    def body(self, lane: int) -> int:
        """The body in a lane."""
        return min(lane, self.bodies - 1)


@register_model(Coordinates)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, ir.ArrayType(_vector(numba_type.lanes), numba_type.axes))


def _vector(lanes: int) -> ir.VectorType:
    return ir.VectorType(DOUBLE, lanes)


def vectors(builder: Any, coordinates: Any) -> list[Any]:
    """The vector of each axis."""
    return [builder.extract_value(coordinates, axis) for axis in range(coordinates.type.count)]


def joined(builder: Any, axes: list[Any]) -> Any:
    """Coordinates from the vector of each axis."""
    value = ir.Constant(ir.ArrayType(axes[0].type, len(axes)), ir.Undefined)
    for axis, along in enumerate(axes):
        value = builder.insert_value(value, along, axis)
    return value


def constant(number: float, lanes: int) -> Any:
    """The vector with `number` in every lane."""
    return ir.Constant(_vector(lanes), [number] * lanes)


def _register(operation: Callable[..., Any], left: type, right: type, emit: Callable[[Any, Any, Any], Any]) -> None:
    """Gives `operation(left, right)` to numba: the instruction that `emit(builder, a, b)` writes for two vectors."""

    @type_callable(operation)
    def _type(context: Any) -> Any:
        def typer(a: Any, b: Any) -> Any:
            if not (isinstance(a, left) and isinstance(b, right)) or (left is right and a != b):
                return None
            return a if isinstance(a, Coordinates) else b

        return typer

    @lower_builtin(operation, left, right)
    def _lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = signature.return_type
        a, b = (
            vectors(builder, value) if given == kind else [splat(builder, value, kind.lanes)] * kind.axes
            for value, given in zip(arguments, signature.args, strict=True)
        )
        return joined(builder, [emit(builder, *pair) for pair in zip(a, b, strict=True)])


_register(operator.add, Coordinates, Coordinates, lambda builder, a, b: builder.fadd(a, b))
_register(operator.sub, Coordinates, Coordinates, lambda builder, a, b: builder.fsub(a, b))
_register(operator.mul, types.Float, Coordinates, lambda builder, a, b: builder.fmul(a, b))
_register(operator.truediv, Coordinates, types.Float, lambda builder, a, b: builder.fdiv(a, b))


def _element(context: Any, builder: Any, kind: Any, array: Any, place: int) -> Any:
    """Pointer to an element of a contiguous array."""
    return builder.gep(context.make_array(kind)(context, builder, value=array).data, [INDEX(place)])


@compiled_only
def from_array(context, array, axes, bodies):  # type: ignore[no-untyped-def]
    """A flat contiguous array, body after body, as coordinates.

    array: float64, of as many elements as the tuples `axes` and `bodies` have together, one times the other.
    """
    kind = Coordinates(len(axes), len(bodies))

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        found = []
        for axis in range(kind.axes):
            along = ir.Constant(_vector(kind.lanes), ir.Undefined)
            for lane in range(kind.lanes):
                place = kind.axes * kind.body(lane) + axis
                pointer = _element(context, builder, signature.args[0], arguments[0], place)
                along = builder.insert_element(along, builder.load(pointer), INDEX(lane))
            found.append(along)
        return joined(builder, found)

    return kind(array, axes, bodies), generate


@compiled_only
def to_array(context, coordinates, array):  # type: ignore[no-untyped-def]
    """Writes coordinates to a flat contiguous float64 array of their size, body after body."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = signature.args[0]
        for axis, along in enumerate(vectors(builder, arguments[0])):
            for body in range(kind.bodies):
                pointer = _element(context, builder, signature.args[1], arguments[1], kind.axes * body + axis)
                builder.store(builder.extract_element(along, INDEX(body)), pointer)
        return context.get_dummy_value()

    return types.void(coordinates, array), generate


def tuple_from_arrays(arrays: tuple[Any, ...], axes: tuple[int, ...], bodies: tuple[int, ...]) -> tuple[Any, ...]:
    """`from_array` of each array."""
    return tuple(from_array(array, axes, bodies) for array in arrays)


@overload(tuple_from_arrays, strict=False)
def _tuple_from_arrays(arrays: Any, axes: Any, bodies: Any) -> Callable[..., Any]:
    # one element at a time: each has a type of its own for numba
    if len(arrays) == 0:
        return lambda arrays, axes, bodies: ()
    return lambda arrays, axes, bodies: (
        from_array(arrays[0], axes, bodies),
        *tuple_from_arrays(arrays[1:], axes, bodies),
    )


def tuple_to_arrays(values: tuple[Any, ...], arrays: tuple[Any, ...]) -> None:
    """`to_array` of each of the coordinates."""
    for value, array in zip(values, arrays, strict=True):
        to_array(value, array)


@overload(tuple_to_arrays, strict=False)
def _tuple_to_arrays(values: Any, arrays: Any) -> Callable[..., Any]:
    if len(arrays) == 0:
        return lambda values, arrays: None

    def first_and_others(values, arrays):  # type: ignore[no-untyped-def]
        to_array(values[0], arrays[0])
        tuple_to_arrays(values[1:], arrays[1:])

    return first_and_others


@compiled_only
def all_finite(context, coordinates):  # type: ignore[no-untyped-def]
    """True if no coordinate is infinite or NaN."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        lanes = signature.args[0].lanes
        # x - x is 0 where x is finite, else NaN, and a sum with NaN is NaN
        differences = [builder.fsub(x, x) for x in vectors(builder, arguments[0])]
        total = differences[0]
        for difference in differences[1:]:
            total = builder.fadd(total, difference)
        bits = ir.IntType(lanes)
        finite = builder.fcmp_ordered("==", total, constant(0.0, lanes))
        return builder.icmp_unsigned("==", builder.bitcast(finite, bits), bits(2**lanes - 1))

    return types.boolean(coordinates), generate
