"""Atomic counter that threads of compiled code share."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def fetch_add(typing_context: Any, counter: Any, amount: Any) -> Any:
    """``old = counter[0]; counter[0] += amount; return old`` in one indivisible step.

    `counter` is an int64 array; numba has no atomics for processors, LLVM has.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, args[0])
        first = cgutils.get_item_pointer(
            context, builder, signature.args[0], array, [ir.Constant(ir.IntType(64), 0)]
        )
        return builder.atomic_rmw("add", first, args[1], "monotonic")

    return types.int64(counter, types.int64), codegen
