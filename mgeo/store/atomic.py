"""Atomic writing of files, and a lock that restricts writing into a folder to one process."""

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
from numpy.typing import NDArray

#: Name of the file that is locked while a process writes into its folder.
LOCK_FILE = ".mgeo-lock"
_PROBE_SIZE = 2**16  # Free disk space required before a run [bytes], enough for a small front.


def write_file(path: Path | str, content: bytes) -> None:
    """Write a file atomically, so that readers see either the old or the new content.

    Raises
    ------
    OSError
        If the file cannot be written. An existing file is then unchanged.
    """
    path = Path(path)
    write_files(path.parent, {path.name: content})


def write_files(folder: Path | str, contents: Mapping[str, bytes]) -> None:
    """Write several files into a folder. A full disk leaves all existing files unchanged.

    All contents are written to temporary files before the first one is renamed. Files are renamed
    in the given order. The last file marks the set as complete, so an existing one is removed
    before the first file is renamed.

    Parameters
    ----------
    folder : path
        Existing folder.
    contents : mapping of str to bytes
        Contents, keyed by file name.

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
            # Mode "x" refuses an existing file or link, which another user may have created.
            with _add_path_to_errors(folder / name), temporary.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        *previous, last = staged.values()
        if previous:
            last.unlink(missing_ok=True)
        for temporary, path in staged.items():
            os.replace(temporary, path)
    except BaseException:
        for temporary in staged:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
        raise


def check_writable(folder: Path | str) -> None:
    """Raise OSError if a folder is not writable.

    If the folder does not exist, its nearest existing parent is checked.

    Raises
    ------
    OSError
        If a file of 64 KiB cannot be written. The error names the folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        folder = next(parent for parent in folder.absolute().parents if parent.is_dir())
    with _add_path_to_errors(folder), tempfile.TemporaryFile(dir=folder) as file:
        file.write(bytes(_PROBE_SIZE))
        file.flush()


def encode_json(document: Mapping[str, Any]) -> bytes:
    """Encode a dict as the content of a JSON file.

    Floats have the shortest form that restores their exact value.

    Raises
    ------
    TypeError, ValueError
        If a value has no JSON form, such as an infinity.
    """
    return (json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n").encode()


def encode_npz(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Encode named numeric arrays as the content of an .npz file."""
    named: dict[str, Any] = dict(arrays)
    content = io.BytesIO()
    np.savez(content, **named)
    return content.getvalue()


@contextmanager
def lock_folder(folder: Path, timeout: float = 0.0) -> Iterator[None]:
    """Context manager that locks a folder, so that no other process can write into it.

    The operating system releases the lock if the process is killed.

    Parameters
    ----------
    folder : Path
        Existing folder.
    timeout : float
        Maximum time to wait for another process [s].

    Raises
    ------
    ValueError
        If another process still holds the lock.
    OSError
        If the lock file cannot be written.
    """
    from filelock import FileLock, Timeout  # This optional dependency is needed only here.

    lock = FileLock(folder / LOCK_FILE)
    try:
        lock.acquire(timeout=timeout)
    except Timeout:
        raise ValueError(f"{folder} is in use: another process is running there") from None
    try:
        yield
    finally:
        with suppress(OSError):  # Windows does not remove an open file.
            (folder / LOCK_FILE).unlink()  # A waiting process detects this and creates a new file.
        lock.release()


@contextmanager
def _add_path_to_errors(path: Path) -> Iterator[None]:
    """Context manager that adds a path to the message of an OSError.

    A full disk gives errors without a path.
    """
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
