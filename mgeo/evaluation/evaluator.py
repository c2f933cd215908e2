"""An evaluator that survives failing candidates."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.evaluator import Evaluator

from mgeo._typing import BoolArray, FloatArray
from mgeo.evaluation.failures import Failure, attempt
from mgeo.evaluation.individuals import own, values_of
from mgeo.validation.arguments import validate_integer

if TYPE_CHECKING:
    from pymoo.core.population import Population
    from pymoo.core.problem import Problem

_CAUSES = 20  # different ones that are counted
_OTHERS = "other causes"
_UNKNOWN = 1e30  # stands for the worst objective while no candidate has succeeded

_POINTS = 3
_ROUNDING = 1e-9  # of a column's largest value: other versions and other batches round differently


class EvaluationError(RuntimeError):
    """Every candidate fails."""


class TolerantEvaluator(Evaluator):
    """A pymoo evaluator that survives failing candidates.

    A candidate fails when the problem raises an exception for it, when the worker process that
    evaluates it dies, or when it gets a NaN or infinite objective or a NaN constraint. A batch that
    raises is halved until the failing candidates are alone; an elementwise problem is caught at its
    element. Failed candidates count as evaluations and are marked by
    ``individual.get("failed")``.

    Algorithms of the MGEO family keep the NaN: they rank a failed candidate last and never archive
    it. In other algorithms a NaN can wipe the front. There a failed candidate gets, in each
    objective and constraint, the worst value seen so far plus the range seen, so that every
    candidate that succeeded dominates it. A failed candidate counts as infeasible, so that a run in
    which no candidate succeeded has no result.

    Parameters
    ----------
    patience : number of candidates in a row that may fail before the run stops; a batch counts as a
        whole if none in it succeeded.
    warn : whether the first exception of a problem is reported by a RuntimeWarning.
    options : as for pymoo's `Evaluator`.

    Attributes
    ----------
    n_eval : number of evaluations, failed ones included.
    n_failed : number of failed evaluations.
    causes : number of failures by cause, in the order of first occurrence.
    n_in_a_row : number of failures since the last batch in which a candidate succeeded.

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
        self.n_in_a_row = 0
        self._any_succeeded = False
        self.causes: dict[str, int] = {}
        self._first_in_a_row: Failure | None = None
        self._seen: dict[str, tuple[FloatArray, FloatArray]] = {}

    @classmethod
    def like(cls, evaluator: Evaluator) -> Evaluator:
        """Return a tolerant evaluator with the options of a plain one; any other kind as it is."""
        if type(evaluator) is not Evaluator:
            return evaluator
        tolerant = cls()
        tolerant.__dict__.update(evaluator.__dict__)
        return tolerant

    def settings(self) -> dict[str, Any]:
        """Return the arguments of the constructor as JSON values, without the callback."""
        return {
            "patience": self.patience,
            "warn": self.warn,
            "skip_already_evaluated": bool(self.skip_already_evaluated),
            "evaluate_values_of": list(self.evaluate_values_of),
        }

    def counts(self) -> dict[str, Any]:
        """Return the counters as JSON values."""
        return {
            "n_eval": self.n_eval,
            "n_failed": self.n_failed,
            "n_in_a_row": self.n_in_a_row,
            "causes": dict(self.causes),
        }

    def count_on(self, counts: Mapping[str, Any]) -> None:
        """Continue from the `counts` of another evaluator, of which only ``n_eval`` is required."""
        self.n_eval = counts["n_eval"]
        self.n_failed = counts.get("n_failed", 0)
        self._any_succeeded = self.n_eval > self.n_failed
        self.n_in_a_row = counts.get("n_in_a_row", 0)
        self.causes = dict(counts.get("causes", {}))

    def require_success(self) -> None:
        """Refuse a run in which every candidate failed.

        Raises
        ------
        EvaluationError
            If candidates were evaluated and all of them failed.
        """
        if self.n_failed and not self._any_succeeded:
            raise self._error()

    def _eval(
        self, problem: Problem, pop: Population, evaluate_values_of: list[str], **kwargs: Any
    ) -> None:
        values, failures = attempt(problem, values_of(pop, "X"), evaluate_values_of, kwargs)
        self._count(failures, len(pop))
        failed = np.zeros(len(pop), dtype=np.bool_)
        failed[list(failures)] = True
        takes_nan = getattr(kwargs.get("algorithm"), "takes_nan", False)
        if not takes_nan:
            for name in values.keys() & {"F", "G", "H"}:
                self._penalize(name, values[name], failed)
        # an individual has no values of a kind to begin with
        given = {name: value for name, value in values.items() if value.size}
        for i, individual in enumerate(pop.tolist()):
            for name, value in given.items():
                individual.set(name, own(value[i]))
            individual.evaluated.update(values)
        if failures:
            pop[failed].set("failed", True)
        if failures and not takes_nan and not problem.has_constraints():
            pop[failed].set("CV", np.ones((len(failures), 1)))

    def _count(self, failures: dict[int, Failure], n: int) -> None:
        self.n_failed += len(failures)
        in_order = [failure for _, failure in sorted(failures.items())]
        for failure in in_order:
            known = failure.cause in self.causes or len(self.causes) < _CAUSES
            cause = failure.cause if known else _OTHERS
            self.causes[cause] = self.causes.get(cause, 0) + 1
        if len(failures) < n:
            self.n_in_a_row = 0
            self._any_succeeded = True
        else:
            if not self.n_in_a_row:
                self._first_in_a_row = in_order[0]
            self.n_in_a_row += n
        if self.n_in_a_row >= self.patience:
            raise self._error()
        for failure in in_order:
            if failure.trace and self.warn:
                self.warn = False
                warnings.warn(
                    f"a candidate failed with {failure.cause}; the run goes on, and its evaluator "
                    "counts the failures in n_failed and causes",
                    RuntimeWarning,
                    stacklevel=2,
                )

    def _error(self) -> EvaluationError:
        first = self._first_in_a_row
        cause = first.cause if first else next(iter(self.causes))  # before the run was resumed
        error = EvaluationError(
            f"all of the last {self.n_in_a_row} candidates failed, the first with {cause}"
        )
        if first and first.trace:
            error.add_note(f"which was raised as\n{first.trace}")
        return error

    def _penalize(self, name: str, values: FloatArray, failed: BoolArray) -> None:
        """Write values worse than all seen into the failed rows, in place."""
        if not values.shape[1]:
            return
        good = np.abs(values[~failed]) if name == "H" else values[~failed]
        if len(good):
            low, high = good.min(axis=0), good.max(axis=0)
            if name in self._seen:
                before = self._seen[name]
                low, high = np.minimum(low, before[0]), np.maximum(high, before[1])
            self._seen[name] = low, high
        if not failed.any():
            return
        if name not in self._seen:
            values[failed] = _UNKNOWN
            return
        low, high = self._seen[name]
        worse = high + np.where(high > low, high - low, np.maximum(1.0, np.abs(high)))
        values[failed] = worse if name == "F" else np.maximum(worse, 1.0)


