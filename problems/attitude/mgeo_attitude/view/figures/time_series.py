"""Figures of several plans: front, body rates against time, and convergence of the filter."""

from __future__ import annotations

import dataclasses

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from mgeo._text import format_duration, format_two_digits
from mgeo.figures.style import apply_style, build_log_axis_layout
from mgeo.runs.summary import find_knee
from mgeo_attitude._typing import Floats
from mgeo_attitude.criteria.objectives import PAPER_OBJECTIVES, scale_for_indicators
from mgeo_attitude.maneuvers.schedule import build_rate_intervals
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.trajectory.trajectory import Trajectory
from mgeo_attitude.view import lower_bound
from mgeo_attitude.view.figures.front import draw_front
from mgeo_attitude.view.figures.style import (
    PlottedSolutions,
    build_line_style,
    compute_panels_height,
)
from mgeo_attitude.view.plans import Plans, select_sample_rows
from mgeo_attitude.view.summaries import format_nominal_suffix

#: Color of the constant-rate hold, visible on light and on dark pages.
_HOLD_COLOR = "rgba(128,128,128,0.15)"


def build_figures(plans: Plans) -> dict[str, go.Figure]:
    """Draw the figures ``front``, ``maneuvers`` and ``convergence`` of a front.

    ``maneuvers`` and ``convergence`` show up to six plans. Plans are numbered by their row in the
    front. Plans whose covariance lost positivity are left out. ``front`` exists only for the
    paper's objectives.

    Returns
    -------
    dict of str to plotly Figure

    Raises
    ------
    ValueError
        If no plan has finite objectives.
    """
    problem, solutions = plans.problem, PlottedSolutions.from_plans(plans)
    F = plans.F[solutions.numbers]
    knee_index = find_knee(scale_for_indicators(problem.objectives, F, problem.scenario))
    selected = solutions.select_representative(knee_index)
    front = {}
    if problem.objectives == PAPER_OBJECTIVES:
        rows = select_sample_rows(len(solutions.X))
        sample = plans.select(solutions.numbers[rows])
        robust_values = np.full((len(F), 3), np.nan)
        robust_values[rows] = np.column_stack(
            [sample.monte_carlo_objectives, sample.monte_carlo_sigma_deg]
        )
        unconverged_t_end = problem.model.nonconvergence_time
        # Values of plans of which too few Monte Carlo runs converge are not drawn.
        robust_values[robust_values[:, 0] >= unconverged_t_end] = np.nan
        front["front"] = draw_front(
            problem.scenario,
            dataclasses.replace(solutions, F=F),
            robust_values,
            unconverged_t_end=unconverged_t_end,
            is_infeasible=bool((plans.violations[solutions.numbers] > 0.0).any(axis=1).all()),
            lower_bound=lower_bound.compute_bound_curves(problem, F[:, 0]),
            knee_index=knee_index,
        )
    return front | {
        "maneuvers": draw_maneuvers(problem, selected, plans.hold_end[selected.numbers]),
        "convergence": draw_convergence(problem, selected),
    }


def draw_maneuvers(
    problem: AttitudeManeuverProblem, solutions: PlottedSolutions, hold_ends: Floats | None = None
) -> go.Figure:
    """Draw body rates against time, with one panel per plan.

    Each panel has its own time axis.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    solutions : PlottedSolutions
    hold_ends : array, shape (n,), optional
        End of the constant-rate hold of each plan [s], which has a gray background; default:
        t_end. A slew back follows.

    Returns
    -------
    plotly Figure
    """
    rows = len(solutions.F)
    titles = [
        f"{label}: {format_duration(t_end)}, attitude {format_two_digits(sigma)} deg"
        for label, t_end, sigma in zip(
            solutions.labels, solutions.F[:, 0], solutions.sigma_deg, strict=True
        )
    ]
    figure = make_subplots(rows, 1, vertical_spacing=0.36 / rows, subplot_titles=titles)
    hold_ends = solutions.F[:, 0] if hold_ends is None else hold_ends
    for row, (x, until) in enumerate(zip(solutions.X, hold_ends, strict=True), 1):
        times, rates, maneuver_end = compute_rate_profile(problem, x, until)
        for axis, name in enumerate("xyz"):
            figure.add_scatter(
                x=times,
                y=rates[:, axis],
                name=f"about {name}",
                legendgroup=name,
                showlegend=row == 1,
                mode="lines",
                line=build_line_style(axis, 2.5) | {"shape": "hv"},
                hovertemplate=f"about {name} %{{y:+.3f}} deg/s from %{{x:.6g}} s<extra></extra>",
                row=row,
                col=1,
            )
        figure.add_vrect(
            x0=maneuver_end,
            x1=until,
            fillcolor=_HOLD_COLOR,
            layer="below",
            line_width=0,
            row=row,
            col=1,
        )
    apply_style(
        figure,
        "Body rates",
        "gray: constant-rate hold"
        + (", followed by the slew back" if problem.scenario.maneuvers.slew_back else ""),
    )
    limit = 1.1 * problem.scenario.maneuvers.max_rate_deg_s
    figure.update_yaxes(range=[-limit, limit], title_text="body rate [deg/s]")
    figure.update_xaxes(title_text="time [s]", tickformat="d", row=rows, col=1)
    return figure.update_layout(height=compute_panels_height(rows))


