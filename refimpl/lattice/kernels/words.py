"""Wide words for kernels: 512 bits, 8 words of 64, one machine operation each where the machine has them.

LLVM splits the type on machines with narrower registers. Operators: ~, and & | ^ + * >> between wide words or with one
uint64 for all lanes. Functions of a model (`arrivals`, `collided` ...) take the model's *type*, which
holds its table: the logic is laid out while the kernel is compiled, and the kernel is kept on disk with it.
"""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Callable
from functools import cache
from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import NativeValue, intrinsic, models, register_model, typeof_impl, unbox

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


# -- memory ----------------------------------------------------------------------------------------------------


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, value=array).data
    return builder.bitcast(builder.gep(data, [index]), _WIDE.as_pointer())


@intrinsic
def load(typing: Any, words: Any, index: Any) -> Any:
    """words[index : index + WIDTH]."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_pointer(context, builder, sig.args[0], *args), align=8)

    return wide(words, types.intp), code


@intrinsic
def splat(typing: Any, value: Any) -> Any:
    """One uint64 in all lanes."""
    return wide(types.uint64), lambda context, builder, sig, args: _splat(builder, args[0])


@intrinsic
def lanes(typing: Any) -> Any:
    """0, 1, ... WIDTH - 1."""
    return wide(), lambda context, builder, sig, args: ir.Constant(_WIDE, list(range(WIDTH)))


@intrinsic
def any_bit(typing: Any, value: Any) -> Any:
    """Whether any bit is set."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        which = builder.icmp_unsigned("!=", args[0], _constant(0))
        packed = builder.bitcast(which, ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", packed, ir.Constant(ir.IntType(WIDTH), 0))

    return types.boolean(wide), code


@intrinsic
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


# -- what a model does to wide words -----------------------------------------------------------------------------


def _parts(builder: Any, value: Any, number: int) -> list[Any]:
    return [builder.extract_value(value, i) for i in range(number)]


@intrinsic(prefer_literal=True)
def arrivals(typing: Any, model: Any, odd: Any, planes: Any, below: Any, here: Any, above: Any, size: Any) -> Any:
    """The occupations that propagation brings to WIDTH words of a row, one wide word a channel.

    odd: a literal, 1 in odd rows of a triangular lattice. below, here, above: places of those words in the first plane,
    in the row below, the row itself and the row above; size: words of a plane.
    """

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        _, _, array, below_, here_, above_, size_ = args
        one, top = _constant(1), _constant(63)
        found = []
        for i, (a, b) in enumerate(model.integers):
            base = {1: below_, 0: here_, -1: above_}[b]
            index = builder.add(base, builder.mul(size_, ir.Constant(_LANE, i)))
            shift = (a + (odd.literal_value - b) % 2 - odd.literal_value) // 2 if model.half_rows else a
            word = builder.load(_pointer(context, builder, sig.args[2], array, index), align=8)
            if shift:
                aside = builder.add(index, ir.Constant(_LANE, -shift))
                other = builder.load(_pointer(context, builder, sig.args[2], array, aside), align=8)
                if shift == 1:
                    word = builder.or_(builder.shl(word, one), builder.lshr(other, top))
                else:
                    word = builder.or_(builder.lshr(word, one), builder.shl(other, top))
            found.append(word)
        return context.make_tuple(builder, sig.return_type, found)

    whole = types.intp
    return types.UniTuple(wide, model.channels)(model, odd, planes, whole, whole, whole, whole), code


def _run(builder: Any, operations: Any, values: list[Any]) -> None:
    for name, a, b in operations:
        x, y = values[a], values[b]
        if name == "not":
            values.append(builder.not_(x))
        elif name in ("andnot", "ornot"):
            join = builder.and_ if name == "andnot" else builder.or_
            values.append(join(x, builder.not_(y)))
        else:
            values.append({"and": builder.and_, "or": builder.or_, "xor": builder.xor}[name](x, y))


@intrinsic
def collided(typing: Any, model: Any, occupied: Any, random: Any) -> Any:
    """Occupations after the collision, and the sites whose random bits must be drawn again."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        logic = program(model.outcomes)
        before = _parts(builder, args[1], model.channels)
        values = before + _parts(builder, args[2], logic.draws)
        _run(builder, logic.operations, values)
        after = [
            n if toggle is None else builder.xor(n, values[toggle])
            for n, toggle in zip(before, logic.toggles, strict=True)
        ]
        again = _constant(0) if logic.rejected is None else values[logic.rejected]
        occupations, both = sig.return_type.types[0], sig.return_type
        return context.make_tuple(builder, both, [context.make_tuple(builder, occupations, after), again])

    return types.Tuple((types.UniTuple(wide, model.channels), wide))(model, occupied, random), code


@intrinsic
def reflected(typing: Any, model: Any, occupied: Any, flip_x: Any, flip_y: Any) -> Any:
    """Occupations with their x component reversed where flip_x is set, the y component where flip_y is."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        found = _parts(builder, args[1], model.channels)
        for mask, image in zip(args[2:], model.mirror, strict=True):
            found = [
                builder.xor(found[i], builder.and_(mask, builder.xor(found[i], found[image[i]])))
                for i in range(model.channels)
            ]
        return context.make_tuple(builder, sig.return_type, found)

    return types.UniTuple(wide, model.channels)(model, occupied, wide, wide), code


@intrinsic
def pushed(typing: Any, model: Any, occupied: Any, along: Any, against: Any) -> Any:
    """Particles moved from the channel -x to an empty channel +x where `along` is set, back where `against` is.

    Returns the occupations, and the sites where one moved.
    """

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        found = _parts(builder, args[1], model.channels)
        back = model.mirror[0][0]
        plus, minus = found[0], found[back]
        differ = builder.and_(args[2], builder.and_(minus, builder.not_(plus)))
        differ = builder.or_(differ, builder.and_(args[3], builder.and_(plus, builder.not_(minus))))
        found[0], found[back] = builder.xor(plus, differ), builder.xor(minus, differ)
        occupations, both = sig.return_type.types[0], sig.return_type
        return context.make_tuple(builder, both, [context.make_tuple(builder, occupations, found), differ])

    return types.Tuple((types.UniTuple(wide, model.channels), wide))(model, occupied, wide, wide), code


@intrinsic
def chosen(typing: Any, mask: Any, where: Any, elsewhere: Any) -> Any:
    """Tuples of wide words: `where` at the bits of the mask, `elsewhere` at the others."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        number = sig.return_type.count
        pairs = zip(_parts(builder, args[1], number), _parts(builder, args[2], number), strict=True)
        mixed = [builder.xor(b, builder.and_(args[0], builder.xor(a, b))) for a, b in pairs]
        return context.make_tuple(builder, sig.return_type, mixed)

    return where(wide, where, where), code


@intrinsic
def store(typing: Any, occupied: Any, planes: Any, here: Any, size: Any) -> Any:
    """Writes a wide word a channel at `here`, a multiple of WIDTH in an array aligned to 64 bytes."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        for i, word in enumerate(_parts(builder, args[0], sig.args[0].count)):
            index = builder.add(args[2], builder.mul(args[3], ir.Constant(_LANE, i)))
            builder.store(word, _pointer(context, builder, sig.args[1], args[1], index), align=8 * WIDTH)
        return context.get_dummy_value()

    return types.void(occupied, planes, types.intp, types.intp), code
