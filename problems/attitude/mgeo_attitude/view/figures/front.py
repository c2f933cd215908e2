"""The front: how well the errors are known against how soon."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go

from mgeo.evaluation.dominance import front_rows
from mgeo.figures.style import COLORS, GRAY, HOVER, SYMBOLS, finished, literal, log_axis
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.view.describe import exactly, front_summary, maneuver_texts
from mgeo_attitude.view.figures.style import Solutions
from mgeo_attitude.view.plans import MOST_SAMPLES

#: Ticks of the upper axis, at most.
_TICKS = 20
#: Up to how many times the last plan's end the end of a window is drawn.
_FAR = 3.0
#: Minutes between ticks of the upper axis.
_MINUTES = (1, 2, 5, 10, 20, 30, 60, 120, 240, 480, 1440)
#: What `front_figure` takes for each time: t_end [s], trace, and 1-sigma of the attitude [deg].
_NOTHING = np.empty((0, 3))


class _Scale(NamedTuple):
    """What tells how well the errors are known: the trace, or the attitude alone.

    `column` is its place in what `front_figure` takes; `required` is infinite without a limit.
    """

    name: str
    title: str
    column: int
    required: float = math.inf


def front_figure(
    scenario: Scenario,
    solutions: Solutions,
    kept: Floats | None = None,
    *,
    longest: float = math.inf,
    dead_end: bool = False,
    least: Floats = _NOTHING,
    bend: int | None = None,
) -> go.Figure:
    """What is known against t_end, with each plan in its hover text, up to where plans end.

    A button chooses between the 1-sigma of the attitude [deg] and the trace; that of the paper's
    satellite comes first with the trace, as in the paper. Traces: the boundary of what the front
    dominates; the solutions (``customdata`` is their number), of the paper's satellite in two by
    the orbit in which they converge; those that do not converge; the boundary of what most flights
    keep; what no maneuver can beat; what is required; the knee. The end of the window is shaded.

    Parameters
    ----------
    kept : array, shape (n, 3), optional
        t_end, trace and 1-sigma of the attitude [deg] that most flights of the solutions keep, NaN
        where nobody looked or fewer converge.
    longest
        t_end of a run that does not converge [s].
    dead_end
        That none of the solutions keeps all limits.
    least : array, shape (m, 3)
        Times [s], and trace and 1-sigma of the attitude [deg] that no maneuver can beat then.
    bend
        Place of the knee among the solutions.
    """
    papers = of_the_paper(scenario)
    kept = np.full((len(solutions.X), 3), np.nan) if kept is None else kept
    values = np.column_stack([solutions.F, solutions.sigma_deg])
    span = _span(scenario, values[:, 0], kept[:, 0])
    hover = np.array([_hover_text(solutions, i, scenario, kept[i]) for i in range(len(values))])
    groups = []
    for name, group, color, symbol in _groups(scenario, values[:, 0], longest, papers=papers):
        # no outline: where points overlap it would hide their color
        look = {"color": color, "symbol": symbol, "size": 8, "opacity": 0.8, "line": {"width": 0}}
        more = {"marker": look, "customdata": solutions.numbers[group], "hovertext": hover[group]}
        groups.append((name, group, more))
    knee = values[[] if bend is None else [bend]]
    scales = _scales(scenario, values, papers=papers)
    drawn = [list(_traces(scale, values, groups, kept, least, knee, span)) for scale in scales]
    axes = [
        _axis(scale, [each["y"] for each in some])
        for scale, some in zip(scales, drawn, strict=True)
    ]
    figure = go.Figure(drawn[0])
    summary = f"{len(values)} plans, none of which keeps all limits"
    if not dead_end:
        summary = _summary(scenario, solutions.F, papers=papers)
    finished(
        figure,
        f"Calibration maneuvers: what is known against {scenario.convergence.time}",
        f"scenario {literal(scenario.name)}; {summary}{HOVER}",
    )
    _mark_times(figure, scenario, span)
    figure.update_xaxes(title_text="t_end [s]", tickformat="d", range=span)
    figure.update_yaxes(axes[0], title_text=scales[0].title)
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
        hovermode="closest",
        margin={"t": 150, "b": 105},  # room for buttons and upper axis, and the legend
        xaxis2=_upper_axis(scenario, span, orbits=papers),
        updatemenus=[_buttons(scales, drawn, axes)],
    )


def _traces(
    scale: _Scale,
    values: Floats,
    groups: list[tuple[str, Bools, dict[str, Any]]],
    kept: Floats,
    least: Floats,
    knee: Floats,
    span: list[float],
) -> Iterator[dict[str, Any]]:
    """All that is drawn by one of the scales, of tables whose columns it knows."""
    at = [0, scale.column]
    yield _stairs(values[:, at], "boundary", {"width": 1, "color": "#b9c2cc"}) | {
        "xaxis": "x2",  # which plotly draws only if it has data
        "showlegend": False,
    }
    for name, group, more in groups:
        shown = {"hoverinfo": "text", "showlegend": bool(group.any())}
        yield {**_points(values[group][:, at], name), **more, **shown}
    line = {"width": 1.5, "color": COLORS[2], "dash": "dot"}
    yield _stairs(kept[:, at], f"kept by {MOST_SAMPLES}", line)
    yield {
        **_line(least[:, at], "no maneuver can beat", {"width": 1.5, "color": GRAY}),
        "hovertemplate": "no maneuver can beat %{y:.4g} after %{x:.6g} s<extra></extra>",
    }
    required = np.array([[time, scale.required] for time in span if scale.required < math.inf])
    line = {"width": 1.5, "color": COLORS[3], "dash": "dash"}
    yield _line(required.reshape(-1, 2), f"required, {scale.required:.4g} deg", line)
    ring = {"symbol": "circle-open", "size": 16, "color": COLORS[6], "line": {"width": 2}}
    yield {
        **_points(knee[:, at], "knee"),
        "mode": "markers+text",
        "text": ["knee"] * len(knee),
        "textposition": "bottom left",
        "marker": ring,
        "hoverinfo": "skip",
        "showlegend": False,
    }


def of_the_paper(scenario: Scenario) -> bool:
    """Whether it is the paper's satellite, with nothing required of it: shown as in the paper."""
    return scenario.suite == Scenario.paper().suite and not scenario.required_sigma


