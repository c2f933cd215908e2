"""Interactive figures of the site, drawn when the site is built."""

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

import concept_figures
import numpy as np
import pandas as pd
import plotly.graph_objects as go
import portuguese_figures
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.environment.interpolation import interpolate
from mgeo_attitude.filter.history import can_measure
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.filter.wheel_load import compute_wheel_loads
from mgeo_attitude.maneuvers.motion import Motion
from plotly.subplots import make_subplots

from mgeo.figures.style import SYMBOLS

_FRONTS = Path(__file__).parents[1] / "fronts"
_TRACKER = Path(__file__).parents[1] / "scenarios" / "tracker.toml"
#: t_end of the knee of the front of the tracker's scenario [s].
_KNEE = 1323.0
_ERRORS = _FRONTS.parent / "errors.csv"

#: Files on which figures depend. If one of them changes, pages with figures are built again.
SOURCES = (
    Path(__file__),
    Path(concept_figures.__file__),
    Path(portuguese_figures.__file__),
    _TRACKER,
    *sorted(_FRONTS.glob("*.csv")),
    _ERRORS,
)

_LIMITS = {
    "free": ("without constraints", "#1f5fa8"),
    "limits": ("with the constraints of limits.toml", "#c8501e"),
}
_STARTS = {
    "free": ("body axes along GCRS", "#1f5fa8"),
    "nadir": ("nadir pointing", "#c8501e"),
    "sun": ("Sun pointing", "#3d8b4f"),
}
#: Name, number of samples, use of velocities, and color.
_POLYNOMIALS = (
    ("linear", 2, False, "#8a8a8a"),
    ("Lagrange, degree 3", 4, False, "#e39b6f"),
    ("Lagrange, degree 7", 8, False, "#c8501e"),
    ("Hermite, degree 3", 2, True, "#7fa8d4"),
    ("Hermite, degree 7", 4, True, "#1f5fa8"),
)
#: Color and name of each direction with an exclusion angle of the star tracker.
_DIRECTIONS = {
    "sun": ("#e0a000", "Sun"),
    "earth": ("#1f5fa8", "Earth's limb"),
    "moon": ("#8a8a8a", "Moon"),
}
_FLOOR_COLUMNS = {
    "attitude [deg]": "attitude [deg]",
    "sun bias [arcmin]": "Sun sensor bias [arcmin]",
    "mag bias [nT]": "magnetometer bias [nT]",
}
_FLOOR_COLORS = ("#1f5fa8", "#c8501e", "#4a8f3c")
_ORBIT = 5992.0


def limits() -> go.Figure:
    """Fronts of `cubesat_6u` with and without constraints."""
    return _draw_fronts(_LIMITS)


def starts() -> go.Figure:
    """Fronts of `cubesat_6u` from several initial attitudes."""
    return _draw_fronts(_STARTS)


def _draw_fronts(runs: Mapping[str, tuple[str, str]]) -> go.Figure:
    """Draw stored fronts, given the name and color of each file."""
    figure = go.Figure()
    for symbol, (run, (name, color)) in zip(SYMBOLS, runs.items(), strict=False):
        table = pd.read_csv(_FRONTS / f"{run}.csv").sort_values("t_end [s]")
        table = table[table["t_end [s]"] >= 100.0]
        time, trace = table["t_end [s]"], table["trace [-]"]
        figure.add_scatter(
            x=time.tolist(),
            y=trace.tolist(),
            mode="lines+markers",
            line={"shape": "hv", "color": color, "width": 1},
            marker={"size": 5, "symbol": symbol},
            name=name,
            text=_hover_texts(table),
            hovertemplate="%{x:.0f} s, trace %{y:.3g}<br>%{text}<extra></extra>",
        )
    times = [100, 200, 500, 1000, 2000, 5000]
    figure.update_xaxes(title="end of the plan, t_end [s]", type="log", tickvals=times)
    title = "trace of the covariance [-]"
    figure.update_yaxes(title=title, type="log", dtick=1, exponentformat="power")
    figure.update_layout(
        template="plotly_white",
        height=420,
        margin={"l": 60, "r": 20, "t": 30, "b": 50},
        legend={"orientation": "h", "y": -0.2, "yanchor": "top", "x": 0.0},
    )
    return figure


def interpolation() -> go.Figure:
    """Largest error of interpolated positions over two hours of the paper's orbit."""
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
            found, _ = interpolate(times, position, velocity if slopes else None, count, at)
            errors.append(float(np.linalg.norm(found - truth, axis=1).max()))
        figure.add_scatter(x=spacings.tolist(), y=errors, name=name, line={"color": color})
    figure.update_xaxes(title="time between samples [s]", type="log")
    figure.update_yaxes(title="error [m]", type="log", dtick=2, exponentformat="power")
    figure.update_layout(
        template="plotly_white", height=420, margin={"l": 60, "r": 20, "t": 20, "b": 50}
    )
    return figure


