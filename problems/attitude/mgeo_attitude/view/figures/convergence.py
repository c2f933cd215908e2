"""How a filter run converges: its trace and the 1-sigma of every error against time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from mgeo.figures.style import finished, log_axis
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.view.figures.solutions import Solutions
from mgeo_attitude.view.figures.style import line, panels_height

if TYPE_CHECKING:
    from mgeo_attitude.view.protocol import ManeuverProblem


#: Samples drawn of each curve, spread evenly, and as many again more densely at its start.
_SAMPLES = 300
_COLUMNS = 2


def convergence_figure(problem: ManeuverProblem, solutions: Solutions) -> go.Figure:
    """Panels of the trace and of each state block's worst axis, one line per solution."""
    blocks = block_units(problem.model.suite)
    panels = ["trace [-]", *(f"{block.label}, 1-sigma [{block.unit}]" for block in blocks)]
    rows = -(-len(panels) // _COLUMNS)
    figure = make_subplots(
        rows,
        _COLUMNS,
        subplot_titles=panels,
        horizontal_spacing=0.09,
        vertical_spacing=0.28 / rows,
    )
    finished(
        figure,
        "Convergence of the filter",
        "predicted 1-sigma of the worst body axis of each error, until t_end",
    )
    lines = curves(problem, solutions)
    for panel in range(len(panels)):
        place = {"row": panel // _COLUMNS + 1, "col": panel % _COLUMNS + 1}
        for index, (label, (times, values)) in enumerate(zip(solutions.labels, lines, strict=True)):
            figure.add_scatter(
                x=times,
                y=values[panel],
                name=label,
                legendgroup=label,
                showlegend=panel == 0,
                mode="lines",
                line=line(index),
                hovertemplate="%{x:.6g} s: %{y:.4g}",
                **place,
            )
        figure.update_yaxes(
            log_axis(np.concatenate([values[panel] for _, values in lines])), **place
        )
        if panel >= len(panels) - _COLUMNS:  # the lowest of its column
            figure.update_xaxes(title_text="time [s]", **place)
    figure.update_xaxes(matches="x", tickformat="d")
    return figure.update_layout(height=panels_height(rows))


def curves(problem: ManeuverProblem, solutions: Solutions) -> list[tuple[Floats, Floats]]:
    """For each solution, times [s], shape (k,), and the panels' values then, (1 + n_blocks, k)."""
    model = problem.model
    factors = [block.factor for block in block_units(model.suite)]
    result = problem.run(solutions.X, history=True)
    lines = []
    for t_end, history in zip(result.t_end, result.variances, strict=True):
        steps = sample_steps(round(t_end / model.step))
        times: Floats = steps.astype(np.float64) * model.step
        worst = np.sqrt(history[steps].reshape(len(steps), -1, 3).max(axis=2))
        values: Floats = np.vstack([history[steps] @ model.weights, (worst * factors).T])
        lines.append((times, values))
    return lines


def sample_steps(last: int) -> NDArray[np.int64]:
    """Steps from 0 to `last`, both included, at which a curve is drawn."""
    even = np.linspace(0, last, _SAMPLES)
    dense_at_start = np.geomspace(1, last, _SAMPLES)
    return np.unique(np.rint(np.concatenate([even, dense_at_start])).astype(np.int64))
