"""Options of a problem, from a scenario file or a preset's name, and a result to go on from."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from mgeo.plugins.problems import read_files
from mgeo.store.reading import parse_json, parse_toml, read_text
from mgeo.validation.entries import errors_of

#: Largest result to go on from [bytes].
MOST_BYTES = 50_000_000


def read_scenario(
    problem: str,
    text: str | None,
    folder: Path | str = "",
    after: Path | None = None,
    *,
    named: Collection[str] = (),
) -> dict[str, Any]:
    """Options of a problem from what was given: nothing, ``FILE.toml`` or a preset's name.

    A file's name is relative to `folder`; what it names itself is relative to its own folder, and
    is read by the problem, one of those `named` if that is ``module:Class`` (see
    `mgeo.plugins.problems.load_problem`). What the JSON file `after` holds becomes the option of
    this name.

    Raises
    ------
    OSError
        If it looks like a file and there is none, or `after` cannot be read.
    ValueError
        If the file is no valid TOML, or of a file that it names; or `after` is no JSON.
    """
    more: dict[str, Any] = {}
    if after is not None:
        content = read_text(after, MOST_BYTES)
        with errors_of(after):
            more = {"after": parse_json(content)}
    if text is None:
        return more
    path = Path(text)
    if path.suffix != ".toml" and len(path.parts) == 1:
        return {"preset": text, **more}
    path = Path(folder) / path
    if not path.is_file():
        raise FileNotFoundError(f"there is no scenario file {path}")
    text = read_text(path)
    with errors_of(path):
        return read_files(problem, parse_toml(text) | more, path.parent, named=named)
