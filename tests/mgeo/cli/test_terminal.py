"""The command on a terminal of its own: colors and redrawing where they belong, and only there."""

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
def terminal(seen):
    """A terminal to write to; what appears on it is put into a list when it is closed."""
    ours, its = pty.openpty()
    with ThreadPoolExecutor(1) as pool:
        shown = pool.submit(read, ours)
        with open(its, "w") as file:
            yield file
        seen.append(shown.result(timeout=300).decode())
    os.close(ours)


def read(end):
    found = b""
    while True:
        try:
            some = os.read(end, 65536)
        except OSError:  # Linux: the other end is closed
            return found
        if not some:
            return found
        found += some


@pytest.mark.parametrize(
    ("variables", "colored"),
    [
        ({}, True),
        ({"NO_COLOR": "1"}, False),
    ],
    ids=["terminal", "NO_COLOR"],
)
def test_colors_and_redrawing(stand_in, tmp_path, monkeypatch, variables, colored):
    """In this process, which has loaded already what takes a command seconds."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("NO_COLOR")  # what --no-color sets is undone, too
    for name, value in (TERMINAL | variables).items():
        monkeypatch.setenv(name, value)
    seen = []
    with terminal(seen) as its, monkeypatch.context() as streams:
        streams.setattr(sys, "stdout", its)
        streams.setattr(sys, "stderr", its)
        with pytest.raises(SystemExit) as ended:
            app(RUN)
    assert not ended.value.code, seen
    check(seen[0], colored)


def check(text, colored):
    assert "400 of 400 evaluations" in text
    assert "written: a/front.html" in text
    assert bool(re.search(COLOR, text)) == colored
    assert ESCAPE in text
    assert "\r" in text.replace("\r\n", "\n")
