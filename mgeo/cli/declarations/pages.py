"""A run or a study is looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output


def report(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR [DIR]",
            help="Folder of a run, or of a study; two runs, or two solutions' files, are set side "
            "by side.",
            autocompletion=options.runs_with("run.json"),
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="File to write [default: DIR/report.html, of two comparison.html]."
        ),
    ] = None,
    solution: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, help="Solution to be reviewed [default: the knee]."),
    ] = None,
    png: Annotated[
        bool, typer.Option("--png", help="Also write the figures as PNG, into figures beside FILE.")
    ] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Also write the figures as PDF, into figures beside FILE.")
    ] = False,
    figure: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Write only this figure, such as front, knee-rates or ranks, as PNG unless --pdf "
            "is given; may be given several times. No report is written.",
        ),
    ] = None,
    paper: Annotated[
        bool,
        typer.Option(
            "--paper", help="Figures for a paper: 88 mm wide, 8-point serif, no title, as PDF."
        ),
    ] = False,
    problem: options.Problem = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Write one HTML file about a run, to be attached to a review.

    It shows what was run, the front and the plan of each of its points, and opens without a
    network. Printed, it is a document for a review of one solution. Pictures are of the front, the
    hypervolume, and the knee and the best solutions; they need kaleido (pip install 'mgeo[png]')
    and Chrome or Chromium. A study has its report already: of it only figures are written, and
    without an option their names are told.
    """
    from mgeo.cli.report import is_study, write_comparison, write_report, write_study_figures

    output = Output(quiet, json)
    if len(sources) > 1:
        with bad_input():
            if len(sources) > 2:
                raise ValueError(f"{len(sources)} runs: expected one, or two to be compared")
            if png or pdf or figure or paper or solution is not None:
                raise ValueError("of two runs there is a page only: expected no other options")
        write_comparison(sources[0], sources[1], out, output)
        return
    formats = [kind for kind, wanted in (("png", png), ("pdf", pdf or paper)) if wanted]
    if figure and not formats:
        formats = ["png"]
    (folder,) = sources
    only = figure or ()
    if is_study(folder):
        with bad_input():
            if out is not None or solution is not None:
                raise ValueError("of a study there are figures only: expected no --out, --solution")
        write_study_figures(folder, formats, output, only=only, paper=paper, problem=problem)
    else:
        write_report(
            folder,
            out,
            formats,
            output,
            only=only,
            paper=paper,
            solution=solution,
            problem=problem,
        )


def explore(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR",
            help="Folder of a run.",
            autocompletion=options.runs_with("run.json"),
        ),
    ],
    save: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR|FILE.json",
            help="Where the page may write solutions: into a folder, or only this file "
            "[default: DIR].",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port on 127.0.0.1; 0 for any that is free.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
    problem: options.Problem = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Explore a run on a page: filter, choose and change solutions, and save them.

    Changed variables are evaluated while a slider moves. The page is served to this machine alone,
    under an address that nobody can guess, until Ctrl-C.
    """
    from mgeo.cli.explore import serve

    serve(folder, Output(quiet, json), save=save, port=port, browser=browser, problem=problem)
