"""`mgeo explore` as a process: its address, and how it ends."""

import json
import signal
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app

from ..report.conftest import solved  # noqa: F401
from .test_process import started


@pytest.mark.slow
def test_it_serves_until_it_is_told_to_end(solved, stand_in_environment, tmp_path):  # noqa: F811
    arguments = ["explore", str(solved()), "--no-browser"]
    for number, code, last in [(signal.SIGINT, 0, "ended\n"), (signal.SIGTERM, 143, "")]:
        with started(arguments, stand_in_environment, tmp_path) as process:
            # both lines: what a text stream has read ahead is lost to `communicate`
            url, advice = urlsplit(process.stdout.readline().strip()), process.stdout.readline()
            assert advice == "open on this machine only; Ctrl-C ends it\n"
            assert url.hostname == "127.0.0.1"
            connection = HTTPConnection(url.netloc, timeout=30)
            connection.request("GET", url.path)
            assert connection.getresponse().status == 200
            connection.close()
            process.send_signal(number)
            output, errors = process.communicate(timeout=60)
        assert process.returncode == code, errors
        assert output == last
        assert errors == ("" if code == 0 else "Error: interrupted\n")


@pytest.mark.slow
def test_scripts_get_the_address(solved, stand_in_environment, tmp_path):  # noqa: F811
    folder = solved()
    arguments = ["explore", str(folder), "--no-browser", "--json", "--save", "mine.json"]
    with started(arguments, stand_in_environment, tmp_path) as process:
        lines = [process.stdout.readline() for _ in range(5)]
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    found = json.loads("".join(lines))
    assert found["url"].startswith("http://127.0.0.1:")
    assert (found["folder"], found["save"]) == (str(folder), "mine.json")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ([], "run.json"),
        (["--save", "none/plan.json"], ""),
        (["--port", "99999"], "65535"),
    ],
)
def test_what_it_cannot_do_is_one_line(more, message, tmp_path):
    done = CliRunner().invoke(app, ["explore", str(tmp_path), "--no-browser", *more])
    assert done.exit_code == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_a_port_that_is_taken_is_named(solved):  # noqa: F811
    import socket

    folder = solved()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        arguments = ["explore", str(folder), "--no-browser", "--port", str(port)]
        done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 2
    assert f"127.0.0.1:{port}" in done.stderr
