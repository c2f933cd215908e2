"""Compiles straight-line arithmetic into vector instructions, one candidate in each lane.

The text is lines like ``t1 = W[3] * W[5]`` and ``W[3] = t1``. It means one candidate; here every
name becomes a vector of as many candidates as there are lanes. LLVM's own vectorizer gets to the
same instructions from a loop over the lanes, but needs ten times as long.
"""

from __future__ import annotations

import ast
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

# No nnan and ninf: a covariance that breaks down must show as NaN. No reassoc: sums are in the
# order that fuses into multiply-adds best as they are written.
_FLAGS = ("nsz", "arcp", "contract")
_OPERATORS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}


def lanewise(text: str, lanes: int) -> Any:
    """A function ``f(W)`` for compiled code that runs `text` for all lanes at once.

    W is a pointer to float64: ``W[k]`` in the text is a lane's ``W[k * lanes + lane]``.

    Parameters
    ----------
    text : str
        Assignments to names or ``W[k]`` of expressions of names, ``W[k]``, numbers, ``+ - * /``,
        ``sqrt(x)`` and ``a if x >= y else b``.
    lanes : int

    Raises
    ------
    ValueError
        When compiled, for any other text.
    """

    @intrinsic
    def function(typing_context: Any, W: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            writer = _Writer(builder, lanes, args[0])
            # What does not fit the registers goes to the stack: there too a vector across two
            # cache lines takes twice as long.
            attributes = builder.function.attributes
            attributes.add("nounwind")  # llvmlite does not write the next one alone
            attributes.alignstack = 8 * lanes
            for line in ast.parse(text).body:
                writer.assign(line)
            return context.get_dummy_value()

        return types.void(W), codegen

    return function


class _Writer:
    """Writes one instruction for every operation, in the order of the text."""

    def __init__(self, builder: ir.IRBuilder, lanes: int, W: ir.Value) -> None:
        self.builder, self.lanes, self.W = builder, lanes, W
        self.vector = ir.VectorType(ir.DoubleType(), lanes)
        self.values: dict[str, ir.Value] = {}

    def assign(self, line: ast.stmt) -> None:
        match line:
            case ast.Assign([ast.Name(name)], value):
                self.values[name] = self.value(value)
            case ast.Assign([ast.Subscript(ast.Name("W"), ast.Constant(int(k)))], value):
                self.builder.store(self.value(value), self.slot(k), align=8)
            case _:
                raise ValueError(f"{ast.unparse(line)}: expected an assignment to a name or W[k]")

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
            case ast.Subscript(ast.Name("W"), ast.Constant(int(k))):
                return builder.load(self.slot(k), align=8)
        raise ValueError(f"{ast.unparse(node)}: expected straight-line arithmetic")

    def slot(self, k: int) -> ir.Value:
        """Pointer to the vector of value k."""
        first = self.builder.gep(self.W, [ir.Constant(ir.IntType(64), k * self.lanes)])
        return self.builder.bitcast(first, self.vector.as_pointer())
