"""Evaluate a batch of candidates some of which fail, and find out which and why."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem, default_shape

from mgeo._foreign import foreign, one_line

Values = dict[str, NDArray[Any]]
_LONGEST = 200  # characters of a cause
_BATCH = ("evaluate", "do", "_evaluate_elementwise")  # what pymoo takes a batch through


@dataclass(frozen=True)
class Failure:
    """Why one candidate failed: a short cause, and the traceback if there was an exception."""

    cause: str
    trace: str = ""

    @classmethod
    def of(cls, error: Exception) -> Failure:
        """From an exception that is being handled."""
        text = one_line(f"{type(error).__name__}: {error}").removesuffix(":")
        return cls(text[:_LONGEST], "".join(traceback.format_exception(error)).rstrip())


Part = tuple[Values, dict[int, Failure]]


def attempt(
    problem: Problem, X: NDArray[Any], names: Sequence[str], options: Mapping[str, Any]
) -> tuple[Values, dict[int, Failure]]:
    """Evaluate all candidates that can be.

    Parameters
    ----------
    problem : a pymoo problem, elementwise or not.
    X : (n, n_var) candidates, or (n,) objects.
    names : what to evaluate, as in `Problem.evaluate`: "F", "G", "H".
    options : further keywords for `Problem.evaluate`.

    Returns
    -------
    values : what the problem gives by name, n rows each; NaN in rows that raised.
    failures : by row.
    """

    def evaluate(candidates: NDArray[Any]) -> Part:
        guarded, in_elements = _guarded(problem)
        values = guarded.evaluate(
            candidates, return_values_of=names, return_as_dictionary=True, **options
        )
        return values, in_elements

    parts = _by_halves(evaluate, X)
    pattern = next((part[0] for part in parts if not isinstance(part, Failure)), None)
    if pattern is None:
        shapes = default_shape(problem, 0)
        pattern = {name: np.empty(shapes.get(name, (0,))) for name in names}
    failures: dict[int, Failure] = {}
    pieces: list[Values] = []
    row = 0
    for part in parts:
        if isinstance(part, Failure):
            failures[row] = part
            pieces.append({name: _missing(value) for name, value in pattern.items()})
            row += 1
        else:
            values, failed = part
            failures |= {row + i: failure for i, failure in failed.items()}
            pieces.append(values)
            row += len(next(iter(values.values())))
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in pattern}
    for name in joined.keys() & {"F", "G", "H"}:  # also where a problem replaces NaN
        joined[name][list(failures)] = np.nan
    return joined, _not_finite(joined) | failures


def _by_halves(evaluate: Callable[[NDArray[Any]], Part], X: NDArray[Any]) -> list[Part | Failure]:
    try:
        with foreign():
            return [evaluate(X)]
    except Exception as error:  # whatever a problem raises: foreign code
        if len(X) == 1:
            return [Failure.of(error)]
    half = len(X) // 2
    return _by_halves(evaluate, X[:half]) + _by_halves(evaluate, X[half:])


def _missing(pattern: NDArray[Any]) -> NDArray[Any]:
    """One row like those of `pattern`, without values."""
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


def _guarded(problem: Problem) -> tuple[Problem, dict[int, Failure]]:
    """A problem to evaluate once, and where the failures of its elements will be, by row.

    Threads share problems, so the guard is put on a shallow copy, of which pymoo reads nothing but
    how to evaluate a batch. The elements themselves are evaluated by the problem that is shared:
    what `_evaluate` writes to it, such as a count of its calls, stays. That is so for pymoo's way
    through a batch alone; a problem with a way of its own is evaluated as it is.
    """
    if not problem.elementwise or any(
        getattr(type(problem), name) is not getattr(Problem, name) for name in _BATCH
    ):
        return problem, {}
    failures: dict[int, Failure] = {}

    def run(f: Any, X: Any) -> list[dict[str, Any]]:
        failures.clear()
        results = list(problem.elementwise_runner(partial(_evaluated, f), X))
        done = next((out for out in results if not isinstance(out, Failure)), None)
        if done is None:
            shapes = default_shape(problem, 1)
            pattern = {name: np.empty(shapes[name]) for name in ("F", "G", "H")}
        else:
            pattern = {name: np.asarray([value]) for name, value in done.items()}
        for i, out in enumerate(results):
            if isinstance(out, Failure):
                failures[i] = out
                results[i] = {name: _missing(value)[0] for name, value in pattern.items()}
        return results

    copy: Problem = object.__new__(type(problem))  # not by pickling, which may leave things out
    vars(copy).update(
        vars(problem),
        elementwise_func=lambda _, *arguments: problem.elementwise_func(problem, *arguments),
        elementwise_runner=run,
    )
    return copy, failures


def _evaluated(f: Any, x: Any) -> dict[str, Any] | Failure:
    """One element, evaluated wherever the runner takes it; an exception comes back as text."""
    try:
        with foreign():
            out: dict[str, Any] = f(x)
    except Exception as error:  # whatever a problem raises: foreign code
        return Failure.of(error)
    return out
