"""What a report is about: a finished run and the problem it solved."""

from __future__ import annotations

from pathlib import Path

from pymoo.core.problem import Problem

from mgeo.files.reading import errors_of
from mgeo.plugins.discovery import load_problem
from mgeo.runs import RUN_FILE, Highlight, Run, highlights, read_run


def read_subject(folder: Path) -> tuple[Run, Problem, list[Highlight], str]:
    """The run of a folder, its problem as it is installed, the solutions that tell most, a title.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
    ValueError, TypeError
        If a file in it is damaged, or the problem refuses the options in it or has other variables
        or objectives.
    """
    run = read_run(folder)
    recipe, outcome = run.recipe, run.outcome
    with errors_of(folder / RUN_FILE):
        problem = load_problem(recipe.problem, recipe.options)
        counts = len(outcome.variables), len(outcome.objectives)
        if counts != (problem.n_var, problem.n_obj):
            raise ValueError(
                f"the front has {counts[0]} variables and {counts[1]} objectives: expected "
                f"{problem.n_var} and {problem.n_obj}, as the installed problem "
                f"{recipe.problem!r} has with these options"
            )
    chosen = highlights(problem, outcome.F, outcome.objectives)
    title = f"{recipe.problem} · {recipe.algorithm} · seed {recipe.seed}"
    return run, problem, chosen, title
