"""Evaluation of a batch in which some candidates fail, and the cause of each failure."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem, default_shape

from mgeo._text import one_line

Values = dict[str, NDArray[Any]]
_LONGEST = 200  # characters of a cause


@dataclass(frozen=True)
class Failure:
    """Cause of a failure in one line, and the traceback if there was an exception."""

    cause: str
    trace: str = ""

    @classmethod
    def of(cls, error: Exception) -> Failure:
        """Return the failure of an exception that is being handled."""
        text = one_line(f"{type(error).__name__}: {error}").removesuffix(":")
        return cls(text[:_LONGEST], "".join(traceback.format_exception(error)).rstrip())


Part = tuple[Values, dict[int, Failure]]


def attempt(
    problem: Problem, X: NDArray[Any], names: Sequence[str], options: Mapping[str, Any]
) -> Part:
    """Evaluate all candidates that do not fail.

    A batch that raises is halved until the candidates that raise are alone. An exception of an
    elementwise problem is caught at its element, so that no other candidate is evaluated again.

    Parameters
    ----------
    problem : a pymoo problem, elementwise or not.
    X : (n, n_var) candidates, or (n,) objects.
    names : values to evaluate, as in `Problem.evaluate`: "F", "G", "H".
    options : further keywords for `Problem.evaluate`.

    Returns
    -------
    values : values by name, n rows each; NaN in rows that raised.
    failures : by row.

    Raises
    ------
    Exception
        The exception of the runner of an elementwise problem, if it is the same for each of
        several candidates: then evaluation itself does not work.
    """

    def evaluate(candidates: NDArray[Any]) -> Part:
        raised: dict[int, Failure] = {}
        guarded = _guarded(problem, raised) if problem.elementwise else problem
        values = guarded.evaluate(
            candidates, return_values_of=names, return_as_dictionary=True, **options
        )
        return values, raised

    parts = _by_halves(evaluate, X)
    errors = [part for part in parts if isinstance(part, Exception)]
    pattern = next((part[0] for part in parts if not isinstance(part, Exception)), None)
    if pattern is None:
        if problem.elementwise and len(X) > 1 and len(set(map(repr, errors))) == 1:
            raise errors[0]
        shapes = default_shape(problem, 0)
        pattern = {name: np.empty(shapes.get(name, (0,))) for name in names}
    failures: dict[int, Failure] = {}
    pieces: list[Values] = []
    row = 0
    for part in parts:
        if isinstance(part, Exception):
            failures[row] = Failure.of(part)
            pieces.append({name: _missing(value) for name, value in pattern.items()})
            row += 1
        else:
            values, raised = part
            failures |= {row + i: failure for i, failure in raised.items()}
            pieces.append(values)
            row += len(next(iter(values.values())))
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in pattern}
    for name in joined.keys() & {"F", "G", "H"}:  # also where a problem replaces NaN
        joined[name][list(failures)] = np.nan
    return joined, _not_finite(joined) | failures


class _TolerantElement:
    """Function that evaluates one element of a problem, and returns a `Failure` if it raises.

    It is called as pymoo's own function is: `RayParallelization` sends the method ``__call__``.
    """

    def __init__(self, function: Callable[[Any], dict[str, Any]]) -> None:
        self.function = function

    def __call__(self, x: Any) -> dict[str, Any] | Failure:
        try:
            return self.function(x)
        except Exception as error:  # a problem may raise anything
            return Failure.of(error)


def _by_halves(evaluate: Callable[[NDArray[Any]], Part], X: NDArray[Any]) -> list[Part | Exception]:
    try:
        return [evaluate(X)]
    except Exception as error:  # a problem may raise anything
        if len(X) == 1:
            return [error]
    half = len(X) // 2
    return _by_halves(evaluate, X[:half]) + _by_halves(evaluate, X[half:])


def _missing(pattern: NDArray[Any]) -> NDArray[Any]:
    """Return one row like those of `pattern`, without values."""
    value = np.nan if np.issubdtype(pattern.dtype, np.number) else None
    return np.full((1, *pattern.shape[1:]), value)


def _not_finite(values: Values) -> dict[int, Failure]:
    found: dict[int, Failure] = {}
    for name in ("H", "G", "F"):  # of several causes the objectives are named
        if name not in values:
            continue
        value = values[name]
        bad = ~np.isfinite(value) if name == "F" else np.isnan(value)
        for row in np.flatnonzero(bad.any(axis=1)):
            column = int(bad[row].argmax())
            found[int(row)] = Failure(f"{name}[{column}] = {value[row, column]}")
    return found


def _guarded(problem: Problem, failures: dict[int, Failure]) -> Problem:
    """Return a copy of an elementwise problem that puts failures of elements into `failures`.

    The elements are evaluated by the problem itself, so that a counter in its `_evaluate` counts.
    """

    def run(f: Any, X: Any) -> list[dict[str, Any]]:
        results = list(problem.elementwise_runner(f, X))
        done = next((out for out in results if not isinstance(out, Failure)), None)
        shapes = default_shape(problem, 1)
        blank = {name: np.empty(shapes[name]) for name in ("F", "G", "H")}
        if done is not None:
            blank = {name: np.asarray([value]) for name, value in done.items()}
        for i, out in enumerate(results):
            if isinstance(out, Failure):
                failures[i] = out
                results[i] = {name: _missing(value)[0] for name, value in blank.items()}
        return results

    guarded: Problem = object.__new__(type(problem))  # pymoo's copy leaves the runner out
    vars(guarded).update(
        vars(problem),
        elementwise_func=lambda _, *args: _TolerantElement(
            problem.elementwise_func(problem, *args)
        ),
        elementwise_runner=run,
    )
    return guarded
