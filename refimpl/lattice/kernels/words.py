"""Wide words for kernels: 512 bits, 8 words of 64, one machine operation each where the machine has them.

LLVM splits the type on machines with narrower registers. Operators: ~, and & | ^ + * >> between wide words or with one
uint64 for all lanes. Functions of a model (`arrivals`, `collided` ...) take the model's *type*, which
holds its table: the logic is laid out while the kernel is compiled, and the kernel is kept on disk with it.

Where kernels run as plain Python, a wide word is a numpy array of `WIDTH` uint64. What a model does is written once, in
operators: on `_Written` values they write instructions, on arrays they compute.
"""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Callable
from functools import cache
from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import NativeValue, models, register_model, typeof_impl, unbox

from refimpl.compilation import instruction
from refimpl.lattice.logic import program
from refimpl.lattice.models import Model

#: Words of 64 sites in a wide word.
WIDTH = 8
_LANE = ir.IntType(64)
_WIDE = ir.VectorType(_LANE, WIDTH)


class WideType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="wide")


wide = WideType()


@register_model(WideType)
class _WideModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _WIDE)


class ModelType(types.Type):
    """The type of one model: its collision table and its lattice. Equal tables are one type."""

    def __init__(self, outcomes: Any, integers: Any, half_rows: bool, mirror: Any) -> None:
        self.outcomes, self.integers, self.half_rows, self.mirror = outcomes, integers, half_rows, mirror
        content = repr((outcomes, integers, half_rows))
        super().__init__(name=f"model({hashlib.sha256(content.encode()).hexdigest()})")

    @property
    def channels(self) -> int:
        return len(self.integers)


register_model(ModelType)(models.OpaqueModel)


@typeof_impl.register(Model)
def _typeof_model(model: Model, context: Any) -> ModelType:
    return _type_of(model)


@cache
def _type_of(model: Model) -> ModelType:
    """Cached: needed at every call of a kernel."""
    v = model.velocities
    return ModelType(model.outcomes, v.integers, v.half_rows, (v.image(-1, 1), v.image(1, -1)))


@unbox(ModelType)
def _unbox_model(kind: Any, value: Any, c: Any) -> NativeValue:
    return NativeValue(c.context.get_dummy_value())


# -- operators -------------------------------------------------------------------------------------------------


