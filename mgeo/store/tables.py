"""Tables as CSV files that read back exactly."""

from __future__ import annotations

import csv
import io
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

from mgeo.store.reading import read_text
from mgeo.validation.tables import errors_of

if TYPE_CHECKING:
    import pandas as pd


# Python also reads 1_0 as a number, and digits of other scripts
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)


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
    import pandas as pd

    text = read_text(path)
    with errors_of(path):
        if not text.endswith("\n"):
            raise ValueError("expected a header and rows, each with its end of line")
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


def read_numbers(path: Path) -> pd.DataFrame:
    """A table of finite numbers.

    Raises
    ------
    OSError, ValueError
        As `read_texts`, or naming the row and the column of what is no finite number.
    """
    texts = read_texts(path)
    values = texts.map(_number).astype(float)
    with errors_of(path):
        for name in values.columns[values.isna().any()]:
            row = int(values[name].isna().argmax())
            found = texts[name].iloc[row]
            raise ValueError(f"row {row + 1}, {name} = {found!r:.40}: expected a finite number")
    return values


def _number(text: str) -> float:
    number = float(text) if _NUMBER.fullmatch(text) else math.nan
    return number if math.isfinite(number) else math.nan
