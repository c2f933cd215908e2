"""Scenarios as a user names them: a TOML file or the name of a preset."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mgeo.files.reading import errors_of, parse_toml, read_text
from mgeo.plugins.discovery import read_files


def read_scenario(problem: str, text: str | None, folder: Path | str = "") -> dict[str, Any]:
    """Options of a problem from what was given: nothing, ``FILE.toml`` or a preset's name.

    A file's name is relative to `folder`; what it names itself is relative to its own folder, and
    is read by the problem.

    Raises
    ------
    FileNotFoundError
        If it looks like a file and there is none.
    ValueError
        If the file is no valid TOML, or of a file that it names.
    """
    if text is None:
        return {}
    path = Path(text)
    if path.suffix != ".toml" and len(path.parts) == 1:
        return {"preset": text}
    path = Path(folder) / path
    if not path.is_file():
        raise FileNotFoundError(f"there is no scenario file {path}")
    text = read_text(path)
    with errors_of(path):
        return read_files(problem, parse_toml(text), path.parent)
