"""The file of a record: an SQLite database with the names of its columns and a row a generation.

A row holds the generation's candidates as one blob of `row_type`, the type of X in it, and the
CRC-32 of all this and of the names. SQLite's WAL mode keeps it whole whenever who writes is killed.
"""

from __future__ import annotations

import json
import re
import sqlite3
import time
import zlib
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mgeo.store.atomic import remove_leftovers, write_file
from mgeo.store.reading import parse_json
from mgeo.validation.entries import FileError, entry, errors_of

NAME = "record.sqlite"
FORMAT = 3
_BESIDE = ("-journal", "-wal", "-shm")  # files in which SQLite keeps what is under way
_ATTEMPTS = 3  # at reading a record that stands still
_TICK = 0.01  # seconds in which a file's time may not tell that it was written
_PATIENCE = 60.0  # seconds to wait for another process
_TABLES = [
    "CREATE TABLE names (X TEXT, F TEXT, G TEXT, H TEXT)",
    "CREATE TABLE generations (number INTEGER PRIMARY KEY, dtype TEXT, candidates, crc32)",
]

Names = dict[str, list[str]]  # of the columns of X, F, G and H
Rows = NDArray[np.void]  # of `row_type`


def row_type(names: Names, dtype: str = "<f8") -> np.dtype[np.void]:
    """What is recorded of a candidate: X of this type, F, G and H as float64, and ``failed``.

    Raises
    ------
    ValueError : if the type is none of little-endian numbers.
    """
    if not re.fullmatch(r"[<|][biuf][1248]", dtype):
        raise ValueError(f"dtype = {dtype!r:.80}: expected one of numbers")
    types = {"X": dtype, "F": "<f8", "G": "<f8", "H": "<f8"}
    arrays = [(key, types[key], (len(names[key]),)) for key in types]
    return np.dtype([*arrays, ("failed", "?")])


def create(folder: Path, names: Names) -> None:
    """Begin a record, in place of one that may be there."""
    remove(folder)
    folder.mkdir(parents=True, exist_ok=True)
    write_file(folder / NAME, b"")  # a link or another file of this name is never written into
    with _opened(folder, "rw") as database:
        database.execute("PRAGMA journal_mode=WAL")
        with database:
            database.execute("BEGIN")
            for table in _TABLES:
                database.execute(table)
            texts = [json.dumps(names[key]) for key in "XFGH"]
            database.execute("INSERT INTO names VALUES (?, ?, ?, ?)", texts)
            database.execute(f"PRAGMA user_version={FORMAT}")


def append(folder: Path, generations: Iterable[tuple[int, Rows]]) -> None:
    """Add generations, with their numbers: all of them, or none if that fails.

    Raises
    ------
    OSError : if they cannot be written.
    """
    with _opened(folder, "rw") as database, database:
        names = _names(database)
        for number, rows in generations:
            content = rows.dtype["X"].base.str, rows.tobytes()
            row = number, *content, crc32_of(names, number, *content)
            database.execute("INSERT INTO generations VALUES (?, ?, ?, ?)", row)


def cut(folder: Path, names: Names, generation: int) -> None:
    """Remove a generation and those after it.

    Raises
    ------
    ValueError : if there is no record, or that of another problem, or one that ends before.
    """
    expected = f"the generations before {generation}"
    try:
        with _opened(folder, "rw") as database, database:
            if _names(database) != names:
                raise ValueError("it is the record of another problem")
            database.execute("DELETE FROM generations WHERE number >= ?", [generation])
            ((last,),) = database.execute("SELECT ifnull(max(number), 0) FROM generations")
            if last != generation - 1:
                raise ValueError(f"it ends with generation {last}: expected {expected}")
    except FileNotFoundError as error:
        raise FileError(f"{error}: expected that of {expected}") from error


def read(folder: Path) -> tuple[Names, list[Rows]]:
    """Names, and the rows of each generation.

    It may be called while a run adds some.

    Raises
    ------
    FileNotFoundError : if there is no record.
    ValueError : if it is damaged, or of another version.
    """
    in_vain = 0
    while True:
        before = _stamps(folder)
        try:
            return _read(folder)
        except (FileError, OSError):
            time.sleep(_TICK)
            in_vain += _stamps(folder) == before  # else a run has written meanwhile
            if in_vain == _ATTEMPTS:
                raise


