"""One run of one algorithm on one problem."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.algorithms.staged import MGEOStaged, is_rough
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.plugins.protocol import column_names, constraint_names
from mgeo.runs.meters import HypervolumeMeter, NearestMeter
from mgeo.runs.refine import Refinement
from mgeo.runs.setup import IDLE_STEPS
from mgeo.runs.setup import set_up as set_up
from mgeo.store.run import Hypervolume, Nearest, Notes, Outcome

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem

    from mgeo.store.run_persistence import RunPersistence


class State:
    """A run under way, as its callback sees it after every step of the algorithm."""

    def __init__(
        self, problem: Problem, algorithm: Algorithm, budget: int, notes: Notes | None = None
    ) -> None:
        self.variables, self.objectives = column_names(problem)
        self.budget = budget
        self.evaluations = 0
        self.stopped = False
        self._algorithm = algorithm
        self.constraints = constraint_names(problem)
        self._meter = HypervolumeMeter(problem)
        self._nearest = NearestMeter(problem)
        self._front: Population | None = None
        self._problem = problem
        self._clock = time.perf_counter()
        self.started = datetime.now(UTC)
        self.rough = 0  # evaluations until the last one that gave an estimate
        self.refinement: Refinement | None = None
        self.to_refine = False  # once the budget is used, until that has come to an end
        if notes is not None:
            self.rough = notes.rough
            self.started = notes.started
            self._clock -= notes.wall_time_s
            self._meter.seen = notes.seen
            self._nearest.seen = notes.nearest
        self._watcher = algorithm.evaluator.callback
        algorithm.evaluator.callback = self._evaluated
        if algorithm.opt is not None:
            self.update()
        if len(self.front()[0]) and not is_rough(algorithm):
            self._nearest.stop()

    def stop(self) -> None:
        """End the run here; its status is then "interrupted"."""
        self.stopped = True

    @property
    def ended(self) -> bool:
        """Whether there is nothing left to do."""
        return self.stopped or (self.evaluations >= self.budget and not self.to_refine)

    def refine(self) -> Iterator[None]:
        """Let the problem refine what was found, step by step."""
        found = self._found()
        self.refinement = Refinement(self._problem, found)
        for tried in self.refinement:
            self._meter.see(tried)
            self._front = self.refinement.front
            yield
        self.to_refine = False

    @property
    def failures(self) -> dict[str, int]:
        """How many of the evaluations so far failed why (see `mgeo.TolerantEvaluator`)."""
        return dict(getattr(self._algorithm.evaluator, "causes", {}))

    @property
    def elapsed(self) -> float:
        """Seconds that the run has taken, without the time between its parts."""
        return time.perf_counter() - self._clock

    def front(self) -> tuple[FloatArray, FloatArray]:
        """X (n, n_var) and F (n, n_obj) of the feasible solutions of the front so far.

        Candidates that failed are none. Of a staged run `F` is an estimate before its last stage.
        """
        n_var, n_obj = self._problem.n_var, self._problem.n_obj
        feasible = self._found()
        if not len(feasible):
            return np.empty((0, n_var)), np.empty((0, n_obj))
        X, F = feasible.get("X", "F")
        return as_numbers(self._problem, X).astype(float), F.astype(float).reshape(-1, n_obj)

    def _found(self) -> Population:
        if self._front is None or not len(self._front):
            return Population()
        return self._front[self._front.get("feas") & succeeded(self._front)]

    def notes(self) -> dict[str, Any]:
        """What a run that goes on from here has to know, as JSON values."""
        return {
            "started": self.started.isoformat(),
            "wall_time_s": self.elapsed,
            "seen": self._meter.seen,
            "nearest": self._nearest.seen,
            "rough": self.rough,
        }

    @property
    def nearest(self) -> Nearest:
        """What comes nearest to the constraints, if nothing has kept them so far."""
        return self._nearest.nearest

    def hypervolume(self, F: FloatArray) -> Hypervolume | None:
        """Hypervolume of a front of this run; None while its objectives are estimates."""
        return None if is_rough(self._algorithm) else self._meter(F)

    def _evaluated(self, population: Population) -> None:
        if is_rough(self._algorithm):
            self.rough = self._algorithm.evaluator.n_eval
        else:
            self._meter.see(population)
            self._nearest.see(population)
        if self._watcher is not None:
            self._watcher(population)

    def update(self) -> None:
        """Take over what the algorithm has after a whole step."""
        self._front = self._algorithm.opt
        self.evaluations = self._algorithm.evaluator.n_eval


def follow(
    problem: Problem,
    algorithm: Algorithm,
    budget: int,
    callback: Callable[[State], object] | None = None,
    persistence: RunPersistence | None = None,
    notes: Notes | None = None,
    *,
    polish: bool = False,
) -> Outcome:
    """Run an algorithm that is set up or resumed until it has used its budget, or is stopped.

    The last generation is completed, so slightly more evaluations may be made; and fewer, where an
    algorithm finds no design that it has not tried. A KeyboardInterrupt ends the run at once; what
    was found up to the last whole step is returned, with status "interrupted". Evaluations that
    fail cost the candidates concerned (see `mgeo.TolerantEvaluator`).

    Parameters
    ----------
    budget
        Evaluations that the algorithm's termination stands for.
    callback
        Called after every step; it may call ``state.stop()``.
    persistence
        Writes what is needed to go on after a crash.
    notes
        Of the checkpoint from which it is resumed; None for a new run.
    polish
        Whether the problem refines what was found, once the budget is used. No checkpoint holds
        that: a run that ended amid it, and is resumed, begins it again, to the same end.

    Raises
    ------
    EvaluationError
        If every candidate fails.
    """
    state = State(problem, algorithm, budget, notes)
    state.to_refine = polish
    if persistence is not None:
        persistence.begin(algorithm, state.notes)
    amid = False  # a generation
    idle = 0  # steps: pymoo's C-TAEA goes on for ever where there are no other designs
    try:
        while algorithm.has_next() and not state.stopped and idle < IDLE_STEPS:
            before = algorithm.evaluator.n_eval
            algorithm.next()
            idle = idle + 1 if algorithm.evaluator.n_eval == before else 0
            state.update()
            if callback is not None:
                callback(state)
    except KeyboardInterrupt:  # amid a generation, which no checkpoint can hold
        state.stop()
        amid = True
    else:
        if not state.stopped and isinstance(algorithm.evaluator, TolerantEvaluator):
            algorithm.evaluator.require_success()
        if persistence is not None:
            persistence.end()
    if isinstance(algorithm, MGEOStaged):
        algorithm.conclude()  # one that was stopped, or was resumed at its end
        state.update()
        if persistence is not None and not amid:
            persistence.conclude()
    if state.to_refine and not state.stopped:
        _refine(state, callback)
    return _outcome(state)


def _refine(state: State, callback: Callable[[State], object] | None) -> None:
    try:
        for _ in state.refine():
            if callback is not None:
                callback(state)
            if state.stopped:
                return
    except KeyboardInterrupt:  # what was found up to the last whole step is kept
        state.stop()
    if callback is not None:
        callback(state)


def _outcome(state: State) -> Outcome:
    X, F = state.front()
    order = np.lexsort(F.T[::-1])
    amid = state.stopped and (state.evaluations < state.budget or state.to_refine)
    refined = state.refinement
    return Outcome(
        X=X[order],
        F=F[order],
        variables=state.variables,
        objectives=state.objectives,
        constraints=state.constraints,
        nearest=Nearest.none() if len(F) else state.nearest,
        status="interrupted" if amid else "finished",
        evaluations=state.evaluations,
        hypervolume=state.hypervolume(F),
        started=state.started,
        wall_time_s=state.elapsed,
        failures=state.failures,
        rough=state.rough,
        refined=0 if refined is None else int(refined.changed.sum()),
        added=0 if refined is None else refined.added,
        unrefined="" if refined is None else refined.error,
    )
