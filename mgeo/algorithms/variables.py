"""Which variables a problem has, and how numbers become design vectors as it wants them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem
from pymoo.core.variable import Binary, Integer, Real, Variable

from mgeo._typing import BoolArray, FloatArray

Kind = Literal["real", "integer", "binary"]

MOST_WHOLE = 2**53 - 1  # in size: floats tell the whole numbers up to it apart
MOST_REAL = 1e150  # in size: the product of two such numbers is a float

_OF_TYPE: tuple[tuple[tuple[type, ...], Kind], ...] = (
    ((bool, np.bool_), "binary"),  # first: a bool is an int
    ((int, np.integer), "integer"),
    ((float, np.floating), "real"),
)
_OF_VARIABLE: dict[type[Variable], Kind] = {Real: "real", Integer: "integer", Binary: "binary"}


@dataclass(frozen=True, eq=False)
class Variables:
    """The variables of a problem, each with the numbers it may take.

    Attributes
    ----------
    kinds : (n_var) "real", "integer" or "binary" (0 or 1).
    xl, xu : (n_var,) bounds of at most `MOST_REAL` in size; unless real, whole numbers of at
        most `MOST_WHOLE`.
    names : (n_var) keys of a design vector, if it is a dict as in `Problem(vars=...)`; else None.
    """

    kinds: tuple[Kind, ...]
    xl: FloatArray
    xu: FloatArray
    names: tuple[str, ...] | None = None

    @classmethod
    def of(cls, problem: Problem, allowed: Sequence[Kind]) -> Variables:
        """Those of a problem.

        Raises
        ------
        ValueError : if a variable is of another kind than those allowed, is not bounded, or has
            bounds too large to compute with.
        """
        name = type(problem).__name__
        if (declared := getattr(problem, "vars", None)) is not None:
            for key, variable in declared.items():
                if _OF_VARIABLE.get(type(variable)) not in allowed:
                    raise ValueError(
                        f"{name}.vars[{key!r}] is a {type(variable).__name__}: expected "
                        f"{_listed(allowed)} variables"
                    )
            names = tuple(declared)
            kinds = tuple(_OF_VARIABLE[type(variable)] for variable in declared.values())
            given = [
                (0, 1) if isinstance(variable, Binary) else variable.bounds
                for variable in declared.values()
            ]
            xl, xu = (_numbers([pair[side] for pair in given]) for side in (0, 1))
        else:
            names = None
            kinds = (_kind(problem.vtype, name, allowed),) * problem.n_var
            xl, xu = (_numbers(bound, problem.n_var) for bound in (problem.xl, problem.xu))
            if kinds[0] == "binary":
                xl, xu = np.zeros(problem.n_var), np.ones(problem.n_var)
        variables = cls(kinds, xl, xu, names)
        variables._check_bounds(problem)
        return variables

    def _check_bounds(self, problem: Problem) -> None:
        name, whole = type(problem).__name__, ~self.real
        for key, bound in (("xl", self.xl), ("xu", self.xu)):
            if not np.isfinite(bound).all():
                shown = getattr(problem, key)
                raise ValueError(
                    f"{name}.{key} = {shown}: expected a finite bound for every variable"
                )
            if np.any(bound[whole] != np.rint(bound[whole])):
                raise ValueError(
                    f"{name}.{key} = {bound}: expected whole numbers for integer variables"
                )
            if np.any(large := np.abs(bound) > np.where(whole, MOST_WHOLE, MOST_REAL)):
                i = int(large.argmax())
                value, most = (int(bound[i]), MOST_WHOLE) if whole[i] else (bound[i], MOST_REAL)
                raise ValueError(
                    f"{name}.{key}[{self.label(i)}] = {value}: expected a bound of at most {most} "
                    "in size, to compute with it in floats"
                )
        if np.any(self.xl > self.xu):
            raise ValueError(f"{name}: expected xl <= xu, got xl = {self.xl}, xu = {self.xu}")

    def label(self, variable: int) -> str:
        """How to name a variable in a message: by its number, or as the key that it has."""
        return str(variable) if self.names is None else repr(self.names[variable])

    @property
    def real(self) -> BoolArray:
        """(n_var,) mask of the real ones."""
        return np.array([kind == "real" for kind in self.kinds])

    def designs(self, values: FloatArray) -> NDArray[Any]:
        """(n, n_var) numbers as the problem takes them: floats, ints, bools, or (n,) dicts."""
        if self.names is not None:
            types = [{"real": float, "integer": int, "binary": bool}[kind] for kind in self.kinds]
            columns = [
                column.astype(kind).tolist() for column, kind in zip(values.T, types, strict=True)
            ]
            rows = np.empty(len(values), dtype=object)
            rows[:] = [
                dict(zip(self.names, row, strict=True)) for row in zip(*columns, strict=True)
            ]
            return rows
        if self.kinds[0] == "real":
            return values
        return values.astype(bool if self.kinds[0] == "binary" else int)

    def values(self, designs: NDArray[Any]) -> FloatArray:
        """(n, n_var) numbers of design vectors: the inverse of `designs`."""
        if self.names is None:
            return np.array(designs, dtype=float)
        return np.array([[design[name] for name in self.names] for design in designs], dtype=float)


def _kind(vtype: Any, name: str, allowed: Sequence[Kind]) -> Kind:
    given = float if vtype is None else vtype
    for types, kind in _OF_TYPE:
        if isinstance(given, type) and issubclass(given, types):
            if kind in allowed:
                return kind
            break
    raise ValueError(f"{name} has vtype = {vtype!r}: expected {_listed(allowed)} variables")


def _listed(kinds: Sequence[Kind]) -> str:
    return " or ".join(kinds)


def _numbers(bound: Any, n: int | None = None) -> FloatArray:
    if bound is None:
        return np.full(n or 0, np.nan)
    return np.array([_number(value) for value in np.ravel(bound)])


def _number(bound: Any) -> float:
    try:
        return np.nan if bound is None else float(bound)
    except OverflowError:  # an integer that no float can hold
        return np.inf if bound > 0 else -np.inf
