"""Tables of the documentation pages, and files of the results that they summarize, one JSON object
per line.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: Results that the validation pages show.
VALIDATION_DATA = DOCS / "validation" / "data"


def format_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table whose first column is left-aligned text and whose other columns are
    right-aligned.
    """
    alignment = ["---", *["---:"] * (len(header) - 1)]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (header, alignment, *rows))


def write_table(page: Path, name: str, table: str) -> None:
    """Replace the text between the markers of a named table on a page.

    The markers are ``<!-- begin of NAME -->`` and ``<!-- end of NAME -->``.

    Raises
    ------
    ValueError
        If the page does not have both markers.
    """
    begin, end = f"<!-- begin of {name} -->", f"<!-- end of {name} -->"
    before, begin_found, rest = page.read_text(encoding="utf-8").partition(begin)
    _, end_found, after = rest.partition(end)
    if not begin_found or not end_found:
        raise ValueError(f"{page}: expected the markers {begin} and {end}")
    page.write_text(f"{before}{begin}\n{table}\n{end}{after}", encoding="utf-8")


def read_results(path: Path) -> list[dict[str, Any]]:
    """Return the results stored in a file, as a list of dicts; empty if there is no file."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [json.loads(line) for line in lines]


def add_result(path: Path, result: dict[str, Any]) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(result) + "\n")
