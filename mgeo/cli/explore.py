"""``mgeo explore``: a run as a page on this machine, until Ctrl-C."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import Terminated, bad_input
from mgeo.cli.output import Output


def explore(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR",
            help="Folder of a run.",
            autocompletion=options.runs_with("run.json"),
        ),
    ],
    save: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR|FILE.json",
            help="Where the page may write solutions: into a folder, or only this file "
            "[default: DIR].",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port on 127.0.0.1; 0 for any that is free.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
    problem: options.Problem = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Explore a run on a page: filter, choose and change solutions, and save them.

    Changed variables are evaluated while a slider moves. The page is served to this machine alone,
    under an address that nobody can guess, until Ctrl-C.
    """
    from mgeo.explore.explorer import Explorer
    from mgeo.explore.server import ExplorerServer

    output = Output(quiet, json)
    with bad_input():
        server = ExplorerServer(Explorer(folder, save=save, problem=problem), port)
    with server:
        output.print(server.url, "open on this machine only; Ctrl-C ends it")
        output.result({"url": server.url, "folder": str(folder), "save": str(save or folder)})
        if browser:
            webbrowser.open(server.url)
        try:
            server.serve_forever()
        except Terminated:
            raise
        except KeyboardInterrupt:
            output.print("ended")
