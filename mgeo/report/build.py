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

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray
from plotly.offline import get_plotlyjs
from pymoo.core.problem import Problem

from mgeo.evaluation.dominance import nondominated
from mgeo.figures.page import render
from mgeo.plugins import protocol
from mgeo.plugins.problems import load_problem
from mgeo.plugins.shown import ask, cells, kinds_of
from mgeo.plugins.view import TOLERANCE, View, is_own, view_of
from mgeo.report.solutions import figure_json, script_json, solutions_json
from mgeo.runs.answer import RepresentativeSolution, answer, dead_end, representative_solutions
from mgeo.runs.hypervolume import MAX_OBJECTIVES, scaled, unit_hypervolume
from mgeo.store.provenance import difference
from mgeo.store.reading import read_json
from mgeo.store.recorder import read_record
from mgeo.store.run import Outcome, Run
from mgeo.store.run_folder import (
    ABOUT,
    RECORD_FOLDER,
    RUN_FILE,
    VERIFICATION_FILES,
    check_verification,
    read_run,
)
from mgeo.validation.entries import errors_of

_SAMPLES = 60


def recorded_history(folder: Path, problem: Problem, outcome: Outcome) -> go.Figure | None:
    """Hypervolume against evaluations; None of a run that saved no record, or has no hypervolume.

    Raises
    ------
    ValueError
        If the record is damaged, or of another run.
    """
    try:
        columns = [*outcome.objectives, *_constraints(problem, "g"), *_constraints(problem, "h")]
        record = read_record(folder / RECORD_FOLDER, [*columns, "failed"])
    except FileNotFoundError:
        return None
    found = hypervolume_history(problem, outcome, record)
    if found is None:
        return None
    figure = go.Figure().add_scatter(
        x=found[0],
        y=found[1],
        mode="lines",
        line={"shape": "hv", "color": "#0072B2", "width": 2.5},
        hovertemplate="%{x:,d} evaluations: %{y:.4f}<extra></extra>",
    )
    title = f"evaluations, after {outcome.rough:,} by estimates" if outcome.rough else "evaluations"
    figure.update_xaxes(title=title, type="log", dtick=1)
    figure.update_yaxes(title="hypervolume", rangemode="tozero")
    return figure.update_layout(margin={"l": 70, "r": 20, "t": 20, "b": 55}, height=340)


def hypervolume_history(
    problem: Problem, outcome: Outcome, record: pd.DataFrame
) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
    """Evaluations and the hypervolume of all that was found until then, shapes (k,).

    It is measured in the indicator space of the problem, or else with the objectives scaled to the
    range of all feasible evaluations. It begins after the evaluations that gave estimates only.
    None for one objective, for more than `MAX_OBJECTIVES`, or if there is no feasible evaluation.

    Parameters
    ----------
    record
        What `mgeo.read_record` reads, with the objectives and constraints.
    """
    if not 1 < problem.n_obj <= MAX_OBJECTIVES:
        return None
    G, H = (record[_constraints(problem, kind)].to_numpy(float) for kind in "gh")
    feasible = (G <= 0.0).all(axis=1) & (np.abs(H) <= TOLERANCE).all(axis=1)
    F = record[list(outcome.objectives)].to_numpy(float).copy()
    F[record["failed"].to_numpy(bool) | ~feasible] = np.nan
    precise = F[outcome.rough :]
    reached = precise[~np.isnan(precise).any(axis=1)]
    if not len(reached):
        return None
    space = protocol.indicator_space(problem)
    ideal, nadir = reached.min(axis=0), reached.max(axis=0)
    ends = np.unique(np.geomspace(outcome.rough + 1, len(F), _SAMPLES).astype(np.int64))
    front, volumes, done = F[:0], [], outcome.rough
    for end in ends:
        candidates = np.vstack([front, F[done:end]])
        front, done = candidates[nondominated(candidates)], end
        points = scaled(front, ideal, nadir) if space is None else space(front)
        volumes.append(unit_hypervolume(points) if len(front) else 0.0)
    return ends, np.array(volumes)


def _constraints(problem: Problem, kind: str) -> list[str]:
    n = {"g": problem.n_ieq_constr, "h": problem.n_eq_constr}[kind]
    return [f"{kind}{j + 1}" for j in range(n)]


_LONGEST = 200  # characters of a difference, which may quote a whole list


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
    """All results of a folder by name: the file, and why it is ignored, or "" and what it says.

    Raises
    ------
    ValueError
        For a file of another form, naming it.
    """
    options = protocol.options(problem)
    solved = {
        "problem": run.configuration.problem,
        # as a file gives them
        "options": run.configuration.options
        if options is None
        else json.loads(json.dumps(options)),
    }
    solutions = run.outcome.X.tolist()
    for path in sorted(folder.glob(VERIFICATION_FILES)):
        found = read_json(path)
        with errors_of(path):
            check_verification(found)
        missing = [key for key in ABOUT if key not in found]
        why_ignored = ""
        if missing:
            why_ignored = f"it does not say what it is about, its {' and '.join(missing)}"
        elif other := difference(solved, {key: found[key] for key in solved}):
            why_ignored = f"it is about another problem, {other:.{_LONGEST}}"
        elif found["design"] not in solutions:
            why_ignored = "its design is no solution of this front"
        yield path.name, why_ignored, found


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