def remove(folder: Path) -> None:
    """Remove a record, if there is one, and what a killed process left of it; others stay."""
    with suppress(OSError):  # it is not there, or may not be looked through
        remove_leftovers(folder / NAME)
    for path in _files(folder):
        path.unlink(missing_ok=True)
    with suppress(OSError):  # other files are in it, or it is not there
        folder.rmdir()


def _stamps(folder: Path) -> list[tuple[int, int]]:
    """Size and time of each file, to tell whether a record has changed."""
    stats = []
    for path in _files(folder):
        with suppress(OSError):
            found = path.stat()
            stats.append((found.st_size, found.st_mtime_ns))
    return stats


def _files(folder: Path) -> list[Path]:
    return [folder / f"{NAME}{end}" for end in ("", *_BESIDE)]


@contextmanager
def _opened(folder: Path, mode: str) -> Iterator[sqlite3.Connection]:
    path, journal, wal, _ = _files(folder)
    if not path.exists():
        if (folder / "index.json").exists():
            raise FileError(f"{folder} holds a record of an earlier mgeo: expected {NAME} in it")
        raise FileNotFoundError(f"{folder} holds no record")
    if path.is_symlink() or not path.is_file():
        raise FileError(f"{path} is a link, a folder, a pipe or a device: expected a file")
    if mode == "rw":
        journal.unlink(missing_ok=True)  # never ours, and it could name any file to be removed
    elif not wal.exists():  # nobody is at it: nothing is locked, nor any file made beside it
        mode = "ro&immutable=1"
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    try:
        with closing(sqlite3.connect(uri, uri=True, timeout=_PATIENCE)) as database:
            database.execute("PRAGMA trusted_schema=OFF")
            with errors_of(path):
                yield database
    except FileNotFoundError as error:
        raise FileNotFoundError(f"{folder} holds no record") from error
    except sqlite3.OperationalError as error:
        raise OSError(f"{path}: {error}") from error
    except sqlite3.DatabaseError as error:
        raise FileError(f"{path} is damaged: {error}") from error


def _names(database: sqlite3.Connection) -> Names:
    """The names, of a database that has our tables and nothing else."""
    ((version,),) = database.execute("PRAGMA user_version")
    if version == 0:  # it is being created
        raise FileNotFoundError
    if version != FORMAT:
        raise ValueError(f"format = {version!r}: this version of mgeo reads format {FORMAT}")
    if [sql for (sql,) in database.execute("SELECT sql FROM sqlite_schema LIMIT 3")] != _TABLES:
        raise ValueError("damaged: it has other tables")
    for texts in database.execute("SELECT * FROM names"):
        read = {key: parse_json(str(text)) for key, text in zip("XFGH", texts, strict=True)}
        names: Names = {key: entry(read, key, list[str]) for key in read}
        if len({*names["X"], *names["F"]}) < len(names["X"]) + len(names["F"]):
            raise ValueError("variables and objectives: expected different names")
        return names
    raise ValueError("damaged: it has no names")


def _read(folder: Path) -> tuple[Names, list[Rows]]:
    with _opened(folder, "ro") as database:
        left = sum(path.stat().st_size for path in _files(folder) if path.exists())
        names = _names(database)
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, left)
        found: list[Rows] = []
        for number, *content, check in database.execute("SELECT * FROM generations ORDER BY 1"):
            dtype, candidates = content
            left -= len(candidates)
            # damaged pages could also lead round in circles
            if left < 0 or number != len(found) + 1 or check != crc32_of(names, number, *content):
                raise ValueError(f"damaged: generation {len(found) + 1} is not what was written")
            found.append(np.frombuffer(candidates, row_type(names, dtype)))
        return names, found


def crc32_of(names: Names, number: int, dtype: str, candidates: bytes) -> int:
    return zlib.crc32(candidates, zlib.crc32(f"{json.dumps(names)} {number} {dtype}".encode()))
