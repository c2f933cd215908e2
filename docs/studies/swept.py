"""Tables and the figure of a study on a grid of parameters."""

import pandas as pd
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from mgeo.studies import Comparison, Study

PARAMETERS = {"perturbation": "perturbation", "tau": "τ", "n_walkers": "n_i"}


def swept(study: Study, comparison: Comparison) -> pd.DataFrame:
    """Return the final row of each run, with the parameters of its algorithm as columns."""
    rows = {c.label: {p: c.parameters[p] for p in PARAMETERS} for c in study.algorithms}
    return comparison.select_final_rows().join(pd.DataFrame(rows).T, on="algorithm")


def marginal(runs: pd.DataFrame) -> pd.DataFrame:
    """Return mean and standard deviation of the hypervolume for each value of each parameter."""
    rows = {}
    for parameter, name in PARAMETERS.items():
        for value, group in runs.groupby(parameter):
            values = group["hypervolume"]
            rows[f"{name} = {value}"] = f"{values.mean():.4f} ± {values.std():.4f}"
    return pd.DataFrame({"hypervolume": rows}).rename_axis("parameter")


def swept_figure(runs: pd.DataFrame) -> go.Figure:
    """Return heat maps of the mean hypervolume over τ and n_i, one for each perturbation."""
    kinds = list(dict.fromkeys(runs["perturbation"]))
    figure = make_subplots(cols=len(kinds), subplot_titles=kinds, shared_yaxes=True)
    for column, kind in enumerate(kinds, 1):
        chosen = runs[runs["perturbation"] == kind]
        means = chosen.pivot_table("hypervolume", "n_walkers", "tau", aggfunc="mean")
        spread = chosen.pivot_table("hypervolume", "n_walkers", "tau", aggfunc="std")
        heat = go.Heatmap(
            x=[f"{value:g}" for value in means.columns],
            y=[f"{value:g}" for value in means.index],
            z=means.to_numpy(float),
            customdata=spread.to_numpy(float),
            coloraxis="coloraxis",
            texttemplate="%{z:.3f}",
            hovertemplate=f"<b>{kind}</b>, τ = %{{x}}, n_i = %{{y}}<br>"
            "hypervolume %{z:.4f}, sd %{customdata:.4f}<extra></extra>",
        )
        figure.add_trace(heat, row=1, col=column)
        figure.update_xaxes(title="τ", row=1, col=column)
    figure.update_yaxes(title="n_i", row=1, col=1)
    return figure.update_layout(
        template="plotly_white",
        coloraxis={"colorscale": "Viridis", "colorbar": {"title": "hypervolume"}},
        height=400,
        margin={"l": 60, "r": 20, "t": 70, "b": 50},
    )
