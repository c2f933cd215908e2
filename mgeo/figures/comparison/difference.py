"""Where one algorithm attains more often than another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import moocore
import numpy as np
import plotly.graph_objects as go

from mgeo.figures.comparison.attainment import stacked
from mgeo.figures.comparison.style import finished
from mgeo.figures.front import axis

if TYPE_CHECKING:
    from mgeo._typing import FloatArray
    from mgeo.studies.comparison import Comparison

LEVELS = 5  # steps of the share of runs in each direction
_LEVELS = (*range(LEVELS, 0, -1), *range(-1, -LEVELS - 1, -1))
_FIRST, _SECOND = (0, 92, 148), (190, 75, 0)  # at their strongest


def difference_figure(comparison: Comparison, first: str, seconds: list[str]) -> go.Figure:
    """Differences of the attainment of one algorithm and of each of some others, on a menu.

    Raises
    ------
    ValueError
        Unless there are two objectives, and every algorithm has a finished run, one of each pair
        with a front.
    """
    if comparison.problem.n_obj != 2:
        raise ValueError(f"{comparison.problem.n_obj} objectives: attainment is drawn for two")
    pairs = [_as_many(comparison.fronts(first), comparison.fronts(other)) for other in seconds]
    for second, pair in zip(seconds, pairs, strict=True):
        if not any(len(front) for side in pair for front in side):
            raise ValueError(
                f"{first!r} and {second!r}: expected a finished run of each, and a front"
            )
    everything = np.concatenate([front for pair in pairs for side in pair for front in side])
    corner = everything.max(axis=0) + 0.05 * np.ptp(everything, axis=0)
    groups = [_rectangles(*pair, corner) for pair in pairs]
    figure = go.Figure()
    shown: list[list[bool]] = []
    for second, pair, group in zip(seconds, pairs, groups, strict=True):
        shares = [_share(abs(level), min(LEVELS, len(pair[0]))) for level in _LEVELS]
        shown.append([bool(share) for share in shares])
        for level, share in zip(_LEVELS, shares, strict=True):
            sides = (first, second) if level > 0 else (second, first)
            figure.add_trace(_area(*sides, level, share, group.get(level, [])))
    figure.update_traces(visible=False)
    for trace, visible in zip(figure.data, shown[0], strict=False):
        trace.visible = visible
    if len(seconds) > 1:
        figure.update_layout(updatemenus=[_menu(first, seconds, shown)])
    for update, i in ((figure.update_xaxes, 0), (figure.update_yaxes, 1)):
        update(axis(comparison.objectives[i], everything[:, i]))
    finished(
        figure,
        f"Where {first} attains more often, and where less",
        f"blue: {first} gets there in more of its runs than the other; orange: in fewer; "
        "the darker, the more",
    )
    return figure.update_layout(legend={"title": "difference in share of runs"})


def _as_many(
    first: list[FloatArray], second: list[FloatArray]
) -> tuple[list[FloatArray], list[FloatArray]]:
    """As many fronts of one as of the other, the first ones: moocore expects equal numbers."""
    runs = min(len(first), len(second))
    return first[:runs], second[:runs]


def _rectangles(
    first: list[FloatArray], second: list[FloatArray], corner: FloatArray
) -> dict[int, list[FloatArray]]:
    """Rectangles (x0, y0, x1, y1) of the plane by level of the difference, cut at a corner.

    Level k is a difference of k in min(`LEVELS`, runs), or up to the next.
    """
    sides = [stacked(fronts) for fronts in (first, second)]
    if np.array_equal(*(moocore.eaf(points, sets) for points, sets in sides)):
        return {}  # moocore 0.3 cannot say that there is no difference
    found = moocore.eafdiff(
        *(np.column_stack(side) for side in sides),
        intervals=min(LEVELS, len(first)),
        rectangles=True,
    )
    found[:, 2:4] = np.minimum(found[:, 2:4], corner)
    groups: dict[int, list[FloatArray]] = {}
    for rectangle in found:
        level = int(rectangle[4])
        if level and (rectangle[:2] < rectangle[2:4]).all():
            groups.setdefault(level, []).append(rectangle[:4])
    return groups


def _share(level: int, steps: int) -> str:
    """What a level means in percent of the runs; nothing if there is no such level."""
    if level > steps:
        return ""
    low = f"{100 * level / steps:.3g}"
    return f"{low} %" if level == steps else f"{low} to {100 * (level + 1) / steps:.3g} %"


def _area(
    winner: str, loser: str, level: int, share: str, rectangles: list[FloatArray]
) -> go.Scatter:
    """One filled trace of all rectangles; an empty one keeps its place in the legend."""
    color = _color(level)
    x: list[float | None] = []
    y: list[float | None] = []
    for x0, y0, x1, y1 in rectangles:
        x += [x0, x1, x1, x0, x0, None]
        y += [y0, y0, y1, y1, y0, None]
    return go.Scatter(
        x=x or [None],
        y=y or [None],
        mode="lines",
        fill="toself",
        fillcolor=color,
        line={"width": 0.5, "color": color},  # closes the seams between rectangles
        name=f"{winner}: {share}",
        text=f"<b>{winner}</b> attains this in {share} more<br>of its runs than {loser} does",
        hoverinfo="text",
        hoveron="fills",
    )


def _color(level: int) -> str:
    strength = abs(level) / LEVELS
    parts = [round(255 - strength * (255 - c)) for c in (_FIRST if level > 0 else _SECOND)]
    return "rgb({},{},{})".format(*parts)


def _menu(first: str, seconds: list[str], shown: list[list[bool]]) -> dict[str, Any]:
    none = [False] * len(_LEVELS)
    buttons = []
    for j, second in enumerate(seconds):
        visible = [on for i, own in enumerate(shown) for on in (own if i == j else none)]
        label = f"{first} against {second}"
        buttons.append({"label": label, "method": "update", "args": [{"visible": visible}]})
    place = {"x": 1.0, "xanchor": "right", "y": 1.02, "yanchor": "bottom"}
    return {"buttons": buttons, "direction": "down", "showactive": True, **place}
