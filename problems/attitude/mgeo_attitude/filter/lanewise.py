"""Compiler from scalar arithmetic to vector instructions, with one candidate in each lane.

The source has lines such as ``t1 = W[3] * W[5]`` and ``W[3] = t1``, and loops over slots. It
describes one candidate, and the compiler replaces every name by a vector with one value per lane.
LLVM's vectorizer would derive the same instructions from a loop over the lanes, but takes ten times
as long.

The module also has two operations that numba lacks: calls of a function by its address, and atomic
access to int64 arrays.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

# The flags nnan and ninf are omitted, so that a covariance that is not positive definite gives NaN.
# The flag reassoc is omitted, because the order of the source fuses best into multiply-adds.
_FLAGS = ("nsz", "arcp", "contract")
_INTEGER = ir.IntType(64)
_OPERATORS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}


def lanewise(text: str, n_lanes: int) -> Any:
    """Compile arithmetic source code to a function that evaluates it for several candidates at
    once, one per SIMD lane.

    The function ``f(W)`` can be called from numba code. W is a pointer to float64. The value
    ``W[k]`` in the source is ``W[k * n_lanes + lane]`` in each lane.

    Parameters
    ----------
    text : str
        Assignments to names or ``W[k]`` of expressions of names, ``W[k]``, numbers, ``+ - * /``,
        ``sqrt(x)`` and ``a if x >= y else b``; and loops ``for i in range(start, stop, step)`` of
        assignments to new names or ``W[k]``. The integers k, start and stop are expressions of
        ``+``, ``*``, ``// 2`` and ``a if i >= j else b`` without negative values.
    n_lanes : int
        Number of candidates.

    Raises
    ------
    ValueError
        During compilation, if the source contains anything else.
    """

    @intrinsic
    def function(typing_context: Any, W: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            builder.call(_compile_function(builder.module, ast.parse(text).body, n_lanes), args)
            return context.get_dummy_value()

        return types.void(W), codegen

    return function


def _compile_function(module: ir.Module, lines: Sequence[ast.stmt], n_lanes: int) -> ir.Function:
    """Build an LLVM function that executes a list of statements in all SIMD lanes.

    The source is split into several functions, since they compile faster than a large one.
    """
    kind = ir.FunctionType(ir.VoidType(), [ir.DoubleType().as_pointer()])
    function = ir.Function(module, kind, module.get_unique_name("lanewise"))
    function.linkage = "internal"
    attributes = function.attributes
    attributes.add("noinline")
    # Values that do not fit the registers are on the stack, where a vector across two cache lines
    # also takes twice as long.
    attributes.add("nounwind")  # llvmlite writes `alignstack` only if there is another attribute.
    attributes.alignstack = 8 * n_lanes
    if any(isinstance(line, ast.For) for line in lines):
        attributes.add(
            "optsize"
        )  # This prevents unrolled loops, which exceed the instruction cache.
    builder = ir.IRBuilder(function.append_basic_block())
    writer = _Translator(builder, n_lanes, function.args[0])
    for line in lines:
        writer.write(line)
    builder.ret_void()
    return function


class _Translator:
    """Translator from Python statements to LLVM vector instructions.

    Each operation becomes one instruction, in the order of the source.
    """

    def __init__(self, builder: ir.IRBuilder, lanes: int, W: ir.Value) -> None:
        self.builder, self.n_lanes, self.W = builder, lanes, W
        self.vector = ir.VectorType(ir.DoubleType(), lanes)
        self.values: dict[str, ir.Value] = {}
        self.indices: dict[str, ir.Value] = {}
        self.outer_names: Collection[str] = ()

    def write(self, line: ast.stmt) -> None:
        match line:
            case ast.Assign([ast.Name(name)], value) if name not in self.outer_names:
                self.values[name] = self.translate_value(value)
            case ast.Assign([ast.Subscript(ast.Name("W"), k)], value):
                self.builder.store(self.translate_value(value), self.build_pointer(k), align=8)
            case ast.For(
                ast.Name(name),
                ast.Call(ast.Name("range"), [start, stop, ast.Constant(int(step))]),
                body,
            ) if step > 0:
                self.write_loop(
                    name, self.translate_integer(start), self.translate_integer(stop), step, body
                )
            case _:
                raise ValueError(
                    f"{ast.unparse(line)}: expected an assignment to a name or W[k], in a loop to "
                    "a new name, or a loop over a range with a step"
                )

    def write_loop(
        self, name: str, start: ir.Value, stop: ir.Value, step: int, body: Sequence[ast.stmt]
    ) -> None:
        """Translate a loop over a range to LLVM instructions.

        The names that the body assigns are local to one iteration and undefined after the loop.
        """
        builder, values, outside = self.builder, dict(self.values), self.outer_names
        before, inside = builder.block, builder.append_basic_block(name)
        after = builder.append_basic_block(f"after_{name}")
        builder.cbranch(builder.icmp_signed("<", start, stop), inside, after)
        builder.position_at_end(inside)
        index = builder.phi(_INTEGER, name)
        index.add_incoming(start, before)
        self.indices[name], self.outer_names = index, {*values}
        for line in body:
            self.write(line)
        following = builder.add(index, _INTEGER(step), flags=["nsw"])
        index.add_incoming(following, builder.block)
        builder.cbranch(builder.icmp_signed("<", following, stop), inside, after)
        builder.position_at_end(after)
        self.values, self.outer_names = values, outside
        del self.indices[name]

    def translate_value(self, node: ast.expr) -> ir.Value:
        builder = self.builder
        match node:
            case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
                write = getattr(builder, _OPERATORS[type(operator)])
                return write(self.translate_value(left), self.translate_value(right), flags=_FLAGS)
            case ast.UnaryOp(ast.USub(), operand):
                return builder.fneg(self.translate_value(operand), flags=_FLAGS)
            case ast.Call(ast.Name("sqrt"), [argument]):
                kind = ir.FunctionType(self.vector, [self.vector])
                name = f"llvm.sqrt.v{self.n_lanes}f64"
                sqrt = cgutils.get_or_insert_function(builder.module, kind, name)
                return builder.call(sqrt, [self.translate_value(argument)], fastmath=_FLAGS)
            case ast.IfExp(ast.Compare(left, [ast.GtE()], [right]), yes, no):
                test = builder.fcmp_ordered(
                    ">=", self.translate_value(left), self.translate_value(right)
                )
                return builder.select(test, self.translate_value(yes), self.translate_value(no))
            case ast.Constant(float(number)):
                return ir.Constant(self.vector, [number] * self.n_lanes)
            case ast.Name(name) if name in self.values:
                return self.values[name]
            case ast.Subscript(ast.Name("W"), k):
                return builder.load(self.build_pointer(k), align=8)
        raise ValueError(f"{ast.unparse(node)}: expected arithmetic of names, W[k] and numbers")

    def build_pointer(self, k: ast.expr) -> ir.Value:
        """Return a pointer to the values of ``W[k]`` in all SIMD lanes.

        A constant summand of k becomes a constant offset.
        """
        constant, first = 0, self.W
        while isinstance(k, ast.BinOp) and isinstance(k.op, ast.Add):
            match k.right:
                case ast.Constant(int(number)):
                    constant, k = constant + number, k.left
                case _:
                    break
        match k:
            case ast.Constant(int(number)):
                constant += number
            case _:
                variable = self.builder.mul(
                    self.translate_integer(k), _INTEGER(self.n_lanes), flags=["nsw"]
                )
                first = self.builder.gep(first, [variable])
        first = self.builder.gep(first, [_INTEGER(constant * self.n_lanes)])
        return self.builder.bitcast(first, self.vector.as_pointer())

    def translate_integer(self, node: ast.expr) -> ir.Value:
        builder = self.builder
        match node:
            case ast.Constant(int(number)):
                return _INTEGER(number)
            case ast.Name(name) if name in self.indices:
                return self.indices[name]
            case ast.BinOp(left, ast.Add(), right):
                return builder.add(
                    self.translate_integer(left), self.translate_integer(right), flags=["nsw"]
                )
            case ast.BinOp(left, ast.Mult(), right):
                return builder.mul(
                    self.translate_integer(left), self.translate_integer(right), flags=["nsw"]
                )
            case ast.BinOp(left, ast.FloorDiv(), ast.Constant(2)):
                return builder.lshr(self.translate_integer(left), _INTEGER(1))
            case ast.IfExp(ast.Compare(left, [ast.GtE()], [right]), yes, no):
                test = builder.icmp_signed(
                    ">=", self.translate_integer(left), self.translate_integer(right)
                )
                return builder.select(test, self.translate_integer(yes), self.translate_integer(no))
        raise ValueError(f"{ast.unparse(node)}: expected integer arithmetic of loop indices")


_ALIGNMENT = 8


@intrinsic
def call_address(typing_context: Any, function: Any, pointer: Any) -> Any:
    """Call the C function ``void f(double *)`` at an address, with `pointer` as its argument."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        values = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [values]).as_pointer()
        builder.call(builder.inttoptr(args[0], kind), [builder.inttoptr(args[1], values)])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), codegen


