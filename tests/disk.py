"""Simulation of a full disk."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

try:
    import resource
except ImportError:
    resource = None


@contextmanager
def room(limit: int) -> Iterator[None]:
    """Context manager that limits the size of the files that this process writes, in bytes.

    Writing more fails as on a full disk.
    """
    if resource is None:
        pytest.skip("the size of files cannot be limited on this platform")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
