"""One HTML file from a run folder; it loads nothing, and runs nothing that the folder brings."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

from markupsafe import Markup
from plotly.offline import get_plotlyjs

from mgeo.figures.page import render
from mgeo.plugins import protocol
from mgeo.report.encode import figure_json, script_json
from mgeo.report.history import recorded_history
from mgeo.report.reading import read_subject
from mgeo.report.solutions import solutions_json
from mgeo.report.verification import verifications
from mgeo.runs.answer import answer
from mgeo.runs.dead_end import dead_end


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
    run, problem, chosen, title = read_subject(folder)
    nearest = run.outcome.nearest
    history = recorded_history(folder, problem, run.outcome)
    data = solutions_json(problem, run, chosen, title) if chosen else {"table": None}
    data["history"] = None if history is None else figure_json(history)
    return render(
        "report/assets/report.html",
        title=title,
        answer=None if nearest else answer(problem, run.outcome),
        remarks=[] if nearest else protocol.remarks(problem, run.outcome.X),
        dead_end=dead_end(problem, nearest) if nearest else None,
        folder=folder.resolve().name,
        run=run,
        configuration=run.configuration,
        outcome=run.outcome,
        options=json.dumps(run.configuration.options, indent=2, ensure_ascii=False),
        chosen=chosen,
        verifications=list(verifications(folder, run, problem)),
        solutions=run.outcome.X.tolist(),
        data=data,
        json=Markup(script_json(data)),
        style=_asset("report.css"),
        library=Markup(get_plotlyjs()),
        script=Markup("").join(_asset(f"{name}.js") for name in ("figures", "motion", "report")),
    )


def _asset(name: str) -> Markup:
    return Markup(files("mgeo.report").joinpath("assets", name).read_text(encoding="utf-8"))