def compute_rate_profile(
    problem: AttitudeManeuverProblem, x: Floats, end_time: float
) -> tuple[Floats, Floats, float]:
    """Return the body rates of a plan and the times at which they change.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    x : array, shape (n_var,)
        Design.
    end_time : float
        Time until which the last rate is held [s].

    Returns
    -------
    times : array, shape (k,)
        Start of each interval of constant rate, then the end of the plan [s].
    rates : array, shape (k, 3)
        Body rates from each time on [deg/s]; the last row repeats the one before.
    maneuver_end : float
        End of the last maneuver, at most `end_time` [s].
    """
    model = problem.model
    intervals = Trajectory(problem.scenario, model, x, end_time).intervals
    rates = np.degrees(intervals.rates)
    maneuver_end = build_rate_intervals(x, end_time, model.step, model.slew_limits).maneuver_end
    return intervals.times, np.vstack([rates, rates[-1:]]), maneuver_end


#: Number of evenly spaced samples of a curve; as many more are denser at its start.
_SAMPLES = 300
_COLUMNS = 2


def draw_convergence(problem: AttitudeManeuverProblem, solutions: PlottedSolutions) -> go.Figure:
    """Draw the trace and the worst-axis 1-sigmas against time, with one curve per plan."""
    blocks = list_block_units(problem.model.suite)
    panels = ["trace [-]", *(f"{block.label} [{block.unit}]" for block in blocks)]
    rows = -(-len(panels) // _COLUMNS)
    figure = make_subplots(
        rows,
        _COLUMNS,
        subplot_titles=panels,
        horizontal_spacing=0.09,
        vertical_spacing=0.28 / rows,
    )
    apply_style(
        figure,
        "Convergence of the Kalman filter",
        f"predicted 1-sigma of the worst body axis{format_nominal_suffix(problem.scenario)}",
    )
    lines = compute_convergence_curves(problem, solutions)
    for panel in range(len(panels)):
        position = {"row": panel // _COLUMNS + 1, "col": panel % _COLUMNS + 1}
        for index, (label, (times, values)) in enumerate(zip(solutions.labels, lines, strict=True)):
            figure.add_scatter(
                x=times,
                y=values[panel],
                name=label,
                legendgroup=label,
                showlegend=panel == 0,
                mode="lines",
                line=build_line_style(index),
                hovertemplate="%{x:.6g} s: %{y:.4g}",
                **position,
            )
        figure.update_yaxes(
            build_log_axis_layout(np.concatenate([values[panel] for _, values in lines])),
            **position,
        )
        if panel >= len(panels) - _COLUMNS:  # The panel is the lowest one of its column.
            figure.update_xaxes(title_text="time [s]", **position)
    figure.update_xaxes(matches="x", tickformat="d")
    return figure.update_layout(height=compute_panels_height(rows))


def compute_convergence_curves(
    problem: AttitudeManeuverProblem, solutions: PlottedSolutions
) -> list[tuple[Floats, Floats]]:
    """Compute the trace and the worst-axis 1-sigmas of each plan over time, until its t_end.

    Returns
    -------
    list of tuple
        One pair per plan: times [s], shape (k,), and values, shape (1 + n_blocks, k): the trace,
        then the 1-sigma of each 3-vector of the state in display units.
    """
    model = problem.model
    factors = [block.factor for block in list_block_units(model.suite)]
    result = problem.evaluate_nominal(solutions.X, history=True)
    lines = []
    for t_end, history in zip(result.t_end, result.variances, strict=True):
        steps = select_sample_steps(round(t_end / model.step))
        times: Floats = steps.astype(np.float64) * model.step
        worst = np.sqrt(history[steps].reshape(len(steps), -1, 3).max(axis=2))
        values: Floats = np.vstack([history[steps] @ model.weights, (worst * factors).T])
        lines.append((times, values))
    return lines


def select_sample_steps(last: int) -> NDArray[np.int64]:
    """Return filter steps from 0 to `last` at which to draw a curve, denser at the start."""
    even = np.linspace(0, last, _SAMPLES)
    dense_at_start = np.geomspace(1, last, _SAMPLES)
    return np.unique(np.rint(np.concatenate([even, dense_at_start])).astype(np.int64))
