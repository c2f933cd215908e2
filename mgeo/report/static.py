"""Figures of runs and studies as PNG and PDF files."""

from __future__ import annotations

import asyncio
import itertools
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import plotly.graph_objects as go

from mgeo.figures.motion import get_motion
from mgeo.figures.style import CLICK_HINT, HOVER_HINT, format_for_print
from mgeo.plugins.protocol import call_optional
from mgeo.plugins.view import View
from mgeo.report.history import draw_hypervolume_history
from mgeo.report.loaded_run import load_run
from mgeo.report.solutions import draw_front
from mgeo.validation.arguments import format_suggestion

#: Default width and height of a figure [px].
_DEFAULT_SIZE = (900, 560)
_SOLUTION_WIDTH = 640
_TEXT_COLOR = "#222222"
_PNG_SCALE = 2  # resolution of a PNG relative to the figure's size


class StaticExportError(RuntimeError):
    """Raised if figures cannot be exported, because kaleido or a working browser is missing."""


def draw_run_figures(
    folder: Path | str, names: Sequence[str] = (), *, trusted_classes: Collection[str] = ()
) -> dict[str, go.Figure]:
    """Return the static figures of a run as a dict keyed by figure name.

    The figures are the front, the hypervolume of a recorded run, and the ``solution_figures`` that
    the problem draws of the knee and of the best solution of each objective. Animated figures are
    omitted.

    Parameters
    ----------
    folder
        Run folder.
    names
        Names of the figures to return. Default: all.
    trusted_classes
        Problem classes whose modules may be imported, see `mgeo.report.build_report_html`.

    Raises
    ------
    ValueError
        If the run has no figure of a requested name.
    FileNotFoundError, TypeError
        See `mgeo.report.build_report_html`.
    """
    loaded = load_run(Path(folder), trusted_classes)
    front = draw_front(loaded.view, loaded.title) if loaded.representatives else None
    history = draw_hypervolume_history(Path(folder), loaded.problem, loaded.run.outcome)
    figures_by_name = {"front": front, "hypervolume": history}
    labeled = [solution for solution in loaded.representatives if solution.label != "intermediate"]
    figures_of_solutions = call_optional(
        loaded.view.select([solution.row for solution in labeled]), View.solution_figures
    )
    for solution, figures in zip(labeled, figures_of_solutions, strict=True):
        for name, figure in figures.items():
            if get_motion(figure) is None:
                figures_by_name[_build_figure_name(solution.label, str(name))] = figure
    available = {name: figure for name, figure in figures_by_name.items() if figure is not None}
    for name in names:
        if name not in available:
            raise ValueError(
                f"the run has no figure {name!r}: expected a name such as "
                f"{', '.join(list(available)[:3])}{format_suggestion(name, available)}"
            )
    return {name: available[name] for name in names or available}


def prepare_figures(figures: Mapping[str, go.Figure], paper: bool) -> dict[str, go.Figure]:
    """Prepare copies of figures for export: set their size, and remove interactive controls.

    Parameters
    ----------
    figures
        Figures by name.
    paper
        Whether to use the style for publications, see `mgeo.figures.style.format_for_print`.
    """
    set_format = format_for_print if paper else _set_size
    return {name: set_format(_remove_controls(figure)) for name, figure in figures.items()}


def export_figures(figures: Mapping[str, go.Figure], formats: Sequence[str]) -> dict[str, bytes]:
    """Render figures as PNG or PDF files.

    Return a dict that maps file names to contents.

    Parameters
    ----------
    figures
        Figures by name.
    formats
        File formats, "png" or "pdf"; one file per figure and format.

    Raises
    ------
    StaticExportError
        If kaleido or a browser is missing, or the browser does not start.
    """
    if not formats:
        return {}
    try:
        from kaleido import Kaleido
    except ImportError as error:
        raise StaticExportError(
            "PNG and PDF files require kaleido: pip install 'mgeo[png]'"
        ) from error

    async def draw() -> dict[str, bytes]:
        files = {}
        async with Kaleido(mathjax=False) as browser:  # Loading MathJax needs the network.
            for (name, figure), kind in itertools.product(figures.items(), formats):
                options = {"format": kind, "scale": _PNG_SCALE if kind == "png" else 1}
                files[f"{name}.{kind}"] = await browser.calc_fig(figure, opts=options)
        return files

    try:
        return asyncio.run(draw())
    except (RuntimeError, OSError) as error:
        raise StaticExportError(
            "PNG and PDF files need Chrome or Chromium, but neither was found or could be started "
            f"({type(error).__name__}): install one, run kaleido_get_chrome, or set BROWSER_PATH"
        ) from error


def _build_figure_name(label: str, figure: str) -> str:
    """Return the name of a solution figure in lower case with hyphens, such as ``knee-rates``."""
    return "-".join(re.findall(r"[a-z0-9_]+", f"{label} {figure}".lower()))


def _set_size(figure: go.Figure) -> go.Figure:
    width, height = _DEFAULT_SIZE if figure.layout.height is None else (_SOLUTION_WIDTH, None)
    sized = go.Figure(figure).update_layout(template="plotly_white", font_color=_TEXT_COLOR)
    return sized.update_layout(width=width, height=height or figure.layout.height)


def _remove_controls(figure: go.Figure) -> go.Figure:
    """Return a copy of a figure without menus, sliders or hints about interaction."""
    still = go.Figure(figure)
    still.layout.updatemenus, still.layout.sliders = (), ()
    if text := still.layout.title.text:
        for hint in (HOVER_HINT, CLICK_HINT):
            text = text.replace(hint, "")
        still.update_layout(title_text=text)
    return still
