"""Variables of a problem, and the conversion of its designs to rows of a float array and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem
from pymoo.core.variable import Binary, Choice, Integer, Real, Variable

from mgeo._typing import BoolArray, FloatArray
from mgeo.evaluation.individuals import convert_dicts_to_numbers, get_choice_options

Kind = Literal["real", "integer", "binary", "choice"]
KINDS: tuple[Kind, ...] = ("real", "integer", "binary", "choice")

#: Largest absolute bound of an integer, so that all values are exact as floats.
MAX_INTEGER_BOUND = 2**53 - 1
#: Largest absolute bound of a real variable, so that products of two values are finite.
MAX_REAL_BOUND = 1e150

_KINDS_BY_TYPE: tuple[tuple[tuple[type, ...], Kind], ...] = (
    ((bool, np.bool_), "binary"),  # First, because bool is a subclass of int.
    ((int, np.integer), "integer"),
    ((float, np.floating), "real"),
)
_KINDS_BY_VARIABLE: dict[type[Variable], Kind] = {
    Real: "real",
    Integer: "integer",
    Binary: "binary",
    Choice: "choice",
}
_HINT = (
    ". MGEODirected (mgeo-directed) and MGEOCanonical (mgeo-canonical) also support integer, "
    "binary and choice variables, and MGEOVar (mgeo-var) integers of 3 levels or more"
)
_TYPES: dict[Kind, type] = {"real": float, "integer": int, "binary": bool, "choice": int}


@dataclass(frozen=True, eq=False)
class Variables:
    """Kinds and bounds of the variables of a problem.

    Attributes
    ----------
    kinds : tuple of str, length n_var
        "real", "integer", "binary" (0 or 1) or "choice" (index of the option).
    xl, xu : array, shape (n_var,)
        Bounds: absolute values up to `MAX_REAL_BOUND` for real variables, and integers up to
        `MAX_INTEGER_BOUND` for all others.
    names : tuple of str, length n_var, or None
        Keys of a design if designs are dicts, as in ``Problem(vars=...)``, else None.
    options : mapping of str to tuple
        Options of each choice variable, keyed by variable name.
    """

    kinds: tuple[Kind, ...]
    xl: FloatArray
    xu: FloatArray
    names: tuple[str, ...] | None = None
    options: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)

    @classmethod
    def from_problem(cls, problem: Problem, allowed_kinds: Sequence[Kind]) -> Variables:
        """Read the variables of a problem, and check that their kinds are allowed.

        Parameters
        ----------
        problem : Problem
        allowed_kinds : sequence of str
            Supported kinds of variables.

        Raises
        ------
        ValueError
            If a variable has another kind, has no bounds or too large ones, or is a choice without
            options or with duplicate options.
        """
        name = type(problem).__name__
        declared: dict[str, Variable] | None = getattr(problem, "vars", None)
        options = get_choice_options(problem)
        if declared is None:
            kind = get_kind(problem.vtype)
            kinds = [
                _require_kind(kind, allowed_kinds, f"{name}.vtype", problem.vtype)
            ] * problem.n_var
            bounds: Sequence[Any] = (0, 1) if kind == "binary" else (problem.xl, problem.xu)
        else:
            kinds = [
                _require_kind(
                    _KINDS_BY_VARIABLE.get(cls), allowed_kinds, f"{name}.vars[{key!r}]", cls
                )
                for key, cls in ((key, type(each)) for key, each in declared.items())
            ]
            pairs = [_get_bounds(variable, options.get(key)) for key, variable in declared.items()]
            bounds = list(zip(*pairs, strict=True))
        xl, xu = (np.array(np.broadcast_to(bound, problem.n_var), dtype=float) for bound in bounds)
        names = None if declared is None else tuple(declared)
        variables = cls(tuple(kinds), xl, xu, names, options)
        variables._check_bounds(problem)
        return variables

    def _check_bounds(self, problem: Problem) -> None:
        name, is_real = type(problem).__name__, self.is_real
        max_bounds = np.where(is_real, MAX_REAL_BOUND, MAX_INTEGER_BOUND)
        for key, bound in (("xl", self.xl), ("xu", self.xu)):
            is_valid = (np.abs(bound) <= max_bounds) & (is_real | (bound == np.rint(bound)))
            for i in np.flatnonzero(~is_valid).tolist():
                kind = "number" if is_real[i] else "integer"
                raise ValueError(
                    f"{name}.{key}[{self.format_label(i)}] = {bound[i]:g}: expected a finite "
                    f"{kind} of at most {max_bounds[i]:g} in absolute value"
                )
        if np.any(self.xl > self.xu):
            raise ValueError(f"{name}: expected xl <= xu, got xl = {self.xl}, xu = {self.xu}")

    def format_label(self, variable: int) -> str:
        """Return the label of a variable in messages: the quoted name, or the index."""
        return str(variable) if self.names is None else repr(self.names[variable])

    @property
    def is_real(self) -> BoolArray:
        """Boolean array that is True for the real variables, shape (n_var,)."""
        return np.array([kind == "real" for kind in self.kinds])

    @property
    def is_choice(self) -> BoolArray:
        """Boolean array that is True for the choice variables, shape (n_var,)."""
        return np.array([kind == "choice" for kind in self.kinds])

    def to_designs(self, values: FloatArray) -> NDArray[Any]:
        """Convert rows of numbers to designs that the problem can evaluate.

        Parameters
        ----------
        values : array, shape (n, n_var)
            Values of the variables; the value of a choice is the index of its option.

        Returns
        -------
        array of float, int or bool, shape (n, n_var); or array of dict, shape (n,)
            Dicts if the problem declares its variables as ``Problem(vars=...)``.
        """
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

    def to_numbers(self, designs: NDArray[Any]) -> FloatArray:
        """Convert designs to rows of numbers.

        This is the inverse of `to_designs`.
        """
        if self.names is None:
            return np.array(designs, dtype=float)
        return convert_dicts_to_numbers(designs, self.names, self.options)


def get_kind(vtype: Any) -> Kind | None:
    """Convert the ``vtype`` of a problem to a kind of variable: real, integer or binary.

    Parameters
    ----------
    vtype : type or None
        Attribute ``vtype`` of the problem. None means real variables.

    Returns
    -------
    {"real", "integer", "binary"} or None
        None if the type is not supported.
    """
    if vtype is None:
        return "real"
    kinds = _KINDS_BY_TYPE if isinstance(vtype, type) else ()
    return next((kind for types, kind in kinds if issubclass(vtype, types)), None)


def convert_numbers_to_designs(problem: Problem, X: FloatArray) -> NDArray[Any]:
    """Convert rows of numbers to designs that the problem can evaluate.

    This is the inverse of `mgeo.evaluation.individuals.convert_designs_to_numbers`.

    Parameters
    ----------
    problem : Problem
    X : array, shape (n, n_var)
        Values of the variables; the value of a choice is the index of its option.

    Returns
    -------
    array, shape (n, n_var) or (n,)
        Designs in the form that ``problem.evaluate`` expects.
    """
    if getattr(problem, "vars", None) is None:
        kind = get_kind(problem.vtype)
        return X if kind is None else X.astype(_TYPES[kind], copy=False)
    return Variables.from_problem(problem, KINDS).to_designs(X)


def _require_kind(kind: Kind | None, allowed_kinds: Sequence[Kind], where: str, value: Any) -> Kind:
    if kind is None or kind not in allowed_kinds:
        hint = _HINT if kind else ""
        raise ValueError(
            f"{where} = {value!r}: expected {' or '.join(allowed_kinds)} variables{hint}"
        )
    return kind


def _get_bounds(variable: Variable, options: Sequence[Any] | None) -> Any:
    if isinstance(variable, Binary):
        return 0, 1
    return variable.bounds if options is None else (0, len(options) - 1)