@intrinsic
def fetch_add(typing_context: Any, counter: Any, amount: Any) -> Any:
    """Atomically add `amount` to ``counter[0]`` and return the previous value."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        first = _build_item_pointer(
            context, builder, signature, args[0], context.get_constant(types.int64, 0)
        )
        return builder.atomic_rmw("add", first, args[1], "monotonic")

    return types.int64(counter, types.int64), codegen


@intrinsic
def store_release(typing_context: Any, flags: Any, index: Any, value: Any) -> Any:
    """Atomically set ``flags[index]`` to `value`.

    A thread that reads the value by `load_acquire` also sees all earlier writes of the calling
    thread.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _build_item_pointer(context, builder, signature, args[0], args[1])
        builder.store_atomic(args[2], place, "release", _ALIGNMENT)
        return context.get_dummy_value()

    return types.void(flags, types.int64, types.int64), codegen


@intrinsic
def load_acquire(typing_context: Any, flags: Any, index: Any) -> Any:
    """Atomically read and return ``flags[index]``.

    All writes that preceded the `store_release` of the value are then visible to the calling
    thread.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _build_item_pointer(context, builder, signature, args[0], args[1])
        return builder.load_atomic(place, "acquire", _ALIGNMENT)

    return types.int64(flags, types.int64), codegen


def _build_item_pointer(context: Any, builder: Any, signature: Any, array: Any, index: Any) -> Any:
    struct = context.make_array(signature.args[0])(context, builder, array)
    return cgutils.get_item_pointer(context, builder, signature.args[0], struct, [index])
