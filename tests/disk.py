"""Disks with little room."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

try:
    import resource
except ImportError:
    resource = None


@contextmanager
def room(limit: int) -> Iterator[None]:
    """Files of this process cannot grow beyond so many bytes: writes fail as on a full disk."""
    if resource is None:
        pytest.skip("a process whose files cannot be limited")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
