"""Figures of the page ``docs/concepts.md``."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from mgeo_attitude import (
    AttitudeManeuverProblem,
    FilterHistory,
    FilterModel,
    Scenario,
    compute_lower_bound,
    run_filter,
)

from mgeo.runs.summary import find_knee

_FRONTS = Path(__file__).parents[1] / "fronts"
_BLUE, _ORANGE, _GREEN, _GRAY = "#1f5fa8", "#c8501e", "#4a8f3c", "#8a8a8a"
#: Rates about x, y and z [deg/s] and duration [s] of three rotations.
_ROTATIONS = (0.5, 0.0, 0.0, 400.0, 0.0, 0.5, 0.0, 400.0, 0.0, 0.0, 0.5, 400.0)
_AT_REST = (0.0, 0.0, 0.0, 1200.0)


def observability() -> go.Figure:
    """1-sigma of attitude and magnetometer misalignment, at rest and during three rotations."""
    figure = go.Figure()
    colors = {"attitude": _BLUE, "mag.misalignment": _ORANGE}
    for name, design, dash in (
        ("at rest", _AT_REST, "dot"),
        ("rotating about x, y, z", _ROTATIONS, None),
    ):
        history = _run(design, "end")
        for block, color in colors.items():
            figure.add_scatter(
                x=history.times.tolist(),
                y=_worst_axis(history, block).tolist(),
                name=f"{block.replace('mag.', 'magnetometer ')}, {name}",
                line={"color": color, "dash": dash},
            )
    for time in (400.0, 800.0):
        figure.add_vline(time, line={"color": _GRAY, "width": 1, "dash": "dash"})
    figure.update_yaxes(
        title="1-sigma of the worst axis [deg]", type="log", dtick=1, exponentformat="power"
    )
    return _finish(figure, "time [s]")


def convergence() -> go.Figure:
    """Trace of the covariance during and after a plan, and its end by the rules end and trace."""
    history = _run(_ROTATIONS, "trace")
    figure = go.Figure()
    figure.add_scatter(
        x=history.times.tolist(),
        y=history.trace.tolist(),
        showlegend=False,
        line={"color": _BLUE},
    )
    for rule, time, color in (("end", 1200.0, _ORANGE), ("trace", history.t_end, _GREEN)):
        figure.add_scatter(
            x=[time],
            y=[float(history.trace[round(time)])],
            name=f"t_end by the rule {rule}",
            mode="markers",
            marker={"color": color, "size": 11, "symbol": "diamond" if rule == "end" else "circle"},
        )
    figure.update_yaxes(
        title="trace of the covariance [-]", type="log", dtick=1, exponentformat="power"
    )
    return _finish(figure, "time [s]")


def front() -> go.Figure:
    """A stored front of cubesat_6u, its three plans with names, and the lower bound."""
    table = pd.read_csv(_FRONTS / "free.csv").sort_values("t_end [s]")
    table = table[table["t_end [s]"] >= 100.0]
    time, trace = table["t_end [s]"].to_numpy(), table["trace [-]"].to_numpy()
    bound = compute_lower_bound(Scenario.cubesat_6u())
    figure = go.Figure()
    figure.add_scatter(
        x=time.tolist(), y=trace.tolist(), name="plans", mode="markers", marker={"color": _BLUE}
    )
    shown = (bound.times >= time[0]) & (bound.times <= time[-1])
    figure.add_scatter(
        x=bound.times[shown][::20].tolist(),
        y=np.minimum.accumulate(bound.trace_at_end)[shown][::20].tolist(),
        name="lower bound",
        line={"color": _GRAY},
    )
    problem = AttitudeManeuverProblem(Scenario.cubesat_6u())
    knee = find_knee(problem.map_to_indicator_space(np.column_stack([time, trace])))
    for name, row in (("min-time", 0), ("knee", knee), ("min-trace", len(time) - 1)):
        figure.add_scatter(
            x=[time[row]],
            y=[trace[row]],
            text=[name],
            mode="markers+text",
            textposition="top right" if row != len(time) - 1 else "top left",
            marker={"color": _ORANGE, "size": 11},
            showlegend=False,
        )
    figure.update_xaxes(type="log", tickvals=[100, 200, 500, 1000, 2000, 5000])
    figure.update_yaxes(
        title="trace of the covariance [-]", type="log", dtick=1, exponentformat="power"
    )
    return _finish(figure, "time until the end of the plan, t_end [s]")


def selection_pressure() -> go.Figure:
    """Probability with which a walker accepts the candidate of each rank."""
    figure, ranks = go.Figure(), np.arange(1, 9)
    for tau, color in ((0.0, _GRAY), (1.0, _ORANGE), (3.0, _BLUE)):
        weights = ranks**-tau
        figure.add_bar(
            x=ranks.tolist(),
            y=(weights / weights.sum()).tolist(),
            name=f"τ = {tau:g}",
            marker={"color": color},
        )
    figure.update_yaxes(title="probability")
    return _finish(figure, "rank of the candidate")


def hypervolume() -> go.Figure:
    """Area between a front and the reference point."""
    time, trace = np.array([0.1, 0.25, 0.55, 0.8]), np.array([0.8, 0.45, 0.2, 0.12])
    figure = go.Figure()
    figure.add_scatter(
        x=[*time.tolist(), 1.0, 1.0, time[0]],
        y=[*trace.tolist(), trace[-1], 1.0, 1.0],
        line={"shape": "hv", "width": 0},
        fill="toself",
        fillcolor="rgba(31, 95, 168, 0.2)",
        mode="lines",
        name="hypervolume",
    )
    figure.add_scatter(
        x=time.tolist(), y=trace.tolist(), mode="markers", marker={"color": _BLUE}, name="front"
    )
    figure.add_scatter(
        x=[1.0],
        y=[1.0],
        mode="markers",
        marker={"color": _ORANGE, "symbol": "x", "size": 10},
        name="reference point",
    )
    figure.update_xaxes(range=[0.0, 1.1])
    figure.update_yaxes(title="second objective, scaled", range=[0.0, 1.1])
    return _finish(figure, "first objective, scaled")


def _run(design: tuple[float, ...], rule: str) -> FilterHistory:
    """Run the filter of cubesat_6u along a plan."""
    changes: dict[str, Any] = {"maneuvers": {"count": len(design) // 4}}
    scenario = Scenario.from_dict(
        {"preset": "cubesat_6u", "convergence": {"rule": rule}, **changes}
    )
    return run_filter(FilterModel.from_scenario(scenario), design)


def _worst_axis(history: FilterHistory, block: str) -> np.ndarray:
    """Return the largest 1-sigma of the three axes of a block [deg]."""
    first = 3 * history.blocks.index(block)
    return np.degrees(history.sigma[:, first : first + 3].max(axis=1))


def _finish(figure: go.Figure, x_title: str) -> go.Figure:
    figure.update_xaxes(title=x_title)
    figure.update_layout(
        template="plotly_white",
        height=340,
        margin={"l": 60, "r": 20, "t": 40, "b": 50},
        legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0.0},
    )
    return figure


FIGURES: dict[str, Callable[[], go.Figure]] = {
    "concept-observability": observability,
    "concept-convergence": convergence,
    "concept-front": front,
    "concept-selection-pressure": selection_pressure,
    "concept-hypervolume": hypervolume,
}
