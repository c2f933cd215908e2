"""Symbols that write code: arithmetic on them becomes lines of straight-line Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Symbol:
    """A piece of source text that stands for a number; zeros and ones fold away."""

    text: str
    #: How tightly the text binds: 0 for a sum, 1 for a product, 2 for a name.
    binding: int = 2

    def __add__(self, other: Symbol | float) -> Symbol | float:
        if _is(other, 0.0):
            return self
        return Symbol(f"{self.text} + {_at(0, other)}", 0)

    def __radd__(self, other: float) -> Symbol | float:
        return self if _is(other, 0.0) else Symbol(f"{other!r} + {self.text}", 0)

    def __sub__(self, other: Symbol | float) -> Symbol | float:
        return self if _is(other, 0.0) else Symbol(f"{self.text} - {_at(1, other)}", 0)

    def __rsub__(self, other: float) -> Symbol | float:
        return -self if _is(other, 0.0) else Symbol(f"{other!r} - {_at(1, self)}", 0)

    def __neg__(self) -> Symbol:
        return Symbol(f"-{_at(1, self)}", 1)

    def __mul__(self, other: Symbol | float) -> Symbol | float:
        if _is(other, 0.0):
            return 0.0
        return self if _is(other, 1.0) else Symbol(f"{_at(1, self)} * {_at(2, other)}", 1)

    def __rmul__(self, other: float) -> Symbol | float:
        if _is(other, 0.0):
            return 0.0
        return self if _is(other, 1.0) else Symbol(f"{other!r} * {_at(1, self)}", 1)

    def __rtruediv__(self, other: float) -> Symbol:
        return Symbol(f"{other!r} / {_at(2, self)}", 1)


@dataclass
class SymbolArithmetic:
    """Collects the lines; the `Arithmetic` of symbols."""

    lines: list[str] = field(default_factory=list)
    _temporaries: int = 0

    def keep(self, value: Symbol | float) -> Symbol | float:
        if not isinstance(value, Symbol) or value.binding == 2:
            return value
        self._temporaries += 1
        name = Symbol(f"t{self._temporaries}")
        self.lines.append(f"{name.text} = {value.text}")
        return name

    def sqrt(self, value: Symbol | float) -> Symbol:
        return Symbol(f"sqrt({_text(value)})")

    def at_least(self, value: Symbol | float, bound: Symbol | float) -> Symbol:
        """One where the value reaches the bound, else zero."""
        return self.choose(value, bound, 1.0, 0.0)

    def maximum(self, a: Symbol | float, b: Symbol | float) -> Symbol:
        """The greater of two values."""
        a, b = self.keep(a), self.keep(b)
        return self.choose(a, b, a, b)

    def choose(
        self, value: Symbol | float, bound: Symbol | float, yes: Symbol | float, no: Symbol | float
    ) -> Symbol:
        """One thing where the value reaches the bound, another where it does not."""
        return Symbol(f"({_text(yes)} if {_text(value)} >= {_text(bound)} else {_text(no)})")

    def store(self, slot: str, value: Symbol | float) -> None:
        self.lines.append(f"{slot} = {_text(value)}")


@dataclass(frozen=True)
class SymbolTriangle:
    """Lower triangle in named slots: reading gives the slot's name, writing records a store."""

    slot: Callable[[int, int], str]
    ops: SymbolArithmetic

    def __getitem__(self, index: tuple[int, int]) -> Symbol:
        return Symbol(self.slot(max(index), min(index)))

    def __setitem__(self, index: tuple[int, int], value: Symbol | float) -> None:
        self.ops.store(self.slot(max(index), min(index)), value)


def _is(value: Symbol | float, number: float) -> bool:
    return not isinstance(value, Symbol) and value == number


def _text(value: Symbol | float) -> str:
    return value.text if isinstance(value, Symbol) else repr(float(value))


def _at(binding: int, value: Symbol | float) -> str:
    """Text of a value, in parentheses unless it binds at least as tightly as asked."""
    if isinstance(value, Symbol) and value.binding < binding:
        return f"({value.text})"
    return _text(value)
