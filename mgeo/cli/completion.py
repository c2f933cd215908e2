"""What a shell offers when the tabulator key is pressed; nothing is imported from plugins."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from pkgutil import resolve_name

import typer

from mgeo.plugins.discovery import installed_plugins, preset_names

_DEPTH = 3  # of folders below that in which a run is looked for

Complete = Callable[[str], list[str]]


def among(names: Iterable[str]) -> Complete:
    """Completion by fixed names."""
    return lambda incomplete: [name for name in names if name.startswith(incomplete)]


def among_those_of(table: str) -> Complete:
    """Completion by the names in a table, ``module:TABLE``, imported only then."""
    return lambda incomplete: among(resolve_name(table))(incomplete)


def problems(incomplete: str) -> list[str]:
    """Installed problems."""
    return among(plugin.name for plugin in installed_plugins())(incomplete)


def algorithms(incomplete: str) -> list[str]:
    """Algorithms, mgeo's own and installed ones."""
    return among(resolve_name("mgeo.runs.algorithms:algorithm_names")())(incomplete)


def scenarios(ctx: typer.Context, incomplete: str) -> list[str]:
    """Presets of the problem that was named, and files."""
    # an option without its value makes typer leave the arguments unread
    words = [str(ctx.params.get("problem")), *ctx.args]
    presets = among(preset for word in words for preset in preset_names(word))
    return [*presets(incomplete), *toml_files(incomplete)]


def toml_files(incomplete: str) -> list[str]:
    """TOML files, and the folders on the way to them."""
    start = incomplete.rpartition("/")[2]
    entries = [entry for entry in _below(incomplete, "*") if entry.name.startswith(start)]
    found = [f"{entry}/" if entry.is_dir() else str(entry) for entry in entries]
    return [name for name in found if name.endswith((".toml", "/"))]


def runs_with(file: str) -> Complete:
    """Completion by the folders of runs in which there is this file."""

    def complete(incomplete: str) -> list[str]:
        patterns = ["*/" * depth + file for depth in range(1, _DEPTH + 1)]
        found = [path.parent for pattern in patterns for path in _below(incomplete, pattern)]
        return among(map(str, found))(incomplete)

    return complete


def _below(incomplete: str, pattern: str) -> list[Path]:
    """What is found in the folder that is spelled out, and not hidden."""
    folder = Path("".join(incomplete.rpartition("/")[:2]))
    hidden = re.compile(r"(^|/)\.")
    found = folder.glob(pattern)
    return sorted(e for e in found if not hidden.search(e.relative_to(folder).as_posix()))
