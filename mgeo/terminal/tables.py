"""Tables for people."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real

from rich.table import Table

from mgeo.terminal.consoles import plain


def table(titles: Iterable[object], rows: Iterable[Sequence[object]], digits: int = 5) -> Table:
    """Columns without lines between them, texts to the left, others right.

    Parameters
    ----------
    digits
        Of numbers that are not whole.
    """
    entries = list(rows)
    made = Table(box=None, pad_edge=False, show_edge=False, padding=(0, 3, 0, 0))
    for i, title in enumerate(titles):
        texts = all(isinstance(row[i], str) for row in entries)
        made.add_column(plain(title), justify="left" if texts else "right")
    for row in entries:
        made.add_row(*(plain(_shown(value, digits)) for value in row))
    return made


def pairs(texts: Mapping[str, str]) -> Table:
    """Names and what they stand for, a line each."""
    grid = Table.grid(padding=(0, 2))
    for name, text in texts.items():
        grid.add_row(plain(name, style="dim"), plain(text))
    return grid


def _shown(value: object, digits: int) -> str:
    whole = not isinstance(value, Real) or isinstance(value, Integral)
    return str(value) if whole else f"{value:.{digits}g}"
