"""``mgeo report``: one HTML file about a run."""

from __future__ import annotations

from pathlib import Path

from rich.text import Text

from mgeo.cli.consoles import console
from mgeo.cli.errors import one_line_errors
from mgeo.files import write_file
from mgeo.report import report_html

REPORT_FILE = "report.html"


def run(folder: Path, *, out: Path | None, quiet: bool, debug: bool) -> None:
    """Write the report of a run folder, into it unless `out` is given."""
    path = out or folder / REPORT_FILE
    with one_line_errors(debug):
        html = report_html(folder).encode()
        write_file(path, html)
    if not quiet:
        console().print(Text(f"written: {path} ({len(html) / 1e6:.1f} MB)"), soft_wrap=True)
