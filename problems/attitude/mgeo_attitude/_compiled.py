"""Two kinds of compiled functions: parts of others, and those that Python calls, kept on disk.

numba keeps machine code under names that are unique in one process alone: a function's own name and
a number that counts what the process has compiled. Where two functions have one name, such as two
closures of one text, code that one process has written may call the other's that another process
has written (numba/numba#10486), and nothing says so. A file that is kept for one signature may hold
the code of another that a second process compiled at the same time. Hence no two compiled functions
have the same name, and what is kept has one signature.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from numba import njit

P = ParamSpec("P")
T = TypeVar("T")

#: Functions that are compiled into those that call them. They have no file of their own.
helper = njit(error_model="numpy")


def kept(signature: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Compile a function for one signature, and keep it beside its file if it has one.

    Parameters
    ----------
    signature : str
        In numba's words, such as "float64(float64[:,::1])". Other arguments raise TypeError.
    """

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        file = Path(function.__code__.co_filename).is_file()  # or a module that is in memory alone
        made: Callable[P, T] = njit(signature, cache=file, error_model="numpy", nogil=True)(
            function
        )
        return made

    return decorate


def entry(signature: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """One that is `kept`, and compiled when Python first calls it."""

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        @cache
        def compiled() -> Callable[P, T]:
            return kept(signature)(function)

        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            return compiled()(*args, **kwargs)

        return call

    return decorate
