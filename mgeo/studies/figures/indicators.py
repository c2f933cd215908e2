"""Figures of indicator values, and of average ranks and runtimes over several problems."""

from __future__ import annotations

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo._typing import FloatArray
from mgeo.figures.front import build_axis_layout
from mgeo.figures.style import CLICK_HINT, build_log_axis_layout, escape_markup
from mgeo.studies.aggregation import TARGET_DISTANCES
from mgeo.studies.comparison import Comparison
from mgeo.studies.figures.style import (
    TraceStyle,
    apply_comparison_style,
    assign_trace_styles,
    compute_height,
)
from mgeo.studies.statistics import FriedmanResult, bootstrap_band


def draw_anytime_curves(comparison: Comparison, indicator: str | None = None) -> go.Figure:
    """Draw the mean indicator of each algorithm against evaluations, with a 95 % bootstrap band.

    A curve begins at the first evaluation count at which all runs have finite values, because an
    empty front has a finite hypervolume only. The vertical axis is logarithmic if lower values are
    better and all means are positive.

    Raises
    ------
    ValueError
        If the indicator is unknown.
    """
    chosen = comparison.select_indicator(indicator)
    figure = go.Figure()
    for name, style in assign_trace_styles(comparison.algorithms).items():
        rows = comparison.table[comparison.table["algorithm"] == name]
        wide = rows.pivot(index="seed", columns="evaluations", values=chosen.name)
        wide = wide.loc[:, np.isfinite(wide.to_numpy(float)).all(axis=0)]
        if wide.size:
            values = wide.to_numpy(float)
            figure.add_traces(_build_curve(name, style, wide.columns.to_numpy(int), values))
    figure.update_xaxes(title="evaluations", tickformat=",d", rangemode="tozero")
    positive = all(np.min(curve.y) > 0 for curve in figure.data if curve.mode == "lines")
    figure.update_yaxes(
        title=chosen.title,
        type="log" if positive and not chosen.is_maximized else "linear",
        exponentformat="power",
    )
    return apply_comparison_style(
        figure,
        f"{chosen.title[0].upper()}{chosen.title[1:]} over evaluations",
        f"mean of the runs, {chosen.direction}; band: 95 % bootstrap interval of the mean"
        f"{CLICK_HINT}",
    )


def draw_box_plots(comparison: Comparison) -> go.Figure:
    """Draw box plots of the final indicator values, with one point per run."""
    figure = make_subplots(rows=1, cols=len(comparison.indicators), shared_yaxes=True)
    final = comparison.select_final_rows()
    for name, style in assign_trace_styles(comparison.algorithms).items():
        rows = final[final["algorithm"] == name]
        for column, indicator in enumerate(comparison.indicators, 1):
            values = rows[indicator.name].to_numpy(float)
            is_finite = np.isfinite(values)
            box = go.Box(
                x=values[is_finite],
                name=escape_markup(name),
                orientation="h",
                boxpoints="all",
                jitter=0.5,
                pointpos=0,
                marker={"color": style.color, "size": 4, "opacity": 0.7},
                line={"width": 1.2},
                fillcolor=style.format_color(0.2),
                customdata=rows["seed"][is_finite],
                hovertemplate=f"<b>{escape_markup(name)}</b>, seed %{{customdata}}<br>"
                f"{indicator.title}: %{{x:.5g}}<extra></extra>",
                hoveron="points",
                showlegend=False,
            )
            figure.add_trace(box, row=1, col=column)
    for column, indicator in enumerate(comparison.indicators, 1):
        values = final[indicator.name].to_numpy(float)
        figure.update_xaxes(build_axis_layout("", values[np.isfinite(values)]), col=column)
        figure.update_xaxes(title=f"{indicator.title}<br>{indicator.direction}", col=column)
    figure.update_xaxes(tickangle=0)
    figure.update_yaxes(autorange="reversed", automargin=True)
    n_empty = int((final["points"] == 0).sum())
    return apply_comparison_style(
        figure,
        f"All runs after {comparison.n_eval:,} evaluations",
        "box: quartiles and median; each point is a run, hover over one for its seed"
        + (f"; omitted: {n_empty} runs without a feasible solution" if n_empty else ""),
    ).update_layout(height=compute_height(len(comparison.algorithms)))


def _build_curve(
    name: str, style: TraceStyle, x: FloatArray, values: FloatArray
) -> list[go.Scatter]:
    mean = values.mean(axis=0)
    low, high = bootstrap_band(values)
    hover = (
        f"<b>{escape_markup(name)}</b><br>after %{{x:,d}} evaluations<br>"
        f"mean of {len(values)} runs: %{{y:.5g}}<br>"
        "95 % interval: %{customdata[0]:.5g} to %{customdata[1]:.5g}<extra></extra>"
    )
    band = go.Scatter(
        x=np.concatenate([x, x[::-1]]),
        y=np.concatenate([high, low[::-1]]),
        mode="none",
        fill="toself",
        fillcolor=style.format_color(0.18),
        line={"width": 0},
        hoverinfo="skip",
        legendgroup=name,
        showlegend=False,
    )
    line = go.Scatter(
        x=x,
        y=mean,
        mode="lines",
        name=escape_markup(name),
        legendgroup=name,
        line=style.build_line(2),
        customdata=np.column_stack([low, high]),
        hovertemplate=hover,
    )
    return [band, line]


