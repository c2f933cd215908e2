"""Command ``mgeo explore``: its process, and its error messages."""

import json
import signal
import socket
import sys
from urllib.request import urlopen

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

from ..report.conftest import run_cache, solved  # noqa: F401
from .test_process import start


def explore(*arguments):
    return CliRunner().invoke(app, ["explore", "--no-browser", *map(str, arguments)])


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143)])
def test_explore_serves_until_a_signal(solved, stand_in_environment, tmp_path, number, code):  # noqa: F811
    arguments = ["explore", str(solved()), "--no-browser", "--json"]
    with start(arguments, stand_in_environment, tmp_path) as process:
        document = json.loads("".join(process.stdout.readline() for _ in range(5)))
        assert document["url"].startswith("http://127.0.0.1:")
        assert urlopen(document["url"], timeout=30).status == 200
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == code
    assert errors == ("" if code == 0 else "Error: interrupted\n")


@pytest.mark.parametrize(("more", "message"), [([], "run.json"), (["--port", "99999"], "65535")])
def test_invalid_input_is_one_line(more, message, tmp_path):
    done = explore(tmp_path, *more)
    assert done.exit_code == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


def test_error_names_the_used_port_or_the_missing_folder(solved):  # noqa: F811
    folder = solved()
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        done = explore(folder, "--port", port)
    assert done.exit_code == 2
    assert f"127.0.0.1:{port}" in done.stderr
    done = explore(folder, "--save", folder / "none" / "plan.json")
    assert done.exit_code == 2
    assert str(folder / "none") in done.stderr


def test_error_without_dash_names_the_extra(monkeypatch, tmp_path):
    for name in [name for name in sys.modules if name.startswith("mgeo.explore")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "dash", None)
    done = explore(tmp_path)
    assert done.exit_code == 2
    assert "pip install 'mgeo[explore]'" in done.stderr
