"""Options shared by several commands, and shell completion of their values.

Completion imports no plugins. The shell completes the names of files and folders.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from pkgutil import resolve_name
from typing import Annotated, Any

import typer

from mgeo.cli.help_text import GENERAL_OPTIONS
from mgeo.plugins.discovery import list_plugins, list_preset_names
from mgeo.terminal import reserve_stdout


def complete_from(names: Iterable[str]) -> Callable[[], list[str]]:
    """Return a shell-completion callback that suggests the given names."""
    return lambda: list(names)


def complete_problems() -> list[str]:
    """Return the names of the installed problems, for shell completion."""
    return [plugin.name for plugin in list_plugins()]


def complete_algorithms() -> list[str]:
    """Return the names of the algorithms, for shell completion."""
    names: list[str] = resolve_name("mgeo.runs.algorithms:list_algorithms")()
    return names


def complete_scenarios(ctx: typer.Context) -> list[str]:
    """Return the presets of the problem on the command line, for shell completion.

    Parameters
    ----------
    ctx
        Context of the command line that the shell completes.
    """
    # typer does not parse the arguments before an option that still lacks its value.
    words = [str(ctx.params.get("problem")), *ctx.args]
    return [preset for word in words for preset in list_preset_names(word)]


def _reserve_stdout_for_json(ctx: typer.Context, is_requested: bool) -> bool:
    if is_requested and not ctx.resilient_parsing:
        ctx.find_root().with_resource(reserve_stdout())
    return is_requested


RunFolder = Annotated[
    Path, typer.Argument(metavar="DIR", help="Folder that `mgeo solve` has written.")
]
Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", rich_help_panel=GENERAL_OPTIONS, help="Print errors only."),
]
Json = Annotated[
    bool,
    typer.Option(
        "--json",
        callback=_reserve_stdout_for_json,
        rich_help_panel=GENERAL_OPTIONS,
        help="Print the result as one JSON document on stdout, and all other output on stderr.",
    ),
]
Debug = Annotated[
    bool,
    typer.Option(
        "--debug", rich_help_panel=GENERAL_OPTIONS, help="Print the traceback of an error."
    ),
]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run",
        rich_help_panel="Output",
        help="Check the input, and print what would be computed and written, without running.",
    ),
]

Problem = Annotated[
    str | None,
    typer.Option(
        metavar="MODULE:CLASS",
        help="Class of the problem. Required if the run was made with MODULE:CLASS.",
    ),
]
Walkers = Annotated[
    int | None,
    typer.Option(
        "--walkers",
        metavar="N",
        rich_help_panel="Search",
        help="Number of walkers, the parallel search trajectories of the MGEO family; the same as "
        "--set n_walkers=N.",
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        rich_help_panel="Search",
        help="Parameter of the algorithm, such as tau=2 or population=50. Can be repeated. "
        "`mgeo algorithms NAME` lists the parameters.",
    ),
]


def parse_parameters(settings: Iterable[str]) -> dict[str, Any]:
    """Convert ``--set NAME=VALUE`` options to a dict of algorithm parameters.

    Returns
    -------
    dict
        Values by name; a value is an integer, a float, a boolean, a string, or a list of these.

    Raises
    ------
    ValueError
        If an option does not have the form NAME=VALUE.
    """
    parameters = {}
    for setting in settings:
        name, _, value = setting.partition("=")
        if not (name and value):
            raise ValueError(f"--set {setting}: expected NAME=VALUE")
        parameters[name] = _parse_value(value)
    return parameters


def _parse_value(text: str) -> Any:
    """Parse an integer, float, boolean or string, or a comma-separated list of these."""
    if "," in text:
        return [_parse_value(entry) for entry in text.split(",")]
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text
