"""Execution of one run: search, local refinement, and outcome."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.callback import Callback, CallbackCollection
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.algorithms.staged import MGEOStaged, is_low_fidelity
from mgeo.evaluation.individuals import convert_designs_to_numbers, find_successful
from mgeo.plugins.protocol import get_column_names, get_constraint_names
from mgeo.runs.algorithms import MAX_IDLE_GENERATIONS
from mgeo.runs.hypervolume import compute_hypervolume
from mgeo.runs.nearest_solutions import select_nearest_solutions
from mgeo.runs.refinement import Refinement
from mgeo.store.recorder import Recorder
from mgeo.store.run import CheckpointMetadata, NearestSolutions, Outcome, StopReason

if TYPE_CHECKING:
    from mgeo.store.checkpoint import Checkpoint


class SolveState(Callback):
    """State of a run in progress, updated after each generation and each refinement step.

    Parameters
    ----------
    algorithm : Algorithm
        Algorithm that is set up or resumed.
    budget : int
        Budget of evaluations, equal to that of the algorithm's termination criterion.
    callback : function, optional
        Called with the state after every update. It may call ``state.stop()``.
    metadata : CheckpointMetadata, optional
        Data of the checkpoint of a resumed run.
    max_time : float, optional
        Time from now after which the run ends [s].

    Attributes
    ----------
    n_evaluations, n_low_fidelity : int
        Numbers of all evaluations and of low-fidelity evaluations.
    stop_reason : StopReason or None
        Reason for ending the run before its budget is used.
    refinement : Refinement or None
        Local refinement after the search, None before.
    checkpoint, recorder : Checkpoint and Recorder, or None
        Callbacks that save the run while it continues.
    """

    def __init__(
        self,
        algorithm: Any,
        budget: int,
        callback: Callable[[SolveState], object] | None = None,
        *,
        metadata: CheckpointMetadata | None = None,
        max_time: float | None = None,
    ) -> None:
        super().__init__()
        self.algorithm, self.problem, self.budget = algorithm, algorithm.problem, budget
        self.n_evaluations = 0
        self.stop_reason: StopReason | None = None
        self.refinement: Refinement | None = None
        self.checkpoint: Checkpoint | None = None
        self.recorder: Recorder | None = None
        self.start_time = datetime.now(UTC) if metadata is None else metadata.start_time
        self.n_low_fidelity = 0 if metadata is None else metadata.n_low_fidelity
        self._start_clock = time.perf_counter() - (
            0.0 if metadata is None else metadata.wall_time_s
        )
        self._deadline = None if max_time is None else time.monotonic() + max_time
        self._callback = callback
        self._n_idle = 0
        self._front = Population()
        if algorithm.opt is not None:
            self.update_from_algorithm()

    def stop(self, reason: StopReason = "signal") -> None:
        """End the run after the current generation, and store the reason."""
        self.stop_reason = reason

    @property
    def failures(self) -> dict[str, int]:
        """Number of failed evaluations for each cause of failure."""
        return dict(self.algorithm.evaluator.causes)

    @property
    def elapsed_time(self) -> float:
        """Time spent on the run so far [s], excluding interruptions."""
        return time.perf_counter() - self._start_clock

    @property
    def checkpoint_error(self) -> str | None:
        """Error message of the last attempt to write a checkpoint, or None if it succeeded."""
        error = None if self.checkpoint is None else self.checkpoint.error
        return None if error is None else str(error)

    def select_feasible_solutions(self) -> Population:
        """Return the feasible solutions of the current front."""
        if not len(self._front):
            return Population()
        return self._front[self._front.get("feas") & find_successful(self._front)]

    def build_front(self) -> tuple[FloatArray, FloatArray]:
        """Return the variables and objectives of the feasible solutions of the current front.

        Returns
        -------
        X : array, shape (n, n_var)
            Variables.
        F : array, shape (n, n_obj)
            Objectives, of low fidelity before the last fidelity level of a staged run.
        """
        solutions = self.select_feasible_solutions()
        X = solutions.get("X") if len(solutions) else np.empty((0, self.problem.n_var))
        F = stack_values(solutions, "F", self.problem.n_obj)
        return convert_designs_to_numbers(self.problem, X).astype(float), F

    def compute_hypervolume(self, F: FloatArray) -> float | None:
        """Return the hypervolume of a front, or None during low-fidelity evaluations.

        The result is also None if the problem has no indicator space, see
        `mgeo.runs.hypervolume.compute_hypervolume`.
        """
        return None if is_low_fidelity(self.algorithm) else compute_hypervolume(self.problem, F)

    def update_from_algorithm(self) -> None:
        opt = self.algorithm.opt
        self._front = Population() if opt is None else opt
        self.n_evaluations = self.algorithm.evaluator.n_eval
        if is_low_fidelity(self.algorithm):
            self.n_low_fidelity = self.n_evaluations

    def refine(self) -> bool:
        """Refine the front locally, and return True unless the refinement was stopped."""
        self.refinement = Refinement(self.problem, self.select_feasible_solutions())
        for _ in self.refinement:
            self._front = self.refinement.front
            self._check_stop()
            if self.stop_reason is not None:
                return False
        return True

    def _update(self, algorithm: Any) -> None:
        n_before = self.n_evaluations
        self.update_from_algorithm()
        self._n_idle = self._n_idle + 1 if self.n_evaluations == n_before else 0
        self._check_stop()
        # pymoo's C-TAEA continues forever if it finds no new designs.
        if self.stop_reason is not None or self._n_idle >= MAX_IDLE_GENERATIONS:
            algorithm.termination.terminate()
            algorithm.termination.update(algorithm)

    def _check_stop(self) -> None:
        """Check the time limit and call the callback, either of which may stop the run."""
        if self._deadline is not None and time.monotonic() >= self._deadline:
            self.stop("max_time")
        if self._callback is not None:
            self._callback(self)


def solve(state: SolveState, *, refine: bool = False) -> Outcome:
    """Run an algorithm until its budget is used up or it is stopped, and return the outcome.

    The last generation is completed, so the budget can be exceeded slightly. A KeyboardInterrupt
    ends the run immediately, with the result of the last complete generation. A failed evaluation
    discards only its candidate (see `mgeo.TolerantEvaluator`).

    Parameters
    ----------
    state : SolveState
        State of the run, with the algorithm.
    refine : bool
        Whether the problem refines the front locally when the budget is used. The checkpoint
        contains the state before the refinement.

    Returns
    -------
    Outcome
        Front and statistics of the run.

    Raises
    ------
    EvaluationError
        If every evaluation failed.
    """
    algorithm = state.algorithm
    writers = [writer for writer in (state.recorder, state.checkpoint) if writer is not None]
    algorithm.callback = CallbackCollection(state, *writers)
    is_refined = not refine
    try:
        algorithm.run()
    except KeyboardInterrupt:
        state.stop()
    if state.stop_reason is None:
        algorithm.evaluator.require_success()
    if isinstance(algorithm, MGEOStaged):
        algorithm.evaluate_archive()
        state.update_from_algorithm()
        if state.recorder is not None and algorithm.is_archive_evaluated:
            state.recorder.record(algorithm)
            state.recorder.flush()
    if refine and state.stop_reason is None:
        try:
            is_refined = state.refine()
        except KeyboardInterrupt:
            state.stop()
    if is_refined and state.n_evaluations >= state.budget:
        return _build_outcome(state, "budget")
    return _build_outcome(state, state.stop_reason or "exhausted")


def _build_outcome(state: SolveState, reason: StopReason) -> Outcome:
    problem, refined = state.problem, state.refinement
    X, F = state.build_front()
    order = np.lexsort(F.T[::-1])
    solutions = state.select_feasible_solutions()
    constraints = get_constraint_names(problem)
    variables, objectives = get_column_names(problem)
    is_stuck = constraints and not len(F)
    return Outcome(
        X=X[order],
        F=F[order],
        G=stack_values(solutions, "G", problem.n_ieq_constr)[order],
        H=stack_values(solutions, "H", problem.n_eq_constr)[order],
        variables=variables,
        objectives=objectives,
        constraints=constraints,
        nearest=select_nearest_solutions(state.algorithm) if is_stuck else NearestSolutions.empty(),
        stop_reason=reason,
        n_evaluations=state.n_evaluations,
        hypervolume=state.compute_hypervolume(F),
        start_time=state.start_time,
        wall_time_s=state.elapsed_time,
        failures=state.failures,
        n_low_fidelity=state.n_low_fidelity,
        n_refined=0 if refined is None else int(refined.is_replaced.sum()),
        n_added=0 if refined is None else refined.n_added,
        refinement_error="" if refined is None else refined.error,
        checkpoint_error=state.checkpoint_error,
    )


def stack_values(solutions: Population, key: str, n_columns: int) -> FloatArray:
    """Return objectives or constraint values as a float array, one row per solution.

    Parameters
    ----------
    solutions : Population
        Solutions; the population may be empty.
    key : str
        "F" for objectives, "G" for inequality constraints, "H" for equality constraints.
    n_columns : int
        Number of columns.

    Returns
    -------
    array, shape (n, n_columns)
    """
    values = solutions.get(key) if len(solutions) else np.empty(0)
    return np.asarray(values, dtype=float).reshape(len(solutions), n_columns)
