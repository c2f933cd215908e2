"""Compiles arithmetic into vector instructions, one candidate in each lane.

The text is lines like ``t1 = W[3] * W[5]`` and ``W[3] = t1``, and loops over slots. It means one
candidate; here every name becomes a vector of as many candidates as there are lanes.
LLVM's own vectorizer gets to the same instructions from a loop over the lanes, but needs ten times
as long.

Also what else numba lacks and LLVM has: calls by address, atomic access to int64 arrays.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

# No nnan and ninf: a covariance that breaks down must show as NaN. No reassoc: sums are in the
# order that fuses into multiply-adds best as they are written.
_FLAGS = ("nsz", "arcp", "contract")
_INTEGER = ir.IntType(64)
_OPERATORS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}


def lanewise(text: str, lanes: int) -> Any:
    """A function ``f(W)`` for compiled code that runs `text` for all lanes at once.

    W is a pointer to float64: ``W[k]`` in the text is a lane's ``W[k * lanes + lane]``.

    Parameters
    ----------
    text : str
        Assignments to names or ``W[k]`` of expressions of names, ``W[k]``, numbers, ``+ - * /``,
        ``sqrt(x)`` and ``a if x >= y else b``; and loops ``for i in range(start, stop, step)`` of
        assignments to new names or ``W[k]``. There k, start and stop are integer expressions of
        ``+``, ``*``, ``// 2`` and ``a if i >= j else b`` without negative values.
    lanes : int

    Raises
    ------
    ValueError
        When compiled, for any other text.
    """

    @intrinsic
    def function(typing_context: Any, W: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            builder.call(_function(builder.module, ast.parse(text).body, lanes), args)
            return context.get_dummy_value()

        return types.void(W), codegen

    return function


def _function(module: ir.Module, lines: Sequence[ast.stmt], lanes: int) -> ir.Function:
    """Of its own within the module: a compiler's time grows faster than a function."""
    kind = ir.FunctionType(ir.VoidType(), [ir.DoubleType().as_pointer()])
    function = ir.Function(module, kind, module.get_unique_name("lanewise"))
    function.linkage = "internal"
    attributes = function.attributes
    attributes.add("noinline")
    # What does not fit the registers goes to the stack: there too a vector across two cache lines
    # takes twice as long.
    attributes.add("nounwind")  # llvmlite does not write the next one alone
    attributes.alignstack = 8 * lanes
    if any(isinstance(line, ast.For) for line in lines):
        attributes.add("optsize")  # loops are there to be short: none is unrolled
    builder = ir.IRBuilder(function.append_basic_block())
    writer = _Writer(builder, lanes, function.args[0])
    for line in lines:
        writer.write(line)
    builder.ret_void()
    return function


class _Writer:
    """Writes one instruction for every operation, in the order of the text."""

    def __init__(self, builder: ir.IRBuilder, lanes: int, W: ir.Value) -> None:
        self.builder, self.lanes, self.W = builder, lanes, W
        self.vector = ir.VectorType(ir.DoubleType(), lanes)
        self.values: dict[str, ir.Value] = {}
        self.indices: dict[str, ir.Value] = {}
        self.outside: Collection[str] = ()

    def write(self, line: ast.stmt) -> None:
        match line:
            case ast.Assign([ast.Name(name)], value) if name not in self.outside:
                self.values[name] = self.value(value)
            case ast.Assign([ast.Subscript(ast.Name("W"), k)], value):
                self.builder.store(self.value(value), self.slot(k), align=8)
            case ast.For(
                ast.Name(name),
                ast.Call(ast.Name("range"), [start, stop, ast.Constant(int(step))]),
                body,
            ) if step > 0:
                self.loop(name, self.integer(start), self.integer(stop), step, body)
            case _:
                raise ValueError(
                    f"{ast.unparse(line)}: expected an assignment to a name or W[k], in a loop to "
                    "a new name, or a loop over a range with a step"
                )

    def loop(
        self, name: str, start: ir.Value, stop: ir.Value, step: int, body: Sequence[ast.stmt]
    ) -> None:
        """Write a loop; names of its body are unknown outside, and none carries a value over."""
        builder, values, outside = self.builder, dict(self.values), self.outside
        before, inside = builder.block, builder.append_basic_block(name)
        after = builder.append_basic_block(f"after_{name}")
        builder.cbranch(builder.icmp_signed("<", start, stop), inside, after)
        builder.position_at_end(inside)
        index = builder.phi(_INTEGER, name)
        index.add_incoming(start, before)
        self.indices[name], self.outside = index, {*values}
        for line in body:
            self.write(line)
        following = builder.add(index, _INTEGER(step), flags=["nsw"])
        index.add_incoming(following, builder.block)
        builder.cbranch(builder.icmp_signed("<", following, stop), inside, after)
        builder.position_at_end(after)
        self.values, self.outside = values, outside
        del self.indices[name]

    def value(self, node: ast.expr) -> ir.Value:
        builder = self.builder
        match node:
            case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
                write = getattr(builder, _OPERATORS[type(operator)])
                return write(self.value(left), self.value(right), flags=_FLAGS)
            case ast.UnaryOp(ast.USub(), operand):
                return builder.fneg(self.value(operand), flags=_FLAGS)
            case ast.Call(ast.Name("sqrt"), [argument]):
                kind = ir.FunctionType(self.vector, [self.vector])
                name = f"llvm.sqrt.v{self.lanes}f64"
                sqrt = cgutils.get_or_insert_function(builder.module, kind, name)
                return builder.call(sqrt, [self.value(argument)], fastmath=_FLAGS)
            case ast.IfExp(ast.Compare(left, [ast.GtE()], [right]), yes, no):
                test = builder.fcmp_ordered(">=", self.value(left), self.value(right))
                return builder.select(test, self.value(yes), self.value(no))
            case ast.Constant(float(number)):
                return ir.Constant(self.vector, [number] * self.lanes)
            case ast.Name(name) if name in self.values:
                return self.values[name]
            case ast.Subscript(ast.Name("W"), k):
                return builder.load(self.slot(k), align=8)
        raise ValueError(f"{ast.unparse(node)}: expected arithmetic of names, W[k] and numbers")

    def slot(self, k: ast.expr) -> ir.Value:
        """Pointer to the vector of value k. What is constant in k comes last, as an offset."""
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
                variable = self.builder.mul(self.integer(k), _INTEGER(self.lanes), flags=["nsw"])
                first = self.builder.gep(first, [variable])
        first = self.builder.gep(first, [_INTEGER(constant * self.lanes)])
        return self.builder.bitcast(first, self.vector.as_pointer())

    def integer(self, node: ast.expr) -> ir.Value:
        builder = self.builder
        match node:
            case ast.Constant(int(number)):
                return _INTEGER(number)
            case ast.Name(name) if name in self.indices:
                return self.indices[name]
            case ast.BinOp(left, ast.Add(), right):
                return builder.add(self.integer(left), self.integer(right), flags=["nsw"])
            case ast.BinOp(left, ast.Mult(), right):
                return builder.mul(self.integer(left), self.integer(right), flags=["nsw"])
            case ast.BinOp(left, ast.FloorDiv(), ast.Constant(2)):
                return builder.lshr(self.integer(left), _INTEGER(1))
            case ast.IfExp(ast.Compare(left, [ast.GtE()], [right]), yes, no):
                test = builder.icmp_signed(">=", self.integer(left), self.integer(right))
                return builder.select(test, self.integer(yes), self.integer(no))
        raise ValueError(f"{ast.unparse(node)}: expected integer arithmetic of loops' indices")


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
