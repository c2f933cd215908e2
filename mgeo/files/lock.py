"""One process a folder: two runs that wrote into the same one would spoil each other's files."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def lock(folder: Path) -> Iterator[None]:
    """Keep other processes that ask out of a folder, while the context lasts.

    The operating system releases the lock when the process ends, in whatever way, and nobody else
    can take it before. No file stands for it.

    Raises
    ------
    ValueError
        If another process has it.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise ValueError(f"{folder} is in use: another process is running there") from error
        yield
    finally:
        os.close(descriptor)
