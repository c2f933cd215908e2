"""One process a folder: two runs that wrote into the same one would spoil each other's files."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: The file that is locked. It is there while somebody works, or after that was killed.
LOCK_FILE = ".mgeo-lock"


@contextmanager
def lock(folder: Path) -> Iterator[None]:
    """Keep other processes that ask out of a folder, while the context lasts.

    The operating system releases the lock when the process ends, in whatever way, and nobody else
    can take it before. A file is locked, not the folder itself: network file systems lock only
    what is open for writing.

    Raises
    ------
    ValueError
        If another process has it.
    OSError
        If nothing can be written into the folder.
    """
    path = folder / LOCK_FILE
    descriptor = _locked(path)
    while not _is_same(path, descriptor):  # who had it before has removed it meanwhile
        os.close(descriptor)
        descriptor = _locked(path)
    try:
        yield
    finally:
        if _is_same(path, descriptor):
            path.unlink()
        os.close(descriptor)


def _locked(path: Path) -> int:
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise ValueError(f"{path.parent} is in use: another process is running there") from error
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _is_same(path: Path, descriptor: int) -> bool:
    with suppress(FileNotFoundError):
        return os.path.samestat(path.lstat(), os.fstat(descriptor))
    return False
