"""One run of one algorithm on one problem."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pymoo.core.callback import Callback, CallbackCollection
from pymoo.core.population import Population

from mgeo._typing import FloatArray
from mgeo.algorithms.base import ExtremalOptimization
from mgeo.algorithms.staged import MGEOStaged, is_rough
from mgeo.evaluation.evaluator import TolerantEvaluator
from mgeo.evaluation.individuals import as_numbers, succeeded
from mgeo.plugins.protocol import column_names, constraint_names
from mgeo.runs.algorithms import IDLE_STEPS
from mgeo.runs.hypervolume import hypervolume
from mgeo.runs.nearest import nearest_solutions
from mgeo.runs.refine import Refinement
from mgeo.store.checkpoint import Checkpoint
from mgeo.store.recorder import Recorder
from mgeo.store.run import Nearest, Notes, Outcome, RunConfiguration, StopReason
from mgeo.store.run_folder import CHECKPOINT_FILE, RECORD_FOLDER

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm
    from pymoo.core.problem import Problem


class State(Callback):
    """State of a run, updated after each generation; it runs the algorithm and can stop it.

    Parameters
    ----------
    problem : Problem
    algorithm : Algorithm
        Set up or resumed.
    budget : int
        Budget of evaluations, that of the termination of the algorithm.
    callback : function, optional
        Called with the state after every generation. It may call ``state.stop()``.
    notes : Notes, optional
        Notes of the checkpoint of a resumed run.
    max_time : float, optional
        Time from now after which the run ends [s].

    Attributes
    ----------
    variables, objectives, constraints : tuples of str
    budget, evaluations : int
        Budget of evaluations, and those made.
    stopped : StopReason or None
        Why the run ends before its budget is used.
    refinement : Refinement or None
        The refinement after the search, once it has begun.
    checkpoint, recorder : Checkpoint and Recorder, or None
        What is saved, see `save`.
    """

    def __init__(
        self,
        problem: Problem,
        algorithm: Algorithm,
        budget: int,
        callback: Callable[[State], object] | None = None,
        *,
        notes: Notes | None = None,
        max_time: float | None = None,
    ) -> None:
        super().__init__()
        self.variables, self.objectives = column_names(problem)
        self.constraints = constraint_names(problem)
        self.budget = budget
        self.evaluations = 0
        self.stopped: StopReason | None = None
        self.refinement: Refinement | None = None
        self.checkpoint: Checkpoint | None = None
        self.recorder: Recorder | None = None
        self.started = datetime.now(UTC) if notes is None else notes.started
        self.rough = 0 if notes is None else notes.rough  # evaluations that gave estimates
        self._clock = time.perf_counter() - (0.0 if notes is None else notes.wall_time_s)
        self._deadline = None if max_time is None else time.monotonic() + max_time
        self._problem = problem
        self._algorithm = algorithm
        self._callback = callback
        self._to_refine = False  # until the refinement has ended
        self._n_idle = 0
        self._front: Population | None = None
        if algorithm.opt is not None:
            self._take_over()

    def save(self, folder: Path, configuration: RunConfiguration, *, record: bool = False) -> None:
        """Save the run while it continues: checkpoints of the MGEO family, and a record.

        Parameters
        ----------
        folder
            Existing folder of the run.
        configuration
            Written into each checkpoint, so that this file alone is enough to continue.
        record
            Whether to record every evaluation (see `mgeo.Recorder`).
        """
        if record:
            is_new = (self._algorithm.n_iter or 1) == 1
            self.recorder = Recorder(folder / RECORD_FOLDER, overwrite=is_new)
        if isinstance(self._algorithm, ExtremalOptimization):
            fixed = {"configuration": configuration.model_dump(), "record": record}
            self.checkpoint = Checkpoint(
                folder / CHECKPOINT_FILE, notes=lambda: {**fixed, **self._notes()}, warn=False
            )

    def run(self, *, polish: bool = False) -> Outcome:
        """Run the algorithm until its budget is used or it is stopped.

        The last generation is completed, so that a few more evaluations may be made. A
        KeyboardInterrupt ends the run at once, with the result of the last complete generation.
        Failing evaluations cost the candidates concerned (see `mgeo.TolerantEvaluator`).

        Parameters
        ----------
        polish
            Whether the problem refines the front when the budget is used. A checkpoint has the
            state before the refinement.

        Raises
        ------
        EvaluationError
            If every candidate fails.
        """
        algorithm, self._to_refine = self._algorithm, polish
        saving = [each for each in (self.recorder, self.checkpoint) if each is not None]
        algorithm.callback = CallbackCollection(self, *saving)
        try:
            algorithm.run()
        except KeyboardInterrupt:
            self.stop()
        if self.stopped is None and isinstance(algorithm.evaluator, TolerantEvaluator):
            algorithm.evaluator.require_success()
        if isinstance(algorithm, MGEOStaged):
            algorithm.conclude()
            self._take_over()
            if self.recorder is not None and algorithm.concluded:
                self.recorder.take(algorithm)
                self.recorder.flush()
        if polish and self.stopped is None:
            try:
                self._refine()
            except KeyboardInterrupt:
                self.stop()
            self._watch()
        return self._outcome()

    def stop(self, reason: StopReason = "signal") -> None:
        """End the run after this generation."""
        self.stopped = reason

    @property
    def ended(self) -> bool:
        """Whether the run has ended."""
        used = self.evaluations >= self.budget and not self._to_refine
        return self.stopped is not None or used

    @property
    def failures(self) -> dict[str, int]:
        """Number of failed evaluations by cause (see `mgeo.TolerantEvaluator`)."""
        return dict(getattr(self._algorithm.evaluator, "causes", {}))

    @property
    def elapsed(self) -> float:
        """Duration of the run [s], without the time between its parts."""
        return time.perf_counter() - self._clock

    @property
    def checkpoint_error(self) -> str | None:
        """Error of the latest attempt to write a checkpoint, None if there was none."""
        error = None if self.checkpoint is None else self.checkpoint.error
        return None if error is None else str(error)

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

    def _notes(self) -> dict[str, Any]:
        """Return what a resumed run has to know, as JSON values."""
        return {
            "started": self.started.isoformat(),
            "wall_time_s": self.elapsed,
            "rough": self.rough,
        }

    def _outcome(self) -> Outcome:
        """Return the result of the run."""
        X, F = self.front()
        order = np.lexsort(F.T[::-1])
        found, refined = self.solutions(), self.refinement
        is_complete = self.evaluations >= self.budget and not self._to_refine
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
            checkpoint_error=self.checkpoint_error,
        )

    def _values(self, solutions: Population, key: str) -> FloatArray:
        p = self._problem
        width = {"F": p.n_obj, "G": p.n_ieq_constr, "H": p.n_eq_constr}[key]
        values = solutions.get(key) if len(solutions) else np.empty(0)
        return np.asarray(values, dtype=float).reshape(len(solutions), width)

    def _nearest(self) -> Nearest:
        is_constrained = self._problem.n_ieq_constr + self._problem.n_eq_constr > 0
        return nearest_solutions(self._algorithm) if is_constrained else Nearest.none()

    def _update(self, algorithm: Any) -> None:
        before = self.evaluations
        self._take_over()
        self._n_idle = self._n_idle + 1 if self.evaluations == before else 0
        self._watch()
        # C-TAEA of pymoo continues forever where there are no other designs
        if self.stopped is not None or self._n_idle >= IDLE_STEPS:
            algorithm.termination.terminate()
            algorithm.termination.update(algorithm)

    def _take_over(self) -> None:
        """Take over the front and the counts of the algorithm."""
        self._front = self._algorithm.opt
        self.evaluations = self._algorithm.evaluator.n_eval
        if is_rough(self._algorithm):
            self.rough = self.evaluations

    def _watch(self) -> None:
        """Check the time, and call the callback, which may stop the run."""
        if self._deadline is not None and time.monotonic() >= self._deadline:
            self.stop("max_time")
        if self._callback is not None:
            self._callback(self)

    def _refine(self) -> None:
        """Let the problem refine the front, step by step."""
        self.refinement = Refinement(self._problem, self.solutions())
        for _ in self.refinement:
            self._front = self.refinement.front
            self._watch()
            if self.stopped is not None:
                return
        self._to_refine = False
