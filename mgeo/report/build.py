"""One HTML file from a run folder; it loads nothing, and runs nothing that the folder brings.

Of a recorded run it has the hypervolume against evaluations. Results of Monte Carlo that a
problem's own tools leave there are files ``verification*.json``: each an object with the strings
``title`` and ``conclusion``, and a table as ``columns``, a list of strings, and ``rows``, lists of
as many numbers or strings. It says what it is about by the ``problem``'s name, its ``options`` and
the ``design``, a list of numbers as in a row of ``front.csv``. One that is about no solution of the
folder's front, as a front before it may have left, proves nothing here, and is not shown.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup
from plotly.offline import get_plotlyjs
from pymoo.core.problem import Problem

from mgeo.figures.page import render
from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem
from mgeo.plugins.shown import ask, cells, kinds_of
from mgeo.plugins.view import View, is_own, view_of
from mgeo.report.history import recorded_history
from mgeo.report.solutions import figure_json, script_json, solutions_json
from mgeo.runs.answer import RepresentativeSolution, answer, dead_end, representative_solutions
from mgeo.store.reading import read_json
from mgeo.store.run import Run
from mgeo.store.run_folder import RUN_FILE, VERIFICATION_FILES, check_verification, read_run
from mgeo.validation.tables import errors_of


def more_tables(found: Mapping[str, Any]) -> Iterator[tuple[str, list[list[str]]]]:
    """What else it tells in rows, lists of objects with the same keys, by name, titles first."""
    for key, rows in found.items():
        if not (isinstance(rows, list) and rows and all(isinstance(row, dict) for row in rows)):
            continue
        titles = list(rows[0])
        if all(list(row) == titles for row in rows):
            yield key.replace("_", " "), cells(pd.DataFrame(rows, columns=titles))


def verifications(
    folder: Path, run: Run, problem: Problem
) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """Yield name, reason to ignore it, and content of each verification file of a run folder.

    The reason is empty if the file verifies a solution of this front.

    Raises
    ------
    ValueError
        If a file has another form.
    """
    options = protocol.options(problem)
    if options is None:
        options = run.configuration.options
    about = {"problem": run.configuration.problem, "options": json.loads(json.dumps(options))}
    designs = run.outcome.X.tolist()
    for path in sorted(folder.glob(VERIFICATION_FILES)):
        found = read_json(path)
        with errors_of(path):
            check_verification(found)
        reason = ""
        if {key: found.get(key) for key in about} != about:
            reason = "its problem or options are not those of this run"
        elif found.get("design") not in designs:
            reason = "its design is no solution of this front"
        yield path.name, reason, found


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
    run, made, chosen, title = read_subject(folder, [problem] if problem else [])
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
    folder: Path, named: Collection[str] = ()
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
        problem = load_problem(configuration.problem, configuration.options, named=named)
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
