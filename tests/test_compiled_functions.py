"""Compiled functions that numba caches on disk: unique names, and one signature each.

numba names cache files by function and signature. If two functions have equal names, or if two
processes compile different signatures at the same time, one can load the code of the other
(numba/numba#10486). This happens rarely and without an error, so that the tests check the names and
signatures in the objects of numba.
"""

import inspect
from functools import partial
from pkgutil import iter_modules

import pytest
from mgeo_attitude.filter.kernel import load_driver
from mgeo_calibration.estimation import kernels
from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher

WITHOUT_LOOPS = ("algebra", "signatures")
SMOOTHER = [
    pytest.param(
        partial(kernels.load_compiled_module, name), id=name, marks=[pytest.mark.slow] * is_slow
    )
    for _, name, _ in iter_modules(kernels.__path__)
    if name not in WITHOUT_LOOPS
    for is_slow in [name == "process_noise"]  # No other fast test compiles this module.
]


def called_functions(function):
    """Return the compiled functions that a compiled function calls."""
    scope = inspect.getclosurevars(function.py_func)
    return {
        each
        for each in (*scope.globals.values(), *scope.nonlocals.values())
        if isinstance(each, Dispatcher)
    }


@pytest.mark.parametrize("load", [load_driver, *SMOOTHER])
def test_cached_functions_have_unique_names_and_one_signature(load):
    functions = {each for each in vars(load()).values() if isinstance(each, Dispatcher)}
    cached = {each for each in functions if not isinstance(each._cache, NullCache)}
    assert cached
    assert all(len(each.signatures) == 1 and not each._can_compile for each in cached)
    while more := {each for one in functions for each in called_functions(one)} - functions:
        functions |= more
    # A function that only compiled functions call is cached as a part of their files.
    assert all(isinstance(each._cache, NullCache) for each in functions - cached)
    assert len({(each.__module__, each.__qualname__) for each in functions}) == len(functions)
