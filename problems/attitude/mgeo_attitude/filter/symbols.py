"""Symbols that write code: every operation on them becomes a line of Python."""

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
        if not isinstance(other, (Symbol, float, int)):
            return NotImplemented  # a vector multiplies its components
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


@dataclass(frozen=True)
class Index:
    """An integer of which only bounds are known while code is written: a loop's variable."""

    text: str
    low: int
    high: int

    def __add__(self, k: int) -> Index:
        return Index(f"{self.text} + {k}", self.low + k, self.high + k) if k else self

    def __str__(self) -> str:
        return self.text


@dataclass
class Code:
    """Lines of assignments to names and to the slots ``W[k]`` of a workspace, and loops of such."""

    lines: list[str] = field(default_factory=list)
    depth: int = 0

    @property
    def text(self) -> str:
        """The lines that what is stored depends on."""
        used: set[str] = set()
        kept = []
        for line in reversed(self.lines):
            target, _, expression = line.strip().partition(" = ")
            if target in used or target.startswith(("W", "for ")):
                used.update(re.findall(r"t\d+", expression))
                kept.append(line)
        return "\n".join(reversed(kept))

    def line(self, expression: str) -> Symbol:
        """A new name for the value of an expression."""
        name = f"t{len(self.lines)}"
        self._write(f"{name} = {expression}")
        return Symbol(name, self)

    @contextmanager
    def loop(self, start: int | Index, stop: int | Index, step: int = 1) -> Iterator[Index]:
        """What is written meanwhile is done for all indices of a range; at least one line."""
        name = f"i{len(self.lines)}"
        self._write(f"for {name} in range({start}, {stop}, {step}):")
        self.depth += 1
        yield Index(name, _low(start), _high(stop) - 1)
        self.depth -= 1

    def slot(self, k: int | str) -> Symbol:
        return Symbol(f"W[{k}]", self)

    def slots(self, first: int, count: int) -> Sequence[Symbol]:
        return [self.slot(first + k) for k in range(count)]

    def store(self, k: int | str, value: Symbol | float) -> None:
        self.assign(self.slot(k), value)

    def assign(self, slot: Symbol, value: Symbol | float) -> None:
        self._write(f"{slot.name} = {_text(value)}")

    def _write(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)


@dataclass(frozen=True)
class Triangle:
    """The lower triangle of a symmetric matrix, row by row, in the slots from `first` on.

    As many slots from `scratch` on are free, if loops need them (`loops.py`).
    """

    code: Code
    scratch: int = 0
    first: int = 0

    def __getitem__(self, index: tuple[int | Index, int | Index]) -> Symbol:
        return self.code.slot(self._place(*index))

    def __setitem__(self, index: tuple[int | Index, int | Index], value: Symbol | float) -> None:
        self.code.store(self._place(*index), value)

    def below(self, i: int | Index, j: int | Index) -> Symbol:
        """Entry (i, j) where i >= j is known."""
        return self.code.slot(self._below(i, j))

    def _place(self, i: int | Index, j: int | Index) -> int | str:
        if _low(i) >= _high(j):
            return self._below(i, j)
        if _low(j) >= _high(i):
            return self._below(j, i)
        return f"{self._below(i, j)} if {i} >= {j} else {self._below(j, i)}"

    def _below(self, i: int | Index, j: int | Index) -> int | str:
        if isinstance(i, Index):
            return f"({i}) * ({i} + 1) // 2 + {j} + {self.first}"
        row = self.first + slot_of(i, 0)
        return row + j if isinstance(j, int) else f"{j} + {row}"


@cache
def triangle(n: int) -> tuple[Ints, Ints]:
    """Rows and columns of a `Triangle` of n rows, in the order of its slots."""
    return np.tril_indices(n)


def slots_of(n: int) -> int:
    """Number of slots of a `Triangle` of n rows."""
    return n * (n + 1) // 2


def slot_of(i: int, j: int) -> int:
    """Slot of entry (i, j) of a `Triangle`."""
    row, column = max(i, j), min(i, j)
    return slots_of(row) + column


def _low(index: int | Index) -> int:
    return index.low if isinstance(index, Index) else index


def _high(index: int | Index) -> int:
    return index.high if isinstance(index, Index) else index


def _is(value: Symbol | float, number: float) -> bool:
    return not isinstance(value, Symbol) and value == number


def _text(value: Symbol | float) -> str:
    return value.name if isinstance(value, Symbol) else repr(float(value))
