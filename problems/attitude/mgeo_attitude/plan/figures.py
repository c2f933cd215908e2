"""Figures of one plan on the page that ``mgeo attitude show --html`` writes."""

from __future__ import annotations

import dataclasses

import plotly.graph_objects as go

from mgeo.figures.style import COLORS, apply_style, build_log_axis_layout, select_symbol
from mgeo_attitude.maneuvers.motion import HOLD_LABEL
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.view.figures.style import PlottedSolutions, build_line_style
from mgeo_attitude.view.figures.time_series import draw_maneuvers
from mgeo_attitude.view.observability.error_budget import TOTAL
from mgeo_attitude.view.summaries import format_nominal_suffix


def build_plan_figures(plan: ManeuverPlan) -> dict[str, go.Figure]:
    """Draw the figures that accompany the sections about a plan.

    The figures show the body rates, the uncertainty by phase, the error budget and the
    correlations.

    Parameters
    ----------
    plan : ManeuverPlan

    Returns
    -------
    dict of str to plotly Figure
        Figures with the keys ``timeline``, ``accuracy``, ``drivers`` and ``axes``; see
        `mgeo_attitude.plan_sections`.
    """
    solutions = dataclasses.replace(PlottedSolutions.from_plans(plan.view), labels=("plan",))
    rates = draw_maneuvers(plan.problem, solutions, plan.view.hold_end)
    has_hold = any(phase.label.startswith(HOLD_LABEL) for phase in plan.phases)
    hold = "gray: the last rates are held" if has_hold else ""
    apply_style(rates, "Body rates", hold).layout.annotations = ()
    return {
        "timeline": rates,
        "accuracy": _draw_uncertainty_by_phase(plan),
        "drivers": _draw_error_budget(plan),
        "axes": _draw_correlation(plan),
    }


def _draw_uncertainty_by_phase(plan: ManeuverPlan) -> go.Figure:
    table = plan.compute_uncertainty_by_phase()
    sigma = table.iloc[:, -plan.problem.model.suite.n_states :].to_numpy(float)
    worst = sigma.reshape(len(table), -1, 3).max(axis=2)
    times = zip(table.index, table["time [s]"], strict=True)
    ends = [f"{name}<br>{time:.6g} s" for name, time in times]
    figure = go.Figure()
    for index, block in enumerate(list_block_units(plan.problem.model.suite)):
        figure.add_scatter(
            x=ends,
            y=worst[:, index] / worst[0, index],
            name=block.label,
            mode="lines+markers",
            line=build_line_style(index),
            marker={"symbol": select_symbol(index), "size": 9},
            customdata=worst[:, index],
            hovertemplate=f"{block.label} %{{customdata:.4g}} {block.unit} (%{{y:.3g}})",
        )
    subtitle = "1-sigma of the worst body axis at the end of each maneuver"
    apply_style(figure, "Uncertainty reduction", subtitle + format_nominal_suffix(plan.scenario))
    figure.update_layout(hovermode="x unified", height=460)
    return figure.update_yaxes(
        build_log_axis_layout(worst / worst[0]), title_text="1-sigma / initial 1-sigma"
    )


def _draw_error_budget(plan: ManeuverPlan) -> go.Figure:
    table = plan.compute_error_budget()
    share = 100.0 * (table / table.loc[TOTAL]) ** 2
    figure = go.Figure()
    for index, source in enumerate(table.index.drop(TOTAL)):
        pattern = ("", "/", "x", ".")[
            index // len(COLORS) % 4
        ]  # The pattern distinguishes equal colors.
        figure.add_bar(
            y=[block.label for block in list_block_units(plan.problem.model.suite)],
            x=share.loc[source],
            name=source,
            orientation="h",
            marker={"color": COLORS[index % len(COLORS)], "pattern": {"shape": pattern}},
            customdata=table.loc[source],
            hovertemplate=f"{source} %{{customdata:.3g}} (%{{x:.1f}} % of the variance)",
        )
    subtitle = "share of each error source in the variance of the worst body axis"
    apply_style(figure, "Error budget", subtitle + format_nominal_suffix(plan.scenario))
    height = 320 + 30 * len(table.columns)
    figure.update_layout(barmode="stack", height=height, legend_traceorder="normal")
    figure.update_yaxes(autorange="reversed", title_text="")
    return figure.update_xaxes(range=[0.0, 100.0], title_text="share of the variance [%]")


def _draw_correlation(plan: ManeuverPlan) -> go.Figure:
    table = plan.compute_correlations()
    figure = go.Figure(
        go.Heatmap(
            x=table.columns,
            y=table.index,
            z=table,
            coloraxis="coloraxis",
            xgap=1,
            ygap=1,
            hovertemplate="%{y} and %{x}: %{z:.3f}<extra></extra>",
        )
    )
    apply_style(
        figure,
        "Correlation of the errors",
        "orange: positive, blue: negative; only the sum or the difference of strongly correlated "
        "errors is well observable",
    )
    figure.update_coloraxes(
        cmin=-1.0,
        cmax=1.0,
        colorscale=[COLORS[0], "#ffffff", COLORS[1]],
        colorbar={"title": {"text": "correlation"}, "outlinewidth": 0},
    )
    figure.update_layout(height=260 + 30 * len(table), margin={"l": 150, "b": 150})
    figure.update_xaxes(tickangle=-60, showgrid=False)
    return figure.update_yaxes(autorange="reversed", showgrid=False)
