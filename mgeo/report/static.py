"""Figures of a report as files: PNG for slides, PDF for publications."""

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
from mgeo.validation.arguments import validate_choice

#: Default width and height of a figure [px].
_DEFAULT_SIZE = (900, 560)
_SOLUTION_WIDTH = 640
_TEXT_COLOR = "#222222"
_PNG_SCALE = 2  # resolution of a PNG relative to the figure's size


class StaticExportError(RuntimeError):
    """Error raised if figures cannot be written, because kaleido or a browser is missing."""


def draw_run_figures(
    folder: Path | str, names: Sequence[str] = (), *, trusted_classes: Collection[str] = ()
) -> dict[str, go.Figure]:
    """Return the figures of a run by name.

    These are the front, the hypervolume of a recorded run, and the problem's `solution_figures` of
    the knee and of the best solution of each objective, without animated figures.

    Parameters
    ----------
    folder
        Run folder.
    names
        Names of figures. Default: all.
    trusted_classes
        Problems ``module:Class`` whose modules may be imported, see `mgeo.report.report_html`.

    Raises
    ------
    ValueError
        If there is no figure of a name.
    FileNotFoundError, TypeError
        See `mgeo.report.report_html`.
    """
    shown = load_run(Path(folder), trusted_classes)
    front = draw_front(shown.view, shown.title) if shown.representatives else None
    history = draw_hypervolume_history(Path(folder), shown.problem, shown.run.outcome)
    figures_by_name = {"front": front, "hypervolume": history}
    labeled = [solution for solution in shown.representatives if solution.label != "between"]
    each = call_optional(
        shown.view.select([solution.row for solution in labeled]), View.solution_figures
    )
    for solution, figures in zip(labeled, each, strict=True):
        for name, figure in figures.items():
            if get_motion(figure) is None:
                figures_by_name[_join_words(solution.label, str(name))] = figure
    available = {name: figure for name, figure in figures_by_name.items() if figure is not None}
    for name in names:
        validate_choice("figure", name, available)
    return {name: available[name] for name in names or available}


def prepare_figures(figures: Mapping[str, go.Figure], paper: bool) -> dict[str, go.Figure]:
    """Return copies of figures for files: with a size, without menus and interactive hints.

    Parameters
    ----------
    figures
        Figures by name.
    paper
        Whether to use the style for publications, see `mgeo.figures.style.for_paper`.
    """
    shape = format_for_print if paper else _set_size
    return {name: shape(_remove_controls(figure)) for name, figure in figures.items()}


def export_figures(figures: Mapping[str, go.Figure], formats: Sequence[str]) -> dict[str, bytes]:
    """Return the contents of the figure files, by file name.

    Parameters
    ----------
    figures
        Figures by name.
    formats
        File formats, "png" or "pdf".

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
        raise StaticExportError("PNG and PDF need kaleido: pip install 'mgeo[png]'") from error

    async def draw() -> dict[str, bytes]:
        files = {}
        async with Kaleido(mathjax=False) as browser:  # MathJax would be loaded from the network.
            for (name, figure), kind in itertools.product(figures.items(), formats):
                options = {"format": kind, "scale": _PNG_SCALE if kind == "png" else 1}
                files[f"{name}.{kind}"] = await browser.calc_fig(figure, opts=options)
        return files

    try:
        return asyncio.run(draw())
    except (RuntimeError, OSError) as error:
        raise StaticExportError(
            "PNG and PDF need Chrome or Chromium, and no working one was found: install one, run "
            f"kaleido_get_chrome, or set BROWSER_PATH to one ({type(error).__name__})"
        ) from error


def _join_words(label: str, figure: str) -> str:
    """Return the lower-case words of both texts, joined by hyphens."""
    return "-".join(re.findall(r"[a-z0-9_]+", f"{label} {figure}".lower()))


def _set_size(figure: go.Figure) -> go.Figure:
    width, height = _DEFAULT_SIZE if figure.layout.height is None else (_SOLUTION_WIDTH, None)
    still = go.Figure(figure).update_layout(template="plotly_white", font_color=_TEXT_COLOR)
    return still.update_layout(width=width, height=height or figure.layout.height)


def _remove_controls(figure: go.Figure) -> go.Figure:
    """Return a copy without menus, and without the hints for interactive use in its title."""
    still = go.Figure(figure)
    still.layout.updatemenus, still.layout.sliders = (), ()
    if text := still.layout.title.text:
        for words in (HOVER_HINT, CLICK_HINT):
            text = text.replace(words, "")
        still.update_layout(title_text=text)
    return still
