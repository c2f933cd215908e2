"""Run of a folder with its problem and representative solutions, for reports and the explorer."""

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
    """Run with its problem and the solutions to show.

    Attributes
    ----------
    run : Run
    problem : Problem
        Installed problem with the options of the run.
    view : View
        View of the front or, if no solution is feasible, of the solutions nearest to feasibility.
    representatives : sequence of RepresentativeSolution
        The knee, the extremes and solutions between them.
    default : RepresentativeSolution, optional
        Solution to show first; None if the run found none.
    title : str
        Problem, algorithm and seed.
    """

    run: Run
    problem: Problem
    view: View
    representatives: Sequence[RepresentativeSolution]
    default: RepresentativeSolution | None
    title: str


def load_run(folder: Path, trusted_classes: Collection[str] = ()) -> LoadedRun:
    """Read the run of a folder, and load its problem.

    Parameters
    ----------
    folder
        Run folder.
    trusted_classes
        Problems ``module:Class`` whose modules may be imported.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
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
        shown = [RepresentativeSolution(row, "near" if row else "nearest") for row in rows]
        default = shown[0]
    else:
        X, F = outcome.X, outcome.F
        shown = select_representative_solutions(problem, F, outcome.objectives)
        default = select_default_solution(problem, F) if shown else None
    title = f"{configuration.problem} · {configuration.algorithm} · seed {configuration.seed}"
    return LoadedRun(run, problem, build_view(problem, X, F), shown, default, title)
