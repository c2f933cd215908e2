"""Counts the arithmetic of one filter step in the text from which the kernel is compiled."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from mgeo_attitude import FilterModel
from mgeo_attitude.filter.codegen import step_source


@dataclass(frozen=True)
class Count:
    """Operations of one filter step of one candidate.

    ``multiplications`` is also the number of multiply-adds that the step needs: nearly every
    product has a sum to be fused with, and additions without one are not counted as multiply-adds.
    """

    multiplications: int
    additions: int
    divisions: int
    roots: int

    @property
    def flops(self) -> int:
        return self.multiplications + self.additions + self.divisions + self.roots


def count_step(model: FilterModel) -> Count:
    """Count the distinct operations of a step: what is computed twice is needed once."""
    return count_source(step_source(model.suite, model.gated, lanes=1))


def count_source(source: str) -> Count:
    """Count operations of the function ``step``, with the functions it calls, by numbering values.

    Every expression gets the number of its operator and its operands' numbers, every name that of
    the value last assigned to it; so equal numbers are equal values, and each is counted once.
    """
    numbers: dict[tuple[object, ...], int] = {}
    current: dict[str, int] = {}

    def number(*key: object) -> int:
        return numbers.setdefault(key, len(numbers))

    def value(node: ast.expr) -> int:
        match node:
            case ast.BinOp(left, ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as operator, right):
                return number(type(operator), value(left), value(right))
            case ast.UnaryOp(ast.USub(), operand):
                return number(ast.USub, value(operand))
            case ast.Call(ast.Name("sqrt"), [argument]):
                return number("sqrt", value(argument))
            case ast.IfExp(ast.Compare(left, [_], [bound]), _, _):
                return number("compare", value(left), value(bound))
            case ast.Name() | ast.Subscript():
                text = ast.unparse(node)
                return current[text] if text in current else number("given", text)
            case ast.Constant(constant):
                return number("constant", constant)
        raise ValueError(f"{ast.unparse(node)}: expected straight-line arithmetic")

    for assignment in _assignments(ast.parse(source), "step"):
        result = value(assignment.value)
        current[ast.unparse(assignment.targets[0])] = result

    def total(*operators: object) -> int:
        return sum(key[0] in operators for key in numbers)

    return Count(
        multiplications=total(ast.Mult),
        additions=total(ast.Add, ast.Sub),
        divisions=total(ast.Div),
        roots=total("sqrt"),
    )


def _assignments(module: ast.Module, name: str) -> Iterator[ast.Assign]:
    """Assignments of a function of straight lines, lane loops and calls, in the order they run."""
    functions = {node.name: node for node in module.body if isinstance(node, ast.FunctionDef)}
    for node in functions[name].body:
        match node:
            case ast.Expr(ast.Call(ast.Name(called))):
                yield from _assignments(module, called)
            case ast.For():
                yield from (line for line in node.body if isinstance(line, ast.Assign))
            case ast.Assign():
                yield node