def _splat(builder: Any, value: Any) -> Any:
    first = builder.insert_element(ir.Constant(_WIDE, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, ir.Constant(_WIDE, ir.Undefined), zeros)


def _constant(value: int) -> Any:
    return ir.Constant(_WIDE, [value] * WIDTH)


def _operator(symbol: Callable[..., Any], instruction: str) -> None:
    @infer_global(symbol)
    class _Template(ConcreteTemplate):  # type: ignore[misc]
        cases = [signature(wide, wide, wide), signature(wide, wide, types.uint64)]

    @lower_builtin(symbol, wide, wide)
    def _both(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)

    @lower_builtin(symbol, wide, types.uint64)
    def _scalar(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(args[0], _splat(builder, args[1]))


for _symbol, _instruction in (
    (operator.and_, "and_"),
    (operator.or_, "or_"),
    (operator.xor, "xor"),
    (operator.add, "add"),
    (operator.mul, "mul"),
    (operator.rshift, "lshr"),
):
    _operator(_symbol, _instruction)


@infer_global(operator.invert)
class _Invert(ConcreteTemplate):  # type: ignore[misc]
    cases = [signature(wide, wide)]


@lower_builtin(operator.invert, wide)
def _invert(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.not_(args[0])


class _Written:
    """A value of the code that is being written, a wide word or an index: operators write instructions.

    builder: writes them. value: LLVM's. The other operand may be a Python integer.
    """

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def _with(self, instruction: str, other: Any) -> _Written:
        if not isinstance(other, _Written):
            kind = self.value.type
            constant = _constant(other) if kind == _WIDE else ir.Constant(kind, other)
            return _Written(self.builder, getattr(self.builder, instruction)(self.value, constant))
        return _Written(self.builder, getattr(self.builder, instruction)(self.value, other.value))

    def __and__(self, other: Any) -> _Written:
        return self._with("and_", other)

    def __or__(self, other: Any) -> _Written:
        return self._with("or_", other)

    def __xor__(self, other: Any) -> _Written:
        return self._with("xor", other)

    def __add__(self, other: Any) -> _Written:
        return self._with("add", other)

    def __mul__(self, other: Any) -> _Written:
        return self._with("mul", other)

    def __lshift__(self, other: Any) -> _Written:
        return self._with("shl", other)

    def __rshift__(self, other: Any) -> _Written:
        return self._with("lshr", other)

    def __invert__(self) -> _Written:
        return _Written(self.builder, self.builder.not_(self.value))


def _written(builder: Any, value: Any, number: int) -> list[Any]:
    """The members of a tuple."""
    return [_Written(builder, builder.extract_value(value, i)) for i in range(number)]


def _as_tuple(context: Any, builder: Any, kind: Any, members: Any) -> Any:
    return context.make_tuple(builder, kind, [member.value for member in members])


# -- memory ----------------------------------------------------------------------------------------------------


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, value=array).data
    return builder.bitcast(builder.gep(data, [index]), _WIDE.as_pointer())


@instruction(lambda words, index: words[index : index + WIDTH].copy())
def load(typing: Any, words: Any, index: Any) -> Any:
    """words[index : index + WIDTH]."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_pointer(context, builder, sig.args[0], *args), align=8)

    return wide(words, types.intp), code


@instruction(lambda value: np.full(WIDTH, value, dtype=np.uint64))
def splat(typing: Any, value: Any) -> Any:
    """One uint64 in all lanes."""
    return wide(types.uint64), lambda context, builder, sig, args: _splat(builder, args[0])


@instruction(lambda: np.arange(WIDTH, dtype=np.uint64))
def lanes(typing: Any) -> Any:
    """0, 1, ... WIDTH - 1."""
    return wide(), lambda context, builder, sig, args: ir.Constant(_WIDE, list(range(WIDTH)))


@instruction(lambda value: bool(value.any()))
def any_bit(typing: Any, value: Any) -> Any:
    """Whether any bit is set."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        which = builder.icmp_unsigned("!=", args[0], _constant(0))
        packed = builder.bitcast(which, ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", packed, ir.Constant(ir.IntType(WIDTH), 0))

    return types.boolean(wide), code


@instruction(lambda value: sum(word.bit_count() for word in value.tolist()))
def population(typing: Any, value: Any) -> Any:
    """Number of bits set."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(_WIDE, [_WIDE])
        count = cgutils.get_or_insert_function(builder.module, kind, f"llvm.ctpop.v{WIDTH}i64")
        counts = builder.call(count, [args[0]])
        total = builder.extract_element(counts, ir.Constant(ir.IntType(32), 0))
        for lane in range(1, WIDTH):
            total = builder.add(total, builder.extract_element(counts, ir.Constant(ir.IntType(32), lane)))
        return total

    return types.int64(wide), code


@instruction(lambda word: int(word).bit_count())
def ones(typing: Any, word: Any) -> Any:
    """Bits set in a word of 64."""
    return types.int64(types.uint64), lambda context, builder, sig, args: builder.ctpop(args[0])


# -- what a model does to wide words -----------------------------------------------------------------------------


def _arrived(kind: ModelType, odd: int, read: Any, below: Any, here: Any, above: Any, size: Any) -> tuple[Any, ...]:
    """read: gives the wide word at a place."""
    found = []
    for i, (a, b) in enumerate(kind.integers):
        place = {1: below, 0: here, -1: above}[b] + size * i
        shift = (a + (odd - b) % 2 - odd) // 2 if kind.half_rows else a
        word = read(place)
        if shift == 1:
            word = (word << 1) | (read(place + -1) >> 63)
        elif shift == -1:
            word = (word >> 1) | (read(place + 1) << 63)
        found.append(word)
    return tuple(found)


def _plain_arrivals(model: Model, odd: int, planes: Any, below: int, here: int, above: int, size: int) -> Any:
    return _arrived(_type_of(model), odd, lambda place: planes[place : place + WIDTH], below, here, above, size)


@instruction(_plain_arrivals, prefer_literal=True)
def arrivals(typing: Any, model: Any, odd: Any, planes: Any, below: Any, here: Any, above: Any, size: Any) -> Any:
    """The occupations that propagation brings to WIDTH words of a row, one wide word a channel.

    odd: a literal, 1 in odd rows of a triangular lattice. below, here, above: places of those words in the first plane,
    in the row below, the row itself and the row above; size: words of a plane.
    """

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        def read(place: _Written) -> _Written:
            where = _pointer(context, builder, sig.args[2], args[2], place.value)
            return _Written(builder, builder.load(where, align=8))

        places = [_Written(builder, value) for value in args[3:]]
        return _as_tuple(context, builder, sig.return_type, _arrived(model, odd.literal_value, read, *places))

    whole = types.intp
    return types.UniTuple(wide, model.channels)(model, odd, planes, whole, whole, whole, whole), code


_OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
    "andnot": lambda x, y: x & ~y,
    "ornot": lambda x, y: x | ~y,
    "not": lambda x, y: ~x,
}


def _after_collision(kind: ModelType, occupied: Any, random: Any) -> tuple[tuple[Any, ...], Any]:
    """None in place of the sites to be drawn again where there never are any."""
    logic = program(kind.outcomes)
    values = [*occupied, *random]
    for name, a, b in logic.operations:
        values.append(_OPERATIONS[name](values[a], values[b]))
    after = [n if toggle is None else n ^ values[toggle] for n, toggle in zip(occupied, logic.toggles, strict=True)]
    return tuple(after), None if logic.rejected is None else values[logic.rejected]


def _plain_collided(model: Model, occupied: Any, random: Any) -> Any:
    after, again = _after_collision(_type_of(model), occupied, random)
    return after, np.zeros(WIDTH, dtype=np.uint64) if again is None else again


@instruction(_plain_collided)
def collided(typing: Any, model: Any, occupied: Any, random: Any) -> Any:
    """Occupations after the collision, and the sites whose random bits must be drawn again."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = _written(builder, args[2], program(model.outcomes).draws)
        after, again = _after_collision(model, _written(builder, args[1], model.channels), bits)
        occupations, both = sig.return_type.types[0], sig.return_type
        members = [_as_tuple(context, builder, occupations, after), _constant(0) if again is None else again.value]
        return context.make_tuple(builder, both, members)

    return types.Tuple((types.UniTuple(wide, model.channels), wide))(model, occupied, random), code


def _after_reflection(kind: ModelType, found: Any, flip_x: Any, flip_y: Any) -> tuple[Any, ...]:
    for flip, image in zip((flip_x, flip_y), kind.mirror, strict=True):
        found = [n ^ (flip & (n ^ found[image[i]])) for i, n in enumerate(found)]
    return tuple(found)


@instruction(lambda model, *words: _after_reflection(_type_of(model), *words))
def reflected(typing: Any, model: Any, occupied: Any, flip_x: Any, flip_y: Any) -> Any:
    """Occupations with their x component reversed where flip_x is set, the y component where flip_y is."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        flips = [_Written(builder, value) for value in args[2:]]
        found = _after_reflection(model, _written(builder, args[1], model.channels), *flips)
        return _as_tuple(context, builder, sig.return_type, found)

    return types.UniTuple(wide, model.channels)(model, occupied, wide, wide), code


def _after_push(kind: ModelType, occupied: Any, along: Any, against: Any) -> tuple[tuple[Any, ...], Any]:
    found, back = list(occupied), kind.mirror[0][0]
    plus, minus = found[0], found[back]
    differ = (along & (minus & ~plus)) | (against & (plus & ~minus))
    found[0], found[back] = plus ^ differ, minus ^ differ
    return tuple(found), differ


@instruction(lambda model, *words: _after_push(_type_of(model), *words))
def pushed(typing: Any, model: Any, occupied: Any, along: Any, against: Any) -> Any:
    """Particles moved from the channel -x to an empty channel +x where `along` is set, back where `against` is.

    Returns the occupations, and the sites where one moved.
    """

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        masks = [_Written(builder, value) for value in args[2:]]
        found, moved = _after_push(model, _written(builder, args[1], model.channels), *masks)
        occupations, both = sig.return_type.types[0], sig.return_type
        return context.make_tuple(builder, both, [_as_tuple(context, builder, occupations, found), moved.value])

    return types.Tuple((types.UniTuple(wide, model.channels), wide))(model, occupied, wide, wide), code


def _mixed(mask: Any, where: Any, elsewhere: Any) -> tuple[Any, ...]:
    return tuple(b ^ (mask & (a ^ b)) for a, b in zip(where, elsewhere, strict=True))


@instruction(_mixed)
def chosen(typing: Any, mask: Any, where: Any, elsewhere: Any) -> Any:
    """Tuples of wide words: `where` at the bits of the mask, `elsewhere` at the others."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        both = [_written(builder, value, sig.return_type.count) for value in args[1:]]
        return _as_tuple(context, builder, sig.return_type, _mixed(_Written(builder, args[0]), *both))

    return where(wide, where, where), code


def _plain_store(occupied: Any, planes: Any, here: int, size: int) -> None:
    for i, word in enumerate(occupied):
        planes[here + size * i : here + size * i + WIDTH] = word


@instruction(_plain_store)
def store(typing: Any, occupied: Any, planes: Any, here: Any, size: Any) -> Any:
    """Writes a wide word a channel at `here`, a multiple of WIDTH in an array aligned to 64 bytes."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        here_, size_ = _Written(builder, args[2]), _Written(builder, args[3])
        for i, word in enumerate(_written(builder, args[0], sig.args[0].count)):
            place = (here_ + size_ * i).value
            builder.store(word.value, _pointer(context, builder, sig.args[1], args[1], place), align=8 * WIDTH)
        return context.get_dummy_value()

    return types.void(occupied, planes, types.intp, types.intp), code
