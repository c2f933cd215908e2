"""HTML report of a calibration."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup

from mgeo.figures.page import render_report_page
from mgeo.plugins.review import Section, find_column_kinds, format_cells
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.sections import build_detail_sections, build_summary_sections

#: Results in tables that are marked as violations.
_BAD_RESULTS = ("FAILED", "FOUND")


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
        Markup("<h1>{}</h1><p><strong>{}</strong></p>").format(title, calibration.conclusion),
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


def render_section(section: Section) -> Markup:
    """Return a section as HTML: its title, table, note and lines."""
    parts = [Markup("<h2>{}</h2>").format(section.title)]
    if section.table is not None:
        rows = format_cells(section.table)
        parts.append(
            Markup('<div class="wide" role="region" tabindex="0" aria-label="{}">').format(
                section.title
            )
            + _render_table(rows)
            + Markup("</div>")
        )
    if section.note:
        parts.append(Markup('<p class="note">{}</p>').format(section.note))
    lines = [line.removeprefix("- ") for line in section.lines]
    if lines != list(section.lines):
        items = Markup("").join(Markup("<li>{}</li>").format(line) for line in lines)
        parts.append(Markup("<ul>{}</ul>").format(items))
    else:
        parts += [Markup("<p>{}</p>").format(line) for line in lines]
    return Markup("").join(parts)


def _render_table(rows: list[list[str]]) -> Markup:
    """Return a table whose first row has the column titles and whose first column has the row
    names.
    """
    kinds = find_column_kinds(rows)
    styles = ["right" if kind == "number" else "left" for kind in kinds]
    head = Markup("").join(
        Markup('<th scope="col" style="text-align: {}">{}</th>').format(style, name)
        for style, name in zip(styles, rows[0], strict=True)
    )
    body = Markup("").join(
        Markup('<tr><th scope="row">{}</th>{}</tr>').format(
            row[0],
            Markup("").join(
                Markup('<td style="text-align: {}"{}>{}</td>').format(
                    style, Markup(' class="exceeded"') if cell in _BAD_RESULTS else "", cell
                )
                for style, cell in zip(styles[1:], row[1:], strict=True)
            ),
        )
        for row in rows[1:]
    )
    return Markup("<table><thead><tr>{}</tr></thead><tbody>{}</tbody></table>").format(head, body)


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
