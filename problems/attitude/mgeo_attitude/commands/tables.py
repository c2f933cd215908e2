"""Tables for people and for JSON."""

from __future__ import annotations

from typing import Any

import pandas as pd
from rich.text import Text

from mgeo.terminal import Columns, plain, table


def titled(title: str, frame: pd.DataFrame, digits: int = 4) -> tuple[Text, Columns]:
    """A table for people, with its index and so many digits, under a title."""
    rows = frame.itertuples(name=None)
    return plain(f"\n{title}", "bold"), table(["", *frame.columns], rows, digits)


def note(text: str) -> Text:
    """What explains a table."""
    return plain(text, "dim")


def rows(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """The rows of a table, with its index unless that only counts them."""
    named = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    return named.to_dict("records")
