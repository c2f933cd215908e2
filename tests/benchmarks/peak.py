"""The processor's multiply-add peak: vector multiply-adds that never leave the registers."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from mgeo_attitude.filter.kernel import lanes
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

#: Independent chains of multiply-adds: more than latency times units of any processor (Intel: 4
#: cycles x 2), and few enough that with the two constants 16 registers hold them.
CHAINS = 12


@intrinsic
def _chains(typing_context: Any, iterations: Any) -> Any:
    """CHAINS vector accumulators, each a ← a x + y in every iteration; returns their sum."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.VectorType(ir.DoubleType(), lanes())

        def constant(number: float) -> ir.Constant:
            return ir.Constant(vector, [number] * lanes())

        fma = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fma.v{lanes()}f64"
        )
        # allocated in memory as numba does; LLVM's first pass moves them to registers
        accumulators = [
            cgutils.alloca_once_value(builder, constant(float(k))) for k in range(CHAINS)
        ]
        with cgutils.for_range(builder, args[0]):
            for slot in accumulators:
                operands = [builder.load(slot), constant(0.5), constant(1.0)]
                builder.store(builder.call(fma, operands), slot)
        total = builder.load(accumulators[0])
        for slot in accumulators[1:]:
            total = builder.fadd(total, builder.load(slot))
        result = ir.Constant(ir.DoubleType(), 0.0)
        for lane in range(lanes()):
            element = builder.extract_element(total, ir.Constant(ir.IntType(32), lane))
            result = builder.fadd(result, element)
        return result

    return types.float64(types.int64), codegen


@njit("float64(int64)", nogil=True)
def multiply_adds(iterations):
    """Do `iterations` x CHAINS x lanes() multiply-adds."""
    return _chains(iterations)


def multiply_adds_of(iterations: int) -> int:
    """How many multiply-adds `multiply_adds` does."""
    return iterations * CHAINS * lanes()
