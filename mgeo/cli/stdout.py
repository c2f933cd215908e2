"""Stdout for a document alone, whatever else is printed."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import TextIO

import typer

_C_LIBRARY = "ucrtbase" if os.name == "nt" else None  # None: what this process has loaded
_kept: list[TextIO] = []  # stdout itself, while it is reserved


@contextmanager
def reserved() -> Iterator[None]:
    """Meanwhile `write` alone writes to stdout; what anybody prints goes to stderr.

    So it does from threads and processes that are started meanwhile, and from compiled code, which
    knows nothing of `sys.stdout`: it is the descriptor that is changed.
    """
    if _kept or sys.stdout is None:
        yield
        return
    try:
        is_descriptor = sys.stdout.fileno() == 1
    except OSError:  # of a stream in memory
        is_descriptor = False
    if not is_descriptor:
        _kept.append(sys.stdout)
        try:
            with redirect_stdout(sys.stderr):
                yield
        finally:
            _kept.clear()
        return
    stdout = sys.stdout
    stdout.flush()
    with open(os.dup(1), "w", encoding=stdout.encoding, errors=stdout.errors) as document:
        os.dup2(2, 1)
        _kept.append(document)
        try:
            yield
        finally:
            _kept.clear()
            stdout.flush()
            # what compiled code has printed and C still holds
            ctypes.CDLL(_C_LIBRARY).fflush(None)
            os.dup2(document.fileno(), 1)


def write(text: str) -> None:
    """Write a line to stdout, also while it is reserved."""
    file = _kept[0] if _kept else sys.stdout
    typer.echo(text, file=file)


def reserve(ctx: typer.Context, wanted: bool) -> bool:
    """Callback of the flag --json: stdout is the document's until all of the command has ended."""
    if wanted and not ctx.resilient_parsing:
        ctx.find_root().with_resource(reserved())
    return wanted
