"""Colors and redrawing on a terminal."""

import os
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest

from mgeo.cli.app import app

pty = pytest.importorskip("pty")

RUN = ["solve", "cantilever", "--walkers", "4", "--evaluations", "400", "--out", "a"]
TERMINAL = {"TERM": "xterm-256color", "COLUMNS": "100"}
ESCAPE, COLOR = "\x1b", r"\x1b\[[\d;]*\b[349]\d\b[\d;]*m"


@contextmanager
def open_terminal(output):
    """Context manager that yields a terminal, and appends its output to a list on exit."""
    primary, secondary = pty.openpty()
    with ThreadPoolExecutor(1) as pool:
        reader = pool.submit(read, primary)
        with open(secondary, "w") as file:
            yield file
        output.append(reader.result(timeout=300).decode())
    os.close(primary)


def read(descriptor):
    content = b""
    while True:
        try:
            block = os.read(descriptor, 65536)
        except OSError:  # On Linux, the other end is closed.
            return content
        if not block:
            return content
        content += block


@pytest.mark.parametrize(
    ("variables", "colored"),
    [
        ({}, True),
        ({"NO_COLOR": "1"}, False),
    ],
    ids=["terminal", "NO_COLOR"],
)
def test_terminal_output_is_colored_unless_no_color_is_set(
    stand_in, tmp_path, monkeypatch, variables, colored
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("NO_COLOR")  # Both calls make monkeypatch undo what --no-color sets.
    for name, value in (TERMINAL | variables).items():
        monkeypatch.setenv(name, value)
    output = []
    with open_terminal(output) as stream, monkeypatch.context() as streams:
        streams.setattr(sys, "stdout", stream)
        streams.setattr(sys, "stderr", stream)
        with pytest.raises(SystemExit) as ended:
            app(RUN)
    assert not ended.value.code, output
    check_output(output[0], colored)


def check_output(text, colored):
    assert "400 of 400 evaluations" in text
    assert "front.html" in text
    assert bool(re.search(COLOR, text)) == colored
    assert ESCAPE in text
    assert "\r" in text.replace("\r\n", "\n")
