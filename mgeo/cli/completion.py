"""What a shell offers when the tabulator key is pressed; nothing is imported from plugins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from pkgutil import resolve_name

import typer

from mgeo.plugins.discovery import installed_plugins, preset_names

_DEPTH = 3  # of folders below that in which a run is looked for
_CHECKPOINT, _RUN = "run.checkpoint", "run.json"

Complete = Callable[[str], list[str]]


def among(names: Sequence[str]) -> Complete:
    """Completion by fixed names."""

    def complete(incomplete: str) -> list[str]:
        return [name for name in names if name.startswith(incomplete)]

    return complete


def among_those_of(table: str) -> Complete:
    """Completion by the names in a table, ``module:TABLE``, imported only then."""
    return lambda incomplete: among(list(resolve_name(table)))(incomplete)


def problems(incomplete: str) -> list[str]:
    """Installed problems."""
    return among([plugin.name for plugin in installed_plugins()])(incomplete)


def scenarios(ctx: typer.Context, incomplete: str) -> list[str]:
    """Presets of the problem that was named, and files."""
    # an option without its value makes typer leave the arguments unread
    words = [str(ctx.params.get("problem")), *ctx.args]
    presets = [preset for word in words for preset in preset_names(word)]
    return [*among(presets)(incomplete), *toml_files(incomplete)]


def toml_files(incomplete: str) -> list[str]:
    """TOML files, and the folders on the way to them."""
    folder, start = _split(incomplete)
    entries = [entry for entry in _entries(folder) if entry.name.startswith(start)]
    found = [f"{entry}/" if entry.is_dir() else str(entry) for entry in entries]
    return [name for name in found if name.endswith((".toml", "/"))]


def runs(incomplete: str) -> list[str]:
    """Folders of finished or interrupted runs."""
    return _folders_with(_RUN, incomplete)


def kept_runs(incomplete: str) -> list[str]:
    """Folders of runs that can be resumed."""
    return _folders_with(_CHECKPOINT, incomplete)


def _folders_with(name: str, incomplete: str) -> list[str]:
    folder, _ = _split(incomplete)
    found = (str(entry) for entry in _below(folder, _DEPTH) if (entry / name).is_file())
    return [entry for entry in found if entry.startswith(incomplete)]


def _below(folder: Path, depth: int) -> Iterator[Path]:
    folders = [entry for entry in _entries(folder) if entry.is_dir() and not entry.is_symlink()]
    if depth > 1:
        return chain(folders, *(_below(entry, depth - 1) for entry in folders))
    return iter(folders)


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(entry for entry in folder.iterdir() if not entry.name.startswith("."))
    except OSError:
        return []


def _split(incomplete: str) -> tuple[Path, str]:
    """The folder that is spelled out, and the beginning of a name in it."""
    folder, slash, start = incomplete.rpartition("/")
    return Path(folder + slash), start
