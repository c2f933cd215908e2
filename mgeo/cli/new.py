"""``mgeo new``: packages to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.commands import Commands, epilog
from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output

app = typer.Typer(
    cls=Commands, help="Write a package to begin with.", rich_markup_mode=None, epilog=epilog("new")
)


@app.callback()
def _new() -> None:
    """A group of commands, though there is but one."""


@app.command(epilog=epilog("new"))
def problem(
    name: Annotated[
        str, typer.Argument(help="What the problem is called, in lower case: my-beam.")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="New folder to write [default: NAME].")
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Write a problem of your own: a package with problem, view, test and README.

    It is complete, a cantilever that is to be light or stiff, installs, passes its tests and is
    solved by its name; change it into yours file by file.
    """
    from mgeo.new import write_problem

    output = Output(quiet, json)
    with bad_input():
        files = write_problem(name, out)
    folder = out or Path(name)
    output.print(*(f"written: {file}" for file in files))
    output.print(f"next: pip install -e {folder}, then mgeo solve {name} --evaluations 6000")
    output.result({"folder": str(folder), "files": [str(file) for file in files]})
