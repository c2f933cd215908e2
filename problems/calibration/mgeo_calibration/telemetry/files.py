"""Tables in files, as ground systems write them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd

from mgeo.store.reading import read_packed

#: A week of four sensors at 4 Hz is smaller.
MOST_BYTES = 2**30
#: Texts of cells in which there is nothing.
MISSING = ("", "nan", "na", "null", "none")

_SEPARATORS = (";", "\t", ",")  # the first of them that the header has
_COMMENT = "#"
_LOOKED_AT = 100  # rows that say whether commas are decimal
_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
#: From version 3.1 on pandas reads every number exactly, and warns of being told to.
_WARNS = tuple(map(int, pd.__version__.split(".")[:2])) >= (3, 1)
_EXACT: dict[str, Any] = {} if _WARNS else {"float_precision": "round_trip"}
_EMPTY = {text for word in MISSING for text in (word, word.upper(), word.title(), "NaN")}


def read_table(path: Path) -> pd.DataFrame:
    """Columns of numbers where all cells are numbers, of texts where they are not.

    A file that ends in ``.parquet`` or ``.pq`` needs pyarrow, one in ``.xlsx`` openpyxl; any other
    is text with a header, in UTF-8 or UTF-16, perhaps compressed by gzip. Cells are apart by
    semicolons, tabs or commas, the first of these that the header has, or else by spaces; decimal
    commas are read where cells are not apart by commas. Empty lines and those that begin with # are
    passed over. Units in a row below the header are put in brackets behind its names, as others
    write them.

    Raises
    ------
    OSError
        If it cannot be read.
    ImportError
        For a format whose package is missing.
    ValueError
        Saying what is not as it should be.
    """
    suffix = path.suffix.lower()
    if suffix in (".parquet", ".pq"):
        return _by_pandas(path, "pyarrow", lambda: pd.read_parquet(path, engine="pyarrow"))
    if suffix in (".xlsx", ".xlsm"):
        return _by_pandas(path, "openpyxl", lambda: pd.read_excel(path, engine="openpyxl"))
    return table_of(_text(read_packed(path, MOST_BYTES)))


def table_of(text: str) -> pd.DataFrame:
    """The table in a text; raises as `read_table`."""
    numbered = [
        (n, line)
        for n, line in enumerate(text.splitlines(), 1)
        if line.strip(";\t, ") and not line.lstrip().startswith(_COMMENT)
    ]
    if not numbered:
        raise ValueError("no CSV with a header: there are no rows")
    separator = next((mark for mark in _SEPARATORS if mark in numbered[0][1]), "")
    if not separator:
        numbered, separator = [(n, "\t".join(line.split())) for n, line in numbered], "\t"
    header = numbered[0][1]
    names = [name.strip() for name in _cells(header, separator)]
    rows = numbered[1:]
    if rows and _are_units(first := _cells(rows[0][1], separator)) and len(first) == len(names):
        names = [
            f"{name} [{unit.strip().strip('[]()')}]" if unit.strip() else name
            for name, unit in zip(names, first, strict=True)
        ]
        del rows[0]
    for n, line in rows:
        if '"' not in line and line.count(separator) == len(names) - 1:
            continue
        if (count := len(_cells(line, separator))) != len(names):
            more = "" if count < len(names) else "; decimal commas go with semicolons or tabs"
            raise ValueError(f"line {n} has {count} values: expected {len(names)}{more}")
    if not rows:
        return pd.DataFrame(columns=names)
    first_cells = (cell for _, line in rows[:_LOOKED_AT] for cell in _cells(line, separator))
    comma = separator != "," and any(map(_COMMA.fullmatch, first_cells))
    frame: pd.DataFrame = pd.read_csv(
        io.StringIO("\n".join(line for _, line in rows)),
        sep=separator,
        decimal="," if comma else ".",
        header=None,
        skipinitialspace=True,
        keep_default_na=False,
        na_values=sorted(_EMPTY),
        low_memory=False,
        **_EXACT,
    )
    return frame.set_axis(pd.Index(names), axis=1)


def _text(content: bytes) -> str:
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        if encoding == "utf-16":
            raise
        text = content.decode("cp1252", "replace")  # a micro or a degree in the header, at most
    if "\0" in text:
        raise ValueError("no CSV: it has bytes of zero; is it a compressed or a binary table?")
    return text


def _cells(line: str, separator: str) -> list[str]:
    try:
        (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True)
    except (csv.Error, ValueError) as error:
        raise ValueError(f"no CSV: {line!r:.60}: {error}") from None
    return [cell.strip() for cell in cells]


def _are_units(cells: list[str]) -> bool:
    """Whether no cell is a number or a time, and some say something."""
    said = [cell for cell in cells if cell.lower() not in MISSING]
    return bool(said) and not any(re.match(r"[-+.,]?\d|[-+]?inf", cell, re.I) for cell in said)


def _by_pandas(path: Path, package: str, read: Callable[[], Any]) -> pd.DataFrame:
    try:
        import_module(package)
    except ImportError:
        kind = path.suffix.lstrip(".")
        raise ImportError(
            f"{path}: {'Parquet' if kind[0].lower() == 'p' else kind} needs {package}: pip install "
            f"{package}, or write CSV"
        ) from None
    try:
        frame: pd.DataFrame = read()
    except OSError:
        raise
    except Exception as error:  # of the other package's own kinds
        raise ValueError(f"no table of {package}: {error}") from None
    return frame
