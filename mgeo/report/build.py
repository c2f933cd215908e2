"""One HTML file from a run folder; it loads nothing, and runs nothing that the folder brings."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from pathlib import Path

import numpy as np
from plotly.offline import get_plotlyjs
from pymoo.core.problem import Problem

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
from mgeo.report.verification import verification
from mgeo.runs.folder import Run, front_table
from mgeo.runs.highlights import Highlight, highlights

_NO_RECORD = (
    "The run kept no record of its evaluations (<code>mgeo solve --record</code> does), so how its "
    "hypervolume grew is not known."
)
# nothing from the network, whatever a string of the run might look like; plotly's three-dimensional
# figures compile functions
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; base-uri 'none'; form-action 'none'"
)


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
    chosen = highlights(problem, outcome.F, outcome.objectives)
    recorded = recorded_history(folder, problem, run.outcome)
    history = None if recorded is None else figure_json(recorded)
    sections = [
        _section("What was run", summary.facts(run, folder)),
        _section("Knee and extremes", summary.cards(chosen, outcome.objectives, outcome.F), "cards")
        if chosen
        else _section("Front", "<p>No feasible solution was found.</p>"),
        _asset("plans.html") if chosen else "",
        _section("Hypervolume", "<div id=history></div>" if history else f"<p>{_NO_RECORD}</p>"),
        _section("Monte Carlo", verification(folder, run, problem)),
        _asset("table.html") if chosen else "",
    ]
    return _document(run, "\n".join(sections), _data(problem, run, chosen, history))


def _data(problem: Problem, run: Run, chosen: list[Highlight], history: Json) -> Json:
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
        "labels": {str(highlight.row): highlight.label for highlight in chosen},
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


def _section(heading: str, body: str, kind: str = "") -> str:
    inner = f'<div class="{kind}">{body}</div>' if kind else body
    return f"<section><h2>{heading}</h2>{inner}</section>"


def _asset(name: str) -> str:
    return files("mgeo.report").joinpath("assets", name).read_text(encoding="utf-8")


def _document(run: Run, body: str, data: Json) -> str:
    title = escape(summary.title(run))
    script = "".join(_asset(f"{name}.js") for name in ("figures", "motion", "report"))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{title}</title>\n<style>{_asset('report.css')}</style>\n"
        f"<script>{get_plotlyjs()}</script>\n</head>\n<body>\n"
        f"<header><h1>{title}</h1><p>{escape(summary.lead(run))}</p></header>\n<main>\n{body}\n"
        f'</main>\n<script type="application/json" id="data">{script_json(data)}</script>\n'
        f"<script>{script}</script>\n</body>\n</html>\n"
    )
