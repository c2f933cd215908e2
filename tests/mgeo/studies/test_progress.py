import io
import re
import sys

import pytest

from mgeo.studies.progress import show_progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("stream", "enabled", "parts"),
    [
        (Terminal, True, ["study: reused 1 of 5 runs", "3/5", "[A], seed 2: ValueError: [no]"]),
        (io.StringIO, True, ["study: reused 1 of 5 runs", "[A], seed 2: ValueError: [no]"]),
        (Terminal, False, []),
    ],
)
def test_progress_output_on_terminal_and_in_pipe(monkeypatch, stream, enabled, parts):
    monkeypatch.setattr(sys, "stderr", stream())
    monkeypatch.setenv("TERM", "xterm")
    with show_progress("study", 5, 1, enabled=enabled) as report:
        report("[A]", 1, "")
        report("[A]", 2, "ValueError: [no]")
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", sys.stderr.getvalue())
    assert all(part in text for part in parts)
    assert ("3/5" in text) == (stream is Terminal and enabled)
    assert bool(text) == enabled
