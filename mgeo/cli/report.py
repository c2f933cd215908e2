"""``mgeo report``: one HTML file about a run."""

from __future__ import annotations

from pathlib import Path

from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output
from mgeo.files import write_file
from mgeo.report import report_html

REPORT_FILE = "report.html"


def run(folder: Path, out: Path | None, output: Output) -> None:
    """Write the report of a run folder, into it unless `out` is given."""
    path = out or folder / REPORT_FILE
    with bad_input():
        html = report_html(folder).encode()
        write_file(path, html)
    output.print(f"written: {path} ({len(html) / 1e6:.1f} MB)")
    output.result({"folder": str(folder), "file": str(path), "bytes": len(html)})