def _scales(scenario: Scenario, values: Floats, *, papers: bool) -> list[_Scale]:
    """The one that comes first, and the other."""
    required = scenario.required_sigma.get("attitude_deg", math.inf)
    label = (  # no longer than the plot on paper
        f"attitude 1-sigma, worst axis{exactly(scenario)} [deg]"
    )
    attitude = _Scale("attitude", label, 2, required)
    trace = _Scale("trace", "trace of the covariance at t_end [-]", 1)
    return [trace, attitude] if papers else [attitude, trace]


def _axis(scale: _Scale, values: list[Floats]) -> dict[str, Any]:
    """Logarithmic; degrees as people write them."""
    shown = np.concatenate(values)
    if scale.column == 1:
        return log_axis(shown)
    low, high = np.floor(np.log10([shown.min(), shown.max()]))
    steps = (1, 2, 5) if high - low < 3 else (1,)
    ticks = [step * 10.0**power for power in np.arange(low, high + 2) for step in steps]
    text = [f"{tick:.6g}" for tick in ticks]
    return {"type": "log", "tickmode": "array", "tickvals": ticks, "ticktext": text}


def _groups(
    scenario: Scenario, t_end: Floats, longest: float, *, papers: bool
) -> list[tuple[str, Bools, str, str]]:
    """Name, members, color and symbol of each."""
    endless, later = t_end >= longest, t_end > scenario.orbit.period
    later = later & papers & ~endless
    first = "first orbit" if papers else "plans"
    second = "second orbit" if scenario.duration <= 2.0 * scenario.orbit.period else "later orbits"
    found = [(first, ~later & ~endless, COLORS[0], SYMBOLS[0])]
    if papers:
        found.append((second, later, COLORS[1], SYMBOLS[1]))
    return found + ([("not converged", endless, GRAY, "x")] if endless.any() else [])


def _summary(scenario: Scenario, F: Floats, *, papers: bool) -> str:
    """How many plans there are, of the paper's satellite by their orbits as in its Table 3."""
    if not papers:
        return f"{len(F)} plans"
    second = "second orbit" if scenario.duration <= 2.0 * scenario.orbit.period else "later orbits"
    counts = zip(("first orbit", second), front_summary(scenario, F).values(), strict=True)
    told = ", ".join(f"{name} {count:.0f}" for name, count in counts if count)
    return f"points on the front: {told}"


def _span(scenario: Scenario, t_end: Floats, kept: Floats) -> list[float]:
    """What the axis of times shows [s]: from the start if that is near, until all is over."""
    first, last = float(t_end.min()), float(np.nanmax(np.append(t_end, kept)))
    if _closes(scenario) < _FAR * last:
        last = max(last, _closes(scenario))
    first = 0.0 if first < 0.5 * last else first
    room = 0.04 * (last - first) or 0.05 * last
    return [max(first - room, 0.0), last + room]


