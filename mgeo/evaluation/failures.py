"""Evaluation of a batch of candidates, with the cause of each failure.

`mgeo.evaluation.evaluator` builds on `evaluate_batch`.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import Problem, default_shape

from mgeo._text import join_lines

Values = dict[str, NDArray[Any]]
#: Largest number of characters in the description of a cause.
_MAX_CAUSE_LENGTH = 200


@dataclass(frozen=True)
class Failure:
    """Failed evaluation of one candidate, with the cause and the traceback.

    Attributes
    ----------
    cause : str
        Description in one line, such as ``"F[0] = nan"`` or an exception with its message.
    trace : str
        Traceback of the exception; empty if the problem returned values that are not finite.
    """

    cause: str
    trace: str = ""

    @classmethod
    def from_exception(cls, error: Exception) -> Failure:
        """Create a `Failure` from an exception and its traceback."""
        text = join_lines(f"{type(error).__name__}: {error}").removesuffix(":")
        return cls(text[:_MAX_CAUSE_LENGTH], "".join(traceback.format_exception(error)).rstrip())


#: Values of a batch by name, and failures by row.
BatchResult = tuple[Values, dict[int, Failure]]


def evaluate_batch(
    problem: Problem, X: NDArray[Any], names: Sequence[str], options: Mapping[str, Any]
) -> BatchResult:
    """Evaluate a batch of candidates, and record failed evaluations instead of raising errors.

    When the evaluation of a batch raises, the batch is bisected until the failing candidates are
    isolated. For an elementwise problem, the exception of each element is caught directly, so that
    no other candidate is evaluated twice.

    Parameters
    ----------
    problem : Problem
        A pymoo problem, vectorized or elementwise.
    X : array, shape (n, n_var), or (n,) for designs that are objects
        Candidates.
    names : sequence of str
        Values to evaluate, as in `Problem.evaluate`: "F", "G", "H".
    options : mapping
        Further keywords for `Problem.evaluate`.

    Returns
    -------
    values : dict of str to array
        Arrays of n rows, keyed by name. "F", "G" and "H" are NaN in rows that raised.
    failures : dict of int to Failure
        Failures, keyed by the row of `X`.

    Raises
    ------
    Exception
        If the runner of an elementwise problem raises the same exception for every one of several
        candidates, for example because its scheduler is not available.
    """

    def evaluate(candidates: NDArray[Any]) -> BatchResult:
        raised: dict[int, Failure] = {}
        guarded = _catch_failures(problem, raised) if problem.elementwise else problem
        values = guarded.evaluate(
            candidates, return_values_of=names, return_as_dictionary=True, **options
        )
        return values, raised

    parts = _evaluate_by_bisection(evaluate, X)
    errors = [part for part in parts if isinstance(part, Exception)]
    template = next((part[0] for part in parts if not isinstance(part, Exception)), None)
    if template is None:
        if problem.elementwise and len(X) > 1 and len(set(map(repr, errors))) == 1:
            raise errors[0]
        shapes = default_shape(problem, 0)
        template = {name: np.empty(shapes.get(name, (0,))) for name in names}
    failures: dict[int, Failure] = {}
    pieces: list[Values] = []
    row = 0
    for part in parts:
        if isinstance(part, Exception):
            failures[row] = Failure.from_exception(part)
            pieces.append({name: _build_missing_row(value) for name, value in template.items()})
            row += 1
        else:
            values, raised = part
            failures |= {row + i: failure for i, failure in raised.items()}
            pieces.append(values)
            row += len(next(iter(values.values())))
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in template}
    # The NaN that marks a failed element may have been replaced by the problem's `evaluate`.
    for name in joined.keys() & {"F", "G", "H"}:
        joined[name][list(failures)] = np.nan
    return joined, _find_nonfinite(joined) | failures


class _TolerantElement:
    """Callable that evaluates one design, and returns a `Failure` instead of raising an exception.

    It is a class, because pymoo's `RayParallelization` calls the method ``__call__`` by name.
    """

    def __init__(self, function: Callable[[Any], dict[str, Any]]) -> None:
        self.function = function

    def __call__(self, x: Any) -> dict[str, Any] | Failure:
        try:
            return self.function(x)
        except Exception as error:  # A problem may raise any exception.
            return Failure.from_exception(error)


def _evaluate_by_bisection(
    evaluate: Callable[[NDArray[Any]], BatchResult], X: NDArray[Any]
) -> list[BatchResult | Exception]:
    try:
        return [evaluate(X)]
    except Exception as error:  # A problem may raise any exception.
        if len(X) == 1:
            return [error]
    half = len(X) // 2
    return _evaluate_by_bisection(evaluate, X[:half]) + _evaluate_by_bisection(evaluate, X[half:])


def _build_missing_row(template: NDArray[Any]) -> NDArray[Any]:
    """Return one row of missing values, shaped like the rows of a template."""
    value = np.nan if np.issubdtype(template.dtype, np.number) else None
    return np.full((1, *template.shape[1:]), value)


def _find_nonfinite(values: Values) -> dict[int, Failure]:
    failures: dict[int, Failure] = {}
    for name in ("H", "G", "F"):  # F last, so that a NaN objective takes precedence as the cause.
        if name not in values:
            continue
        value = values[name]
        is_invalid = ~np.isfinite(value) if name == "F" else np.isnan(value)
        for row in np.flatnonzero(is_invalid.any(axis=1)):
            column = int(is_invalid[row].argmax())
            failures[int(row)] = Failure(f"{name}[{column}] = {value[row, column]}")
    return failures


def _catch_failures(problem: Problem, failures: dict[int, Failure]) -> Problem:
    """Return a copy of an elementwise problem that records exceptions instead of raising them.

    The copy adds the failure of each element to the dict `failures`, keyed by row. The original
    problem evaluates the elements, so that attributes that its `_evaluate` changes, such as
    counters, stay up to date.
    """

    def run(f: Any, X: Any) -> list[dict[str, Any]]:
        results = list(problem.elementwise_runner(f, X))
        success = next((out for out in results if not isinstance(out, Failure)), None)
        shapes = default_shape(problem, 1)
        template = {name: np.empty(shapes[name]) for name in ("F", "G", "H")}
        if success is not None:
            template = {name: np.asarray([value]) for name, value in success.items()}
        for i, out in enumerate(results):
            if isinstance(out, Failure):
                failures[i] = out
                results[i] = {
                    name: _build_missing_row(value)[0] for name, value in template.items()
                }
        return results

    # The copy method of pymoo drops the runner, so the copy is built here.
    guarded: Problem = object.__new__(type(problem))
    vars(guarded).update(
        vars(problem),
        elementwise_func=lambda _, *args: _TolerantElement(
            problem.elementwise_func(problem, *args)
        ),
        elementwise_runner=run,
    )
    return guarded
