"""The page of a run on loopback: for whoever has its address, and for nobody else.

Any page that is open in a browser can send requests to 127.0.0.1. So the address has a random token
in it, `Host` must be this server's own (or another name could lead here, DNS rebinding), an
`Origin`, if there is one, too, and what is asked is JSON, which no form sends.

Everything is computed in one thread, the most urgent first.
"""

from __future__ import annotations

import itertools
import json
import secrets
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import cached_property, partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from queue import PriorityQueue
from typing import Any, TypeVar

from plotly.offline import get_plotlyjs
from pydantic_core import to_jsonable_python

from mgeo._text import one_line
from mgeo.explore.explorer import Explorer
from mgeo.explore.saving import Exists
from mgeo.figures.page import render
from mgeo.store.reading import parse_json
from mgeo.validation.tables import Table, checked

#: Nothing from elsewhere; plotly's three-dimensional figures compile functions.
_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self'; img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
SECURITY = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_SCRIPTS = ("figures/assets/theme", "report/assets/figures", "report/assets/motion")
_OWN = ("parallel", "scatter", "solution", "explore")


def assets(title: str) -> dict[str, tuple[str, bytes]]:
    """Content type and content of each file, by its path below the token."""
    names = [*_SCRIPTS, *(f"explore/assets/{name}" for name in _OWN)]
    script = "\n".join(render(f"{name}.js") for name in names)
    html = render("explore/assets/explore.html", title=title)
    return {
        "": ("text/html; charset=utf-8", html.encode()),
        "explore.js": ("text/javascript; charset=utf-8", script.encode()),
        "plotly.js": ("text/javascript; charset=utf-8", get_plotlyjs().encode()),
    }


T = TypeVar("T")


class Worker:
    """Calls functions one after the other, whichever threads ask for them.

    So a problem need not be one for several threads. The thread ends with the process.
    """

    def __init__(self) -> None:
        self._asked: PriorityQueue[tuple[int, int, Future[Any], Callable[[], Any]]]
        self._asked = PriorityQueue()
        self._numbers = itertools.count()
        threading.Thread(target=self._work, daemon=True, name="explorer").start()

    def ask(self, function: Callable[[], T], urgency: int = 0) -> T:
        """What a function gives or raises; those of a lower number go first."""
        future: Future[T] = Future()
        self._asked.put((urgency, next(self._numbers), future, function))
        return future.result()

    def _work(self) -> None:
        while True:
            *_, future, function = self._asked.get()
            try:
                future.set_result(function())
            except BaseException as error:  # whoever asked is told
                future.set_exception(error)


HOST = "127.0.0.1"
_MOST_BYTES = 2**20  # of a request
_PATIENCE = 60.0  # seconds for a request to arrive


class Nothing(Table):
    """A request without parameters."""


class Design(Table):
    """A design as numbers."""

    design: list[float]


class Rows(Table):
    """Places in the table of solutions."""

    rows: list[int]


class Save(Table):
    """A design, the name of its file, and whether one of that name may be replaced."""

    design: list[float]
    name: str
    overwrite: bool = False


Answer = Callable[[Explorer, Any], Any]
#: From this on nobody waits with a hand on a slider: what takes seconds has a thread of its own.
SLOW = 2
#: What may be asked: the form of the request, how urgent it is (0 first), and what answers it.
API: dict[str, tuple[type[Table], int, Answer]] = {
    "front": (Nothing, 0, lambda explorer, asked: explorer.front()),
    "glance": (Design, 0, lambda explorer, asked: explorer.glance(explorer.design(asked.design))),
    "save": (
        Save,
        0,
        lambda explorer, asked: explorer.save(
            explorer.design(asked.design), asked.name, overwrite=asked.overwrite
        ),
    ),
    "figures": (Design, 1, lambda explorer, asked: explorer.figures(explorer.design(asked.design))),
    "limits": (Rows, 2, lambda explorer, asked: explorer.limits(asked.rows)),
    "answer": (Design, 3, lambda explorer, asked: explorer.answer(explorer.design(asked.design))),
    "review": (Design, 3, lambda explorer, asked: explorer.review(explorer.design(asked.design))),
    "pictures": (Nothing, 4, lambda explorer, asked: explorer.pictures()),
}


class Refusal(Exception):
    """A request that is not answered: why, and by which status."""

    def __init__(self, status: HTTPStatus, message: str) -> None:
        super().__init__(message)
        self.status = status


