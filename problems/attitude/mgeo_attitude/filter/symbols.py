"""Symbols for code generation: every operation on a symbol writes a line of Python source."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from mgeo_attitude._typing import Ints


@dataclass(frozen=True, eq=False)
class Symbol:
    """Symbolic scalar whose arithmetic operators generate code.

    An operator on symbols writes a line of source to `code` and returns a new symbol. Products with
    zero, sums with zero and products with one write no line. ``np.sqrt`` accepts a symbol, as it
    accepts any object with a ``sqrt`` method.
    """

    name: str
    code: Code

    def __add__(self, other: Symbol | float) -> Symbol:
        return (
            self
            if _is_equal(other, 0.0)
            else self.code.define(f"{self.name} + {_format_operand(other)}")
        )

    def __radd__(self, other: float) -> Symbol:
        return (
            self
            if _is_equal(other, 0.0)
            else self.code.define(f"{_format_operand(other)} + {self.name}")
        )

    def __sub__(self, other: Symbol | float) -> Symbol:
        return (
            self
            if _is_equal(other, 0.0)
            else self.code.define(f"{self.name} - {_format_operand(other)}")
        )

    def __rsub__(self, other: float) -> Symbol:
        return (
            -self
            if _is_equal(other, 0.0)
            else self.code.define(f"{_format_operand(other)} - {self.name}")
        )

    def __neg__(self) -> Symbol:
        return self.code.define(f"-{self.name}")

    def __mul__(self, other: Symbol | float) -> Any:
        if not isinstance(other, (Symbol, float, int)):
            return NotImplemented  # The other operand, such as a Vec3, then multiplies itself.
        if _is_equal(other, 0.0):
            return 0.0
        return (
            self
            if _is_equal(other, 1.0)
            else self.code.define(f"{self.name} * {_format_operand(other)}")
        )

    def __rmul__(self, other: float) -> Any:
        return self * other

    def __rtruediv__(self, other: float) -> Symbol:
        return self.code.define(f"{_format_operand(other)} / {self.name}")

    def sqrt(self) -> Symbol:
        return self.code.define(f"sqrt({self.name})")

    def choose(self, bound: float | Symbol, yes: float | Symbol, no: float | Symbol) -> Symbol:
        """Write a conditional expression, and return the symbol of its value.

        The value is `yes` if this symbol is at least `bound`, and `no` otherwise.
        """
        condition = f"{self.name} >= {_format_operand(bound)}"
        return self.code.define(f"{_format_operand(yes)} if {condition} else {_format_operand(no)}")


@dataclass(frozen=True)
class Index:
    """Loop variable of generated code, with its smallest and largest value."""

    text: str
    low: int
    high: int

    def __add__(self, k: int) -> Index:
        return Index(f"{self.text} + {k}", self.low + k, self.high + k) if k else self

    def __str__(self) -> str:
        return self.text


@dataclass
class Code:
    """Python source that is generated line by line.

    The source consists of assignments to names and to workspace slots ``W[k]``, and of loops over
    such assignments.
    """

    lines: list[str] = field(default_factory=list)
    depth: int = 0

    @property
    def text(self) -> str:
        """Generated source, without assignments to unused names."""
        used: set[str] = set()
        lines = []
        for line in reversed(self.lines):
            target, _, expression = line.strip().partition(" = ")
            if target in used or target.startswith(("W", "for ")):
                used.update(re.findall(r"t\d+", expression))
                lines.append(line)
        return "\n".join(reversed(lines))

    def define(self, expression: str) -> Symbol:
        """Assign an expression to a new name, and return the symbol of this name."""
        name = f"t{len(self.lines)}"
        self._write(f"{name} = {expression}")
        return Symbol(name, self)

    @contextmanager
    def loop(self, start: int | Index, stop: int | Index, step: int = 1) -> Iterator[Index]:
        """Generate a loop around the code of a ``with`` block, and yield the loop index.

        The block must generate at least one line.
        """
        name = f"i{len(self.lines)}"
        self._write(f"for {name} in range({start}, {stop}, {step}):")
        self.depth += 1
        yield Index(name, _min_value(start), _max_value(stop) - 1)
        self.depth -= 1

    def slot(self, k: int | str) -> Symbol:
        return Symbol(f"W[{k}]", self)

    def slots(self, first: int, count: int) -> Sequence[Symbol]:
        return [self.slot(first + k) for k in range(count)]

    def store(self, k: int | str, value: Symbol | float) -> None:
        self.assign(self.slot(k), value)

    def assign(self, slot: Symbol, value: Symbol | float) -> None:
        self._write(f"{slot.name} = {_format_operand(value)}")

    def _write(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)


@dataclass(frozen=True)
class Triangle:
    """Symmetric matrix in generated code, stored as its lower triangle in the workspace.

    The entries are stored row by row, starting at slot `first`. The same number of slots, starting
    at `scratch`, is free for intermediate values of loops (`covariance.py`).
    """

    code: Code
    scratch: int = 0
    first: int = 0

    def __getitem__(self, index: tuple[int | Index, int | Index]) -> Symbol:
        return self.code.slot(self._entry_slot(*index))

    def __setitem__(self, index: tuple[int | Index, int | Index], value: Symbol | float) -> None:
        self.code.store(self._entry_slot(*index), value)

    def lower_entry(self, i: int | Index, j: int | Index) -> Symbol:
        """Return the symbol of the matrix entry (i, j), which must be on or below the diagonal."""
        return self.code.slot(self._lower_slot(i, j))

    def _entry_slot(self, i: int | Index, j: int | Index) -> int | str:
        if _min_value(i) >= _max_value(j):
            return self._lower_slot(i, j)
        if _min_value(j) >= _max_value(i):
            return self._lower_slot(j, i)
        return f"{self._lower_slot(i, j)} if {i} >= {j} else {self._lower_slot(j, i)}"

    def _lower_slot(self, i: int | Index, j: int | Index) -> int | str:
        if isinstance(i, Index):
            return f"({i}) * ({i} + 1) // 2 + {j} + {self.first}"
        row = self.first + slot_index(i, 0)
        return row + j if isinstance(j, int) else f"{j} + {row}"


@cache
def triangle_indices(n: int) -> tuple[Ints, Ints]:
    """Return the row and column indices of a lower triangle with n rows, in storage order."""
    return np.tril_indices(n)


def count_slots(n: int) -> int:
    """Return the number of entries in the lower triangle of a symmetric matrix with n rows."""
    return n * (n + 1) // 2


def slot_index(i: int, j: int) -> int:
    """Return the position of entry (i, j) in a symmetric matrix that is stored as its lower
    triangle.
    """
    row, column = max(i, j), min(i, j)
    return count_slots(row) + column


def _min_value(index: int | Index) -> int:
    return index.low if isinstance(index, Index) else index


def _max_value(index: int | Index) -> int:
    return index.high if isinstance(index, Index) else index


def _is_equal(value: Symbol | float, number: float) -> bool:
    return not isinstance(value, Symbol) and value == number


def _format_operand(value: Symbol | float) -> str:
    return value.name if isinstance(value, Symbol) else repr(float(value))
