"""What a report is about: a finished run and the problem it solved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pymoo.core.problem import Problem

from mgeo.plugins.discovery import load_problem
from mgeo.runs.representative import RepresentativeSolution, representative_solutions
from mgeo.store.run import Run
from mgeo.store.run_folder import RUN_FILE, read_run
from mgeo.validation import errors_of

_MOST_NEAR = 5  # cards of what comes nearest


def read_subject(folder: Path) -> tuple[Run, Problem, list[RepresentativeSolution], str]:
    """The run of a folder, its problem as it is installed, its representative solutions, a title.

    Of a run that found nothing that keeps all limits, ``X`` and ``F`` are what comes nearest.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
    ValueError, TypeError
        If a file in it is damaged, or the problem refuses the options in it or has other variables
        or objectives.
    """
    run = read_run(folder)
    configuration, outcome = run.configuration, run.outcome
    with errors_of(folder / RUN_FILE):
        problem = load_problem(configuration.problem, configuration.options)
        counts = len(outcome.variables), len(outcome.objectives)
        if counts != (problem.n_var, problem.n_obj):
            raise ValueError(
                f"the front has {counts[0]} variables and {counts[1]} objectives: expected "
                f"{problem.n_var} and {problem.n_obj}, as the installed problem "
                f"{configuration.problem!r} has with these options"
            )
    chosen = representative_solutions(problem, outcome.F, outcome.objectives)
    if outcome.nearest:  # shown in place of the front
        nearest = outcome.nearest
        run = replace(run, outcome=outcome.model_copy(update={"X": nearest.X, "F": nearest.F}))
        rows = range(min(_MOST_NEAR, len(nearest)))
        chosen = [RepresentativeSolution(row, "near" if row else "nearest") for row in rows]
    title = f"{configuration.problem} · {configuration.algorithm} · seed {configuration.seed}"
    return run, problem, chosen, title