def tracker() -> go.Figure:
    """Angles to the boresight of the star tracker, body rate, and measurement periods of a plan."""
    problem, design = _load_knee()
    model, n = problem.model, round(_KNEE)
    motion = Motion.from_design(model, design, model.n_steps)
    times, C = model.times[: n + 1], motion.attitude[: n + 1]
    sees = can_measure(model, 2, motion.attitude, motion.rates)[: n + 1]
    figure = make_subplots(2, 1, shared_xaxes=True, vertical_spacing=0.06)
    for view in model.suite.sensors[2].list_visibility_cones():
        vectors, radius = model.select_direction(view.direction, slice(n + 1))
        cosines = np.einsum("kij,kj->ki", C, vectors) @ view.axis
        angle = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)) - radius)
        angle[~vectors.any(axis=1)] = np.nan
        color, name = _DIRECTIONS[view.direction]
        least = float(np.degrees(view.half_angle))
        line = {"color": color, "width": 1, "dash": "dash"}
        figure.add_scatter(
            x=times.tolist(), y=angle.tolist(), name=name, line={"color": color}, row=1, col=1
        )
        figure.add_hline(least, line=line, row=1, col=1)
    rate = np.degrees(np.linalg.norm(motion.rates[:n], axis=1))
    figure.add_scatter(
        x=times[1:].tolist(),
        y=rate.tolist(),
        name="body rate",
        line={"color": "#333"},
        row=2,
        col=1,
    )
    figure.add_hline(0.5, line={"color": "#333", "width": 1, "dash": "dash"}, row=2, col=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], sees, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        span = {"fillcolor": "#2a9d5c", "opacity": 0.15, "line_width": 0, "layer": "below"}
        figure.add_vrect(float(times[begin]), float(times[end - 1]), **span)
    figure.update_xaxes(title="time [s]; green: the star tracker measures", row=2, col=1)
    figure.update_yaxes(title="angle to the boresight [deg]", row=1, col=1)
    figure.update_yaxes(title="rate [deg/s]", row=2, col=1)
    figure.update_layout(
        template="plotly_white", height=520, margin={"l": 60, "r": 20, "t": 20, "b": 50}
    )
    return figure


def wheels() -> go.Figure:
    """Largest wheel momentum until each time of a plan, by allocation and disturbances."""
    problem, design = _load_knee()
    steps = np.arange(1, round(_KNEE) + 1, 4)
    plan = problem.model.build_schedule(np.tile(design, (len(steps), 1)))
    figure = go.Figure()
    for allocation, color in (("pseudo-inverse", "#1f5fa8"), ("minimax", "#c8501e")):
        for is_undisturbed, dash in ((False, "solid"), (True, "dot")):
            wheels = dataclasses.replace(problem.scenario.wheels, allocation=allocation)
            scenario = dataclasses.replace(problem.scenario, wheels=wheels)
            budget = MomentumBudget.from_scenario(
                scenario, problem.environment, np.eye(3), np.zeros(3)
            )
            budget = (
                dataclasses.replace(budget, disturbance_margin=0.0) if is_undisturbed else budget
            )
            loads = compute_wheel_loads(budget, plan, steps, problem.model.step, 1)[:, 0]
            figure.add_scatter(
                x=steps.tolist(),
                y=(1e3 * loads).tolist(),
                name=allocation + (", without disturbances" if is_undisturbed else ""),
                line={"color": color, "dash": dash},
            )
    figure.add_hline(2.0, line={"color": "#333", "width": 1, "dash": "dash"})
    figure.update_xaxes(title="time [s]")
    figure.update_yaxes(title="largest wheel momentum so far [mN m s]", rangemode="tozero")
    figure.update_layout(
        template="plotly_white", height=380, margin={"l": 60, "r": 20, "t": 20, "b": 50}
    )
    return figure


def floor() -> go.Figure:
    """1-sigma over ten orbits, with and without environment model errors."""
    history = pd.read_csv(_ERRORS)
    figure = go.Figure()
    for (column, label), color in zip(_FLOOR_COLUMNS.items(), _FLOOR_COLORS, strict=True):
        for errors, dash in (("without", "dash"), ("with", "solid")):
            chosen = history[history["errors"] == errors]
            figure.add_scatter(
                x=(chosen["time [s]"] / _ORBIT).tolist(),
                y=chosen[column].tolist(),
                mode="lines",
                line={"color": color, "dash": dash},
                name=f"{label}, {errors} model errors",
            )
    figure.update_xaxes(title="orbits", type="log")
    figure.update_yaxes(title="1-sigma of the worst axis", type="log", exponentformat="power")
    figure.update_layout(
        template="plotly_white",
        height=520,
        margin={"l": 60, "r": 20, "t": 20, "b": 50},
        legend={"orientation": "h", "y": -0.15, "yanchor": "top", "x": 0.0},
    )
    return figure


def suite() -> go.Figure:
    """The stored front of the page on sensor suites."""
    from mgeo_suite import SensorSuiteProblem

    problem = SensorSuiteProblem()
    table = pd.read_csv(_FRONTS / "suite.csv")
    found: go.Figure = problem.view(table.to_numpy()[:, : problem.n_var]).figures()["front"]
    return found


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "limits": limits,
    "starts": starts,
    "interpolation": interpolation,
    "tracker": tracker,
    "wheels": wheels,
    "floor": floor,
    "suite": suite,
    **concept_figures.FIGURES,
    **portuguese_figures.FIGURES,
}


def _load_knee() -> tuple[AttitudeManeuverProblem, np.ndarray]:
    """Return the problem of the tracker's scenario and the design of the knee of its front."""
    table = pd.read_csv(_FRONTS / "tracker.csv")
    problem = AttitudeManeuverProblem(Scenario.from_toml(_TRACKER))
    (row,) = np.flatnonzero(table["t_end [s]"] == _KNEE)
    return problem, table.loc[row, problem.var_names].to_numpy(float)


def _hover_texts(table: pd.DataFrame) -> list[str]:
    """Return a text for each plan, with one line per maneuver: rates and duration."""
    count = sum(column.startswith("duration_") for column in table.columns)
    texts = []
    for _, row in table.iterrows():
        lines = []
        for m in range(1, count + 1):
            rates = ", ".join(f"{row[f'omega_{axis}_{m} [deg/s]']:+.2f}" for axis in "xyz")
            lines.append(f"({rates}) deg/s for {row[f'duration_{m} [s]']:.0f} s")
        texts.append("<br>".join(lines))
    return texts
