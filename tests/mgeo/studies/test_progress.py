"""Progress of runs, on a terminal and in a pipe."""

import io
import re
import sys

import pytest

from mgeo.studies.progress import show_progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("stream", "shown", "parts"),
    [
        (Terminal, True, ["study: reused 1 of 5 runs", "3/5", "[A], seed 2: ValueError: [no]"]),
        (io.StringIO, True, ["study: reused 1 of 5 runs", "[A], seed 2: ValueError: [no]"]),
        (Terminal, False, []),
    ],
)
def test_progress_is_shown_where_wanted(monkeypatch, stream, shown, parts):
    monkeypatch.setattr(sys, "stderr", stream())
    monkeypatch.setenv("TERM", "xterm")
    with show_progress("study", 5, 1, enabled=shown) as done:
        done("[A]", 1, "")
        done("[A]", 2, "ValueError: [no]")
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", sys.stderr.getvalue())
    assert all(part in text for part in parts)
    assert ("3/5" in text) == (stream is Terminal and shown)
    assert bool(text) == shown
