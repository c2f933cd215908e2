"""One HTML file from a run folder; it loads nothing, and runs nothing that the folder brings."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from markupsafe import Markup
from plotly.offline import get_plotlyjs
from pymoo.core.problem import Problem

from mgeo.figures.page import render
from mgeo.plugins.problems import load_problem
from mgeo.plugins.review import cells, kinds_of
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, is_own, view_of
from mgeo.report.encode import figure_json, script_json
from mgeo.report.history import recorded_history
from mgeo.report.solutions import solutions_json
from mgeo.report.verification import more_tables, verifications
from mgeo.runs.answer import RepresentativeSolution, answer, representative_solutions
from mgeo.runs.limits import dead_end
from mgeo.store.run import Run
from mgeo.store.run_folder import RUN_FILE, read_run
from mgeo.validation.tables import errors_of

_MOST_NEAR = 5  # cards of what comes nearest


def report_html(
    folder: Path | str, solution: int | None = None, *, problem: str | None = None
) -> str:
    """The report of a run folder.

    Parameters
    ----------
    folder
        That `mgeo solve` wrote.
    solution
        Number of the one to be reviewed, with which the page opens; default: the knee.
    problem
        The run's, if that is ``module:Class``: a file alone has no module imported.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
    ValueError, TypeError
        If a file in it is damaged, or the problem refuses the options in it.

    Examples
    --------
    >>> from mgeo.report import report_html
    >>> page = report_html("runs/first")  # doctest: +SKIP
    """
    folder = Path(folder)
    run, made, chosen, title = read_subject(folder, problem)
    nearest = run.outcome.nearest
    found = len(run.outcome.F) > 0 and not nearest
    history = recorded_history(folder, made, run.outcome)
    view = view_of(made, run.outcome.X, run.outcome.F)
    data = solutions_json(view, run, chosen, title) if chosen else {"table": None}
    if solution is not None:
        if not 0 <= solution < len(view.X):
            raise ValueError(f"solution {solution}: expected 0 to {len(view.X) - 1}")
        data["first"] = solution
    review = None
    if chosen and is_own(view, View.review):
        first = int(data["first"] or 0)
        review = ask(view.take([first]), View.review)
    data["history"] = None if history is None else figure_json(history)
    return render(
        "report/assets/report.html",
        title=title,
        review=review,
        cells=cells,
        kinds_of=kinds_of,
        answer=_answer(view, solution) if found else None,
        remarks=ask(view, View.remarks) if found else [],
        dead_end=dead_end(view) if nearest else None,
        folder=folder.resolve().name,
        run=run,
        configuration=run.configuration,
        outcome=run.outcome,
        options=json.dumps(run.configuration.options, indent=2, ensure_ascii=False),
        chosen=chosen,
        more_tables=more_tables,
        verifications=list(verifications(folder, run, made)),
        solutions=run.outcome.X.tolist(),
        data=data,
        json=Markup(script_json(data)),
        library=Markup(get_plotlyjs()),
    )


def _answer(view: View, solution: int | None) -> str:
    """What the solution is worth that the page opens with."""
    if solution is None:
        return str(answer(view))
    (told,) = ask(view.take([solution]), View.answers)
    return f"solution {solution} of {len(view.X):,}: {told}"


def read_subject(
    folder: Path, named: str | None = None
) -> tuple[Run, Problem, list[RepresentativeSolution], str]:
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
        problem = load_problem(configuration.problem, configuration.options, named=(named or "",))
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