def draw_critical_difference_diagram(
    test_result: FriedmanResult, algorithms: tuple[str, ...]
) -> go.Figure:
    """Draw a critical-difference diagram of average ranks (Demsar 2006).

    Parameters
    ----------
    test_result : FriedmanResult
        Friedman's test over problems.
    algorithms : tuple of str
        Labels in the order that determines their colors.
    """
    names, ranks = list(test_result.ranks.index), test_result.ranks.to_numpy(float)
    styles = assign_trace_styles(algorithms)
    scope = f"{test_result.n_problems} problems"
    if test_result.n_blocks < test_result.n_problems:
        scope += f" of {test_result.n_blocks} functions"
    groups = find_equivalent_groups(list(ranks), test_result.critical_difference)
    figure = go.Figure()
    for row, (low, high) in enumerate(groups):
        members = escape_markup(", ".join(names[low : high + 1]))
        figure.add_scatter(
            x=[ranks[low], (ranks[low] + ranks[high]) / 2, ranks[high]],
            y=[0.6 + 0.45 * row] * 3,
            mode="lines",
            line={"width": 6, "color": "#8a8a8a"},
            text=f"not significantly different at 5 %:<br>{members}",
            hoverinfo="text",
        )
    for i, (name, rank) in enumerate(zip(names, ranks, strict=True)):
        style = styles[name]
        figure.add_scatter(
            x=[rank, rank],
            y=[0, -1 - i],
            mode="lines+markers",
            line={"width": 1, "color": style.format_color(0.5)},
            marker={"size": [0, 12], "color": style.color, "symbol": style.symbol, "opacity": 1},
            hovertemplate=f"<b>{escape_markup(name)}</b><br>average rank %{{x:.3f}} over {scope}"
            "<extra></extra>",
        )
    k = len(names)
    figure.update_xaxes(
        title="average rank (1 is the best)",
        range=[0.8, k + 0.2],
        tick0=1,
        dtick=1 if k <= 10 else 2,
    )
    figure.update_yaxes(
        range=[-k - 0.6, 0.8 + 0.45 * max(1, len(groups))],
        tickvals=[-1 - i for i in range(k)],
        ticktext=[
            f"{escape_markup(name)}  <b>{rank:.2f}</b>"
            for name, rank in zip(names, ranks, strict=True)
        ],
        automargin=True,
    )
    return apply_comparison_style(
        figure,
        f"Average ranks over {scope}",
        "bars join algorithms that differ by less than the critical difference of "
        f"{test_result.critical_difference:.2f} (Nemenyi, 5 %); Friedman's test: "
        f"p = {test_result.p_value:.2g}",
    ).update_layout(showlegend=False, height=compute_height(k + len(groups)))


def find_equivalent_groups(ranks: list[float], critical_difference: float) -> list[tuple[int, int]]:
    """Find the largest groups of algorithms without significant differences.

    Groups may overlap; groups of one algorithm are omitted.

    Parameters
    ----------
    ranks : list of float
        Average ranks, ascending.
    critical_difference : float
        Difference from which two ranks differ significantly.

    Returns
    -------
    list of (int, int)
        First and last index of each group.
    """
    groups: list[tuple[int, int]] = []
    for low, rank in enumerate(ranks):
        high = max(i for i, other in enumerate(ranks) if other - rank < critical_difference)
        if high > low and (not groups or high > groups[-1][1]):
            groups.append((low, high))
    return groups


def draw_runtime_distribution(distribution: pd.DataFrame, n_problems: int) -> go.Figure:
    """Draw the share of hypervolume targets that each algorithm reaches over evaluations.

    The COCO benchmarking platform uses the same figure.

    Parameters
    ----------
    distribution : DataFrame
        Table of `mgeo.studies.aggregation.compute_runtime_distribution`.
    n_problems : int
        Number of problems, for the title.
    """
    figure = go.Figure()
    for name, style in assign_trace_styles(tuple(distribution["algorithm"].unique())).items():
        steps = distribution[distribution["algorithm"] == name]
        figure.add_scatter(
            x=steps["evaluations"],
            y=steps["share"],
            mode="lines+markers",  # The markers show the measured evaluation counts.
            line=style.build_line(2) | {"shape": "hv"},
            marker={"symbol": style.symbol, "size": 6},
            name=escape_markup(name),
            hovertemplate=f"<b>{escape_markup(name)}</b><br>%{{y:.1%}} of the targets<br>"
            "within %{x:,.4g} evaluations per variable<extra></extra>",
        )
    evaluations = distribution["evaluations"]
    axis = build_log_axis_layout(evaluations[evaluations > 0]) if (evaluations > 0).any() else {}
    figure.update_xaxes(title="evaluations per variable", **axis)
    figure.update_yaxes(title="share of targets reached", range=[0, 1], tickformat=".0%")
    return apply_comparison_style(
        figure,
        f"Hypervolume targets reached over {n_problems} problem{'s' if n_problems > 1 else ''}",
        f"targets: {100 * TARGET_DISTANCES[0]:.0f} % to {100 * TARGET_DISTANCES[-1]:.3f} % below "
        f"the best hypervolume of each problem{CLICK_HINT}",
    )
