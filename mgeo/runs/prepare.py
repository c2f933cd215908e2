"""Runs prepared from names and options, made again from a configuration, or resumed."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm, LoopwiseAlgorithm
from pymoo.core.problem import Problem

from mgeo.algorithms.base import ExtremalOptimization
from mgeo.plugins import protocol
from mgeo.plugins.problems import is_own_class, load_problem
from mgeo.runs.algorithms import (
    build_algorithm,
    complete_parameters,
    default_algorithm,
    default_evaluations,
    set_up,
)
from mgeo.runs.solve import State, solve
from mgeo.store.checkpoint import Checkpoint, read_notes, resume
from mgeo.store.recorder import Recorder
from mgeo.store.run import Notes, Outcome, RunConfiguration
from mgeo.store.run_folder import CHECKPOINT_FILE, RECORD_FOLDER
from mgeo.validation.entries import errors_of
from mgeo.validation.tables import checked


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """A configuration with the problem and the algorithm that were built from it.

    A new run can be solved more than once.

    Attributes
    ----------
    notes : Notes or None
        Notes of the checkpoint of a resumed run.
    record : bool
        Whether every evaluation is recorded if the run is saved in a folder.
    """

    configuration: RunConfiguration
    problem: Problem
    algorithm: Algorithm
    notes: Notes | None = None
    record: bool = False

    @classmethod
    def of(cls, configuration: RunConfiguration) -> PreparedRun:
        """Build the problem and the algorithm.

        Raises
        ------
        ValueError, TypeError
            If a name, an option or a parameter is refused.
        """
        problem = load_problem(configuration.problem, configuration.options)
        algorithm = build_algorithm(configuration.algorithm, configuration.parameters, problem)
        run = cls(configuration, problem, algorithm)
        run.check()
        return run

    def solve(
        self,
        callback: Callable[[State], object] | None = None,
        folder: Path | None = None,
        max_time: float | None = None,
    ) -> Outcome:
        """Run the algorithm until its budget is used or it is stopped (see `mgeo.runs.solve`).

        Parameters
        ----------
        callback
            Called with the `State` after every generation.
        folder
            Existing folder for checkpoints of the MGEO family and the record; by default nothing is
            saved.
        max_time
            Time from now after which the run ends [s].
        """
        run = self.configuration
        algorithm = self._set_up(run.starts) if self.notes is None else self.algorithm
        state = State(algorithm, run.evaluations, callback, notes=self.notes, max_time=max_time)
        if folder is not None and self.record:
            is_new = (algorithm.n_iter or 1) == 1
            state.recorder = Recorder(folder / RECORD_FOLDER, overwrite=is_new)
        if folder is not None and isinstance(algorithm, ExtremalOptimization):
            state.checkpoint = Checkpoint(
                folder / CHECKPOINT_FILE, notes=lambda: self._notes(state), warn=False
            )
        return solve(state, polish=run.polish)

    def _notes(self, state: State) -> dict[str, Any]:
        """Return what a resumed run has to know: with the checkpoint alone it can continue."""
        notes = Notes(
            configuration=self.configuration,
            record=self.record,
            started=state.started,
            wall_time_s=state.elapsed,
            rough=state.rough,
        )
        return notes.model_dump(mode="json")

    def check(self) -> None:
        """Check that the configuration can be run, before anything is evaluated.

        Raises
        ------
        ValueError
            If the problem or the algorithm refuses a part of it.
        """
        run = self.configuration
        self._set_up(run.starts)
        if self.record and isinstance(self.algorithm, LoopwiseAlgorithm):
            raise ValueError(
                f"evaluations of {run.algorithm!r} cannot be recorded: expected an algorithm that "
                "evaluates its candidates a generation at a time"
            )
        if run.polish:  # without designs, a refinement checks that it is possible
            for _ in protocol.refinement(self.problem, np.empty((0, self.problem.n_var))):
                pass

    def _set_up(self, starts: int = 0) -> Algorithm:
        run = self.configuration
        protocol.column_names(self.problem)  # wrong ones are refused before anything is evaluated
        return set_up(self.problem, self.algorithm, run.evaluations, run.seed, starts)


def prepare(
    problem: str,
    options: Mapping[str, Any] | None = None,
    *,
    algorithm: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    evaluations: int | None = None,
    seed: int = 1,
    robust: bool = False,
    starts: int | None = 0,
    polish: bool | None = False,
    record: bool = False,
) -> PreparedRun:
    """Prepare a new run. Its configuration leaves nothing to defaults that may change.

    Parameters
    ----------
    problem, options
        As for `mgeo.plugins.problems.load_problem`.
    algorithm, parameters
        As for `mgeo.runs.algorithms.build_algorithm`. Default: `default_algorithm`.
    evaluations
        Budget. Default: `default_evaluations`, or the recommendation for a polished run.
    seed
        Seed of all random numbers.
    robust
        Whether to solve the problem of the problem's method ``robust()``.
    starts
        Number of initial designs that the problem suggests. None: as the problem recommends.
    polish
        Whether the problem refines the front. None: as the problem recommends.
    record
        Whether to record every evaluation.

    A problem recommends nothing for a robust run, or if the algorithm, its parameters or the budget
    are given.

    Raises
    ------
    ValueError, TypeError
        If a name, an option or a parameter is refused, or the options are no JSON values.
    """
    plain = not (robust or algorithm or parameters or evaluations)
    algorithm = algorithm or default_algorithm(robust)
    complete = complete_parameters(algorithm, parameters or {})
    built = load_problem(problem, options, named=(problem,))
    if robust:
        built = protocol.robust(built)
    optimizer = build_algorithm(algorithm, complete, built)
    own = protocol.options(built)
    advised = protocol.recommended(built) if plain else protocol.Recommended()
    starts = advised.starts if starts is None else starts
    if polish is None:
        polish, evaluations = advised.polish, evaluations or advised.evaluations
    if evaluations is None:
        evaluations = default_evaluations(optimizer, built)
    data = {
        "problem": problem,
        "options": dict(options or {}) if own is None else own,
        "algorithm": algorithm,
        "parameters": complete,
        "evaluations": evaluations,
        "seed": seed,
        "starts": starts,
        "polish": polish,
    }
    try:  # values as read from a file, so that a run that is made again is the same
        data = json.loads(json.dumps(data, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise ValueError(f"the options of {problem!r} are no JSON values: {error}") from error
    run = PreparedRun(checked(RunConfiguration, data), built, optimizer, record=record)
    run.check()
    return run


def resume_run(
    folder: Path | str,
    *,
    evaluations: int | None = None,
    algorithm: str | None = None,
    problem: str | None = None,
    check: bool = True,
) -> PreparedRun:
    """Return the run of a folder in the state of its last checkpoint.

    Parameters
    ----------
    folder
        Folder of a run with a checkpoint, finished or not.
    evaluations
        New budget, counted from the beginning of the run.
    algorithm, problem
        Class of the run, ``module:Class``. No module is imported because a file names it.
    check
        Whether versions and a few values of the problem must be those of the run (see
        `mgeo.resume`).

    Raises
    ------
    FileNotFoundError
        If the folder has no checkpoint.
    ValueError, TypeError
        If the checkpoint is damaged; if problem, parameters or versions are not those of the run,
        naming the difference; or if the new budget is less than what was evaluated already.
    """
    path = Path(folder) / CHECKPOINT_FILE
    if not path.is_file():
        raise FileNotFoundError(
            f"{folder} cannot be resumed: there is no {CHECKPOINT_FILE} in it; only algorithms of "
            "the MGEO family write one"
        )
    found = read_notes(path)
    with errors_of(path):
        notes = checked(Notes, found)
        run = notes.configuration
        if is_own_class(run.algorithm) and algorithm != run.algorithm:
            raise ValueError(
                f"algorithm = {run.algorithm!r}: its module is imported only if it is named: "
                f"--algorithm {run.algorithm}"
            )
        loaded = load_problem(run.problem, run.options, named=(problem,) if problem else ())
        same = build_algorithm(run.algorithm, run.parameters, loaded)
    budget = evaluations or run.evaluations
    resumed = resume(path, loaded, ("n_eval", budget), algorithm=same, check=check)
    resumed.evaluator.warn = False  # the outcome has the failures
    if budget < min(resumed.evaluator.n_eval, run.evaluations):
        raise ValueError(
            f"the new budget is {budget} evaluations: expected at least the "
            f"{resumed.evaluator.n_eval} that were made already"
        )
    longer = run.model_copy(update={"evaluations": budget})
    return PreparedRun(longer, loaded, resumed, notes, notes.record)
