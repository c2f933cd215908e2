"""Tables and figures of the validation pages, made of the stored results in `data`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from IPython.display import Markdown
from plotly.subplots import make_subplots
from scipy.stats import chi2

from mgeo.figures.style import COLORS, GRAY, GRID_COLOR, SYMBOLS

DOCS = Path(__file__).parents[1]
DATA = DOCS / "validation" / "data"
PRESETS = ("paper", "cubesat_6u")
#: Filters of the page on filter consistency, by their key in the stored results.
FILTERS = {
    "plain": "textbook",
    "Jacobians, reset": "+ Jacobians at the estimate, reset",
    "Jacobians, reset, second order": "+ second order (default)",
}
DEFAULT_FILTER = "Jacobians, reset, second order"
#: Ends of the telemetry of Basilisk, with their name in the stored results.
ENDS = {"until t_end": "at t_end", "two orbits": "at the end"}
STATES = (
    *("attitude", "gyro bias", "Sun sensor misalignment", "Sun sensor bias"),
    *("magnetometer misalignment", "magnetometer bias"),
)
#: Probability that a value of a consistent filter is within the bounds.
COVERAGE = 0.99
_LARGEST_NEES = 30.0
#: Style of a gray band in an empty panel.
_BAND = {
    "fillcolor": GRAY,
    "opacity": 0.25,
    "line_width": 0,
    "layer": "below",
    "exclude_empty_subplots": False,
}


def read_results(name: str, folder: Path = DATA) -> list[dict[str, Any]]:
    """Return the stored results of a benchmark, one dict per case."""
    text = (folder / f"{name}.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


def compute_bounds(n: int) -> tuple[float, float]:
    """Return the bounds of the mean of n squared standard normal values with probability
    `COVERAGE`.
    """
    low, high = chi2.ppf([0.5 * (1.0 - COVERAGE), 0.5 * (1.0 + COVERAGE)], n) / n
    return float(low), float(high)


def format_range(low: float, high: float, digits: int = 2) -> str:
    return f"{low:.{digits}f} to {high:.{digits}f}"


def show_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> Markdown:
    """Return a Markdown table whose columns after the first are right-aligned."""
    lines = [header, ["---", *["---:"] * (len(header) - 1)], *rows]
    return Markdown("\n".join(f"| {' | '.join(map(str, line))} |" for line in lines))


def read_consistency() -> dict[str, dict[str, Any]]:
    """Return the Monte Carlo results of the page on filter consistency, by key."""
    return {row["key"]: row for row in read_results("consistency")}


def list_plans(results: dict[str, dict[str, Any]]) -> pd.DataFrame:
    """Return one row per plan of the two stored fronts, with NEES per state and the ratios of rms
    errors to predicted 1-sigmas in the second orbit.
    """
    rows = []
    for key, row in results.items():
        group, preset, number = key.split("/")[:3]
        if group == "plans":
            criteria = row["criteria"]
            rows.append(
                {
                    "preset": preset,
                    "plan": int(number) + 1,
                    "t_end": row["t_end"],
                    "nees": criteria["nees"][0],
                    "smallest": criteria["smallest rms / predicted"][0],
                    "largest": criteria["largest rms / predicted"][0],
                    "at_end": row["ratio_at_t_end"][1],
                    "is_passed": row["passed"],
                }
            )
    return pd.DataFrame(rows)


def list_uncertainties(results: dict[str, dict[str, Any]]) -> pd.DataFrame:
    """Return NEES per state for each preset, changed initial uncertainty, value and filter, with
    its bounds for perfect filters.
    """
    rows = []
    for key, row in results.items():
        group, preset, rest = key.split("/", 2)
        if group == "map":
            quantity, value, name = rest.rsplit("/", 2)
            rows.append((preset, quantity, float(value), name, *row["criteria"]["nees"]))
    columns = ["preset", "quantity", "value", "filter", "nees", "low", "high"]
    return pd.DataFrame(rows, columns=columns)


def find_consistent_ranges(rows: pd.DataFrame) -> dict[str, float]:
    """Return, for each quantity, the largest initial 1-sigma up to which the default filter is
    consistent with all presets.
    """
    ranges = {}
    for quantity, each in rows[rows["filter"] == DEFAULT_FILTER].groupby("quantity"):
        excess = each.groupby("value")[["nees", "high"]].max()
        is_consistent = (excess["nees"] <= excess["high"]).cummin()
        ranges[str(quantity)] = float(excess.index[is_consistent].max())
    return ranges


def draw_uncertainties(rows: pd.DataFrame) -> go.Figure:
    """Draw NEES per state over each initial uncertainty, for two presets and two filters."""
    low, high = rows.loc[0, ["low", "high"]]
    quantities = list(rows["quantity"].unique())
    figure = make_subplots(rows=len(quantities), vertical_spacing=0.13)
    for panel, quantity in enumerate(quantities, 1):
        figure.add_hrect(y0=low, y1=high, **_BAND, row=panel, col=1)
        for index, preset in enumerate(PRESETS):
            for name, dash in ((DEFAULT_FILTER, "solid"), ("plain", "dash")):
                is_shown = (rows[["preset", "quantity", "filter"]] == [preset, quantity, name]).all(
                    axis=1
                )
                label = f"{preset}, {'default' if dash == 'solid' else 'textbook'} filter"
                figure.add_scatter(
                    x=rows.loc[is_shown, "value"].tolist(),
                    y=rows.loc[is_shown, "nees"].tolist(),
                    mode="lines+markers",
                    line={"color": COLORS[index], "dash": dash},
                    marker={"symbol": SYMBOLS[index], "size": 8},
                    name=label,
                    legendgroup=label,
                    showlegend=panel == 1,
                    row=panel,
                    col=1,
                )
        values = rows.loc[rows["quantity"] == quantity, "value"].unique().tolist()
        title = f"initial 1-sigma of {quantity.replace('[', 'per axis [')}"
        figure.update_xaxes(title=title, type="log", tickvals=values, row=panel, col=1)
    figure.update_yaxes(
        title="NEES per state",
        type="log",
        range=np.log10([0.8, _LARGEST_NEES]).tolist(),
        tickvals=[1, 2, 5, 10, 20],
    )
    return format_for_page(figure, 860)


def read_basilisk() -> pd.DataFrame:
    """Return the stored flights of Basilisk, one row per flight and end of the telemetry."""
    table = pd.DataFrame([row for row in read_results("basilisk") if "errors" in row])
    table[["preset", "plan", "seed", "end"]] = pd.DataFrame(table["key"].tolist())
    return table


def compute_errors(table: pd.DataFrame, relative_to: str = "sigma") -> np.ndarray:
    """Return the errors of all flights relative to their estimated (``sigma``) or ``predicted``
    1-sigmas, shape (n, n_states).
    """
    return np.array(table["errors"].tolist()) / np.array(table[relative_to].tolist())


def compute_block_ratios(table: pd.DataFrame, relative_to: str) -> np.ndarray:
    """Return the root mean square of the relative errors of each block of three states."""
    errors = compute_errors(table, relative_to).reshape(len(table), -1, 3)
    return np.sqrt((errors**2).mean(axis=(0, 2)))


def draw_errors(table: pd.DataFrame) -> go.Figure:
    """Draw the errors of all flights over their estimated 1-sigma, by block of states and axis."""
    figure = make_subplots(rows=len(PRESETS), subplot_titles=PRESETS, vertical_spacing=0.1)
    blocks = np.arange(len(STATES))
    for panel, preset in enumerate(PRESETS, 1):
        errors = compute_errors(table[table["preset"] == preset])
        figure.add_vrect(x0=-3, x1=3, **_BAND, row=panel, col=1)
        for axis, name in enumerate("xyz"):
            offsets = np.linspace(-0.1, 0.1, len(errors)) + 0.27 * (axis - 1)
            figure.add_scatter(
                x=errors[:, axis::3].T.ravel().round(2).tolist(),
                y=np.add.outer(blocks, offsets).ravel().round(3).tolist(),
                mode="markers",
                marker={"size": 3, "color": COLORS[axis], "symbol": SYMBOLS[axis]},
                name=name,
                legendgroup=name,
                showlegend=panel == 1,
                row=panel,
                col=1,
            )
    labels = [state.replace(" ", "<br>") for state in STATES]
    figure.update_yaxes(tickvals=blocks.tolist(), ticktext=labels, autorange="reversed")
    figure.update_xaxes(title="error / estimated 1-sigma", range=[-5, 5], dtick=1)
    return format_for_page(figure, 1000).update_layout(margin_t=60)


def format_for_page(figure: go.Figure, height: int) -> go.Figure:
    """Apply the common layout of the validation pages, and return the figure."""
    figure.update_xaxes(gridcolor=GRID_COLOR, zeroline=False)
    figure.update_yaxes(gridcolor=GRID_COLOR, zeroline=False, automargin=True)
    return figure.update_layout(
        template="plotly_white",
        height=height,
        margin={"l": 60, "r": 20, "t": 30, "b": 60},
        legend={"orientation": "h", "y": -0.12, "yanchor": "top", "x": 0.0},
    )
