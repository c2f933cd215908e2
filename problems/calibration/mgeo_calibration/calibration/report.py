"""HTML report of a calibration."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup

from mgeo.figures.page import render_report_page, render_section
from mgeo.plugins.review import Section
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.sections import (
    build_detail_sections,
    build_summary_sections,
    describe_requirements,
)


def build_report(calibration: Calibration, predicted: pd.DataFrame | None = None) -> str:
    """Return an HTML page with the verdict, the parameters, their figure and the tests of a
    calibration, followed by details. The page loads no external resources.

    Parameters
    ----------
    predicted : DataFrame, optional
        Comparison with the prediction of a plan; see `Calibration.compare`.
    """
    title = f"Calibration, {calibration.scenario.name}"
    first, *summary = build_summary_sections(calibration, predicted)
    figures = calibration.draw_figures()
    parts: list[str | go.Figure] = [
        Markup("<h1>{}</h1><p><strong>{} {}</strong></p>").format(
            title, calibration.conclusion, describe_requirements(calibration)
        ),
        Markup(
            "<p>Estimates at {} UTC. Attitude accuracy: {:.2g} deg (1-sigma, worst body axis).</p>"
        ).format(calibration.utc[:19], calibration.attitude_sigma_deg),
        render_section(first),
        figures.pop("parameters"),
        *map(render_section, summary),
        '<h1 style="break-before: page">Details</h1>',
        *figures.values(),
        *map(render_section, build_detail_sections(calibration, predicted)),
        render_section(_build_correction_section(calibration)),
    ]
    return render_report_page(title, parts)


def _build_correction_section(calibration: Calibration) -> Section:
    rows = []
    for owner, entry in calibration.compute_corrections().items():
        for name, value in entry.items():
            lines = {name: value}
            if isinstance(value, list) and isinstance(value[0], list):
                lines = {f"{name}, row {i}": row for i, row in enumerate(value, 1)}
            rows += [(owner, at, _format_value(v)) for at, v in lines.items()]
    table = pd.DataFrame(rows, columns=["sensor", "parameter", "value"])
    return Section("Correction parameters with full precision", table=table)


def _format_value(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_format_value, value)) + "]"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
