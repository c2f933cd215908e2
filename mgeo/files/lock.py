"""One process a folder: two runs that wrote into the same one would spoil each other's files."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def sole_use(folder: Path) -> Iterator[None]:
    """Keep other processes that ask out of a folder, while the context lasts.

    The operating system forgets it when the process ends, in whatever way. On Windows nobody is
    kept out.

    Raises
    ------
    ValueError
        If another process uses it.
    """
    if sys.platform == "win32":
        yield
        return
    import fcntl

    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise ValueError(f"{folder} is in use: another process is running there") from error
        yield
    finally:
        os.close(descriptor)
