"""What a report is about: a finished run and the problem it solved."""

from __future__ import annotations

from pathlib import Path

from pymoo.core.problem import Problem

from mgeo.files.reading import errors_of
from mgeo.plugins.discovery import load_problem
from mgeo.runs.folder import RUN_FILE, Run, read_run


def run_and_problem(folder: Path) -> tuple[Run, Problem]:
    """The run of a folder, and its problem as it is installed.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
    ValueError, TypeError
        If a file in it is damaged, or the problem refuses the options in it or has other variables
        or objectives.
    """
    run = read_run(folder)
    with errors_of(folder / RUN_FILE):
        problem = load_problem(run.configuration.problem, run.configuration.options)
        counts = len(run.outcome.variables), len(run.outcome.objectives)
        if counts != (problem.n_var, problem.n_obj):
            raise ValueError(
                f"the front has {counts[0]} variables and {counts[1]} objectives: expected "
                f"{problem.n_var} and {problem.n_obj}, as the installed problem "
                f"{run.configuration.problem!r} has with these options"
            )
    return run, problem
