"""The front: how well the errors are known against how soon."""

from __future__ import annotations

import math

import numpy as np
import plotly.graph_objects as go

from mgeo.algorithms.dominance import front_rows
from mgeo.figures.style import COLORS, GRAY, HOVER, SYMBOLS, finished, literal, log_axis
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.view.describe import front_summary, maneuver_texts
from mgeo_attitude.view.figures.solutions import Solutions
from mgeo_attitude.view.plans import MOST_FLIGHTS

#: Ticks of the upper axis over a run of two orbits, a tenth of an orbit apart.
_TICKS = 20


def front_figure(
    scenario: Scenario,
    solutions: Solutions,
    kept: Floats | None = None,
    *,
    longest: float = math.inf,
    dead_end: bool = False,
    least: tuple[Floats, Floats] | None = None,
) -> go.Figure:
    """Trace against t_end, in seconds below and orbits above, with each plan in its hover text.

    Traces: the boundary of what the front dominates, then the solutions that converge within the
    first orbital period, then the later ones, then those that do not (``customdata`` is the
    solution's number), the boundary of what most flights keep, and what no maneuver can beat.

    Parameters
    ----------
    kept : array, shape (n, 2), optional
        What most flights of the solutions keep, NaN where nobody looked or fewer converge.
    longest
        t_end of a run that does not converge [s].
    dead_end
        That none of the solutions keeps all limits.
    least
        Times [s] and the traces that no maneuver can beat then, if they are known.
    """
    kept = np.full(solutions.F.shape, np.nan) if kept is None else kept
    period = scenario.orbit.period
    t_end, trace = solutions.F.T
    endless = t_end >= longest
    later = (t_end > period) & ~endless
    names = ("first orbit", "second orbit" if scenario.duration <= 2.0 * period else "later orbits")
    counts = zip(names, front_summary(scenario, solutions.F).values(), strict=True)
    summary = "points on the front: " + ", ".join(f"{name} {count:.0f}" for name, count in counts)
    if dead_end:
        summary = f"{len(t_end)} plans, none of which keeps all limits"
    hover = np.array([_hover_text(solutions, i, period, kept[i]) for i in range(len(t_end))])
    front = solutions.F[front_rows(solutions.F)]
    figure = go.Figure().add_scatter(
        name="boundary",
        x=front[:, 0],
        y=front[:, 1],
        xaxis="x2",  # which plotly draws only if it has data
        mode="lines",
        line={"shape": "hv", "width": 1, "color": "#b9c2cc"},
        hoverinfo="skip",
        showlegend=False,
    )
    groups = [
        (names[0], ~later & ~endless, COLORS[0], SYMBOLS[0]),
        (names[1], later, COLORS[1], SYMBOLS[1]),
        ("not converged", endless, GRAY, "x"),
    ]
    for name, group, color, symbol in groups if endless.any() else groups[:2]:
        look = {"color": color, "symbol": symbol, "size": 8, "opacity": 0.8}
        figure.add_scatter(
            name=name,
            x=t_end[group],
            y=trace[group],
            mode="markers",
            # no outline: where points overlap it would hide their color
            marker=look | {"line": {"width": 0}},
            customdata=solutions.numbers[group],
            hovertext=hover[group],
            hoverinfo="text",
        )
    safe = front_rows(kept)
    if len(safe):
        figure.add_scatter(
            name=f"kept by {MOST_FLIGHTS}",
            x=kept[safe, 0],
            y=kept[safe, 1],
            mode="lines",
            line={"shape": "hv", "width": 1.5, "color": COLORS[2], "dash": "dot"},
            hoverinfo="skip",
        )
    if least is not None:
        figure.add_scatter(
            name="no maneuver can beat",
            x=least[0],
            y=least[1],
            mode="lines",
            line={"width": 1.5, "color": GRAY},
            hovertemplate="no maneuver can beat %{y:.4g} after %{x:.6g} s<extra></extra>",
        )
    finished(
        figure,
        "Calibration maneuvers: covariance trace against time to converge",
        f"scenario {literal(scenario.name)}; {summary}{HOVER}",
    )
    figure.add_vline(
        x=period,
        line={"color": GRAY, "width": 1.5, "dash": "dash"},
        annotation={
            "text": "one orbital period",
            "textangle": -90,
            "xanchor": "right",
            "yanchor": "top",
            "font": {"color": GRAY},
        },
    )
    figure.update_xaxes(title_text="t_end [s]", tickformat="d")
    shown = trace if least is None else np.append(trace, least[1])
    figure.update_yaxes(log_axis(shown), title_text="trace of the covariance at t_end [-]")
    return figure.update_layout(
        # below the lower axis' title, where neither points nor labels are
        legend={
            "orientation": "h",
            "x": 1,
            "xanchor": "right",
            "y": 0,
            "yref": "container",
            "yanchor": "bottom",
        },
        legend_title_text=None if endless.all() else "converged in",
        hovermode="closest",
        margin={"t": 135, "b": 105},  # room for the upper axis, and the legend
        xaxis2=_orbits_axis(scenario.duration, period),
    )


def _hover_text(solutions: Solutions, i: int, period: float, kept: Floats) -> str:
    t_end, trace = solutions.F[i]
    lines = [
        f"<b>{solutions.labels[i]}</b>",
        f"t_end {t_end:.6g} s ({t_end / period:.3f} orbits)",
        f"trace {trace:.4g}",
        *_kept_text(kept),
        f"attitude {solutions.sigma_deg[i]:.3g} deg (1-sigma, worst body axis)",
        "maneuvers, x / y / z [deg/s] for duration [s]:",
        *(f"{m}: {text}" for m, text in enumerate(maneuver_texts(solutions.X[i]), 1)),
    ]
    return "<br>".join(lines)


def _kept_text(kept: Floats) -> list[str]:
    if not np.isfinite(kept).all():
        return []
    return [f"{MOST_FLIGHTS} keep t_end {kept[0]:.6g} s, trace {kept[1]:.4g}"]


def _orbits_axis(duration: float, period: float) -> dict[str, object]:
    """The same times in orbits, zoomed and moved together with the axis in seconds."""
    distance = 0.1 * math.ceil(10.0 * duration / period / _TICKS)
    orbits = distance * np.arange(_TICKS + 1)
    return {
        "title": {"text": "t_end [orbits]"},
        "overlaying": "x",
        "matches": "x",
        "side": "top",
        "tickmode": "array",
        "tickvals": period * orbits,
        "ticktext": [f"{orbit:g}" for orbit in orbits],
        "showgrid": False,
        "zeroline": False,
        "showline": True,
        "linecolor": GRAY,
        "ticks": "outside",
    }
