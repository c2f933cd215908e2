"""The flag ``--scenario``: a TOML file or the name of a preset."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any


def read_scenario(text: str | None) -> dict[str, Any]:
    """Options of a problem from what was given: nothing, ``FILE.toml`` or a preset's name.

    Raises
    ------
    FileNotFoundError
        If it looks like a file and there is none.
    ValueError
        If the file is no valid TOML.
    """
    if text is None:
        return {}
    path = Path(text)
    if path.suffix != ".toml" and len(path.parts) == 1:
        return {"preset": text}
    if not path.is_file():
        raise FileNotFoundError(f"there is no scenario file {text}")
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{text} is no valid TOML: {error}") from error
