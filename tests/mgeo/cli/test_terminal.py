"""The command on a terminal of its own: colors and redrawing where they belong, and only there."""

import os
import re
import select
import subprocess
import sys
import time

import pytest

pty = pytest.importorskip("pty")

RUN = ["solve", "cantilever", "--runs", "4", "--evaluations", "400", "--out", "a"]
ESCAPE, COLOR = "\x1b", r"\x1b\[[\d;]*\b[349]\d\b[\d;]*m"


def on_a_terminal(arguments, folder, environment):
    """What appears on an xterm that is stdout and stderr of the command, and its exit code."""
    ours, its = pty.openpty()
    environment = {"TERM": "xterm-256color", "COLUMNS": "100", **environment}
    with subprocess.Popen(
        [sys.executable, "-m", "mgeo", *arguments],
        cwd=folder, env=environment, stdin=its, stdout=its, stderr=its,
    ) as process:  # fmt: skip
        os.close(its)
        seen = b""
        deadline = time.monotonic() + 300
        while time.monotonic() < deadline and select.select([ours], [], [], 300)[0]:
            try:
                seen += os.read(ours, 65536)
            except OSError:  # Linux: the other end is closed
                break
        os.close(ours)
    return seen.decode(), process.returncode


@pytest.fixture
def environment(stand_in_environment):
    return {
        key: value
        for key, value in stand_in_environment.items()
        if key not in ("CI", "NO_COLOR", "TERM", "COLUMNS", "FORCE_COLOR")
    }


@pytest.mark.parametrize(
    ("variables", "before", "redrawn", "colored"),
    [
        ({}, [], True, True),
        ({"NO_COLOR": "1"}, [], True, False),
        ({}, ["--no-color"], True, False),
        ({"TERM": "dumb"}, [], False, False),
        ({"CI": "1"}, [], False, False),
    ],
    ids=["terminal", "NO_COLOR", "--no-color", "dumb", "CI"],
)
def test_colors_and_redrawing(environment, tmp_path, variables, before, redrawn, colored):
    text, code = on_a_terminal([*before, *RUN], tmp_path, environment | variables)
    assert code == 0, text
    assert "400 of 400 evaluations" in text
    assert "written: a/front.html" in text
    assert bool(re.search(COLOR, text)) == colored
    assert (ESCAPE in text) == redrawn
    assert ("\r" in text.replace("\r\n", "\n")) == redrawn
