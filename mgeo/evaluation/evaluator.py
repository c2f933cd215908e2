"""Evaluator for pymoo that continues a run when candidates fail."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.evaluator import Evaluator

from mgeo._typing import BoolArray, FloatArray
from mgeo.evaluation.failures import Failure, evaluate_batch
from mgeo.evaluation.individuals import copy_array, get_values
from mgeo.validation.arguments import validate_integer

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

#: Largest number of causes that are counted separately; further ones count as `_OTHER_CAUSES`.
_MAX_CAUSES = 20
_OTHER_CAUSES = "other causes"
#: Value of a failed candidate before any candidate has succeeded.
_PENALTY = 1e30

_N_CHECK_POINTS = 3
#: Tolerance relative to the largest value of a column, because batches of another size and other
#: versions of libraries round differently.
_RTOL = 1e-9


class EvaluationError(RuntimeError):
    """Error that stops a run after too many failed evaluations."""


class TolerantEvaluator(Evaluator):
    """Evaluator for pymoo that tolerates failed evaluations, so that the run can continue.

    A candidate fails if the problem raises an exception, if the worker process that evaluates it
    dies, or if an objective is NaN or infinite or a constraint is NaN. When the evaluation of a
    batch raises, the batch is bisected until the failing candidates are isolated. For an
    elementwise problem, the exception of each element is caught directly. Failed candidates count
    as evaluations and are marked: ``individual.get("failed")`` is True.

    Algorithms of the MGEO family receive the NaN values; they rank failed candidates last and never
    archive them. Other algorithms can lose their front to a NaN. For these algorithms, each
    objective and constraint of a failed candidate is set to the worst value so far plus the range
    of all values so far, so that every successful candidate dominates the failed one. The failed
    candidate is also marked as infeasible, so that a run without any successful candidate has no
    result.

    Parameters
    ----------
    patience : int
        Number of consecutive failures after which the run stops. A batch counts only if all its
        candidates fail.
    warn : bool
        Issue a RuntimeWarning for the first exception that the problem raises.
    **options
        Keywords of pymoo's `Evaluator`.

    Attributes
    ----------
    n_eval : int
        Number of evaluations, including failed ones.
    n_failed : int
        Number of failed evaluations.
    causes : dict of str to int
        Number of failures by cause, in the order of first occurrence.
    n_consecutive_failures : int
        Number of failures since the last batch in which a candidate succeeded.

    Raises
    ------
    EvaluationError
        During a run, after `patience` consecutive failures.

    Examples
    --------
    >>> import numpy as np
    >>> from pymoo.algorithms.moo.nsga2 import NSGA2
    >>> from pymoo.optimize import minimize
    >>> from pymoo.problems.multi import ZDT1
    >>> from mgeo import TolerantEvaluator
    >>> class Fragile(ZDT1):
    ...     def _evaluate(self, x, out, *args, **kwargs):
    ...         super()._evaluate(x, out, *args, **kwargs)
    ...         out["F"][x[:, 0] < 0.05] = np.nan
    >>> tolerant = TolerantEvaluator()
    >>> result = minimize(Fragile(4), NSGA2(), ("n_gen", 3), seed=1, evaluator=tolerant)
    >>> bool(np.isfinite(result.F).all()), list(tolerant.causes)
    (True, ['F[0] = nan'])
    """

    def __init__(self, *, patience: int = 100, warn: bool = True, **options: Any) -> None:
        super().__init__(**options)
        self.patience = validate_integer("patience", patience, low=1)
        self.warn = warn
        self.n_failed = 0
        self.n_consecutive_failures = 0
        self._has_success = False
        self.causes: dict[str, int] = {}
        self._first_consecutive_failure: Failure | None = None
        self._value_ranges: dict[str, tuple[FloatArray, FloatArray]] = {}

    @classmethod
    def from_evaluator(cls, evaluator: Evaluator) -> Evaluator:
        """Convert a pymoo `Evaluator` to a `TolerantEvaluator` with the same settings.

        An evaluator of any other class is returned unchanged.
        """
        if type(evaluator) is not Evaluator:
            return evaluator
        tolerant = cls()
        tolerant.__dict__.update(evaluator.__dict__)
        return tolerant

    def get_settings(self) -> dict[str, Any]:
        """Return the constructor arguments as a JSON-serializable dict.

        The callback is not included.
        """
        return {
            "patience": self.patience,
            "warn": self.warn,
            "skip_already_evaluated": bool(self.skip_already_evaluated),
            "evaluate_values_of": list(self.evaluate_values_of),
        }

    def get_counts(self) -> dict[str, Any]:
        """Return the counters of evaluations and failures as a JSON-serializable dict."""
        return {
            "n_eval": self.n_eval,
            "n_failed": self.n_failed,
            "n_consecutive_failures": self.n_consecutive_failures,
            "causes": dict(self.causes),
        }

    def restore_counts(self, counts: Mapping[str, Any]) -> None:
        """Set the counters to those of an earlier run, so that the earlier run can be resumed.

        Parameters
        ----------
        counts : mapping
            Return value of `get_counts`. Only ``n_eval`` is required.
        """
        self.n_eval = counts["n_eval"]
        self.n_failed = counts.get("n_failed", 0)
        self._has_success = self.n_eval > self.n_failed
        self.n_consecutive_failures = counts.get("n_consecutive_failures", 0)
        self.causes = dict(counts.get("causes", {}))

    def require_success(self) -> None:
        """Raise EvaluationError if every evaluation so far has failed."""
        if self.n_failed and not self._has_success:
            raise self._build_error()

    def _eval(
        self, problem: Problem, pop: Population, evaluate_values_of: list[str], **kwargs: Any
    ) -> None:
        values, failures = evaluate_batch(problem, get_values(pop, "X"), evaluate_values_of, kwargs)
        self._count_failures(failures, len(pop))
        failed = np.zeros(len(pop), dtype=np.bool_)
        failed[list(failures)] = True
        accepts_nan = getattr(kwargs.get("algorithm"), "accepts_nan", False)
        if not accepts_nan:
            for name in values.keys() & {"F", "G", "H"}:
                self._penalize(name, values[name], failed)
        # A new individual already has empty values, so empty arrays need not be set.
        nonempty = {name: value for name, value in values.items() if value.size}
        for i, individual in enumerate(pop.tolist()):
            for name, value in nonempty.items():
                individual.set(name, copy_array(value[i]))
            individual.evaluated.update(values)
        if failures:
            pop[failed].set("failed", True)
        if failures and not accepts_nan and not problem.has_constraints():
            pop[failed].set("CV", np.ones((len(failures), 1)))

    def _count_failures(self, failures: dict[int, Failure], n: int) -> None:
        self.n_failed += len(failures)
        in_order = [failure for _, failure in sorted(failures.items())]
        for failure in in_order:
            is_listed = failure.cause in self.causes or len(self.causes) < _MAX_CAUSES
            cause = failure.cause if is_listed else _OTHER_CAUSES
            self.causes[cause] = self.causes.get(cause, 0) + 1
        if len(failures) < n:
            self.n_consecutive_failures = 0
            self._has_success = True
        else:
            if not self.n_consecutive_failures:
                self._first_consecutive_failure = in_order[0]
            self.n_consecutive_failures += n
        if self.n_consecutive_failures >= self.patience:
            raise self._build_error()
        for failure in in_order:
            if failure.trace and self.warn:
                self.warn = False
                warnings.warn(
                    f"a candidate failed with {failure.cause}; the run continues. See n_failed and "
                    "causes of the evaluator for the number of failures",
                    RuntimeWarning,
                    stacklevel=2,
                )

    def _build_error(self) -> EvaluationError:
        # After a resume, only the causes of earlier failures are known.
        first = self._first_consecutive_failure
        cause = first.cause if first else next(iter(self.causes))
        error = EvaluationError(
            f"all of the last {self.n_consecutive_failures} candidates failed, the first with "
            f"{cause}"
        )
        if first and first.trace:
            error.add_note(f"Traceback of the first failure:\n{first.trace}")
        return error

    def _penalize(self, name: str, values: FloatArray, is_failed: BoolArray) -> None:
        """Overwrite the values of failed candidates with values worse than all successful ones."""
        if not values.shape[1]:
            return
        successful = np.abs(values[~is_failed]) if name == "H" else values[~is_failed]
        if len(successful):
            low, high = successful.min(axis=0), successful.max(axis=0)
            if name in self._value_ranges:
                before = self._value_ranges[name]
                low, high = np.minimum(low, before[0]), np.maximum(high, before[1])
            self._value_ranges[name] = low, high
        if not is_failed.any():
            return
        if name not in self._value_ranges:
            values[is_failed] = _PENALTY
            return
        low, high = self._value_ranges[name]
        worse = high + np.where(high > low, high - low, np.maximum(1.0, np.abs(high)))
        values[is_failed] = worse if name == "F" else np.maximum(worse, 1.0)


def describe_changed_value(
    problem: Problem, population: Population, options: Mapping[str, Any]
) -> str:
    """Evaluate up to three individuals again, and describe the first value that has changed.

    The check detects that a problem has changed since `population` was evaluated. The new
    evaluations are not counted by any evaluator, and the callback of the problem is not called.

    Parameters
    ----------
    problem : Problem
        A deterministic pymoo problem.
    population : Population
        Evaluated individuals. The first, the middle and the last one are evaluated again.
    options : mapping
        Further keywords for `Problem.evaluate`.

    Returns
    -------
    str
        Point, new value and stored value of the first difference; empty if there is none.
    """
    n_points = min(_N_CHECK_POINTS, len(population))
    rows = np.unique(np.linspace(0, len(population) - 1, n_points).round().astype(int))
    if not len(rows):
        return ""
    if problem.callback is not None:
        problem = copy.copy(problem)
        problem.callback = None
    X = get_values(population[rows], "X")
    values, failures = evaluate_batch(problem, X, ["F", "G", "H"], options)
    for name in ("F", "G", "H"):
        stored = get_values(population, name).astype(float).reshape(len(population), -1)
        expected, actual = stored[rows], values[name].reshape(len(rows), -1)
        tolerance = _RTOL * np.abs(stored).max(axis=0, initial=0.0)
        is_close = np.isclose(actual, expected, rtol=0.0, atol=tolerance)
        for row, column in np.argwhere(~is_close):
            cause = f" ({failures[row].cause})" if row in failures else ""
            return (
                f"at x = {X[row : row + 1].tolist()[0]!r:.200} {name}[{column}] = "
                f"{actual[row, column]}{cause}, expected {expected[row, column]}"
            )
    return ""
