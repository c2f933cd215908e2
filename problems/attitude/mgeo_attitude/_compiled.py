"""Decorators for functions that numba compiles.

numba caches machine code on disk under names that are unique in one process only. If two functions
share a name, for example two closures of the same text, code cached by one process may call the
other function cached by another process (numba/numba#10486) without an error. A cache file of one
signature may also contain the code of another signature that a second process compiled at the same
time. Therefore all compiled functions have different names, and a cached function has one
signature.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from numba import njit

P = ParamSpec("P")
T = TypeVar("T")

#: Decorator for functions that are compiled into their callers. They are not cached separately.
helper = njit(error_model="numpy")


def compile_cached(signature: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Return a decorator that compiles a function with numba and caches the result on disk.

    The function is compiled for one signature. The cache lies next to the source file of the
    function. A function without one is not cached.

    Parameters
    ----------
    signature : str
        Signature in numba's notation, such as "float64(float64[:,::1])". Arguments of other types
        raise TypeError.

    Returns
    -------
    decorator
    """

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        # A module that exists only in memory has no file to cache next to.
        file = Path(function.__code__.co_filename).is_file()
        compiled_function: Callable[P, T] = njit(
            signature, cache=file, error_model="numpy", nogil=True
        )(function)
        return compiled_function

    return decorate


def compile_on_first_call(signature: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Return a decorator that compiles a function with numba when it is first called.

    The machine code is cached as by `compile_cached`.

    Parameters
    ----------
    signature : str
        See `compile_cached`.

    Returns
    -------
    decorator
    """

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        @cache
        def compiled() -> Callable[P, T]:
            return compile_cached(signature)(function)

        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            return compiled()(*args, **kwargs)

        return call

    return decorate
