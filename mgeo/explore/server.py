"""Local HTTP server of the explorer."""

from __future__ import annotations

from pathlib import Path
from socketserver import ThreadingMixIn
from typing import Any
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer

from mgeo.explore.explorer import Explorer

try:
    from mgeo.explore.app import build_app
except ImportError as error:
    raise ImportError("mgeo explore requires Dash: pip install 'mgeo[explore]'") from error


class ExplorerServer(ThreadingMixIn, WSGIServer):
    """HTTP server of the explorer page of a run.

    Only programs on this machine can access the server.

    Parameters
    ----------
    folder : path
        Run folder.
    save, problem
        See `Explorer`.
    port : int
        Port on 127.0.0.1; 0 for any free port.

    Attributes
    ----------
    url : str
        Address of the page, which contains a random path.

    Raises
    ------
    OSError
        If the port is in use.
    FileNotFoundError, ValueError, TypeError
        See `Explorer`.

    Examples
    --------
    >>> from mgeo.explore import ExplorerServer
    >>> with ExplorerServer("runs/first") as server:  # doctest: +SKIP
    ...     print(server.url)
    ...     server.serve_forever()
    """

    daemon_threads = True

    def __init__(
        self,
        folder: Path | str,
        *,
        save: Path | str | None = None,
        problem: str | None = None,
        port: int = 0,
    ) -> None:
        app = build_app(Explorer(folder, save=save, problem=problem))
        try:
            super().__init__(("127.0.0.1", port), _Handler)
        except OSError as error:
            raise OSError(
                f"127.0.0.1:{port} cannot be used: {error.strerror}; choose another --port"
            ) from error
        self.set_app(app.server)
        self.url = f"http://127.0.0.1:{self.server_port}{app.config.url_base_pathname}"


class _Handler(WSGIRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        # Requests are not logged, because their path is secret.
        pass
