"""Readers of text, JSON, CSV and .npz files, whose errors name the file."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mgeo.validation.entries import convert_file_errors

if TYPE_CHECKING:
    import pandas as pd


def read_text(path: str | os.PathLike[str]) -> str:
    """Read a UTF-8 text file, and remove a byte-order mark.

    Raises
    ------
    OSError
        If the file cannot be read.
    FileError
        If the file is not encoded in UTF-8.
    """
    content = Path(path).read_bytes()
    with convert_file_errors(path):
        return content.decode("utf-8-sig")


def build_exact_float_options() -> dict[str, Any]:
    """Return the options with which `pandas.read_csv` reads floats exactly.

    pandas 3.1 does so by default and deprecates the option.
    """
    import pandas as pd

    major, minor = map(int, pd.__version__.split(".")[:2])
    return {} if (major, minor) >= (3, 1) else {"float_precision": "round_trip"}


def read_json(path: Path | str) -> Any:
    """Read a JSON file, and return its content as Python objects.

    Raises
    ------
    OSError
        If the file cannot be read.
    FileError
        If the file is not valid JSON.
    """
    text = read_text(path)
    with convert_file_errors(path):
        return parse_json(text)


def parse_json(text: str) -> Any:
    """Parse JSON text, and reject the nonstandard constants NaN and Infinity.

    Raises
    ------
    ValueError
        If the text is not valid JSON.
    """
    return json.loads(text, parse_constant=_reject_constant)


def _reject_constant(name: str) -> float:
    raise ValueError(f"{name} is not a finite number")


def decode_npz(content: bytes) -> dict[str, NDArray[Any]]:
    """Read arrays from the content of an .npz file, without unpickling objects.

    Only arrays of numbers and text are accepted.

    Returns
    -------
    dict of str to array
        Arrays, keyed by name.

    Raises
    ------
    ValueError
        If the content is not an .npz archive, or contains an array of another kind.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = dict(archive)
    except Exception as error:  # zipfile, zlib and numpy raise various errors.
        raise ValueError(f"not an archive of arrays: {type(error).__name__}: {error}") from error
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray) or array.dtype.kind not in "biufU":
            raise ValueError(
                f"not an archive of arrays: {name!r} is not an array of numbers or text"
            )
    return arrays


def encode_csv(table: pd.DataFrame) -> bytes:
    """Encode a DataFrame as the content of a CSV file.

    Floats are exact, and NaN is written as ``nan``.
    """
    text: str = table.to_csv(index=False, na_rep="nan", lineterminator="\n")
    return text.encode()


def read_numeric_table(path: Path) -> pd.DataFrame:
    """Read a CSV file of finite numbers into a DataFrame, without loss of precision.

    Raises
    ------
    OSError
        If the file cannot be read.
    FileError
        If the file is not a table, or a value is not a finite number. The message contains the row
        and the column.
    """
    import pandas as pd

    text = read_text(path)
    with convert_file_errors(path):
        table = pd.read_csv(io.StringIO(text), keep_default_na=False, **build_exact_float_options())
        if not isinstance(table.index, pd.RangeIndex):
            raise ValueError(f"rows are longer than the header {list(table.columns)!r:.200}")
        values: pd.DataFrame = table.apply(pd.to_numeric, errors="coerce").astype(float)
        for name in values:
            is_finite = np.isfinite(values[name])
            if not is_finite.all():
                row = int(np.argmin(is_finite))
                value = table[name].iloc[row]
                raise ValueError(f"row {row + 1}, {name} = {value!r:.40}: expected a finite number")
    return values