class ExplorerServer(ThreadingHTTPServer):
    """Serves the page of an explorer until it is shut down.

    Parameters
    ----------
    explorer : Explorer
    port : int
        0 for any that is free.

    Attributes
    ----------
    url : str
        Of the page, with its token.

    Raises
    ------
    OSError
        If the port is taken.

    Examples
    --------
    >>> from mgeo.explore import Explorer, ExplorerServer
    >>> with ExplorerServer(Explorer("runs/first")) as server:  # doctest: +SKIP
    ...     print(server.url)
    ...     server.serve_forever()
    """

    daemon_threads = True
    allow_reuse_address = True
    request_queue_size = 128  # a slider that moves asks more than the usual five at once

    def __init__(self, explorer: Explorer, port: int = 0) -> None:
        self.explorer, self.worker, self.slow_worker = explorer, Worker(), Worker()
        self.token = secrets.token_urlsafe(24)
        self.assets = assets(explorer.title)
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            raise OSError(error.errno, error.strerror, f"{HOST}:{port}") from error
        self.hosts = tuple(f"{name}:{self.server_port}" for name in (HOST, "localhost"))
        self.url = f"http://{HOST}:{self.server_port}/{self.token}/"

    @cached_property
    def slow_explorer(self) -> Explorer:
        """That of the thread of what takes seconds, with a problem of its own."""
        return self.explorer.another()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Nothing of a browser that went away meanwhile."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)

    def answered(self, name: str, body: bytes) -> Any:
        """What a request of the API is answered with.

        Raises
        ------
        Refusal
        """
        if name not in API:
            raise Refusal(HTTPStatus.NOT_FOUND, f"api/{name:.80}: expected {', '.join(API)}")
        form, urgency, answer = API[name]
        try:
            asked = checked(form, parse_json(body.decode()))
            if urgency >= SLOW:
                return self.slow_worker.ask(lambda: answer(self.slow_explorer, asked), urgency)
            return self.worker.ask(partial(answer, self.explorer, asked), urgency)
        except Exists as error:
            raise Refusal(HTTPStatus.CONFLICT, one_line(str(error))) from error
        except (ValueError, TypeError) as error:
            raise Refusal(HTTPStatus.BAD_REQUEST, one_line(str(error))) from error
        except OSError as error:
            raise Refusal(HTTPStatus.INSUFFICIENT_STORAGE, one_line(str(error))) from error
        except Exception as error:  # a bug, here or in a problem
            text = one_line(f"{type(error).__name__}: {error}")
            raise Refusal(HTTPStatus.INTERNAL_SERVER_ERROR, text) from error


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    timeout = _PATIENCE
    server: ExplorerServer
    server_version, sys_version = "mgeo", ""

    def do_GET(self) -> None:
        self._serve(self._page)

    def do_POST(self) -> None:
        self._serve(self._api)

    def _serve(self, found: Callable[[str], tuple[str, bytes]]) -> None:
        try:
            kind, content = found(self._path())
            self._send(HTTPStatus.OK, kind, content)
        except Refusal as refusal:
            self.close_connection = True  # what is left of its body is not read
            text = json.dumps({"error": str(refusal)}, ensure_ascii=False)
            self._send(refusal.status, "application/json", text.encode())

    def _path(self) -> str:
        """What is asked for, after the token."""
        own = self.server
        if self.headers.get("Host") not in own.hosts:
            raise Refusal(HTTPStatus.FORBIDDEN, f"Host: expected {own.hosts[0]}")
        origin = self.headers.get("Origin")
        if origin is not None and origin.removeprefix("http://") not in own.hosts:
            raise Refusal(HTTPStatus.FORBIDDEN, "Origin: expected this server's")
        token, slash, path = self.path.partition("?")[0].removeprefix("/").partition("/")
        if not (slash and secrets.compare_digest(token.encode(), own.token.encode())):
            raise Refusal(HTTPStatus.FORBIDDEN, "expected the address that mgeo explore printed")
        return path

    def _page(self, path: str) -> tuple[str, bytes]:
        if path not in self.server.assets:
            raise Refusal(HTTPStatus.NOT_FOUND, f"there is no {path:.80}")
        return self.server.assets[path]

    def _api(self, path: str) -> tuple[str, bytes]:
        room, _, name = path.partition("/")
        if room != "api":
            raise Refusal(HTTPStatus.NOT_FOUND, f"there is no {path:.80}")
        if self.headers.get_content_type() != "application/json":
            raise Refusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "expected application/json")
        size = self.headers.get("Content-Length", "")
        if not (size.isascii() and size.isdigit()):
            raise Refusal(HTTPStatus.LENGTH_REQUIRED, "expected a Content-Length")
        if int(size) > _MOST_BYTES:
            raise Refusal(
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"expected {_MOST_BYTES} bytes at most"
            )
        found = self.server.answered(name, self.rfile.read(int(size)))
        finite = to_jsonable_python(found, inf_nan_mode="null")
        text = json.dumps(finite, allow_nan=False, separators=(",", ":"))
        return "application/json", text.encode()

    def _send(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        for name, value in SECURITY.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: the address of every request has the token in it."""
