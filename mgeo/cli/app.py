"""The command ``mgeo``, and which commands it has of its own."""

from __future__ import annotations

import os
import textwrap
import warnings
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from mgeo.cli import new
from mgeo.cli.commands import RootCommands
from mgeo.cli.declarations import installed, pages, runs, studies
from mgeo.cli.errors import ExitCode
from mgeo.cli.examples import epilog


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
        from mgeo.cli.versions import versions

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
    pages.report,
    pages.explore,
    installed.problems,
    installed.algorithms,
    studies.study,
    studies.schema,
):
    app.command(epilog=epilog(_command.__name__))(_command)