def _closes(scenario: Scenario) -> float:
    """When the window does [s]; infinite without one."""
    return scenario.deadline


def _mark_times(figure: go.Figure, scenario: Scenario, span: list[float]) -> None:
    """The orbital period and the end of the window, where they are within what is shown."""
    text = {"textangle": -90, "xanchor": "right", "yanchor": "top", "font": {"color": GRAY}}
    marks = ((scenario.orbit.period, "one orbital period"), (_closes(scenario), "window closes"))
    for time, name in marks:
        if span[0] < time < span[1]:
            line = {"color": GRAY, "width": 1.5, "dash": "dash"}
            figure.add_vline(x=time, line=line, annotation={"text": name, **text})
    if _closes(scenario) < span[1]:
        shade = {"fillcolor": "rgba(128,128,128,0.2)", "line": {"width": 0}, "layer": "below"}
        figure.add_vrect(x0=_closes(scenario), x1=span[1], **shade)


def _buttons(
    scales: list[_Scale], drawn: list[list[dict[str, Any]]], axes: list[dict[str, Any]]
) -> dict[str, Any]:
    """A choice of the scale, by plotly's method ``update``."""
    buttons = []
    for scale, traces, axis in zip(scales, drawn, axes, strict=True):
        now = {key: [np.asarray(each[key]).tolist() for each in traces] for key in "xy"}
        now["visible"] = [each["visible"] for each in traces]
        keys = ("dtick", "tickmode", "tickvals", "ticktext")  # all of them: what is old goes
        layout = {"yaxis.title.text": scale.title, **{f"yaxis.{k}": axis.get(k) for k in keys}}
        where = list(range(len(traces)))
        buttons.append({"label": scale.name, "method": "update", "args": [now, layout, where]})
    return {
        "type": "buttons",
        "direction": "right",
        "buttons": buttons,
        "showactive": True,
        "x": 0,
        "xanchor": "left",
        "y": 1,
        "yanchor": "bottom",
        "pad": {"b": 55},
        "font": {"size": 12},
    }


def _points(at: Floats, name: str) -> dict[str, Any]:
    """A trace of points, shape (n, 2); not to be seen without any."""
    shown = {"type": "scatter", "mode": "markers", "name": name, "visible": bool(len(at))}
    return {**shown, "x": at[:, 0], "y": at[:, 1]}


def _line(at: Floats, name: str, line: dict[str, Any]) -> dict[str, Any]:
    return _points(at, name) | {"mode": "lines", "line": line}


def _stairs(at: Floats, name: str, line: dict[str, Any]) -> dict[str, Any]:
    """The boundary of what points, shape (n, 2), dominate."""
    trace = _line(at[front_rows(at)], name, {"shape": "hv", **line})
    return {**trace, "hoverinfo": "skip"}


def _hover_text(solutions: Solutions, i: int, scenario: Scenario, kept: Floats) -> str:
    t_end, trace = solutions.F[i]
    lines = [
        f"<b>{solutions.labels[i]}</b>",
        f"t_end {t_end:.6g} s ({t_end / scenario.orbit.period:.3f} orbits)",
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
    t_end, trace, sigma = kept
    return [f"{MOST_SAMPLES} keep t_end {t_end:.6g} s, trace {trace:.4g}, attitude {sigma:.3g} deg"]


def _upper_axis(scenario: Scenario, span: list[float], *, orbits: bool) -> dict[str, object]:
    """The same times in orbits or minutes, zoomed and moved together with the axis in seconds."""
    if orbits:
        unit, name = scenario.orbit.period, "orbits"
        distance = 0.1 * math.ceil(10.0 * span[1] / unit / _TICKS)
    else:
        unit, name = 60.0, "min"
        distance = next((m for m in _MINUTES if span[1] < unit * m * _TICKS / 2), _MINUTES[-1])
    ticks = distance * np.arange(math.ceil(span[1] / (unit * distance)) + 1)
    return {
        "title": {"text": f"t_end [{name}]"},
        "overlaying": "x",
        "matches": "x",
        "side": "top",
        "tickmode": "array",
        "tickvals": unit * ticks,
        "ticktext": [f"{tick:g}" for tick in ticks],
        "showgrid": False,
        "zeroline": False,
        "showline": True,
        "linecolor": GRAY,
        "ticks": "outside",
    }
