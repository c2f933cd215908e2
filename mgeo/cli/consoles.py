"""Consoles that write control characters to a terminal only."""

from __future__ import annotations

import sys

from rich.console import Console

_WIDTH_OF_A_FILE = 160  # rich would cut what is wider than 80


def console(*, stderr: bool = False) -> Console:
    """A console on stdout or stderr.

    Whether it is a terminal is asked of the stream: rich also believes environment variables,
    and one that asks for colors would put control characters into a pipe.
    """
    terminal = (sys.stderr if stderr else sys.stdout).isatty()
    return Console(
        stderr=stderr, force_terminal=terminal, width=None if terminal else _WIDTH_OF_A_FILE
    )
