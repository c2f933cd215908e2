"""Telemetry tables in CSV and Parquet files."""

from __future__ import annotations

import gzip
import io
import re
import zlib
from pathlib import Path

import pandas as pd

from mgeo.store.readers import build_exact_float_options

_SEPARATORS = ";\t,"  # The first separator in the header is used.
_NUMBER = re.compile(r"\s*[-+.,]?\d")


def read_table(path: Path) -> pd.DataFrame:
    """Read a telemetry table from a CSV or Parquet file.

    Files with the extension ``.parquet`` or ``.pq`` need pyarrow. Other files are UTF-8 text,
    optionally compressed with gzip; see `parse_table`.

    Raises
    ------
    OSError
        If the file cannot be read.
    ImportError
        If pyarrow is missing for Parquet.
    ValueError
        If the content is not a table.
    """
    if path.suffix.lower() in (".parquet", ".pq"):
        return pd.read_parquet(path)
    content = path.read_bytes()
    try:
        if content.startswith(b"\x1f\x8b"):
            content = gzip.decompress(content)
        text = content.decode("utf-8-sig")
    except (EOFError, OSError, UnicodeDecodeError, zlib.error) as error:
        raise ValueError(f"expected CSV in UTF-8, uncompressed or gzip: {error}") from None
    return parse_table(text)


def parse_table(text: str) -> pd.DataFrame:
    """Parse a telemetry table from delimited text with a header line.

    Cells are separated by semicolons, tabs or commas, depending on the header, otherwise by spaces.
    Decimal commas are accepted unless commas separate cells. Empty lines and lines that start with
    ``#`` are skipped. Units in the line below the header are appended to the names in brackets.

    Raises
    ------
    ValueError
        If there is no header, or a line has more cells than the header.
    """
    lines = [line for line in text.splitlines() if line.strip(_SEPARATORS + " ") and line[0] != "#"]
    if not lines:
        raise ValueError("the table is empty: expected CSV with a header line")
    separator = next((mark for mark in _SEPARATORS if mark in lines[0]), None)
    names, *rows = ([cell.strip(' "') for cell in line.split(separator)] for line in lines[:2])
    for units in rows:
        if len(units) == len(names) and not any(map(_NUMBER.match, units)) and any(units):
            names = [
                f"{name} [{unit.strip('[]()')}]" if unit else name
                for name, unit in zip(names, units, strict=True)
            ]
            del lines[1]
    frame: pd.DataFrame = pd.read_csv(
        io.StringIO("\n".join(lines)),
        sep=separator or r"\s+",
        decimal="," if separator != "," and re.search(r"\d,\d", lines[-1]) else ".",
        skipinitialspace=True,
        index_col=False,
        low_memory=False,
        **build_exact_float_options(),
    )
    return frame.set_axis(pd.Index(names), axis=1)
