"""Counts the arithmetic of one filter step in the text from which the kernel is compiled."""

from __future__ import annotations

import ast
from dataclasses import dataclass

from mgeo_attitude import FilterModel
from mgeo_attitude.filter.codegen import CHECK, step_parts


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
    parts = step_parts(model.suite, model.gated)
    return count_text("\n".join(text for name, text in parts.items() if name != CHECK))


def count_text(text: str) -> Count:
    """Count operations of text by numbering values, of every turn of a loop.

    Every expression gets the number of its operator and its operands' numbers, every name that of
    the value last assigned to it; so equal numbers are equal values, and each is counted once.
    """
    numbers: dict[tuple[object, ...], int] = {}
    current: dict[str, int] = {}
    indices: dict[str, int] = {}

    def integer(node: ast.expr) -> int:
        return int(eval(compile(ast.Expression(node), "index", "eval"), {}, indices))

    def place(node: ast.expr) -> str:
        """Of a name or a slot, whose index may be arithmetic of loops' variables."""
        return f"W[{integer(node.slice)}]" if isinstance(node, ast.Subscript) else ast.unparse(node)

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
                text = place(node)
                return current[text] if text in current else number("given", text)
            case ast.Constant(constant):
                return number("constant", constant)
        raise ValueError(f"{ast.unparse(node)}: expected arithmetic")

    def run(lines: list[ast.stmt]) -> None:
        for line in lines:
            match line:
                case ast.Assign([target], expression):
                    current[place(target)] = value(expression)
                case ast.For(ast.Name(name), ast.Call(ast.Name("range"), bounds), body):
                    for indices[name] in range(*map(integer, bounds)):
                        run(body)
                case _:
                    raise ValueError(f"{ast.unparse(line)}: expected an assignment or a loop")

    run(ast.parse(text).body)

    def total(*operators: object) -> int:
        return sum(key[0] in operators for key in numbers)

    return Count(
        multiplications=total(ast.Mult),
        additions=total(ast.Add, ast.Sub),
        divisions=total(ast.Div),
        roots=total("sqrt"),
    )
