"""Draws the picture of README.md: fronts of the default algorithm and of the published one.

Under them is what no maneuver can beat.

    python -m tests.benchmarks.front_picture

Run it in the repository's root, with the extra `png` and a browser; it takes a minute or two.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from mgeo_attitude.view.at_best import under

from mgeo.figures.style import COLORS, GRAY, SYMBOLS, finished, log_axis
from mgeo.report.static import drawn
from mgeo.runs.algorithms import DEFAULT
from mgeo.runs.prepare import prepare

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "front.png"
SHOWN = {DEFAULT: "our directed walkers", "mgeo-real": "as published, \u03c3 = 1"}


def main() -> None:
    figure, times = go.Figure(), []
    for index, (algorithm, words) in enumerate(SHOWN.items()):
        run = prepare("attitude", algorithm=algorithm)
        outcome = run.solve()
        t_end, trace = outcome.F.T
        times += t_end.tolist()
        volume = outcome.hypervolume
        assert volume is not None
        print(f"{algorithm}: {len(outcome.F)} plans, {outcome.evaluations:,} evaluations, "
              f"hypervolume {volume.value:.4f}")  # fmt: skip
        figure.add_scatter(
            name=f"{algorithm}, {words}: {len(t_end)} plans, hypervolume {volume.value:.3f}",
            x=t_end,
            y=trace,
            mode="lines+markers",
            line={"shape": "hv", "width": 1, "color": COLORS[index]},
            marker={"color": COLORS[index], "symbol": SYMBOLS[index], "size": 7},
        )
    curve = under(run.problem, np.array(times))
    figure.add_scatter(
        name="no maneuver can beat",
        x=curve[:, 0],
        y=curve[:, 1],
        mode="lines",
        line={"color": GRAY},
    )
    words = "the paper's satellite, 60,000 evaluations, seed 1"
    finished(figure, "Calibration maneuvers: how well, and how soon", words)
    figure.update_xaxes(title_text="time to converge [s]")
    figure.update_yaxes(log_axis(curve[:, 1]), title_text="trace of the covariance then [-]")
    figure.update_layout(legend={"x": 0.99, "xanchor": "right", "y": 0.98}, width=900, height=480)
    PICTURE.write_bytes(drawn({"front": figure}, ("png",))["front.png"])


if __name__ == "__main__":
    main()
