"""Figures of the page with the benchmark results."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from plotly.subplots import make_subplots
from stored_studies import CONTROL, load_ranks, load_values

from mgeo.figures.style import GRID_COLOR
from mgeo.studies import Comparison
from mgeo.studies.aggregation import KEY_COLUMNS, compute_average_ranks
from mgeo.studies.figures.style import assign_trace_styles

#: All algorithms of the figures, in the order that determines colors and symbols.
_ALGORITHMS = (
    CONTROL,
    *("NSGA-II", "SPEA2", "NSGA-III", "MOEA/D", "CMOPSO", "GDE3", "SMS-EMOA", "AGE-MOEA-II"),
    *("RVEA", "MO-CMA-ES", f"{CONTROL}, reflect", f"{CONTROL}, resample"),
    *("MGEO_real, clip", "MGEO_real, reflect", "MixedVariableGA", "NSGA-II, mixed operators"),
    *("MGEOCanonical", "MGEO_real, σ = 0.1 range", "MGEO_real, σ = 1 range", "random search"),
)
_STYLES = assign_trace_styles(_ALGORITHMS)


def draw_targets(targets: pd.DataFrame) -> go.Figure:
    """Draw the share of targets that each algorithm reached over evaluations per variable."""
    figure = go.Figure()
    final = targets.groupby("algorithm")["share"].last().sort_values(ascending=False)
    for name in final.index:
        rows = targets[targets["algorithm"] == name]
        _add_curve(figure, name, rows["evaluations"], rows["share"])
    budgets = targets["evaluations"].unique()
    figure.update_xaxes(title="evaluations per variable", type="log", tickvals=budgets)
    figure.update_xaxes(tickformat=",d", range=np.log10([0.9 * budgets.min(), 1.1 * budgets.max()]))
    figure.update_yaxes(title="share of targets reached", tickformat=".0%", rangemode="tozero")
    return format_for_page(figure, 560)


def draw_satellites(comparisons: Mapping[str, Comparison]) -> go.Figure:
    """Draw the mean hypervolume over evaluations, one panel per satellite."""
    figure = make_subplots(
        rows=len(comparisons), subplot_titles=list(comparisons), vertical_spacing=0.12
    )
    for row, comparison in enumerate(comparisons.values(), 1):
        means = comparison.table.groupby(["algorithm", "evaluations"])["hypervolume"].mean()
        for name in comparison.algorithms:
            _add_curve(figure, name, means[name].index, means[name], row=row, col=1)
            figure.data[-1].showlegend = row == 1
    figure.update_xaxes(title="evaluations", row=len(comparisons), col=1)
    figure.update_xaxes(tickformat=",d")
    figure.update_yaxes(title="mean hypervolume")
    return format_for_page(figure, 740).update_layout(margin_t=60)


def draw_average_ranks(ranks: pd.DataFrame) -> go.Figure:
    """Draw the average ranks of algorithms as points on a line, the best at the top."""
    figure = go.Figure()
    for name, rank in zip(ranks["algorithm"], ranks["average_rank"], strict=True):
        style = _STYLES[name]
        figure.add_scatter(
            x=[rank],
            y=[name],
            mode="markers+text",
            text=[f"{rank:.2f}"],
            textposition="middle right",
            marker={"color": style.color, "symbol": style.symbol, "size": 12},
            hovertemplate=f"<b>{name}</b><br>average rank {rank:.2f}<extra></extra>",
        )
    figure.update_xaxes(title="average rank", range=[0.6, 1.2 * len(ranks)], dtick=1)
    figure.update_yaxes(autorange="reversed")
    return format_for_page(figure, 360).update_layout(showlegend=False)


def rank_by_variables() -> pd.DataFrame:
    """Return the average ranks of the algorithms that all studies of 5 to 100 variables share.

    Rows are algorithms, columns are numbers of variables. The last column is of other problems.
    """
    larger = {40: ("forty-variables", 500), 100: ("hundred-variables", 200)}
    names = load_ranks("forty-variables")["algorithm"].unique()
    values = load_values("bbob-biobj")[[*KEY_COLUMNS, *names]]
    smaller = compute_average_ranks(values[values["evaluations"] == 500], CONTROL)
    tables = {n: smaller[smaller["variables"] == n] for n in (5, 10, 20)}
    for n, (study, evaluations) in larger.items():
        ranks = load_ranks(study)
        tables[n] = ranks[ranks["evaluations"] == evaluations]
    columns = {n: rows.set_index("algorithm")["average_rank"] for n, rows in tables.items()}
    return pd.DataFrame(columns).sort_values(40)


def draw_ranks_by_variables(ranks: pd.DataFrame) -> go.Figure:
    """Draw the average ranks of `rank_by_variables` over the number of variables."""
    figure = go.Figure()
    for name, row in ranks.iterrows():
        # The gap separates the functions of COCO from the other problems.
        gap = row.drop(100).tolist(), row[100]
        _add_curve(figure, str(name), [5, 10, 20, 40, 60, 100], [*gap[0], np.nan, gap[1]])
    figure.update_xaxes(
        title="variables", type="log", tickvals=ranks.columns, ticktext=list(map(str, ranks))
    )
    figure.update_yaxes(title=f"average rank of {len(ranks)}", range=[len(ranks) + 0.3, 0.7])
    return format_for_page(figure, 480)


def draw_mixed(runs: pd.DataFrame) -> go.Figure:
    """Draw the hypervolume of all runs on the problem with mixed variables, by budget."""
    figure = go.Figure()
    for name in runs["algorithm"].unique():
        style = _STYLES[name]
        rows = runs[runs["algorithm"] == name]
        figure.add_box(
            x=[f"{n:,} evaluations" for n in rows["evaluations"]],
            y=rows["hypervolume"],
            name=name,
            boxpoints="all",
            jitter=0.5,
            pointpos=0,
            marker={"color": style.color, "size": 4},
            line={"width": 1.2},
            fillcolor=style.format_color(0.2),
        )
    figure.update_yaxes(title="hypervolume")
    return format_for_page(figure, 480).update_layout(boxmode="group")


def format_for_page(figure: go.Figure, height: int) -> go.Figure:
    """Set the layout of a figure that fits a page of any width, with the legend below."""
    lines = {"gridcolor": GRID_COLOR, "zeroline": False, "automargin": True}
    figure.update_xaxes(**lines).update_yaxes(**lines)
    return figure.update_layout(
        template="plotly_white",
        height=height,
        font={"size": 13, "color": "#222222"},
        legend={"orientation": "h", "yref": "container", "y": 0.0, "yanchor": "bottom"},
        margin={"l": 10, "r": 10, "t": 20, "b": 10},
    )


def _add_curve(
    figure: go.Figure, name: str, x: Sequence[float], y: Sequence[float], **place: int
) -> None:
    style = _STYLES[name]
    figure.add_scatter(
        x=np.asarray(x, dtype=float),
        y=np.asarray(y, dtype=float),
        mode="lines+markers",
        name=name,
        legendgroup=name,
        line=style.build_line(3 if name == CONTROL else 1.5),
        marker={"color": style.color, "symbol": style.symbol, "size": 6},
        hovertemplate=f"<b>{name}</b><br>%{{x:,}}: %{{y:.4g}}<extra></extra>",
        **place,
    )
