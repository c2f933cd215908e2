"""A small run of the stand-in problem, and a server of its page."""

import json
import threading
from contextlib import contextmanager
from http.client import HTTPConnection

import pandas as pd
import pytest

from mgeo.explore import Explorer, ExplorerServer

from ..report.conftest import solved  # noqa: F401


@pytest.fixture
def folder(solved, monkeypatch):  # noqa: F811
    """A run of beams whose length is limited."""
    from stand_in import CantileverView

    def limits(self):
        return [
            pd.DataFrame(
                {
                    "unit": "m",
                    "value": x[1],
                    "bound": "at most",
                    "limit": 0.5,
                    "margin": 0.5 - x[1],
                },
                index=["length"],
            )
            for x in self.X
        ]

    monkeypatch.setattr(CantileverView, "limits", limits, raising=False)
    return solved()


@pytest.fixture
def explorer(folder):
    return Explorer(folder)


class Client:
    """Asks a server as a page does, unless told otherwise."""

    def __init__(self, server):
        self.server = server
        self.root = f"/{server.token}/"

    def send(self, method, path, body=None, **headers):
        """Status, headers and content; a header that is None is left out."""
        connection = HTTPConnection("127.0.0.1", self.server.server_port, timeout=30)
        sent = {"Host": self.server.hosts[0], **headers}
        try:
            connection.putrequest(method, path, skip_host=True)
            for name, value in sent.items():
                if value is not None:
                    connection.putheader(name.replace("_", "-"), value)
            connection.endheaders(body)
            answer = connection.getresponse()
            return answer.status, dict(answer.headers), answer.read()
        finally:
            connection.close()

    def ask(self, name, body=None, **headers):
        """Status and JSON of a request of the API."""
        content = body if isinstance(body, bytes) else json.dumps(body or {}).encode()
        sent = {"Content_Type": "application/json", "Content_Length": str(len(content)), **headers}
        status, _, found = self.send("POST", f"{self.root}api/{name}", content, **sent)
        return status, json.loads(found)


@contextmanager
def served(explorer):
    """A client of a server that runs."""
    with ExplorerServer(explorer) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield Client(server)
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture
def client(explorer):
    with served(explorer) as found:
        yield found
