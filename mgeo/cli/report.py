"""``mgeo report``: one HTML file about a run, and its figures as pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output
from mgeo.report import StaticExportError, report_html, static_figures
from mgeo.store.atomic import check_writable, write_file, write_files

REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"


def write_report(
    folder: Path,
    out: Path | None,
    formats: Sequence[str],
    output: Output,
    *,
    only: Sequence[str] = (),
    paper: bool = False,
) -> None:
    """Write the report of a run folder, into it unless `out` is given, and pictures beside it.

    Nothing is written before all of it is made.

    Parameters
    ----------
    formats
        Of the pictures: "png", "pdf", both or none.
    only
        Names of the pictures to write; then no report is written.
    paper
        See `mgeo.report.static_figures`.
    """
    path = out or folder / REPORT_FILE
    figures = path.parent / FIGURES_FOLDER
    with bad_input((ValueError, TypeError, OSError, StaticExportError)):
        if path.suffix != ".html":  # an existing report is replaced, but nothing else
            raise ValueError(f"--out {path}: expected a name that ends in .html")
        if out and not out.parent.is_dir():
            raise FileNotFoundError(f"--out {out}: there is no folder {out.parent}")
        if path.parent.is_dir():
            check_writable(path.parent)
        if path.is_dir():
            raise IsADirectoryError(f"{path} is a folder: expected a file, or none yet")
        if formats and figures.exists() and not figures.is_dir():
            raise FileExistsError(f"{figures} is a file: expected a folder to write figures into")
        html = b"" if only else report_html(folder).encode()
        pictures = static_figures(folder, formats, only=only, paper=paper) if formats else {}
        if pictures:
            figures.mkdir(exist_ok=True)
            write_files(figures, pictures)
        if html:
            write_file(path, html)
    if html:
        output.print(f"written: {path} ({len(html) / 1e6:.1f} MB)")
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
