"""Prefetch: a hint to the processor which memory is needed soon."""

from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils

from refimpl.compilation import instruction


def _no_hint(array: Any, offset: int) -> None:
    pass


@instruction(_no_hint)
def prefetch(typing_context: Any, array: Any, offset: Any) -> Any:
    """Loads the cache line `offset` bytes behind the start of a contiguous array, if there is time for it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        byte, flag = ir.IntType(8).as_pointer(), ir.IntType(32)
        place = builder.gep(builder.bitcast(data, byte), [arguments[1]])
        hint = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(ir.VoidType(), [byte, flag, flag, flag]), "llvm.prefetch.p0"
        )
        builder.call(hint, [place, flag(0), flag(3), flag(1)])
        return context.get_dummy_value()

    return types.void(array, offset), code
