"""Command ``mgeo explore``, which serves a page for the exploration of a run in the browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import TerminationInterrupt, convert_input_errors
from mgeo.terminal import Output

if TYPE_CHECKING:
    from mgeo.documents import ExploreDocument


def explore(
    folder: options.RunFolder,
    save: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR|FILE.json",
            help="Folder or file into which the page saves solutions [default: DIR/plan.json].",
        ),
    ] = None,
    port: Annotated[
        int,
        typer.Option(min=0, max=65535, metavar="N", help="Port on 127.0.0.1; 0 for any free port."),
    ] = 0,
    browser: Annotated[
        bool,
        typer.Option(
            "--browser/--no-browser", help="Open the page in the browser [default: --browser]."
        ),
    ] = True,
    problem: options.Problem = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    debug: options.Debug = False,
) -> None:
    """Explore the solutions of a run in the browser: filter, select, modify and save them.

    The page evaluates a modified design while its slider moves. The page is accessible from this
    machine only, at the printed address, until Ctrl-C. The command requires Dash
    (pip install 'mgeo[explore]').
    """
    output = Output(quiet, json)
    with convert_input_errors((ImportError, ValueError, TypeError, OSError)):
        from mgeo.explore.server import ExplorerServer

        server = ExplorerServer(folder, save=save, problem=problem, port=port)
    with server:
        output.print(
            f"Page: {server.url}",
            "The page is accessible from this machine only. End the server with Ctrl-C.",
        )
        document: ExploreDocument = {
            "url": server.url,
            "folder": str(folder),
            "save": str(save or folder),
        }
        output.print_document(document)
        if browser:
            webbrowser.open(server.url)
        try:
            server.serve_forever()
        except TerminationInterrupt:
            raise
        except KeyboardInterrupt:
            output.print("ended")
