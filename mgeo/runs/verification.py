"""Files in which a problem's own tools prove a solution of the front, see `mgeo.report`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mgeo.store.reading import read_json
from mgeo.validation import entry

VERIFICATION_FILES = "verification*.json"

#: Keys by which such a file says what it is about.
ABOUT = ("problem", "options", "design")


def check_form(found: Any) -> None:
    """Refuse what is no such file's content: see `mgeo.report.verification`.

    Raises
    ------
    ValueError, TypeError
        Naming the key.
    """
    for key in ("title", "conclusion"):
        entry(found, key, str)
    n = len(entry(found, "columns", list[str]))
    for i, row in enumerate(entry(found, "rows", list)):
        kept = isinstance(row, list) and len(row) == n
        if not (kept and all(isinstance(cell, str | int | float) for cell in row)):
            raise ValueError(f"rows[{i}] = {row!r:.80}: expected {n} numbers or strings")


def remove_verifications(folder: Path) -> None:
    """Remove those of the run before; a file of such a name that is none is somebody's own."""
    for path in folder.glob(VERIFICATION_FILES):
        try:
            found = read_json(path)
            check_form(found)
        except (OSError, ValueError, TypeError):
            continue
        if set(ABOUT) <= found.keys():
            path.unlink(missing_ok=True)
