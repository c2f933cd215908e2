"""Reading of text, JSON, TOML, CSV and .npz files with errors that name the file."""

from __future__ import annotations

import csv
import gzip
import io
import json
import math
import os
import re
import tomllib
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mgeo.validation.arguments import decimal_point
from mgeo.validation.entries import FileError, errors_of

if TYPE_CHECKING:
    import pandas as pd

#: Largest file that is read [bytes].
MOST_BYTES = 2**30


def read_file(path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """Return the content of a file.

    Raises
    ------
    OSError
        If the file cannot be read.
    FileError
        If the file has more than `most` bytes.
    """
    path = Path(path)
    size = path.stat().st_size
    if size > most:
        raise FileError(f"{path} has {size} bytes: expected at most {most}")
    return path.read_bytes()


def read_packed(path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """Return the content of a file, decompressed if the file is compressed by gzip.

    Raises
    ------
    OSError, FileError
        As `read_file`, or if the decompressed content is too large or the file is damaged.
    """
    content = read_file(path, most)
    if not content.startswith(b"\x1f\x8b"):
        return content
    try:
        with gzip.open(io.BytesIO(content)) as file:
            unpacked = file.read(most + 1)
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise FileError(f"{path} is a damaged gzip file: {error}") from None
    if len(unpacked) > most:
        raise FileError(f"{path} has more than {most} bytes when decompressed")
    return unpacked


def read_text(path: str | os.PathLike[str], most: int = MOST_BYTES) -> str:
    """Return the text of a UTF-8 file, without a byte-order mark.

    Raises
    ------
    OSError, FileError
        As `read_file`, or if the file is not UTF-8.
    """
    content = read_file(path, most)
    with errors_of(path):
        return content.decode("utf-8-sig")


def read_json(path: Path | str) -> Any:
    """Return the data of a JSON file.

    Raises
    ------
    OSError, FileError
        As `read_text`, or if the file is not JSON.
    """
    text = read_text(path)
    with errors_of(path):
        return parse_json(text)


def parse_json(text: str) -> Any:
    """Return the data of a JSON text, without the non-standard constants NaN and Infinity.

    Raises
    ------
    ValueError
        If the text is not JSON, or nested too deeply.
    """
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        If the text is not TOML, or nested too deeply.
    """
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ValueError(f"no valid TOML: {error}{_decimal_comma(text, error)}") from None


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no finite number")


def _decimal_comma(text: str, error: Exception) -> str:
    """Return a hint if the line of a TOML error has a number with a decimal comma."""
    place = re.search(r"line (\d+)", str(error))
    lines = text.splitlines()
    if place is None or int(place[1]) > len(lines):
        return ""
    return decimal_point(lines[int(place[1]) - 1].partition("=")[2].partition("#")[0])


def from_npz(content: bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of numbers and of text in an .npz archive. Nothing is unpickled.

    Raises
    ------
    ValueError
        If the content is not such an archive, or holds an array of another kind.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = dict(archive)
    except Exception as error:  # zipfile, zlib and numpy raise errors of many kinds
        raise ValueError(f"no archive of arrays: {type(error).__name__}: {error}") from error
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray) or array.dtype.kind not in "biufU":
            raise ValueError(f"no archive of arrays: {name!r} is no array of numbers or text")
    return arrays


def to_csv(table: pd.DataFrame) -> bytes:
    """Return the content of a CSV file. Floats are written by repr, NaN as ``nan``."""
    text: str = table.to_csv(index=False, na_rep="nan", lineterminator="\n")
    return text.encode()


def read_texts(path: Path) -> pd.DataFrame:
    """Return the cells of a CSV file as text, to be converted by `astype`.

    The parser of pandas is not used: it turns the first cells of rows that are too long into an
    index.

    Raises
    ------
    OSError, FileError
        If the file cannot be read or is not a table.
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
    """Return a CSV file of finite numbers.

    Raises
    ------
    OSError, FileError
        As `read_texts`, or naming the row and the column of another value.
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
    try:
        number = float(text)
    except ValueError:
        return math.nan
    return number if math.isfinite(number) else math.nan
