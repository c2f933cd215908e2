"""Tables as CSV files that read back exactly."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pandas as pd

from mgeo.reading import errors_of, read_text


def to_csv(table: pd.DataFrame) -> bytes:
    """Content of a file with a row for each row; floats by repr, NaN as ``nan``."""
    text: str = table.to_csv(index=False, na_rep="nan", lineterminator="\n")
    return text.encode()


def read_texts(path: Path) -> pd.DataFrame:
    """The entries as they stand in the file, to be converted by `astype`.

    pandas' own parsing of floats is, or was in some versions, off by an ulp, and of a row that is
    too long it makes an index.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, or is no table.
    """
    text = read_text(path)
    with errors_of(path):
        try:
            header, *rows = csv.reader(io.StringIO(text, newline=""), strict=True)
        except csv.Error as error:
            raise ValueError(f"no CSV: {error}") from None
        if len(set(header)) < len(header):
            raise ValueError(f"columns {header!r:.200}: expected different names")
        for i, row in enumerate(rows, 1):
            if len(row) != len(header):
                raise ValueError(f"row {i} has {len(row)} values: expected {len(header)}")
        return pd.DataFrame(rows, columns=header).astype(str)
