"""Flags that several commands share, and the names that complete their values.

Completion imports nothing from plugins. The shell itself completes names of files and folders.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from pkgutil import resolve_name
from typing import Annotated, Any

import typer

from mgeo.cli.output import reserve
from mgeo.plugins.discovery import installed_plugins, preset_names


def among(names: Iterable[str]) -> Callable[[], list[str]]:
    """Return a completion of fixed names."""
    return lambda: list(names)


def problems() -> list[str]:
    """Return the names of the installed problems."""
    return [plugin.name for plugin in installed_plugins()]


def algorithms() -> list[str]:
    """Return the names of the algorithms."""
    names: list[str] = resolve_name("mgeo.runs.algorithms:algorithm_names")()
    return names


def scenarios(ctx: typer.Context) -> list[str]:
    """Return the presets of the problem on the command line; the shell completes files."""
    # an option without its value makes typer leave the arguments unread
    words = [str(ctx.params.get("problem")), *ctx.args]
    return [preset for word in words for preset in preset_names(word)]


RunFolder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the run.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Json = Annotated[
    bool,
    typer.Option(
        "--json",
        callback=reserve,
        help="Print the result as one JSON document, for scripts; on stdout there is nothing else.",
    ),
]
Debug = Annotated[
    bool,
    typer.Option("--debug", help="Show the traceback of an error."),
]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run",
        help="Print the size of the run and the files it would write, and do nothing.",
    ),
]

Problem = Annotated[
    str | None,
    typer.Option(
        metavar="MODULE:CLASS",
        help="The problem, where it is none by name: no file has a module imported.",
    ),
]
Sigma = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER[,NUMBER...]",
        help="Standard deviation of steps, one for all variables or one for each.",
    ),
]
Tau = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER|NAME",
        help="Selection pressure; a name lets it follow the search.",
        autocompletion=lambda: list(resolve_name("mgeo.algorithms.selection:RULES")),
    ),
]
Walkers = Annotated[int | None, typer.Option("--walkers", "--runs", help="Number of walkers.")]
Perturbation = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="What sigma is a multiple of.",
        autocompletion=lambda: list(resolve_name("mgeo.algorithms.steps:SCALES")),
    ),
]
Population = Annotated[int | None, typer.Option(help="Population size, of pymoo's algorithms.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Any other parameter of the algorithm, such as bits=12 or restart=archive; may be "
        "given several times.",
    ),
]


def parse_parameters(flags: Mapping[str, Any], settings: Sequence[str]) -> dict[str, Any]:
    """Return the parameters of an algorithm from its flags and from NAME=VALUE texts.

    Parameters
    ----------
    flags
        Values by parameter, None where a flag is not given.

    Raises
    ------
    ValueError
        If a text is not of this form.
    """
    given = {key: value for key, value in flags.items() if value is not None}
    for setting in settings:
        name, _, value = setting.partition("=")
        if not (name and value):
            raise ValueError(f"--set {setting}: expected NAME=VALUE")
        given[name] = value
    return {key: _value(value) for key, value in given.items()}


def _value(given: Any) -> Any:
    """Return the integer, float, boolean or word in a text, or a list where there are commas."""
    if not isinstance(given, str):
        return given
    if "," in given:
        return [_value(entry) for entry in given.split(",")]
    if given.lower() in ("true", "false"):
        return given.lower() == "true"
    for kind in (int, float):
        with suppress(ValueError):
            return kind(given)
    return given
