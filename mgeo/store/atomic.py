"""Atomic writing of files, and a lock that lets one process at a time write into a folder."""

from __future__ import annotations

import io
import json
import os
import secrets
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from filelock import FileLock, Timeout
from numpy.typing import NDArray

#: File that is locked while a process writes into the folder.
LOCK_FILE = ".mgeo-lock"
_PROBE = 2**16  # bytes that must fit on the disk: the tables of a small front


def write_file(path: Path | str, content: bytes) -> None:
    """Write a file. Readers see the old content or the new content, never a part of it.

    Raises
    ------
    OSError
        If the file cannot be written. An existing file is then unchanged.
    """
    path = Path(path)
    write_files(path.parent, {path.name: content})


def write_files(folder: Path | str, contents: Mapping[str, bytes]) -> None:
    """Write several files into a folder. All are on the disk before the first one is renamed.

    A full disk therefore leaves the folder unchanged. Files are renamed in the given order. The
    last file marks the set as complete: an existing one is removed before the others are replaced.

    Raises
    ------
    OSError
        If a file cannot be written. The error names the file.
    """
    folder = Path(folder)
    staged: dict[Path, Path] = {}
    try:
        for name, content in contents.items():
            temporary = folder / f".{name}.{secrets.token_hex(8)}.tmp"
            staged[temporary] = folder / name
            # "x" refuses an existing file or link, which another user may have placed there
            with _errors_name(folder / name), temporary.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        *others, last = staged.values()
        if others:
            last.unlink(missing_ok=True)
        for temporary, path in staged.items():
            os.replace(temporary, path)
    except BaseException:
        for temporary in staged:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
        raise


def check_writable(folder: Path | str) -> None:
    """Check that files can be written into a folder, or into its nearest existing parent.

    Raises
    ------
    OSError
        If a small file cannot be written. The error names the folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        folder = next(parent for parent in folder.absolute().parents if parent.is_dir())
    with _errors_name(folder), tempfile.TemporaryFile(dir=folder) as file:
        file.write(bytes(_PROBE))
        file.flush()


def to_json(document: Mapping[str, Any]) -> bytes:
    """Return the content of a JSON file. Floats are written by repr and read back exactly.

    Raises
    ------
    TypeError, ValueError
        For values that JSON cannot hold, such as an infinity.
    """
    return (json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n").encode()


def to_npz(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the content of an .npz file with these arrays of numbers."""
    named: dict[str, Any] = dict(arrays)
    content = io.BytesIO()
    np.savez(content, **named)
    return content.getvalue()


@contextmanager
def lock(folder: Path, patience: float = 0.0) -> Iterator[None]:
    """Hold the lock of a folder. The operating system releases it when the process ends.

    Parameters
    ----------
    patience
        Time to wait for another process [s].

    Raises
    ------
    ValueError
        If another process still holds the lock.
    OSError
        If the lock file cannot be written.
    """
    guard = FileLock(folder / LOCK_FILE)
    try:
        guard.acquire(timeout=patience)
    except Timeout:
        raise ValueError(f"{folder} is in use: another process is running there") from None
    try:
        yield
    finally:
        with suppress(OSError):  # Windows does not remove an open file
            (folder / LOCK_FILE).unlink()  # who waits for it notices that, and creates another
        guard.release()


@contextmanager
def _errors_name(path: Path) -> Iterator[None]:
    """Add the path to errors of the operating system, which has none when the disk is full."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
