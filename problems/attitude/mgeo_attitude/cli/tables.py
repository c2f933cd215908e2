"""Tables on a terminal or in a pipe."""

from __future__ import annotations

import sys

import pandas as pd
from rich.console import Console
from rich.table import Table
from rich.text import Text

_WIDTH_OF_A_FILE = 400  # rich would cut what is wider than 80


def console() -> Console:
    """A console on stdout that writes control characters to a terminal only.

    Whether it is one is asked of the stream: rich also believes environment variables.
    """
    terminal = sys.stdout.isatty()
    return Console(force_terminal=terminal, width=None if terminal else _WIDTH_OF_A_FILE)


def printed(out: Console, title: str, frame: pd.DataFrame, digits: int = 4) -> None:
    """Print a table under a title: columns of texts left, others right, with so many digits."""
    table = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    table.add_column("")
    for name in frame.columns:
        texts = all(isinstance(value, str) for value in frame[name])
        table.add_column(Text(str(name)), justify="left" if texts else "right")
    for label, row in zip(frame.index, frame.itertuples(index=False), strict=True):
        table.add_row(Text(str(label)), *(Text(_shown(value, digits)) for value in row))
    out.print(Text(f"\n{title}", style="bold"))
    out.print(table)


def _shown(value: object, digits: int) -> str:
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)
