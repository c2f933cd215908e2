"""Which variables a problem has, and how numbers become its design vectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem
from pymoo.core.variable import Binary, Choice, Integer, Real, Variable

from mgeo._typing import BoolArray, FloatArray
from mgeo.evaluation.individuals import numbers, options_of

Kind = Literal["real", "integer", "binary", "choice"]
KINDS: tuple[Kind, ...] = ("real", "integer", "binary", "choice")

MOST_WHOLE = 2**53 - 1  # in size: floats tell the whole numbers up to it apart
MOST_REAL = 1e150  # in size: the product of two such numbers is a float

_OF_TYPE: tuple[tuple[tuple[type, ...], Kind], ...] = (
    ((bool, np.bool_), "binary"),  # first: a bool is an int
    ((int, np.integer), "integer"),
    ((float, np.floating), "real"),
)
_OF_VARIABLE: dict[type[Variable], Kind] = {
    Real: "real",
    Integer: "integer",
    Binary: "binary",
    Choice: "choice",
}
#: Members of the family that take other variables than real ones.
_TAKERS = (
    "; MGEODirected (mgeo-directed) and MGEOCanonical (mgeo-canonical) take integer, binary and "
    "choice ones, too, and MGEOVar (mgeo-var) integer ones of 3 levels or more"
)
_TYPES: dict[Kind, type] = {"real": float, "integer": int, "binary": bool, "choice": int}


@dataclass(frozen=True, eq=False)
class Variables:
    """The variables of a problem, each with the numbers it may take.

    Attributes
    ----------
    kinds : (n_var) "real", "integer", "binary" (0 or 1) or "choice" (the number of the option,
        from 0).
    xl, xu : (n_var,) bounds of at most `MOST_REAL` in size; unless real, whole numbers of at
        most `MOST_WHOLE`.
    names : (n_var) keys of a design vector, if it is a dict as in `Problem(vars=...)`; else None.
    options : options of each choice, by its key.
    """

    kinds: tuple[Kind, ...]
    xl: FloatArray
    xu: FloatArray
    names: tuple[str, ...] | None = None
    options: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem, allowed: Sequence[Kind]) -> Variables:
        """Those of a problem.

        Raises
        ------
        ValueError : if a variable is of another kind than those allowed, is not bounded, has
            bounds too large to compute with, or no options or equal ones.
        """
        name = type(problem).__name__
        declared: dict[str, Variable] | None = getattr(problem, "vars", None)
        options = options_of(problem)
        if declared is None:
            kind = kind_of_type(problem.vtype)
            kinds = [_require_kind(kind, allowed, f"{name}.vtype", problem.vtype)] * problem.n_var
            bounds: Sequence[Any] = (0, 1) if kind == "binary" else (problem.xl, problem.xu)
        else:
            kinds = [
                _require_kind(_OF_VARIABLE.get(cls), allowed, f"{name}.vars[{key!r}]", cls)
                for key, cls in ((key, type(each)) for key, each in declared.items())
            ]
            pairs = [_bounds(variable, options.get(key)) for key, variable in declared.items()]
            bounds = list(zip(*pairs, strict=True))
        xl, xu = (np.array(np.broadcast_to(bound, problem.n_var), dtype=float) for bound in bounds)
        names = None if declared is None else tuple(declared)
        variables = cls(tuple(kinds), xl, xu, names, options)
        variables._check_bounds(problem)
        return variables

    def _check_bounds(self, problem: Problem) -> None:
        name, real = type(problem).__name__, self.real
        most = np.where(real, MOST_REAL, MOST_WHOLE)
        for key, bound in (("xl", self.xl), ("xu", self.xu)):
            fits = (np.abs(bound) <= most) & (real | (bound == np.rint(bound)))
            for i in np.flatnonzero(~fits).tolist():
                kind = "number" if real[i] else "whole number"
                raise ValueError(
                    f"{name}.{key}[{self.label(i)}] = {bound[i]:g}: expected a finite {kind} of at "
                    f"most {most[i]:g} in size"
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

    @property
    def choice(self) -> BoolArray:
        """(n_var,) mask of the choices, whose numbers are in no order."""
        return np.array([kind == "choice" for kind in self.kinds])

    def designs(self, values: FloatArray) -> NDArray[Any]:
        """(n, n_var) numbers as the problem takes them: floats, ints, bools, or (n,) dicts."""
        if self.names is not None:
            columns = [
                column.astype(_TYPES[kind]).tolist()
                for column, kind in zip(values.T, self.kinds, strict=True)
            ]
            for j, (name, kind) in enumerate(zip(self.names, self.kinds, strict=True)):
                if kind == "choice":
                    columns[j] = [self.options[name][number] for number in columns[j]]
            rows = np.empty(len(values), dtype=object)
            rows[:] = [
                dict(zip(self.names, row, strict=True)) for row in zip(*columns, strict=True)
            ]
            return rows
        return values.astype(_TYPES[self.kinds[0]], copy=False)

    def values(self, designs: NDArray[Any]) -> FloatArray:
        """(n, n_var) numbers of design vectors: the inverse of `designs`."""
        if self.names is None:
            return np.array(designs, dtype=float)
        return numbers(designs, self.names, self.options)


def kind_of_type(vtype: Any) -> Kind | None:
    """The kind of variables that a problem's ``vtype`` says; real for None, None if unknown."""
    if vtype is None:
        return "real"
    known = _OF_TYPE if isinstance(vtype, type) else ()
    return next((kind for types, kind in known if issubclass(vtype, types)), None)


def designs_of(problem: Problem, X: FloatArray) -> NDArray[Any]:
    """Numbers (n, n_var) as the problem takes designs: the inverse of `as_numbers`."""
    if getattr(problem, "vars", None) is None:
        kind = kind_of_type(problem.vtype)
        return X if kind is None else X.astype(_TYPES[kind], copy=False)
    return Variables.of(problem, KINDS).designs(X)


def _require_kind(kind: Kind | None, allowed: Sequence[Kind], where: str, given: Any) -> Kind:
    if kind is None or kind not in allowed:
        takers = _TAKERS if kind else ""
        raise ValueError(f"{where} = {given!r}: expected {' or '.join(allowed)} variables{takers}")
    return kind


def _bounds(variable: Variable, options: Sequence[Any] | None) -> Any:
    if isinstance(variable, Binary):
        return 0, 1
    return variable.bounds if options is None else (0, len(options) - 1)
