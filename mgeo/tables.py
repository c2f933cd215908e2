"""Tables as CSV files that read back exactly."""

from __future__ import annotations

from pathlib import Path

import pandas as pd


def to_csv(table: pd.DataFrame) -> bytes:
    """Content of a file with a row for each row; floats by repr, NaN as ``nan``."""
    text: str = table.to_csv(index=False, na_rep="nan", lineterminator="\n")
    return text.encode()


def read_texts(path: Path) -> pd.DataFrame:
    """The entries as they stand in the file, to be converted by `astype`.

    pandas' own parsing of floats is, or was in some versions, off by an ulp.
    """
    return pd.read_csv(path, dtype=str, keep_default_na=False)
