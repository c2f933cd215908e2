"""``mgeo report``: one HTML file about a run, and figures of runs and studies as pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output
from mgeo.report import StaticExportError, compare_html, report_html, static_figures
from mgeo.report.static import drawn, shaped
from mgeo.store.atomic import check_writable, write_file, write_files
from mgeo.store.run_folder import STUDY_FILE

REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"
COMPARISON_FILE = "comparison.html"


def write_report(
    folder: Path,
    out: Path | None,
    formats: Sequence[str],
    output: Output,
    *,
    only: Sequence[str] = (),
    paper: bool = False,
    solution: int | None = None,
    problem: str | None = None,
) -> None:
    """Write the report of a run folder, into it unless `out` is given, and pictures beside it.

    Nothing is written before all of it is made.

    Parameters
    ----------
    formats
        Of the pictures: "png", "pdf", both or none.
    only
        Names of the pictures to write; then no report is written.
    paper, problem
        See `mgeo.report.static_figures`.
    solution
        Number of the one to be reviewed.
    """
    path = out or folder / REPORT_FILE
    figures = path.parent / FIGURES_FOLDER
    with bad_input((ValueError, TypeError, OSError, StaticExportError)):
        if folder.is_file():
            raise ValueError(
                f"{folder} is a file: expected the folder of a run, or two solutions' files to be "
                "set side by side"
            )
        _check_page(path, out)
        if formats and figures.exists() and not figures.is_dir():
            raise FileExistsError(f"{figures} is a file: expected a folder to write figures into")
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


def write_comparison(one: Path, other: Path, out: Path | None, output: Output) -> None:
    """Write two runs, or solutions' files, side by side, to `out` or into this folder."""
    path = out or Path(COMPARISON_FILE)
    with bad_input((ValueError, TypeError, OSError)):
        _check_page(path, out)
        html = compare_html(one, other).encode()
        write_file(path, html)
    output.print(f"written: {path} ({_size(html)})")
    output.result({"compared": [str(one), str(other)], "file": str(path), "bytes": len(html)})


def _size(content: bytes) -> str:
    large = len(content) >= 1e6
    return f"{len(content) / 1e6:.1f} MB" if large else f"{len(content) / 1e3:.0f} kB"


def _check_page(path: Path, out: Path | None) -> None:
    """Refuse where no page could be written; an existing report is replaced, but nothing else."""
    if path.suffix != ".html":
        raise ValueError(f"--out {path}: expected a name that ends in .html")
    if out and not out.parent.is_dir():
        raise FileNotFoundError(f"--out {out}: there is no folder {out.parent}")
    if path.parent.is_dir():
        check_writable(path.parent)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder: expected a file, or none yet")


def is_study(folder: Path) -> bool:
    """Whether a folder is that of a study, which has a report already."""
    return (folder / STUDY_FILE).is_file()


def write_study_figures(
    folder: Path,
    formats: Sequence[str],
    output: Output,
    *,
    only: Sequence[str] = (),
    paper: bool = False,
    problem: str | None = None,
) -> None:
    """Write figures of a study's folder as pictures into it, or, without formats, tell their names.

    Parameters
    ----------
    formats, only, paper
        As of `write_report`.
    problem
        One that may be imported, ``module:Class``.
    """
    from mgeo.studies import read_comparisons
    from mgeo.studies.report import study_figures
    from mgeo.studies.study import REPORT

    figures = folder / FIGURES_FOLDER
    with bad_input((ValueError, TypeError, OSError, StaticExportError)):
        found = read_comparisons(folder, named=[problem] if problem else [])
        chosen = study_figures(found, only)
        check_writable(folder)
        if figures.exists() and not figures.is_dir():
            raise FileExistsError(f"{figures} is a file: expected a folder to write figures into")
        pictures = drawn(shaped(chosen, paper), formats) if formats else {}
        _write(figures, pictures)
    if pictures:
        output.print(f"written: {figures} ({len(pictures)} files)")
    else:
        output.print(f"report: {folder / REPORT}", f"figures, for --figure: {', '.join(chosen)}")
    written = [str(figures / name) for name in pictures]
    output.result(
        {"folder": str(folder), "file": str(folder / REPORT), "bytes": 0, "figures": written}
    )


def _write(folder: Path, pictures: Mapping[str, bytes]) -> None:
    if pictures:
        folder.mkdir(exist_ok=True)
        write_files(folder, pictures)
