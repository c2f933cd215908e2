"""Bad input becomes one line on stderr and exit code 2."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer

BAD_INPUT = 2


@contextmanager
def one_line_errors(
    debug: bool, kinds: tuple[type[Exception], ...] = (ValueError, TypeError, OSError)
) -> Iterator[None]:
    """Report what a user can put right without a traceback, unless `debug`.

    For code that reads and checks input or writes files. Errors of other kinds are bugs, here or
    in a plugin, and keep their traceback.
    """
    try:
        yield
    except kinds as error:
        if debug:
            raise
        message = " ".join(str(error).split()) or type(error).__name__
        typer.echo(f"Error: {message}", err=True)
        raise typer.Exit(BAD_INPUT) from error
