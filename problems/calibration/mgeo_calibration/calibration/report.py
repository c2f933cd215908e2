"""Self-contained HTML report of a calibration."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go
from markupsafe import escape

from mgeo.figures.page import render_report_page
from mgeo_calibration.calibration.calibration import Calibration

#: Largest number of listed outliers; the JSON file contains all.
LISTED = 100


def report_html(calibration: Calibration, promised: pd.DataFrame | None = None) -> str:
    """Return the HTML report of a calibration, which loads no external resources.

    Parameters
    ----------
    promised : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    """
    title = f"calibration, {calibration.scenario.name}"
    parts: list[str | go.Figure] = [
        f"<h1>{escape(title)}</h1>",
        f"<p>At {calibration.time:.6f} s after the epoch, {escape(calibration.utc)} UTC: "
        f"{escape(calibration.conclusion)}.</p>",
        *(f"<p>{escape(note)}.</p>" for note in calibration.notes),
        _format_table(calibration.table().set_index("block")),
    ]
    if promised is not None:
        title = f"What the plan predicted for {promised.attrs['time_s']:.6g} s"
        title += promised.attrs["flown"]
        parts += [f"<h2>{title}</h2>", _format_table(promised.reset_index())]
    figures = calibration.figures()
    parts += [figures.pop("constants"), "<h2>Innovations</h2>"]
    parts.append(_format_table(calibration.test_table().T.reset_index()))
    parts += ["<h2>Estimate and prior</h2>", _format_table(calibration.prior_table().reset_index())]
    if calibration.model_tests:
        parts += [
            "<h2>Errors outside the scenario's model</h2>",
            _format_table(calibration.model_table().reset_index(), classes="wrapped"),
        ]
    parts += list(figures.values())
    rejected = calibration.rejected_table()
    if len(rejected):
        more = f", the first {LISTED}" if len(rejected) > LISTED else ""
        parts += [f"<h2>{len(rejected)} outliers{more}</h2>", _format_table(rejected[:LISTED])]
    parts += ["<h2>Correction parameters</h2>", _format_uplink(calibration)]
    return render_report_page(title, parts)


def _format_uplink(calibration: Calibration) -> str:
    rows = []
    for owner, entry in calibration.uplink().items():
        for name, value in entry.items():
            lines = {name: value}
            if isinstance(value, list) and isinstance(value[0], list):
                lines = {f"{name}, row {i}": row for i, row in enumerate(value, 1)}
            rows += [
                {"of": owner, "number": at, "value": _format_value(v)} for at, v in lines.items()
            ]
    return _format_table(pd.DataFrame(rows), classes="wrapped")


def _format_value(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_format_value, value)) + "]"
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _format_table(frame: pd.DataFrame, classes: str | None = None) -> str:
    shown = frame.reset_index() if frame.index.name else frame
    text: str = shown.map(lambda x: f"{x:.5g}" if isinstance(x, float) else x).to_html(
        index=False, border=0, classes=classes
    )
    return text
