"""One run of one algorithm on one problem."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.callback import Callback, CallbackCollection
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.algorithms.staged import MGEOStaged, is_rough
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.plugins.protocol import column_names, constraint_names
from mgeo.runs.hypervolume import hypervolume
from mgeo.runs.nearest import nearest_solutions
from mgeo.runs.refine import Refinement
from mgeo.runs.setup import IDLE_STEPS
from mgeo.runs.setup import set_up as set_up
from mgeo.store.run import Nearest, Notes, Outcome, StopReason

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

    from mgeo.store.run_persistence import RunPersistence


class State:
    """State of a run for the callback that is called after each generation.

    Attributes
    ----------
    variables, objectives, constraints : tuples of str
    budget, evaluations : int
        Budget of evaluations, and those made.
    stopped : StopReason or None
        Why the run ends before its budget is used.
    refinement : Refinement or None
        The refinement after the search, once it has begun.
    """

    def __init__(
        self, problem: Problem, algorithm: Algorithm, budget: int, notes: Notes | None = None
    ) -> None:
        self.variables, self.objectives = column_names(problem)
        self.constraints = constraint_names(problem)
        self.budget = budget
        self.evaluations = 0
        self.stopped: StopReason | None = None
        self.refinement: Refinement | None = None
        self.to_refine = False  # until the refinement has ended
        self.started = datetime.now(UTC) if notes is None else notes.started
        self.rough = 0 if notes is None else notes.rough  # evaluations that gave estimates
        self._clock = time.perf_counter() - (0.0 if notes is None else notes.wall_time_s)
        self._problem = problem
        self._algorithm = algorithm
        self._front: Population | None = None
        if algorithm.opt is not None:
            self.update()

    def stop(self, reason: StopReason = "signal") -> None:
        """End the run after this generation."""
        self.stopped = reason

    @property
    def ended(self) -> bool:
        """Whether the run has ended."""
        used = self.evaluations >= self.budget and not self.to_refine
        return self.stopped is not None or used

    @property
    def failures(self) -> dict[str, int]:
        """Number of failed evaluations by cause (see `mgeo.TolerantEvaluator`)."""
        return dict(getattr(self._algorithm.evaluator, "causes", {}))

    @property
    def elapsed(self) -> float:
        """Duration of the run [s], without the time between its parts."""
        return time.perf_counter() - self._clock

    def update(self) -> None:
        """Take over the front and the counts of the algorithm after a generation."""
        self._front = self._algorithm.opt
        self.evaluations = self._algorithm.evaluator.n_eval
        if is_rough(self._algorithm):
            self.rough = self.evaluations

    def refine(self) -> Iterator[None]:
        """Let the problem refine the front, step by step."""
        self.refinement = Refinement(self._problem, self.solutions())
        for _ in self.refinement:
            self._front = self.refinement.front
            yield
        self.to_refine = False

    def solutions(self) -> Population:
        """Return the feasible solutions of the front."""
        if self._front is None or not len(self._front):
            return Population()
        return self._front[self._front.get("feas") & succeeded(self._front)]

    def front(self) -> tuple[FloatArray, FloatArray]:
        """Return X (n, n_var) and F (n, n_obj) of `solutions`.

        Before the last stage of a staged run, F is an estimate.
        """
        found = self.solutions()
        if not len(found):
            return np.empty((0, self._problem.n_var)), np.empty((0, self._problem.n_obj))
        X = as_numbers(self._problem, found.get("X")).astype(float)
        return X, self._values(found, "F")

    def hypervolume(self, F: FloatArray) -> float | None:
        """Return the hypervolume of a front, None while its objectives are estimates."""
        return None if is_rough(self._algorithm) else hypervolume(self._problem, F)

    def notes(self) -> dict[str, Any]:
        """Return what a resumed run has to know, as JSON values."""
        return {
            "started": self.started.isoformat(),
            "wall_time_s": self.elapsed,
            "rough": self.rough,
        }

    def outcome(self) -> Outcome:
        """Return the result of the run."""
        X, F = self.front()
        order = np.lexsort(F.T[::-1])
        found, refined = self.solutions(), self.refinement
        is_complete = self.evaluations >= self.budget and not self.to_refine
        return Outcome(
            X=X[order],
            F=F[order],
            G=self._values(found, "G")[order],
            H=self._values(found, "H")[order],
            variables=self.variables,
            objectives=self.objectives,
            constraints=self.constraints,
            nearest=Nearest.none() if len(F) else self._nearest(),
            stop_reason="budget" if is_complete else self.stopped or "exhausted",
            evaluations=self.evaluations,
            hypervolume=self.hypervolume(F),
            started=self.started,
            wall_time_s=self.elapsed,
            failures=self.failures,
            rough=self.rough,
            refined=0 if refined is None else int(refined.changed.sum()),
            added=0 if refined is None else refined.added,
            unrefined="" if refined is None else refined.error,
        )

    def _values(self, solutions: Population, key: str) -> FloatArray:
        p = self._problem
        width = {"F": p.n_obj, "G": p.n_ieq_constr, "H": p.n_eq_constr}[key]
        values = solutions.get(key) if len(solutions) else np.empty(0)
        return np.asarray(values, dtype=float).reshape(len(solutions), width)

    def _nearest(self) -> Nearest:
        is_constrained = self._problem.n_ieq_constr + self._problem.n_eq_constr > 0
        return nearest_solutions(self._algorithm) if is_constrained else Nearest.none()


class _Monitor(Callback):
    """Updates the state after each generation, calls a callback, and ends the run if requested."""

    def __init__(
        self, state: State, callback: Callable[[State], object] | None, deadline: float | None
    ) -> None:
        super().__init__()
        self._state = state
        self._callback = callback
        self._deadline = deadline
        self._n_idle = 0

    def watch(self) -> bool:
        """Call the callback. Return whether the run ends."""
        state = self._state
        if self._deadline is not None and time.monotonic() >= self._deadline:
            state.stop("max_time")
        if self._callback is not None:
            self._callback(state)
        return state.stopped is not None

    def _update(self, algorithm: Any) -> None:
        before = self._state.evaluations
        self._state.update()
        self._n_idle = self._n_idle + 1 if self._state.evaluations == before else 0
        # C-TAEA of pymoo continues forever where there are no other designs
        if self.watch() or self._n_idle >= IDLE_STEPS:
            algorithm.termination.terminate()
            algorithm.termination.update(algorithm)


def follow(
    problem: Problem,
    algorithm: Algorithm,
    budget: int,
    callback: Callable[[State], object] | None = None,
    persistence: RunPersistence | None = None,
    notes: Notes | None = None,
    *,
    polish: bool = False,
    max_time: float | None = None,
) -> Outcome:
    """Run an algorithm that is set up or resumed until its budget is used or it is stopped.

    The last generation is completed, so that a few more evaluations may be made. A
    KeyboardInterrupt ends the run at once, with the result of the last complete generation.
    Failing evaluations cost the candidates concerned (see `mgeo.TolerantEvaluator`).

    Parameters
    ----------
    budget
        Budget of the termination of the algorithm.
    callback
        Called after every generation. It may call ``state.stop()``.
    persistence
        Writes checkpoints and the record.
    notes
        Notes of the checkpoint of a resumed run, None for a new run.
    polish
        Whether the problem refines the front when the budget is used. A checkpoint has the state
        before the refinement.
    max_time
        Time from now after which the run ends [s], None for no limit.

    Raises
    ------
    EvaluationError
        If every candidate fails.
    """
    state = State(problem, algorithm, budget, notes)
    state.to_refine = polish
    deadline = None if max_time is None else time.monotonic() + max_time
    monitor = _Monitor(state, callback, deadline)
    own = [] if persistence is None else persistence.callbacks(algorithm, state.notes)
    algorithm.callback = CallbackCollection(monitor, *own)
    try:
        algorithm.run()
    except KeyboardInterrupt:
        state.stop()
    if state.stopped is None and isinstance(algorithm.evaluator, TolerantEvaluator):
        algorithm.evaluator.require_success()
    if isinstance(algorithm, MGEOStaged):
        algorithm.conclude()
        state.update()
        if persistence is not None and persistence.recorder is not None and algorithm.concluded:
            persistence.recorder.take(algorithm)
            persistence.recorder.flush()
    if state.to_refine and state.stopped is None:
        _refine(state, monitor)
    return state.outcome()


def _refine(state: State, monitor: _Monitor) -> None:
    try:
        for _ in state.refine():
            if monitor.watch():
                return
    except KeyboardInterrupt:
        state.stop()
    monitor.watch()
