"""What there is to be solved, and by what."""

from __future__ import annotations

from typing import Annotated

import typer

from mgeo.cli import completion, options
from mgeo.cli.errors import bad_input
from mgeo.cli.output import Output


def problems(json: options.Json = False, debug: options.Debug = False) -> None:
    """List the installed problems."""
    from mgeo.cli.installed import list_problems

    list_problems(Output(json=json))


def algorithms(
    name: Annotated[
        str | None,
        typer.Argument(help="One of them, or MODULE:CLASS.", autocompletion=completion.algorithms),
    ] = None,
    json: options.Json = False,
    debug: options.Debug = False,
) -> None:
    """List the algorithms, or the parameters of one."""
    from mgeo.cli.installed import list_algorithms

    with bad_input():
        list_algorithms(name, Output(json=json))
