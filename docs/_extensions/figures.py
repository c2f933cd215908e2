"""Interactive figures of the site, drawn from the data in this folder when it is built."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import plotly.graph_objects as go

_FRONTS = Path(__file__).parents[1] / "fronts"

#: Files that figures are drawn from; a page is built again when one of them changes.
SOURCES = (Path(__file__), *sorted(_FRONTS.glob("*.csv")))

_NAMES = {"free": "cubesat_6u", "limits": "with limits.toml"}
_COLORS = {"free": "#1f5fa8", "limits": "#c8501e"}


def limits() -> go.Figure:
    """Fronts of `cubesat_6u` with and without its limits."""
    figure = go.Figure()
    for run, name in _NAMES.items():
        table = pd.read_csv(_FRONTS / f"{run}.csv").sort_values("t_end [s]")
        time, trace = table["t_end [s]"], table["trace [-]"]
        figure.add_scatter(
            x=time.tolist(),
            y=trace.tolist(),
            mode="lines+markers",
            line={"shape": "hv", "color": _COLORS[run], "width": 1},
            marker={"size": 6},
            name=name,
            text=_hover_texts(table),
            hovertemplate="%{x:.0f} s, trace %{y:.3g}<br>%{text}<extra></extra>",
        )
    figure.update_xaxes(title="time to converge t_end [s]")
    figure.update_yaxes(title="trace [-]", type="log", dtick=1, exponentformat="power")
    figure.update_layout(
        template="plotly_white",
        height=460,
        margin={"l": 60, "r": 20, "t": 20, "b": 50},
        legend={"x": 1.0, "xanchor": "right", "y": 1.0},
    )
    return figure


FIGURES: dict[str, Callable[[], go.Figure]] = {"limits": limits}


def _hover_texts(table: pd.DataFrame) -> list[str]:
    """Rates and duration of every maneuver of each solution, a line each."""
    count = sum(column.startswith("duration_") for column in table.columns)
    texts = []
    for _, row in table.iterrows():
        lines = []
        for m in range(1, count + 1):
            rates = ", ".join(f"{row[f'omega_{axis}_{m} [deg/s]']:+.2f}" for axis in "xyz")
            lines.append(f"({rates}) deg/s for {row[f'duration_{m} [s]']:.0f} s")
        texts.append("<br>".join(lines))
    return texts
