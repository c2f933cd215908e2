"""Files that others may have written, read: bounded, plain data, clear errors; tables as CSV."""

from __future__ import annotations

import csv
import gzip
import io
import json
import math
import os
import re
import stat
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

#: Far more than any file of ours holds, and less than memory does.
MOST_BYTES = 2**30

# without waiting for somebody who writes into a pipe; of Windows, every byte as it stands
_READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)

_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")


def read_file(path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """Content of a regular file.

    Raises
    ------
    OSError
        If it cannot be read.
    FileError
        If it is a folder, a pipe or a device, which might never end, or larger than `most` bytes.
    """
    descriptor = os.open(path, _READ)
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode):
        os.close(descriptor)
        raise FileError(f"{path} is a folder, a pipe or a device: expected a file")
    with open(descriptor, "rb") as file:
        if status.st_size > most:
            raise FileError(f"{path} has {status.st_size} bytes: expected at most {most}")
        return file.read(most)


def read_packed(path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """Content of a regular file, or of the file in it if it is compressed by gzip.

    Raises
    ------
    OSError, FileError
        As `read_file`, also if what is in it is larger than `most` bytes, or damaged.
    """
    content = read_file(path, most)
    if not content.startswith(b"\x1f\x8b"):
        return content
    try:
        with gzip.open(io.BytesIO(content)) as file:
            unpacked = file.read(most + 1)
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise FileError(f"{path}: expected a sound .gz: {error}") from None
    if len(unpacked) > most:
        raise FileError(f"{path}: expected at most {most} bytes, and there are more")
    return unpacked


def read_text(path: str | os.PathLike[str], most: int = MOST_BYTES) -> str:
    """Content of a file in UTF-8, without the byte-order mark that some editors begin it with.

    Raises
    ------
    OSError, FileError
        As `read_file`, or if it is no UTF-8.
    """
    content = read_file(path, most)
    with errors_of(path):
        return content.decode("utf-8-sig")


def read_json(path: Path | str) -> Any:
    """Data of a JSON file.

    Raises
    ------
    OSError, FileError
        As `read_text`, or if it is no JSON.
    """
    text = read_text(path)
    with errors_of(path):
        return parse_json(text)


def check_unchanged(path: Path | str, document: Any) -> None:
    """Refuse other files that were read after this one, if they may belong to another by now.

    Raises
    ------
    ValueError, FileNotFoundError
        If its content is no longer this document: somebody wrote all of them anew meanwhile.
    """
    if read_json(path) != document:
        raise FileError(f"{path} was written anew while the files beside it were read: try again")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text:.40} is no finite number")
    return value


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r:.80} occurs twice in an object")
    return table


def parse_json(text: str) -> Any:
    """Data of strict JSON: finite numbers, no key twice in an object, strings that can be written.

    Raises
    ------
    ValueError
        If it is none, or nested too deeply.
    """
    try:
        data = json.loads(
            text, parse_constant=_finite, parse_float=_finite, object_pairs_hook=_unique
        )
        if _SURROGATE.search(text):  # half a character, unless the other half follows
            json.dumps(data, ensure_ascii=False).encode()
        return data
    except RecursionError:
        raise ValueError("nested too deeply") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of TOML.

    Raises
    ------
    ValueError
        If it is none, or nested too deeply.
    """
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ValueError(f"no valid TOML: {error}{_of_commas(text, error)}") from None


def _of_commas(text: str, error: Exception) -> str:
    """What is said where the line of an error has a number with a decimal comma."""
    place = re.search(r"line (\d+)", str(error))
    lines = text.splitlines()
    if place is None or int(place[1]) > len(lines):
        return ""
    return decimal_point(lines[int(place[1]) - 1].partition("=")[2].partition("#")[0])


def from_npz(content: bytes) -> dict[str, NDArray[Any]]:
    """The arrays of numbers in an .npz archive; nothing is unpickled.

    Raises
    ------
    ValueError
        If it is no such archive, or there is anything else in it.
    """
    try:
        archive: Any = np.load(io.BytesIO(content), allow_pickle=False)
        if isinstance(archive, np.ndarray):
            raise ValueError("there is one array alone")
        if sum(member.file_size for member in archive.zip.infolist()) > MOST_BYTES:
            raise ValueError(f"more than {MOST_BYTES} bytes are in it")
        arrays = dict(archive)
    except Exception as error:  # of many kinds: those of zip files, of compression, of memory
        raise ValueError(f"no archive of arrays: {type(error).__name__}: {error}") from error
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray) or array.dtype.kind not in "biuf":
            raise ValueError(f"no archive of arrays: {name!r} is no array of numbers")
    return arrays


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
