"""``mgeo explore``: a run as a page on this machine, until Ctrl-C."""

from __future__ import annotations

import webbrowser
from pathlib import Path

from mgeo.cli.errors import Terminated, bad_input
from mgeo.cli.output import Output
from mgeo.explore import Explorer, ExplorerServer


def serve(
    folder: Path,
    output: Output,
    *,
    save: Path | None = None,
    port: int = 0,
    browser: bool = True,
    problem: str | None = None,
) -> None:
    """Serve the page of a run folder, open it in a browser, and end with Ctrl-C.

    Parameters
    ----------
    save, problem
        See `mgeo.explore.Explorer`.
    port
        0 for any that is free.
    """
    with bad_input((ValueError, TypeError, OSError)):
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
