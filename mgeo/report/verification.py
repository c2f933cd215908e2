"""Monte Carlo results that a problem's own tools leave in a run folder.

Each is a file ``verification*.json``: an object with the strings ``title`` and ``verdict``, and a
table as ``columns``, a list of strings, and ``rows``, lists of as many numbers or strings.
"""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from mgeo.reading import read_json
from mgeo.report import summary

PATTERN = "verification*.json"

_NONE = f"<p>There is none: no file <code>{PATTERN}</code> in the run folder.</p>"


def verification(folder: Path) -> str:
    """All results of a folder as HTML, in the order of their names; every text is escaped.

    Raises
    ------
    ValueError
        For a file of another form, naming it.
    """
    return "".join(_one(path) for path in sorted(folder.glob(PATTERN))) or _NONE


def _one(path: Path) -> str:
    found = read_json(path)
    if not _well_formed(found):
        raise ValueError(
            f"{path}: expected an object with strings title and verdict, a list of strings columns "
            "and rows of as many numbers or strings"
        )
    table = summary.table(found["columns"], found["rows"])
    return (
        f"<h3>{escape(found['title'])}</h3><p><b>{escape(found['verdict'])}</b> "
        f"<span class=note>({escape(path.name)})</span></p>{table}"
    )


def _well_formed(found: Any) -> bool:
    if not isinstance(found, dict):
        return False
    columns, rows = found.get("columns"), found.get("rows")
    return (
        all(isinstance(found.get(key), str) for key in ("title", "verdict"))
        and isinstance(columns, list)
        and all(isinstance(name, str) for name in columns)
        and isinstance(rows, list)
        and all(
            isinstance(row, list)
            and len(row) == len(columns)
            and all(isinstance(cell, str | int | float) for cell in row)
            for row in rows
        )
    )
