"""Preparation of runs from names and options, from a configuration, or from a checkpoint."""

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
from mgeo.plugins.discovery import PluginError
from mgeo.plugins.problems import is_class_path, load_problem
from mgeo.runs.algorithms import (
    build_algorithm,
    complete_parameters,
    compute_default_budget,
    select_default_algorithm,
    set_up,
)
from mgeo.runs.solve import SolveState, solve
from mgeo.store.checkpoint import Checkpoint, read_checkpoint_metadata, resume
from mgeo.store.recorder import Recorder
from mgeo.store.run import CheckpointMetadata, Outcome, RunConfiguration
from mgeo.store.run_folder import CHECKPOINT_FILE, RECORD_FOLDER
from mgeo.validation.entries import FileError, convert_file_errors
from mgeo.validation.tables import validate_table


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """Configuration, problem and algorithm of a run that is ready to start.

    A new run can be solved more than once, with equal results.

    Attributes
    ----------
    configuration : RunConfiguration
        All settings of the run.
    problem : Problem
        Problem of the configuration.
    algorithm : Algorithm
        Algorithm of the configuration, set up only if the run is resumed.
    metadata : CheckpointMetadata or None
        Data of the checkpoint of a resumed run.
    record : bool
        Whether every evaluation is recorded if the run is saved in a folder.
    """

    configuration: RunConfiguration
    problem: Problem
    algorithm: Algorithm
    metadata: CheckpointMetadata | None = None
    record: bool = False

    @classmethod
    def from_configuration(cls, configuration: RunConfiguration) -> PreparedRun:
        """Build the problem and the algorithm of a configuration.

        Raises
        ------
        ValueError, TypeError
            If a name, an option or a parameter is invalid.
        """
        problem = load_problem(configuration.problem, configuration.options)
        algorithm = build_algorithm(configuration.algorithm, configuration.parameters, problem)
        run = cls(configuration, problem, algorithm)
        run.check()
        return run

    def solve(
        self,
        callback: Callable[[SolveState], object] | None = None,
        folder: Path | None = None,
        max_time: float | None = None,
    ) -> Outcome:
        """Run the algorithm until its budget is used up or it is stopped, and return the outcome.

        Parameters
        ----------
        callback : function, optional
            Called with the `SolveState` after every generation. It may stop the run.
        folder : Path, optional
            Existing folder for the record and for checkpoints (MGEO family only). By default,
            no files are written.
        max_time : float, optional
            Time from now after which the run ends [s].

        Returns
        -------
        Outcome
            Front and statistics, see `mgeo.runs.solve.solve`.
        """
        run = self.configuration
        algorithm = self._set_up(run.initial_designs) if self.metadata is None else self.algorithm
        state = SolveState(
            algorithm, run.evaluations, callback, metadata=self.metadata, max_time=max_time
        )
        if folder is not None and self.record:
            is_new = (algorithm.n_iter or 1) == 1
            state.recorder = Recorder(folder / RECORD_FOLDER, overwrite=is_new)
        if folder is not None and isinstance(algorithm, ExtremalOptimization):
            state.checkpoint = Checkpoint(
                folder / CHECKPOINT_FILE,
                build_metadata=lambda: self._build_metadata(state),
                warn=False,
            )
        return solve(state, refine=run.refine)

    def _build_metadata(self, state: SolveState) -> dict[str, Any]:
        metadata = CheckpointMetadata(
            configuration=self.configuration,
            record=self.record,
            start_time=state.start_time,
            wall_time_s=state.elapsed_time,
            n_low_fidelity=state.n_low_fidelity,
        )
        return metadata.model_dump(mode="json")

    def check(self) -> None:
        """Check the configuration without evaluating any design.

        Raises
        ------
        ValueError
            If the problem or the algorithm does not support a setting.
        """
        run = self.configuration
        self._set_up(run.initial_designs)
        if self.record and isinstance(self.algorithm, LoopwiseAlgorithm):
            raise ValueError(
                f"evaluations of {run.algorithm!r} cannot be recorded: expected an algorithm that "
                "evaluates its candidates a generation at a time"
            )
        if run.refine:  # A refinement of zero designs only checks that the problem supports it.
            for _ in protocol.iterate_refinement(self.problem, np.empty((0, self.problem.n_var))):
                pass

    def _set_up(self, initial_designs: int = 0) -> Algorithm:
        run = self.configuration
        protocol.get_column_names(self.problem)  # Raises an error if names are invalid.
        return set_up(self.problem, self.algorithm, run.evaluations, run.seed, initial_designs)


