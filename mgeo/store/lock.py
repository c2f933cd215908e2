"""One process a folder: two runs that wrote into the same one would spoil each other's files."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

except ImportError:  # Windows
    import msvcrt

    def _lock(descriptor: int) -> None:
        # one byte, which need not be there
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]


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
        gone = not _is_same(path, descriptor) or _removed(path)
        os.close(descriptor)
        if not gone:  # Windows removes nothing that is open, nor what somebody else has now
            _removed(path)


def _locked(path: Path) -> int:
    no_follow = getattr(os, "O_NOFOLLOW", None)
    if no_follow is None and path.is_symlink():
        raise OSError(errno.ELOOP, "is a symbolic link", str(path))
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | (no_follow or 0), 0o666)
    try:
        _lock(descriptor)
    except (BlockingIOError, PermissionError) as error:
        os.close(descriptor)
        raise ValueError(f"{path.parent} is in use: another process is running there") from error
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


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
