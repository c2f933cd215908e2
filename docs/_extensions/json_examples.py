"""Examples of JSON documents: a command is run, and a part of its output is shown."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from terminal import run_command


def show_json(command: str, *paths: str) -> None:
    """Run a command with ``--json``, and show the selected keys of its document.

    Parameters
    ----------
    command : str
        Command without ``--json``.
    *paths : str
        Keys in the notation of jq without the first dot, such as ``front[0]``.
    """
    from IPython.display import display

    document = json.loads(run_command(f"{command} --json"))
    shown = json.dumps({path: _select(document, path) for path in paths}, indent=2)
    query = ", ".join(f'"{path}": .{path}' if set(path) & set(".[") else path for path in paths)
    line = f"{command} --json | jq '{{{query}}}'"
    text = f"```sh\n{line}\n```\n\n```json\n{shown}\n```"
    display({"text/markdown": text}, raw=True)


def _select(document: Any, path: str) -> Any:
    for part in path.replace("[", ".").replace("]", "").split("."):
        document = document[int(part) if isinstance(document, list) else part]
    return _shorten(document)


def _shorten(value: Any) -> Any:
    """Return a value with the numbers rounded to five significant digits."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, Mapping):
        return {key: _shorten(each) for key, each in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_shorten(each) for each in value]
    return value
