"""The figures of a report as files: PNG for slides, PDF for papers."""

from __future__ import annotations

import asyncio
import itertools
import logging
import re
from collections.abc import Callable, Container, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import plotly.graph_objects as go

from mgeo.figures.motion import motion_of
from mgeo.figures.style import CLICK, HOVER, for_paper
from mgeo.plugins.shown import ask
from mgeo.plugins.view import View, view_of
from mgeo.report.build import read_subject, recorded_history
from mgeo.report.solutions import front_picture
from mgeo.validation.arguments import did_you_mean

#: Width and height [px] of figures that have no size of their own.
_SIZE = (900, 560)
_WIDTH_OF_SOLUTION = 640
_INK = "#222222"
_PIXELS = 2  # of a PNG for each of these
_PATIENCE = 60.0  # seconds for a browser to open, or to close


class StaticExportError(RuntimeError):
    """Figures cannot be drawn on this machine; the message says what it lacks."""


def static_figures(
    folder: Path | str,
    formats: Sequence[str],
    *,
    only: Sequence[str] = (),
    paper: bool = False,
    problem: str | None = None,
) -> dict[str, bytes]:
    """Files of the figures of a run, by name.

    They are the front, the hypervolume of a recorded run and, of the knee and the best solution
    of each objective, what the problem's `solution_figures` draws; figures that move are left to
    the page.

    Parameters
    ----------
    formats
        Of "png" and "pdf".
    only
        Names of figures, without their endings; none for all of them.
    paper
        As wide as a column of a paper, in its fonts, and without a title.
    problem
        As of `mgeo.report.report_html`.

    Raises
    ------
    StaticExportError
        If kaleido or a browser is missing, or the browser does not start.
    FileNotFoundError, ValueError, TypeError
        See `mgeo.report.report_html`; a ValueError also for a figure that there is not.

    Examples
    --------
    >>> from mgeo.report import static_figures
    >>> files = static_figures("runs/first", ["pdf"], paper=True)  # doctest: +SKIP
    """
    found = _pictures(Path(folder), problem)
    for name in only:
        if name not in found:
            expected = f"expected {', '.join(found)}{did_you_mean(name, found)}"
            raise ValueError(f"the run has no figure {name!r}: {expected}")
    return drawn(shaped({name: found[name] for name in only or found}, paper), formats)


def shaped(figures: Mapping[str, go.Figure], paper: bool) -> dict[str, go.Figure]:
    """Copies of figures that are looked at alone: sized, without menus and what to click."""
    shape = for_paper if paper else _sized
    return {name: shape(_still(figure)) for name, figure in figures.items()}


def drawn(figures: Mapping[str, go.Figure], formats: Sequence[str]) -> dict[str, bytes]:
    """Files of these figures, by their names and formats.

    Raises
    ------
    StaticExportError
        If kaleido or a browser is missing, or the browser does not start.
    """
    try:
        from kaleido import Kaleido
    except ImportError as error:
        needed = "kaleido 1 or newer: pip install 'mgeo[png]'"
        raise StaticExportError(f"PNG and PDF need {needed}") from error
    return asyncio.run(drawn_by(figures, formats, Kaleido))


def _pictures(folder: Path, named: str | None) -> dict[str, go.Figure]:
    run, problem, chosen, title = read_subject(folder, [named] if named else [])
    outcome = run.outcome
    found: dict[str, go.Figure | None] = {}
    view = view_of(problem, outcome.X, outcome.F)
    if chosen:
        found["front"] = front_picture(view, title)
    found["hypervolume"] = recorded_history(folder, problem, outcome)
    told = [solution for solution in chosen if solution.label != "between"]
    drawn = ask(view.take([solution.row for solution in told]), View.solution_figures)
    for solution, figures in zip(told, drawn, strict=True):
        for name, figure in figures.items():
            if motion_of(figure) is None:
                found[_file_name(found, solution.label, str(name))] = figure
    return {name: figure for name, figure in found.items() if figure is not None}


def _file_name(taken: Container[str], label: str, figure: str) -> str:
    """Words in lower case joined by dashes, whatever characters the names have."""
    name = "-".join(re.findall(r"[a-z0-9_]+", f"{label} {figure}".lower())) or "figure"
    numbered = (f"{name}-{number}" for number in itertools.count(2))
    return next(chosen for chosen in itertools.chain([name], numbered) if chosen not in taken)


def _sized(figure: go.Figure) -> go.Figure:
    width, height = _SIZE if figure.layout.height is None else (_WIDTH_OF_SOLUTION, None)
    still = go.Figure(figure).update_layout(template="plotly_white", font_color=_INK)
    return still.update_layout(width=width, height=height or figure.layout.height)


def _still(figure: go.Figure) -> go.Figure:
    """Without menus, and what its title says to whoever sees it on a screen."""
    still = go.Figure(figure)
    still.layout.updatemenus, still.layout.sliders = (), ()
    if text := still.layout.title.text:
        for words in (HOVER, CLICK):
            text = text.replace(words, "")
        still.update_layout(title_text=text)
    return still


def _is_news(record: logging.LogRecord) -> bool:
    """False for a message of the browser that cannot be read, which is passed over anyway."""
    return not record.getMessage().startswith("JSONError decoding message")


async def drawn_by(
    pictures: Mapping[str, go.Figure], formats: Sequence[str], renderer: Callable[..., Any]
) -> dict[str, bytes]:
    browser = None
    logging.getLogger("choreographer.channels.pipe").addFilter(_is_news)
    try:
        browser = renderer(mathjax=False)  # nothing from the network
        await asyncio.wait_for(browser.open(), _PATIENCE)
    except (RuntimeError, OSError) as error:  # choreographer's, or in time
        if browser is not None:
            with suppress(Exception):  # a thread of it would keep this process from ending
                await asyncio.wait_for(browser.close(), _PATIENCE)
        raise StaticExportError(
            "PNG and PDF need Chrome or Chromium, and none was found that starts: install one, run "
            "kaleido_get_chrome, or set BROWSER_PATH to one"
        ) from error
    files = {}
    try:
        for name, figure in pictures.items():
            for kind in formats:
                options = {"format": kind, "scale": _PIXELS if kind == "png" else 1}
                files[f"{name}.{kind}"] = await browser.calc_fig(figure, opts=options)
    finally:
        await browser.close()
    return files
