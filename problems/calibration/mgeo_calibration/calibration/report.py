"""HTML report of a calibration."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go
from markupsafe import escape

from mgeo.figures.page import render_report_page
from mgeo_calibration.calibration.calibration import Calibration

#: Largest number of outliers in the report. The JSON file contains all outliers.
MAX_OUTLIERS = 100


def build_report(calibration: Calibration, predicted: pd.DataFrame | None = None) -> str:
    """Return an HTML page with the estimates, tests and figures of a calibration. The page loads no
    external resources.

    Parameters
    ----------
    predicted : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    """
    title = f"calibration, {calibration.scenario.name}"
    parts: list[str | go.Figure] = [
        f"<h1>{escape(title)}</h1>",
        f"<p>At {calibration.time:.6f} s after the epoch, {escape(calibration.utc)} UTC: "
        f"{escape(calibration.conclusion)}.</p>",
        *(f"<p>{escape(note)}.</p>" for note in calibration.notes),
        _format_table(calibration.build_table().set_index("block")),
    ]
    if predicted is not None:
        title = f"1-sigmas predicted by the plan for {predicted.attrs['time_s']:.6g} s"
        title += predicted.attrs["motion"]
        parts += [f"<h2>{title}</h2>", _format_table(predicted.reset_index())]
    figures = calibration.draw_figures()
    parts += [figures.pop("parameters"), "<h2>Innovations</h2>"]
    parts.append(_format_table(calibration.build_sensor_test_table().T.reset_index()))
    parts += [
        "<h2>Estimate and prior</h2>",
        _format_table(calibration.build_prior_test_table().reset_index()),
    ]
    if calibration.model_tests:
        parts += [
            "<h2>Errors outside the scenario's model</h2>",
            _format_table(calibration.build_model_test_table().reset_index(), classes="wrapped"),
        ]
    parts += list(figures.values())
    outliers = calibration.build_outlier_table()
    if len(outliers):
        more = f", the first {MAX_OUTLIERS}" if len(outliers) > MAX_OUTLIERS else ""
        parts += [
            f"<h2>{len(outliers)} outliers{more}</h2>",
            _format_table(outliers[:MAX_OUTLIERS]),
        ]
    parts += ["<h2>Correction parameters</h2>", _format_corrections(calibration)]
    return render_report_page(title, parts)


def _format_corrections(calibration: Calibration) -> str:
    rows = []
    for owner, entry in calibration.compute_corrections().items():
        for name, value in entry.items():
            lines = {name: value}
            if isinstance(value, list) and isinstance(value[0], list):
                lines = {f"{name}, row {i}": row for i, row in enumerate(value, 1)}
            rows += [
                {"name": owner, "parameter": at, "value": _format_value(v)}
                for at, v in lines.items()
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
