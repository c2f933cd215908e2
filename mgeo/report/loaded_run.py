"""Run folder read together with its problem, for reports and for `mgeo.explore`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from pymoo.core.problem import Problem

from mgeo.plugins.problems import load_problem
from mgeo.plugins.view import View, build_view
from mgeo.runs.summary import (
    RepresentativeSolution,
    select_default_solution,
    select_representative_solutions,
)
from mgeo.store.run import Run
from mgeo.store.run_folder import RUN_FILE, read_run
from mgeo.validation.entries import convert_file_errors

_MAX_NEAREST = 5  # maximum number of representative infeasible solutions


@dataclass(frozen=True)
class LoadedRun:
    """Run loaded from a folder, with its problem and a selection of representative solutions.

    Attributes
    ----------
    run : Run
        Configuration and outcome of the run.
    problem : Problem
        Installed problem with the options of the run.
    view : View
        View of the problem on the front or, if no solution is feasible, on the solutions nearest
        to feasibility.
    representatives : sequence of RepresentativeSolution
        The knee of the front, the best solution of each objective, and solutions between them.
    default : RepresentativeSolution, optional
        Solution to show first; None if the run found no solution.
    title : str
        Title that names problem, algorithm and seed.
    """

    run: Run
    problem: Problem
    view: View
    representatives: Sequence[RepresentativeSolution]
    default: RepresentativeSolution | None
    title: str


def load_run(folder: Path, trusted_classes: Collection[str] = ()) -> LoadedRun:
    """Read a run folder, load the problem of the run, and select representative solutions.

    Parameters
    ----------
    folder
        Run folder.
    trusted_classes
        Problem classes, as ``module:Class``, whose modules may be imported.

    Raises
    ------
    FileNotFoundError
        If the folder contains no run.
    ValueError, TypeError
        If a file is damaged, or the installed problem refuses the options or has another number of
        variables or objectives.
    """
    run = read_run(folder)
    configuration, outcome = run.configuration, run.outcome
    with convert_file_errors(folder / RUN_FILE):
        problem = load_problem(
            configuration.problem, configuration.options, trusted_classes=trusted_classes
        )
        counts = len(outcome.variables), len(outcome.objectives)
        if counts != (problem.n_var, problem.n_obj):
            raise ValueError(
                f"the front has {counts[0]} variables and {counts[1]} objectives: expected "
                f"{problem.n_var} and {problem.n_obj}, as the installed problem "
                f"{configuration.problem!r} has with these options"
            )
    default: RepresentativeSolution | None
    if outcome.nearest:
        X, F = outcome.nearest.X, outcome.nearest.F
        rows = range(min(_MAX_NEAREST, len(X)))
        representatives = [
            RepresentativeSolution(row, "near" if row else "nearest") for row in rows
        ]
        default = representatives[0]
    else:
        X, F = outcome.X, outcome.F
        representatives = select_representative_solutions(problem, F)
        default = select_default_solution(problem, F) if representatives else None
    title = f"{configuration.problem} · {configuration.algorithm} · seed {configuration.seed}"
    return LoadedRun(run, problem, build_view(problem, X, F), representatives, default, title)
