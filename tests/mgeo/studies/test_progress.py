"""Progress of runs, on a terminal and in a pipe."""

import io
import re
import sys

import pytest

from mgeo.cli.study import _bar as bar
from mgeo.studies.progress import choose, lines


class Terminal(io.StringIO):
    def isatty(self):
        return True


def show(monkeypatch, stream, progress):
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with choose(progress)("study", 5, 1) as done:
        done("[A]", 1, "")
        done("[A]", 2, "ValueError: [no]")
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", stream.getvalue())


def test_a_terminal_has_a_bar(monkeypatch):
    text = show(monkeypatch, Terminal(), bar)
    for part in ("study: reused 1 of 5 runs", "3/5", "1 failed", "[A], seed 2: ValueError: [no]"):
        assert part in text


@pytest.mark.parametrize(
    ("stream", "progress", "n_lines"),
    [
        (io.StringIO, True, 3),
        (Terminal, None, 3),
        (io.StringIO, None, 1),  # the reuse is never silent
        (Terminal, False, 0),
    ],
)
def test_lines_are_printed_where_wanted(monkeypatch, stream, progress, n_lines):
    expected = [
        "study: reused 1 of 5 runs",
        "2/5  [A], seed 1: finished",
        "3/5  [A], seed 2: failed: ValueError: [no]",
    ]
    assert show(monkeypatch, stream(), progress).splitlines() == expected[:n_lines]


def test_a_new_study_reuses_nothing(capsys):
    with lines("study", 5, None):
        pass
    assert capsys.readouterr().err == "study: 5 runs\n"
