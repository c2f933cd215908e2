"""All figures of a study, by name: those over problems, and those of each problem."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import plotly.graph_objects as go

from mgeo.studies.figures.attainment import difference_figure
from mgeo.studies.figures.indicators import anytime_figure
from mgeo.studies.figures.ranks import ranks_figure, targets_figure
from mgeo.studies.labels import folder_name
from mgeo.studies.pooled import friedman_over_problems, problem_values
from mgeo.studies.results import targets_reached
from mgeo.validation.arguments import did_you_mean

if TYPE_CHECKING:
    from mgeo.studies.comparison import Comparison


def study_figures(
    comparisons: Mapping[str, Comparison], only: Sequence[str] = ()
) -> dict[str, go.Figure]:
    """Figures of a study, each without a menu, under names that files can have.

    Of several problems they are ``ranks`` and ``targets``, and those of each problem by the name of
    its folder: ``zdt1-anytime``. Indicators but the first and rivals but the first have figures of
    their own: ``anytime-igd_plus``, ``difference-2``.

    Parameters
    ----------
    only : names of figures; that of a problem's figure without the problem stands for that of
        every problem. None for all.

    Raises
    ------
    ValueError
        For a figure that there is not.
    """
    found: dict[str, go.Figure] = {}
    if len(comparisons) > 1:
        every = next(iter(comparisons.values())).algorithms
        ranked = friedman_over_problems(problem_values(comparisons))
        reached = targets_reached(comparisons)
        if ranked:
            found["ranks"] = ranks_figure(ranked, every)
        if len(reached):
            found["targets"] = targets_figure(reached, len(comparisons))
    short: dict[str, list[str]] = {name: [name] for name in found}
    for label, comparison in comparisons.items():
        prefix = f"{folder_name(label)}-" if len(comparisons) > 1 else ""
        for name, figure in _problem_figures(comparison).items():
            found[f"{prefix}{name}"] = figure
            short.setdefault(name, []).append(f"{prefix}{name}")
    known = short | {name: [name] for name in found}
    for name in only:
        if name not in known:
            expected = f"expected {', '.join(short)}{did_you_mean(name, known)}"
            raise ValueError(f"the study has no figure {name!r}: {expected}")
    chosen = [full for name in only or found for full in known[name]]
    return {name: found[name] for name in dict.fromkeys(chosen)}


def _problem_figures(comparison: Comparison) -> dict[str, go.Figure]:
    figures = comparison.figures()
    for indicator in comparison.indicators[1:]:
        figures[f"anytime-{indicator.name}"] = anytime_figure(comparison, indicator.name)
    ranked = [name for name in comparison.order() if any(map(len, comparison.fronts(name)))]
    if "difference" in figures:
        figures["difference"] = difference_figure(comparison, ranked[0], ranked[1:2])
        for number, other in enumerate(ranked[2:], 2):
            figures[f"difference-{number}"] = difference_figure(comparison, ranked[0], [other])
    return figures
