import io
import re
import sys

import pytest

from mgeo.studies.dispatch import progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def shown(monkeypatch, stream, wanted):
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with progress("study", total=5, found=1, shown=wanted) as done:
        done("[A]", 1, "")
        done("[A]", 2, "ValueError: [no]")
        done("[A]", 3, "ValueError: [no]")
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", stream.getvalue())


@pytest.mark.parametrize("wanted", [None, True])
def test_a_terminal_has_a_bar(monkeypatch, wanted):
    text = shown(monkeypatch, Terminal(), wanted)
    assert "4/5" in text
    assert "2 failed" in text
    assert "[A], seed 2: ValueError: [no]" in text


def test_a_pipe_has_lines_if_they_are_wanted(monkeypatch):
    assert shown(monkeypatch, io.StringIO(), None) == ""
    assert shown(monkeypatch, io.StringIO(), True).splitlines() == [
        "study: 5 runs, 1 of them found on disk",
        "2/5  [A], seed 1: finished",
        "3/5  [A], seed 2: failed: ValueError: [no]",
        "4/5  [A], seed 3: failed: ValueError: [no]",
    ]


def test_nothing_is_shown_if_nothing_is_wanted(monkeypatch):
    assert shown(monkeypatch, Terminal(), False) == ""