def changed_value(problem: Problem, known: Population, options: Mapping[str, Any]) -> str:
    """Return the first value that differs in a new evaluation, in words; empty if there is none.

    A few points are evaluated by the problem itself: no evaluator counts them, and the problem's
    callback does not see them.

    Parameters
    ----------
    problem : a pymoo problem that gives the same values for the same point.
    known : evaluated individuals; the first, the last and the one in the middle are looked at.
    options : further keywords for `Problem.evaluate`.
    """
    rows = np.unique(np.linspace(0, len(known) - 1, min(_POINTS, len(known))).round().astype(int))
    if not len(rows):
        return ""
    if problem.callback is not None:
        problem = copy.copy(problem)
        problem.callback = None
    X = values_of(known[rows], "X")
    values, failures = attempt(problem, X, ["F", "G", "H"], options)
    for name in ("F", "G", "H"):
        kept = values_of(known, name).astype(float).reshape(len(known), -1)
        expected, found = kept[rows], values[name].reshape(len(rows), -1)
        tolerance = _ROUNDING * np.abs(kept).max(axis=0, initial=0.0)
        same = np.isclose(found, expected, rtol=0.0, atol=tolerance)
        for row, column in np.argwhere(~same):
            why = f" ({failures[row].cause})" if row in failures else ""
            return (
                f"at x = {X[row : row + 1].tolist()[0]!r:.200} {name}[{column}] = "
                f"{found[row, column]}{why}, expected {expected[row, column]}"
            )
    return ""
