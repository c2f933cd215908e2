"""Interactive figures of the site, drawn when it is built, mostly from the data in this folder."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from mgeo_attitude import Scenario, calibrate, fly
from mgeo_attitude.environment.interpolation import interpolate, nearest
from mgeo_suite import SensorSuiteProblem

_FRONTS = Path(__file__).parents[1] / "fronts"

#: Files that figures are drawn from; a page is built again when one of them changes.
SOURCES = (Path(__file__), *sorted(_FRONTS.glob("*.csv")))

_LIMITS = {"free": ("cubesat_6u", "#1f5fa8"), "limits": ("with limits.toml", "#c8501e")}
_STARTS = {
    "free": ("from GCRS", "#1f5fa8"),
    "nadir": ("from nadir", "#c8501e"),
    "sun": ("from the Sun", "#3d8b4f"),
}
#: Name, samples that it goes through, with velocities or not, and color.
_POLYNOMIALS = (
    ("linear", 2, False, "#8a8a8a"),
    ("Lagrange, degree 3", 4, False, "#e39b6f"),
    ("Lagrange, degree 7", 8, False, "#c8501e"),
    ("Hermite, degree 3", 2, True, "#7fa8d4"),
    ("Hermite, degree 7", 4, True, "#1f5fa8"),
)


def limits() -> go.Figure:
    """Fronts of `cubesat_6u` with and without its limits."""
    return _fronts(_LIMITS)


def starts() -> go.Figure:
    """Fronts of `cubesat_6u` from several attitudes."""
    return _fronts(_STARTS)


def _fronts(runs: Mapping[str, tuple[str, str]]) -> go.Figure:
    """Stored fronts by file, with name and color of each."""
    figure = go.Figure()
    for run, (name, color) in runs.items():
        table = pd.read_csv(_FRONTS / f"{run}.csv").sort_values("t_end [s]")
        time, trace = table["t_end [s]"], table["trace [-]"]
        figure.add_scatter(
            x=time.tolist(),
            y=trace.tolist(),
            mode="lines+markers",
            line={"shape": "hv", "color": color, "width": 1},
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


def interpolation() -> go.Figure:
    """Greatest error of interpolated positions over two hours of the paper's orbit."""
    orbit, epoch = Scenario.paper().orbit, Scenario.paper().epoch
    at = np.arange(0.0, 7200.0, 3.7)
    truth, _ = orbit.propagate(epoch, at)
    spacings = np.geomspace(10.0, 600.0, 30)
    figure = go.Figure()
    for name, count, slopes, color in _POLYNOMIALS:
        errors = []
        for spacing in spacings:
            times = spacing * np.arange(-count, 7200.0 / spacing + count + 1.0)
            position, velocity = orbit.propagate(epoch, times)
            rows = nearest(times, at, count)
            found, _ = interpolate(times, position, velocity if slopes else None, rows, at)
            errors.append(float(np.linalg.norm(found - truth, axis=1).max()))
        figure.add_scatter(x=spacings.tolist(), y=errors, name=name, line={"color": color})
    figure.update_xaxes(title="time between samples [s]", type="log")
    figure.update_yaxes(title="error [m]", type="log", dtick=2, exponentformat="power")
    figure.update_layout(
        template="plotly_white", height=420, margin={"l": 60, "r": 20, "t": 20, "b": 50}
    )
    return figure


def calibration() -> go.Figure:
    """What the example of the page on calibration finds."""
    scenario = Scenario.from_dict(
        {"preset": "cubesat_6u", "duration": 3000.0, "initial": {"attitude_deg": 90.0}}
    )
    plan = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    found: go.Figure = calibrate(scenario, fly(scenario, plan, seed=1)).figures()["constants"]
    return found


def suite() -> go.Figure:
    """The stored front of the page on sensor suites."""
    problem = SensorSuiteProblem()
    table = pd.read_csv(_FRONTS / "suite.csv")
    found: go.Figure = problem.figures(table.to_numpy()[:, : problem.n_var])["front"]
    return found


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "limits": limits,
    "starts": starts,
    "interpolation": interpolation,
    "calibration": calibration,
    "suite": suite,
}


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
