"""Files that are written whole or not at all, what can be in them, and one process a folder.

Two runs that wrote into the same folder would spoil each other's files.
"""

from __future__ import annotations

import errno
import io
import json
import os
import re
import secrets
import stat
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

try:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

except ImportError:  # Windows
    import msvcrt

    def _lock(descriptor: int) -> None:
        # one byte, which need not be there
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]


_TICK = 0.05  # seconds until a lock is tried again
_PROBE = 2**16  # bytes that must have room: tables of a small front


def write_file(path: Path | str, content: bytes) -> None:
    """Write one file; a reader sees the old content or the new one, never a part.

    Raises
    ------
    OSError
        If it cannot be written; what was there before is then unchanged.
    """
    path = Path(path)
    write_files(path.parent, {path.name: content})


def write_files(folder: Path | str, contents: Mapping[str, bytes]) -> None:
    """Write several files of one folder; all reach the disk before the first takes its name.

    So a full disk leaves the folder as it was. They take their names in the order given: what
    tells a reader that the others are complete goes last. Of several, an old one of its name goes
    first, or who is killed in between would leave it beside what it does not belong to.

    Raises
    ------
    OSError
        If one cannot be written, or its name is that of a folder, a pipe or a device.
    """
    folder = Path(folder)
    staged: dict[Path, Path] = {}
    for name in contents:
        _check_replaceable(folder / name)
    try:
        for name, content in contents.items():
            temporary = folder / f".{name}.{secrets.token_hex(8)}.tmp"
            staged[temporary] = folder / name
            # "x": never write into a file (or through a link) that somebody else put there
            with _named(folder / name), temporary.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        *others, last = staged.values()
        if others:
            with _named(last):
                last.unlink(missing_ok=True)
        for temporary, path in staged.items():
            with _named(path):
                os.replace(temporary, path)
    except BaseException:  # an interrupt must not leave temporary files either
        for temporary in staged:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
        raise
    _sync_folder(folder)


def check_writable(folder: Path | str) -> None:
    """Refuse a folder into which nothing can be written, or a full disk, before hours of work.

    Of one that is not there yet the nearest folder above it is tried.

    Raises
    ------
    OSError
        Naming the folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        folder = next(parent for parent in folder.absolute().parents if parent.is_dir())
    with _named(folder), tempfile.TemporaryFile(dir=folder) as file:
        file.write(bytes(_PROBE))
        file.flush()
        os.fsync(file.fileno())


def to_json(document: Mapping[str, Any]) -> bytes:
    """A document as the content of a JSON file; floats by repr, so that they read back exactly.

    Raises
    ------
    TypeError, ValueError
        For what JSON cannot hold, such as an infinity.
    """
    return (json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n").encode()


def to_npz(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays of numbers as the content of an .npz file."""
    named: dict[str, Any] = dict(arrays)  # names that np.savez cannot take for its options
    content = io.BytesIO()
    np.savez(content, **named)
    return content.getvalue()


def remove_leftovers(path: Path | str) -> None:
    """Remove what processes that were killed while they wrote this file have left beside it.

    Only for a file that nobody else is writing at the time.
    """
    path = Path(path)
    pattern = re.compile(rf"\.{re.escape(path.name)}\.[0-9a-f]{{16}}\.tmp")
    for entry in path.parent.iterdir():
        if pattern.fullmatch(entry.name):
            entry.unlink(missing_ok=True)


def replace_files(folder: Path, contents: Mapping[str, bytes]) -> None:
    """As `write_files`, by who alone writes these: what a killed process left of them goes, too."""
    for name in contents:
        remove_leftovers(folder / name)
    write_files(folder, contents)


@contextmanager
def _named(path: Path | str) -> Iterator[None]:
    """Errors name what was to be written: a full disk's name nothing."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def _check_replaceable(path: Path) -> None:
    # taking the name of a device, /dev/null say, would spoil it for everybody
    with suppress(FileNotFoundError):
        kind = stat.S_IFMT(path.lstat().st_mode)
        if kind == stat.S_IFDIR:
            raise IsADirectoryError(f"{path} is a folder: expected a file, or none yet")
        if kind not in (stat.S_IFREG, stat.S_IFLNK):
            raise FileExistsError(f"{path} is a pipe or a device: expected a file, or none yet")


def _sync_folder(folder: Path) -> None:
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except PermissionError:  # it may be written but not read: the files have their names
        return
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # of file systems that cannot sync a folder
            raise
    finally:
        os.close(descriptor)


#: The file that is locked. It is there while somebody works, or after that was killed.
LOCK_FILE = ".mgeo-lock"


@contextmanager
def lock(folder: Path, patience: float = 0.0) -> Iterator[None]:
    """Keep other processes that ask out of a folder, while the context lasts.

    The operating system releases the lock when the process ends, in whatever way, and nobody else
    can take it before. A file is locked, not the folder itself: network file systems lock only
    what is open for writing.

    Parameters
    ----------
    patience
        Time [s] to wait for another process.

    Raises
    ------
    ValueError
        If another process has it, still.
    OSError
        If nothing can be written into the folder.
    """
    path, until = folder / LOCK_FILE, time.monotonic() + patience
    descriptor = _locked(path, until)
    while not _is_same(path, descriptor):  # who had it before has removed it meanwhile
        os.close(descriptor)
        descriptor = _locked(path, until)
    try:
        yield
    finally:
        gone = not _is_same(path, descriptor) or _removed(path)
        os.close(descriptor)
        if not gone:  # Windows removes nothing that is open, nor what somebody else has now
            _removed(path)


def _locked(path: Path, until: float) -> int:
    no_follow = getattr(os, "O_NOFOLLOW", None)
    if no_follow is None and path.is_symlink():
        raise OSError(errno.ELOOP, "is a symbolic link", str(path))
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | (no_follow or 0), 0o666)
        try:
            _lock(descriptor)
        except (BlockingIOError, PermissionError) as error:
            os.close(descriptor)
            if time.monotonic() >= until:
                told = f"{path.parent} is in use: another process is running there"
                raise ValueError(told) from error
        except BaseException:
            os.close(descriptor)
            raise
        else:
            return descriptor
        time.sleep(_TICK)


def _removed(path: Path) -> bool:
    try:
        path.unlink()
    except PermissionError:
        return False
    return True


def _is_same(path: Path, descriptor: int) -> bool:
    with suppress(FileNotFoundError):
        return os.path.samestat(path.lstat(), os.fstat(descriptor))
    return False
