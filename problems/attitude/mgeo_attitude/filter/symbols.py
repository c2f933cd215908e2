"""Symbols that write code: every operation on them becomes a line of straight-line Python."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from mgeo_attitude._typing import Ints


@dataclass(frozen=True, eq=False)
class Symbol:
    """A name in `code` for a number; products with zero, and what changes nothing, write no line.

    ``np.sqrt`` takes one, as it takes every object with a method of that name.
    """

    name: str
    code: Code

    def __add__(self, other: Symbol | float) -> Symbol:
        return self if _is(other, 0.0) else self.code.line(f"{self.name} + {_text(other)}")

    def __radd__(self, other: float) -> Symbol:
        return self if _is(other, 0.0) else self.code.line(f"{_text(other)} + {self.name}")

    def __sub__(self, other: Symbol | float) -> Symbol:
        return self if _is(other, 0.0) else self.code.line(f"{self.name} - {_text(other)}")

    def __rsub__(self, other: float) -> Symbol:
        return -self if _is(other, 0.0) else self.code.line(f"{_text(other)} - {self.name}")

    def __neg__(self) -> Symbol:
        return self.code.line(f"-{self.name}")

    def __mul__(self, other: Symbol | float) -> Any:
        if _is(other, 0.0):
            return 0.0
        return self if _is(other, 1.0) else self.code.line(f"{self.name} * {_text(other)}")

    def __rmul__(self, other: float) -> Any:
        return self * other

    def __rtruediv__(self, other: float) -> Symbol:
        return self.code.line(f"{_text(other)} / {self.name}")

    def sqrt(self) -> Symbol:
        return self.code.line(f"sqrt({self.name})")

    def choose(self, bound: float | Symbol, yes: float | Symbol, no: float | Symbol) -> Symbol:
        """One thing where this reaches the bound, another where it does not."""
        text = f"{_text(yes)} if {self.name} >= {_text(bound)} else {_text(no)}"
        return self.code.line(text)

    def maximum(self, other: Symbol) -> Symbol:
        return self.choose(other, self, other)


@dataclass
class Code:
    """Lines of assignments to names and to the slots ``W[k]`` of a workspace."""

    lines: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The lines that what is stored depends on."""
        used: set[str] = set()
        kept = []
        for line in reversed(self.lines):
            target, _, expression = line.partition(" = ")
            if target in used or target.startswith("W"):
                used.update(re.findall(r"t\d+", expression))
                kept.append(line)
        return "\n".join(reversed(kept))

    def line(self, expression: str) -> Symbol:
        """A new name for the value of an expression."""
        self.lines.append(f"t{len(self.lines)} = {expression}")
        return Symbol(f"t{len(self.lines) - 1}", self)

    def slot(self, k: int) -> Symbol:
        return Symbol(f"W[{k}]", self)

    def slots(self, first: int, count: int) -> Sequence[Symbol]:
        return [self.slot(first + k) for k in range(count)]

    def store(self, k: int, value: Symbol | float) -> None:
        self.lines.append(f"W[{k}] = {_text(value)}")


@dataclass(frozen=True)
class Triangle:
    """The lower triangle of a symmetric matrix, row by row, in the first slots of a workspace."""

    code: Code

    def __getitem__(self, index: tuple[int, int]) -> Symbol:
        return self.code.slot(slot_of(*index))

    def __setitem__(self, index: tuple[int, int], value: Symbol | float) -> None:
        self.code.store(slot_of(*index), value)


@cache
def triangle(n: int) -> tuple[Ints, Ints]:
    """Rows and columns of a `Triangle` of n rows, in the order of its slots."""
    return np.tril_indices(n)


def slot_of(i: int, j: int) -> int:
    """Slot of entry (i, j) of a `Triangle`."""
    row, column = max(i, j), min(i, j)
    return row * (row + 1) // 2 + column


def _is(value: Symbol | float, number: float) -> bool:
    return not isinstance(value, Symbol) and value == number


def _text(value: Symbol | float) -> str:
    return value.name if isinstance(value, Symbol) else repr(float(value))
