"""One HTML file from a run folder; it loads nothing, and runs nothing that the folder brings."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

import numpy as np
from markupsafe import Markup
from plotly.offline import get_plotlyjs
from pymoo.core.problem import Problem

from mgeo.figures.page import render
from mgeo.report import summary
from mgeo.report.encode import Json, figure_json, script_json
from mgeo.report.history import recorded_history
from mgeo.report.reading import run_and_problem
from mgeo.report.solutions import (
    described,
    front_json,
    front_picture,
    limits_json,
    planned_rows,
    plans_json,
)
from mgeo.report.verification import verifications
from mgeo.runs.folder import Run, front_table
from mgeo.runs.representative import RepresentativeSolution, representative_solutions


def report_html(folder: Path | str) -> str:
    """The report of a run folder.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run.
    ValueError, TypeError
        If a file in it is damaged, or the problem refuses the options in it.
    """
    folder = Path(folder)
    run, problem = run_and_problem(folder)
    outcome = run.outcome
    chosen = representative_solutions(problem, outcome.F, outcome.objectives)
    recorded = recorded_history(folder, problem, outcome)
    history = None if recorded is None else figure_json(recorded)
    data = _data(problem, run, chosen, history)
    return render(
        "report/assets/report.html",
        title=summary.title(run),
        lead=summary.lead(run),
        facts=summary.facts(run, folder),
        options=json.dumps(run.configuration.options, indent=2, ensure_ascii=False),
        outcome=outcome,
        chosen=chosen,
        verifications=list(verifications(folder, run, problem)),
        solutions=outcome.X.tolist(),
        data=data,
        json=Markup(script_json(data)),
        style=_asset("report.css"),
        library=Markup(get_plotlyjs()),
        script=Markup("").join(_asset(f"{name}.js") for name in ("figures", "motion", "report")),
    )


def _data(problem: Problem, run: Run, chosen: list[RepresentativeSolution], history: Json) -> Json:
    outcome = run.outcome
    if not len(outcome.X):
        return {"history": history, "table": None}
    rows = planned_rows(chosen, len(outcome.X))
    front = front_table(outcome)
    return {
        "table": {"columns": list(front.columns), "rows": front.to_numpy().tolist()},
        "objectives": len(outcome.objectives),
        "planned": rows.tolist(),
        "described": described(problem, outcome, rows),
        "bounds": _bounds(problem),
        "limits": limits_json(problem, outcome.X, rows),
        "labels": {str(solution.row): solution.label for solution in chosen},
        "first": next((h.row for h in chosen if h.label == "knee"), chosen[0].row),
        "front": front_json(front_picture(problem, outcome, summary.title(run))),
        "plans": plans_json(problem, outcome.X, rows),
        "history": history,
    }


def _bounds(problem: Problem) -> Json:
    """Lower and upper bounds, empty where the problem has none for each variable."""
    bounds = problem.xl, problem.xu
    known = all(isinstance(bound, np.ndarray) and bound.dtype.kind in "biuf" for bound in bounds)
    return [bound.tolist() for bound in bounds] if known else [[], []]


def _asset(name: str) -> Markup:
    return Markup(files("mgeo.report").joinpath("assets", name).read_text(encoding="utf-8"))
