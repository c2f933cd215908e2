"""Command ``mgeo report``, which writes HTML reports of runs, and figures of runs and studies."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import convert_input_errors
from mgeo.terminal import Output

if TYPE_CHECKING:
    from mgeo.documents import ReportDocument

    pass

FIGURES_FOLDER = "figures"
COMPARISON_FILE = "comparison.html"


def report(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR",
            help="Folder of a run or of a study, or two runs or solution files to compare.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            rich_help_panel="Page",
            help="File to write [default: DIR/report.html, or comparison.html for two runs].",
        ),
    ] = None,
    solution: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=0,
            rich_help_panel="Page",
            help="Number of the solution that the printed page reviews [default: knee].",
        ),
    ] = None,
    png: Annotated[
        bool,
        typer.Option(
            "--png",
            rich_help_panel="Figures",
            help="Also write the figures as PNG, into figures/ next to FILE.",
        ),
    ] = False,
    pdf: Annotated[
        bool,
        typer.Option(
            "--pdf",
            rich_help_panel="Figures",
            help="Also write the figures as PDF, into figures/ next to FILE.",
        ),
    ] = False,
    figure: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel="Figures",
            help="Write only this figure, such as front, knee-rates or ranks, and no page; as PNG "
            "unless --pdf is given. Can be repeated.",
        ),
    ] = None,
    paper: Annotated[
        bool,
        typer.Option(
            "--paper",
            rich_help_panel="Figures",
            help="Write the figures as PDF for a paper: 88 mm wide, 8-point serif, no title.",
        ),
    ] = False,
    problem: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MODULE:CLASS",
            help="Class of a problem. Required if the run was made with MODULE:CLASS. Can be "
            "repeated.",
        ),
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Write an HTML report of a run or of two runs side by side, or figures for a paper.

    The page shows the configuration, the front and each solution, and loads nothing from the
    network. Printed, it is a review document of one solution. A study has a report already: the
    command writes its figures or, without options, lists their names. Figures require kaleido
    (pip install 'mgeo[png]') and Chrome or Chromium.
    """
    from mgeo.report.build import build_report_html
    from mgeo.report.compare import build_comparison_html
    from mgeo.report.static import (
        StaticExportError,
        draw_run_figures,
        export_figures,
        prepare_figures,
    )
    from mgeo.store.atomic import write_file, write_files
    from mgeo.store.run_folder import REPORT_FILE, STUDY_FILE
    from mgeo.studies.comparison_files import format_folder_names, read_comparisons
    from mgeo.studies.report import draw_study_figures

    output = Output(quiet, json)
    formats = [kind for kind, is_requested in (("png", png), ("pdf", pdf or paper)) if is_requested]
    if figure and not formats:
        formats = ["png"]
    figure_names, trusted_classes, first = figure or [], problem or [], sources[0]
    is_pair, is_study = len(sources) > 1, len(sources) == 1 and (first / STUDY_FILE).is_file()
    page, figures = "", {}
    with convert_input_errors((ValueError, TypeError, OSError, StaticExportError)):
        _check_options(sources, is_study, formats, out, solution)
        path = out or (Path(COMPARISON_FILE) if is_pair else first / REPORT_FILE)
        _check_page_path(path)
        if is_study:
            comparisons = read_comparisons(first, trusted_classes=trusted_classes)
            figures = draw_study_figures(comparisons, figure_names)
        elif is_pair:
            page = build_comparison_html(*sources, trusted_classes=trusted_classes)
        else:
            figures = (
                draw_run_figures(first, figure_names, trusted_classes=trusted_classes)
                if formats
                else {}
            )
            page = (
                ""
                if figure_names
                else build_report_html(first, solution, trusted_classes=trusted_classes)
            )
        files = export_figures(prepare_figures(figures, paper), formats)
        folder = path.parent / FIGURES_FOLDER
        if files:
            folder.mkdir(exist_ok=True)
            write_files(folder, files)
        if page:
            write_file(path, page.encode())
    output.print_title(f"Report of {' and '.join(map(str, sources))}")
    written = {str(path): f"page for any browser, {len(page) / 1e6:.1f} MB"} if page else {}
    if files:
        written[str(folder)] = (
            f"{len(figures)} figure{'s' if len(figures) > 1 else ''} as "
            f"{' and '.join(map(str.upper, formats))}"
        )
    elif is_study:
        prefixes = "|".join(f"{name}-" for name in format_folder_names(comparisons).values())
        names = dict.fromkeys(re.sub(rf"^({prefixes})", "", name) for name in figures)
        written[str(path)] = "report of the study"
        output.print_text(f"Names for --figure: {', '.join(names)}.")
        if len(comparisons) > 1:
            one = next(name for name in figures if name not in names)
            kind = re.sub(rf"^({prefixes})", "", one)
            output.print_text(f"{kind} draws all problems, {one} only one.")
    output.print_files(written)
    document: ReportDocument = {
        "file": str(path) if page or is_study else None,
        "bytes": len(page.encode()),
        "figures": [str(folder / name) for name in files],
    }
    if is_pair:
        document["compared"] = list(map(str, sources))
    else:
        document["folder"] = str(first)
    output.print_document(document)


def _check_options(
    sources: Sequence[Path],
    is_study: bool,
    formats: Sequence[str],
    out: Path | None,
    solution: int | None,
) -> None:
    if len(sources) == 1 and not sources[0].exists():
        raise FileNotFoundError(f"there is no folder {sources[0]}")
    if len(sources) > 2:
        raise ValueError(f"{len(sources)} runs: expected one run, or two runs to compare")
    if len(sources) == 2 and (formats or solution is not None):
        raise ValueError(
            "a comparison of two runs has no figure files: expected no options for figures or "
            "solutions"
        )
    if is_study and (out is not None or solution is not None):
        raise ValueError("a study already has a report: expected neither --out nor --solution")
    if len(sources) == 1 and sources[0].is_file():
        raise ValueError(f"{sources[0]} is a file: expected the folder of a run, or two solutions")


def _check_page_path(path: Path) -> None:
    """Raise an error unless an HTML page can be written to this path."""
    from mgeo.store.atomic import check_writable

    if path.suffix != ".html":
        raise ValueError(f"--out {path}: expected a name that ends in .html")
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder: expected the path of a file")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{path} cannot be written: there is no folder {path.parent}")
    check_writable(path.parent)
