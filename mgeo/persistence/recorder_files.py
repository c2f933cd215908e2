"""The files of a record: chunks of rows that never change, and an index that names them.

``index.json`` is replaced as a whole and lists the chunks, in order, with the SHA-256 of each; a
chunk is an .npz archive of the columns. So whoever reads the index first sees a consistent record
at any time, also while a run adds to it.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from mgeo.files.atomic import remove_leftovers, to_npz, write_file
from mgeo.files.reading import FileError, entry, errors_of, from_npz, read_file, read_json

FORMAT = 1
INDEX = "index.json"
COLUMNS = ("generation", "X", "F", "G", "H", "failed")
_CHUNK = re.compile(r"rows-\d{12}-\d{12}\.npz")

Rows = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Chunk:
    """Rows of the generations `first` to `last`, in one file."""

    file: str
    rows: int
    first: int
    last: int
    sha256: str


@dataclass(frozen=True)
class Index:
    """What a record consists of: names of the variables and objectives, and its chunks."""

    variables: Sequence[str]
    objectives: Sequence[str]
    chunks: tuple[Chunk, ...] = ()

    @property
    def rows(self) -> int:
        """Rows of all chunks."""
        return sum(chunk.rows for chunk in self.chunks)


def read_index(folder: Path) -> Index | None:
    """The index in a folder, None if there is none.

    Raises
    ------
    ValueError : if it is not as `write_index` writes it, or of another version.
    """
    path = folder / INDEX
    try:
        data = read_json(path)
    except FileNotFoundError:
        return None
    with errors_of(path):
        found = entry(data, "format", int)
        if found != FORMAT:
            raise ValueError(f"format = {found!r}: this version of mgeo reads format {FORMAT}")
        X, F = (entry(data, key, list[str]) for key in ("variables", "objectives"))
        if len({*X, *F}) < len(X) + len(F):
            raise ValueError("variables and objectives: expected different names")
        tables = enumerate(entry(data, "chunks", list))
        return Index(X, F, tuple(_chunk(table, f"chunks[{i}].") for i, table in tables))


def write_index(folder: Path, index: Index) -> None:
    """Replace the index, then remove chunks that it does not name."""
    data = {"format": FORMAT, **asdict(index)}
    write_file(folder / INDEX, json.dumps(data, indent=1, allow_nan=False).encode())
    named = {chunk.file for chunk in index.chunks}
    for path in folder.iterdir():
        if _CHUNK.fullmatch(path.name) and path.name not in named:
            path.unlink(missing_ok=True)


def remove_record(folder: Path) -> None:
    """Remove a record, if there is one; other files in the folder stay."""
    if not (folder / INDEX).exists():
        return
    write_index(folder, Index([], []))
    remove_partial_files(folder)
    (folder / INDEX).unlink()
    with suppress(OSError):  # other files are in it
        folder.rmdir()


def remove_partial_files(folder: Path) -> None:
    """Remove what a process that was killed while it wrote here has left."""
    for name in {
        INDEX,
        *(re.sub(r"^\.|\.[0-9a-f]{16}\.tmp$", "", p.name) for p in folder.iterdir()),
    }:
        if name == INDEX or _CHUNK.fullmatch(name):
            remove_leftovers(folder / name)


def write_chunk(folder: Path, start: int, rows: Rows) -> Chunk:
    """Write rows as the chunk that begins with row number `start`."""
    content = to_npz({name: rows[name] for name in COLUMNS})
    n = len(rows["generation"])
    file = f"rows-{start:012}-{start + n:012}.npz"
    write_file(folder / file, content)
    first, last = int(rows["generation"][0]), int(rows["generation"][-1])
    return Chunk(file, n, first, last, hashlib.sha256(content).hexdigest())


def read_chunk(folder: Path, index: Index, chunk: Chunk) -> Rows:
    """The rows of a chunk.

    Raises
    ------
    FileNotFoundError : if it is not there (any more).
    ValueError : if it is damaged.
    """
    path = folder / chunk.file
    content = read_file(path)
    if hashlib.sha256(content).hexdigest() != chunk.sha256:
        raise FileError(f"{path} is damaged: it is not what the index says")
    with errors_of(path):
        rows = from_npz(content)
        widths = {"X": len(index.variables), "F": len(index.objectives)}
        for name in COLUMNS:
            shape = rows[name].shape if name in rows else ()
            columns = () if name not in "XFGH" else (widths.get(name, shape[-1] if shape else 0),)
            kinds = {"generation": "iu", "failed": "b"}.get(name, "biuf")
            if name in rows and rows[name].dtype.kind not in kinds:
                raise ValueError(f"{name} holds entries of {rows[name].dtype}")
            if shape != (chunk.rows, *columns):
                raise ValueError(f"{name} of shape {shape}: expected {(chunk.rows, *columns)}")
        return rows


def _chunk(table: Any, where: str) -> Chunk:
    values = {f.name: entry(table, f.name, int, where) for f in fields(Chunk) if f.type == "int"}
    file, sha256 = (entry(table, key, str, where) for key in ("file", "sha256"))
    if not _CHUNK.fullmatch(file):  # no other file, wherever it may be
        raise ValueError(f"{where}file = {file!r}: expected rows-FROM-TO.npz")
    return Chunk(file, **values, sha256=sha256)


def cut(folder: Path, index: Index, generation: int) -> tuple[Index, Rows | None]:
    """The part of a record before a generation: whole chunks, and the rows of a chunk cut off."""
    whole = tuple(chunk for chunk in index.chunks if chunk.last < generation)
    broken = [chunk for chunk in index.chunks if chunk.first < generation <= chunk.last]
    if not broken:
        return replace(index, chunks=whole), None
    rows = read_chunk(folder, index, broken[0])
    kept = rows["generation"] < generation
    return replace(index, chunks=whole), {name: column[kept] for name, column in rows.items()}