def prepare_run(
    problem: str,
    options: Mapping[str, Any] | None = None,
    *,
    scenario_file: str | None = None,
    algorithm: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    evaluations: int | None = None,
    seed: int = 1,
    robust: bool = False,
    initial_designs: int | None = 0,
    refine: bool | None = False,
    record: bool = False,
) -> PreparedRun:
    """Build the problem and the algorithm of a new run, using defaults for omitted settings.

    The recommendations of the problem are used only if neither the algorithm, its parameters nor
    the budget are given, and `robust` is false.

    Parameters
    ----------
    problem : str
        Name of the problem, as for `mgeo.plugins.problems.load_problem`.
    options : mapping, optional
        Options of the problem.
    scenario_file : str, optional
        File from which the options were read, for error messages.
    algorithm : str, optional
        Name of the algorithm. Default: `select_default_algorithm`.
    parameters : mapping, optional
        Parameters of the algorithm that differ from the defaults.
    evaluations : int, optional
        Budget of evaluations. Default: the problem's recommendation if `refine` is None, otherwise
        `compute_default_budget`.
    seed : int
        Seed of all random numbers.
    robust : bool
        Whether to solve the robust version of the problem, from its method ``to_robust()``.
    initial_designs : int or None
        Number of initial designs that the problem suggests; None for the problem's recommendation.
    refine : bool or None
        Whether the problem refines the front locally; None for the problem's recommendation.
    record : bool
        Whether to record every evaluation.

    Returns
    -------
    PreparedRun

    Raises
    ------
    ValueError, TypeError
        If a name, an option or a parameter is invalid, or the options are not JSON values.
    """
    uses_recommendation = not (robust or algorithm or parameters or evaluations)
    algorithm = algorithm or select_default_algorithm(robust)
    all_parameters = complete_parameters(algorithm, parameters or {})
    try:
        built = load_problem(problem, options, trusted_classes=(problem,))
    except PluginError:
        raise
    except (ValueError, TypeError) as error:
        if scenario_file is None:
            raise
        raise FileError(f"{scenario_file}: {error}") from error
    if robust:
        built = protocol.get_robust_problem(built)
    optimizer = build_algorithm(algorithm, all_parameters, built)
    problem_options = protocol.get_options(built)
    recommended = (
        protocol.get_recommended_settings(built)
        if uses_recommendation
        else protocol.RecommendedSettings()
    )
    initial_designs = recommended.initial_designs if initial_designs is None else initial_designs
    if refine is None:
        refine, evaluations = recommended.refine, evaluations or recommended.evaluations
    if evaluations is None:
        evaluations = compute_default_budget(optimizer, built)
    data = {
        "problem": problem,
        "options": dict(options or {}) if problem_options is None else problem_options,
        "algorithm": algorithm,
        "parameters": all_parameters,
        "evaluations": evaluations,
        "seed": seed,
        "initial_designs": initial_designs,
        "refine": refine,
    }
    try:  # A repeated run reads its values from JSON, so the first run uses JSON values as well.
        data = json.loads(json.dumps(data, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise ValueError(f"the options of {problem!r} are not JSON values: {error}") from error
    run = PreparedRun(validate_table(RunConfiguration, data), built, optimizer, record=record)
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
    """Restore a run from the last checkpoint in its folder, so that it can continue.

    Parameters
    ----------
    folder : path
        Folder of a run with a checkpoint, finished or not.
    evaluations : int, optional
        New budget, counted from the start of the run. Default: the budget of the run.
    algorithm, problem : str, optional
        Class ``module:Class`` of the run. The caller must specify it, because modules are not
        imported on behalf of a file.
    check : bool
        Whether to require equal versions and equal problem values, see `mgeo.resume`.

    Returns
    -------
    PreparedRun

    Raises
    ------
    FileNotFoundError
        If the folder has no checkpoint.
    ValueError, TypeError
        If the checkpoint is damaged; if problem, parameters or versions differ from those of the
        run (the message contains the difference); or if the new budget is already exceeded.
    """
    path = Path(folder) / CHECKPOINT_FILE
    if not path.is_file():
        raise FileNotFoundError(
            f"{folder} cannot be resumed: there is no {CHECKPOINT_FILE}. Expected the folder of a "
            "run by an algorithm of the MGEO family"
        )
    data = read_checkpoint_metadata(path)
    with convert_file_errors(path):
        metadata = validate_table(CheckpointMetadata, data)
        run = metadata.configuration
        if is_class_path(run.algorithm) and algorithm != run.algorithm:
            raise ValueError(
                f"algorithm = {run.algorithm!r}: its module is imported only if you specify it: "
                f"--algorithm {run.algorithm}"
            )
        problem_of_run = load_problem(
            run.problem, run.options, trusted_classes=(problem,) if problem else ()
        )
        optimizer = build_algorithm(run.algorithm, run.parameters, problem_of_run)
    budget = evaluations or run.evaluations
    resumed = resume(path, problem_of_run, ("n_eval", budget), algorithm=optimizer, check=check)
    resumed.evaluator.warn = False  # The outcome reports the failures.
    if budget < min(resumed.evaluator.n_eval, run.evaluations):
        raise ValueError(
            f"the new budget is {budget} evaluations: expected at least "
            f"{resumed.evaluator.n_eval}, the number of evaluations already made"
        )
    configuration = run.model_copy(update={"evaluations": budget})
    return PreparedRun(configuration, problem_of_run, resumed, metadata, metadata.record)
