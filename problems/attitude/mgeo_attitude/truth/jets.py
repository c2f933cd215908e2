"""Numbers that carry their derivatives: second-order Taylor arithmetic over any scalar.

Evaluated on jets, an expression in ``+ - * /`` gives its value, gradient and second derivatives.
With symbols for scalars they become the text of the generated code; zeros fold away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from typing import Any

#: Gives an intermediate result that is used more than once a name; see `covariance.Arithmetic`.
Keep = Callable[[Any], Any]


@dataclass(frozen=True)
class Jet:
    """Value, first and second partial derivatives by the numbers of their variables.

    Derivatives that are zero for certain are left out; a second one is at (i, j) with i <= j.
    """

    value: Any
    keep: Keep
    first: Mapping[int, Any] = field(default_factory=dict)
    second: Mapping[tuple[int, int], Any] = field(default_factory=dict)

    def gradient(self, i: int) -> Any:
        return self.first.get(i, 0.0)

    def hessian(self, i: int, j: int) -> Any:
        return self.second.get((min(i, j), max(i, j)), 0.0)

    def __neg__(self) -> Jet:
        return self._combined(
            -self.value, lambda i: -self.gradient(i), lambda i, j: -self.hessian(i, j), self
        )

    def __add__(self, other: Any) -> Jet:
        other = self._jet(other)
        return self._combined(
            self.value + other.value,
            lambda i: self.gradient(i) + other.gradient(i),
            lambda i, j: self.hessian(i, j) + other.hessian(i, j),
            other,
        )

    def __radd__(self, other: Any) -> Jet:
        return self.__add__(other)

    def __sub__(self, other: Any) -> Jet:
        other = self._jet(other)
        return self._combined(
            self.value - other.value,
            lambda i: self.gradient(i) - other.gradient(i),
            lambda i, j: self.hessian(i, j) - other.hessian(i, j),
            other,
        )

    def __rsub__(self, other: Any) -> Jet:
        return self._jet(other).__sub__(self)

    def __mul__(self, other: Any) -> Jet:
        other = self._jet(other)
        a, b = self, other
        return self._combined(
            a.value * b.value,
            lambda i: a.gradient(i) * b.value + b.gradient(i) * a.value,
            lambda i, j: (
                a.hessian(i, j) * b.value
                + b.hessian(i, j) * a.value
                + a.gradient(i) * b.gradient(j)
                + a.gradient(j) * b.gradient(i)
            ),
            other,
        )

    def __rmul__(self, other: Any) -> Jet:
        return self.__mul__(other)

    def __rtruediv__(self, other: Any) -> Jet:
        return self._reciprocal().__mul__(other)

    def __truediv__(self, other: Any) -> Jet:
        return self.__mul__(self._jet(other)._reciprocal())

    def _reciprocal(self) -> Jet:
        r = self.keep(1.0 / self.value)
        r2 = self.keep(r * r)
        twice_r3 = self.keep(2.0 * (r2 * r))
        return self._combined(
            r,
            lambda i: -(self.gradient(i) * r2),
            lambda i, j: self.gradient(i) * self.gradient(j) * twice_r3 - self.hessian(i, j) * r2,
            self,
        )

    def _jet(self, other: Any) -> Jet:
        return other if isinstance(other, Jet) else Jet(other, self.keep)

    def _variables(self) -> set[int]:
        # a product of two variables that are zero has second derivatives only
        return {*self.first, *(i for pair in self.second for i in pair)}

    def _combined(
        self,
        value: Any,
        gradient: Callable[[int], Any],
        hessian: Callable[[int, int], Any],
        other: Jet,
    ) -> Jet:
        variables = sorted(self._variables() | other._variables())
        pairs: Iterable[tuple[int, int]] = combinations_with_replacement(variables, 2)
        first = {i: self.keep(gradient(i)) for i in variables}
        second = {(i, j): self.keep(hessian(i, j)) for i, j in pairs}
        return Jet(self.keep(value), self.keep, _nonzero(first), _nonzero(second))


def variable(value: Any, number: int, keep: Keep) -> Jet:
    """The jet of a variable itself."""
    return Jet(value, keep, {number: 1.0})


def _nonzero(derivatives: dict[Any, Any]) -> dict[Any, Any]:
    return {key: d for key, d in derivatives.items() if not (isinstance(d, float) and d == 0.0)}
