"""``mgeo report``: one HTML file about a run, and figures of runs and studies as pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output

FIGURES_FOLDER = "figures"
COMPARISON_FILE = "comparison.html"


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
    problem: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MODULE:CLASS",
            help="A problem, where it is none by name: no file has a module imported; may be given "
            "several times.",
        ),
    ] = None,
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
    from mgeo.store.run_folder import STUDY_FILE

    output = Output(quiet, json)
    formats = [kind for kind, wanted in (("png", png), ("pdf", pdf or paper)) if wanted]
    if figure and not formats:
        formats = ["png"]
    only, named = figure or (), problem or []
    with bad_input():
        if len(sources) > 2:
            raise ValueError(f"{len(sources)} runs: expected one, or two to be compared")
        if len(sources) == 2 and (formats or solution is not None):
            raise ValueError("of two runs there is a page only: expected no other options")
        is_study = (sources[0] / STUDY_FILE).is_file() and len(sources) == 1
        if is_study and (out is not None or solution is not None):
            raise ValueError("of a study there are figures only: expected no --out, --solution")
        if len(sources) == 1 and not is_study and len(named) > 1:
            raise ValueError(f"--problem is given {len(named)} times: a run has one")
    if len(sources) == 2:
        _write_comparison(sources[0], sources[1], out, output, named)
    elif is_study:
        _write_study_figures(sources[0], formats, output, only, paper, named)
    else:
        _write_report(sources[0], out, formats, output, only, paper, solution, *named)


def _write_report(
    folder: Path,
    out: Path | None,
    formats: Sequence[str],
    output: Output,
    only: Sequence[str],
    paper: bool,
    solution: int | None,
    problem: str | None = None,
) -> None:
    """Write the report of a run folder, into it unless `out` is given, and pictures beside it.

    Nothing is written before all of it is made; of pictures `only` some no report is.
    """
    from mgeo.report.build import report_html
    from mgeo.report.static import StaticExportError, static_figures
    from mgeo.store.atomic import write_file
    from mgeo.store.run_folder import REPORT_FILE

    path = out or folder / REPORT_FILE
    figures = path.parent / FIGURES_FOLDER
    with bad_input((ValueError, TypeError, OSError, StaticExportError)):
        if folder.is_file():
            raise ValueError(
                f"{folder} is a file: expected the folder of a run, or two solutions' files to be "
                "set side by side"
            )
        _check_page(path, out)
        if formats:
            _check_figures(figures)
        html = b"" if only else report_html(folder, solution, problem=problem).encode()
        pictures = {}
        if formats:
            pictures = static_figures(folder, formats, only=only, paper=paper, problem=problem)
        _write(figures, pictures)
        if html:
            write_file(path, html)
    if html:
        output.print(f"written: {path} ({_size(html)})")
    if pictures:
        output.print(f"written: {figures} ({len(pictures)} files)")
    written = [str(figures / name) for name in pictures]
    output.result(
        {
            "folder": str(folder),
            "file": str(path) if html else None,
            "bytes": len(html),
            "figures": written,
        }
    )


def _write_comparison(
    one: Path, other: Path, out: Path | None, output: Output, named: Sequence[str]
) -> None:
    """Write two runs, or solutions' files, side by side, to `out` or into this folder."""
    from mgeo.report.compare import compare_html
    from mgeo.store.atomic import write_file

    path = out or Path(COMPARISON_FILE)
    with bad_input():
        _check_page(path, out)
        html = compare_html(one, other, named=named).encode()
        write_file(path, html)
    output.print(f"written: {path} ({_size(html)})")
    output.result({"compared": [str(one), str(other)], "file": str(path), "bytes": len(html)})


def _write_study_figures(
    folder: Path,
    formats: Sequence[str],
    output: Output,
    only: Sequence[str],
    paper: bool,
    named: Sequence[str],
) -> None:
    """Write figures of a study's folder as pictures into it, or, without formats, tell their names.

    It has a report already.
    """
    from mgeo.report.static import StaticExportError, drawn, shaped
    from mgeo.store.atomic import check_writable
    from mgeo.store.run_folder import REPORT_FILE
    from mgeo.studies.report import study_figures
    from mgeo.studies.stored import read_comparisons

    figures = folder / FIGURES_FOLDER
    with bad_input((ValueError, TypeError, OSError, StaticExportError)):
        found = read_comparisons(folder, named=named)
        chosen = study_figures(found, only)
        check_writable(folder)
        _check_figures(figures)
        pictures = drawn(shaped(chosen, paper), formats) if formats else {}
        _write(figures, pictures)
    report = folder / REPORT_FILE
    if pictures:
        output.print(f"written: {figures} ({len(pictures)} files)")
    else:
        output.print(f"report: {report}", f"figures, for --figure: {', '.join(chosen)}")
    written = [str(figures / name) for name in pictures]
    output.result({"folder": str(folder), "file": str(report), "bytes": 0, "figures": written})


def _check_page(path: Path, out: Path | None) -> None:
    """Refuse where no page could be written; an existing report is replaced, but nothing else."""
    from mgeo.store.atomic import check_writable

    if path.suffix != ".html":
        raise ValueError(f"--out {path}: expected a name that ends in .html")
    if out and not out.parent.is_dir():
        raise FileNotFoundError(f"--out {out}: there is no folder {out.parent}")
    if path.parent.is_dir():
        check_writable(path.parent)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder: expected a file, or none yet")


def _check_figures(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{folder} is a file: expected a folder to write figures into")


def _write(folder: Path, pictures: Mapping[str, bytes]) -> None:
    from mgeo.store.atomic import write_files

    if pictures:
        folder.mkdir(exist_ok=True)
        write_files(folder, pictures)


def _size(content: bytes) -> str:
    large = len(content) >= 1e6
    return f"{len(content) / 1e6:.1f} MB" if large else f"{len(content) / 1e3:.0f} kB"
