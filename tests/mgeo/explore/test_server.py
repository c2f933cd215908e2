"""HTTP server of the explorer, accessible only from this machine."""

import json
import threading
from contextlib import contextmanager
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

from mgeo.explore import ExplorerServer


@contextmanager
def served(folder, **options):
    """Context manager that serves the page of a run on a free port, and yields its address."""
    with ExplorerServer(folder, **options) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield server.url
        finally:
            server.shutdown()
            thread.join()


def test_page_has_one_slider_per_variable(folder):
    with served(folder) as url, urlopen(f"{url}_dash-layout", timeout=30) as response:
        layout = json.loads(response.read())
    assert json.dumps(layout).count('"type": "Slider"') == 2


def test_other_paths_and_host_names_are_refused(folder):
    with served(folder) as url:
        root = url.rsplit("/", 2)[0]
        for request in Request(f"{root}/"), Request(url, headers={"Host": "example.com"}):
            with pytest.raises(HTTPError, match=r"40[04]"):
                urlopen(request, timeout=30)
