"""What compiled code needs and numba lacks: calls by address, and atomic access to int64 arrays.

numba has no atomics for processors, LLVM has.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_ALIGNMENT = 8


@intrinsic
def call(typing_context: Any, function: Any, pointer: Any) -> Any:
    """Call a C function ``void f(double *)`` by its address, with an address; both are int64."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        values = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [values]).as_pointer()
        builder.call(builder.inttoptr(args[0], kind), [builder.inttoptr(args[1], values)])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), codegen


@intrinsic
def fetch_add(typing_context: Any, counter: Any, amount: Any) -> Any:
    """``old = counter[0]; counter[0] += amount; return old`` in one indivisible step."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        first = _pointer(context, builder, signature, args[0], context.get_constant(types.int64, 0))
        return builder.atomic_rmw("add", first, args[1], "monotonic")

    return types.int64(counter, types.int64), codegen


@intrinsic
def store_release(typing_context: Any, flags: Any, index: Any, value: Any) -> Any:
    """``flags[index] = value``, after everything this thread wrote before."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _pointer(context, builder, signature, args[0], args[1])
        builder.store_atomic(args[2], place, "release", _ALIGNMENT)
        return context.get_dummy_value()

    return types.void(flags, types.int64, types.int64), codegen


@intrinsic
def load_acquire(typing_context: Any, flags: Any, index: Any) -> Any:
    """``flags[index]``; what its writer wrote before storing it is then seen as well."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _pointer(context, builder, signature, args[0], args[1])
        return builder.load_atomic(place, "acquire", _ALIGNMENT)

    return types.int64(flags, types.int64), codegen


def _pointer(context: Any, builder: Any, signature: Any, array: Any, index: Any) -> Any:
    struct = context.make_array(signature.args[0])(context, builder, array)
    return cgutils.get_item_pointer(context, builder, signature.args[0], struct, [index])
