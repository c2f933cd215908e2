"""The command ``mgeo``, which commands it has of its own, and what versions it finds installed."""

from __future__ import annotations

import os
import re
import textwrap
import warnings
from collections.abc import Iterator
from importlib import metadata
from typing import Annotated, Any

import typer

from mgeo.cli import explore, installed, new, report, runs, study
from mgeo.cli.commands import RootCommands, epilog
from mgeo.cli.errors import ExitCode
from mgeo.plugins.discovery import ALGORITHMS, COMMANDS, PROBLEMS, entry_points

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def versions() -> dict[str, str]:
    """Versions by name: of mgeo, of its plugins, of Python, and of what all of these require."""
    import platform

    plugins = {
        entry.dist.name
        for group in (PROBLEMS, ALGORITHMS, COMMANDS)
        for entry in entry_points(group)
        if entry.dist
    }
    own = ["mgeo", *sorted(plugins)]
    needed = {name for package in own for name in _required(package)} - {*own}
    found = {name: metadata.version(name) for name in own}
    found["python"] = platform.python_version()
    return found | {name: metadata.version(name) for name in sorted(needed)}


def _required(package: str) -> list[str]:
    """Names of what a package cannot do without: what an extra or a platform adds is left out."""
    lines = [line for line in metadata.requires(package) or () if ";" not in line]
    return [match[0].lower() for line in lines if (match := _NAME.match(line))]


def _exit_codes() -> Iterator[str]:
    for code in ExitCode:
        lines = textwrap.wrap(code.meaning, 66)
        yield from (
            f"{c:>5}  {line}" for c, line in zip([code.value, *[""] * 9], lines, strict=False)
        )


app = typer.Typer(
    name="mgeo",
    cls=RootCommands,
    help="Multiobjective generalized extremal optimization of installed problems.",
    epilog="\n".join(["\b", "Exit codes:", *_exit_codes()]),
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["--help", "-h"]},
)
app.add_typer(new.app, name="new")


def main() -> None:
    """Entry point of the command ``mgeo``; what will go of a file's keys is told, each once."""
    shown, told = warnings.showwarning, set[str]()

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if not issubclass(category, FutureWarning):
            shown(message, category, *where, **more)
        elif str(message) not in told:
            told.add(str(message))
            typer.echo(f"Note: {message}", err=True)

    warnings.showwarning = show
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        for name, number in versions().items():
            typer.echo(f"{name} {number}")
        raise typer.Exit


@app.callback()
def _root(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the versions of mgeo, its plugins and what they need, and exit.",
        ),
    ] = False,
    no_color: Annotated[
        bool, typer.Option("--no-color", help="No colors, as with NO_COLOR in the environment.")
    ] = False,
) -> None:
    if no_color:
        os.environ["NO_COLOR"] = "1"


for _command in (
    runs.solve,
    runs.resume,
    report.report,
    explore.explore,
    installed.problems,
    installed.algorithms,
    study.study,
    study.schema,
):
    app.command(epilog=epilog(_command.__name__))(_command)
