"""The cache of compiled kernels: concurrent processes and threads, and an unusable folder."""

import inspect
import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from pkgutil import iter_modules

import pytest
from mgeo_attitude.filter.kernel import load_driver, load_module
from mgeo_calibration.estimation import kernels
from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher

NO_LOOPS = ("algebra", "signatures")
SMOOTHER = [
    pytest.param(partial(kernels.load, name), id=name, marks=[pytest.mark.slow] * slow)
    for _, name, _ in iter_modules(kernels.__path__)
    if name not in NO_LOOPS
    # no other fast test has it compiled
    for slow in [name == "process_noise"]
]

SCRIPT = textwrap.dedent(
    """
    import dataclasses
    from concurrent.futures import ThreadPoolExecutor
    import numpy as np
    from mgeo_attitude import AttitudeManeuverProblem, Scenario, StarTracker
    from mgeo_attitude.scenario import Convergence
    # the smallest suite: the test is about the cache, not the compile
    scenario = dataclasses.replace(
        Scenario.paper(), duration=100.0, sensors=(StarTracker(),),
        convergence=Convergence(window=10.0),
    )
    problem = AttitudeManeuverProblem(scenario)
    designs = np.random.default_rng(0).uniform(problem.xl, problem.xu, (4, 5, 12)) / 50.0
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(problem.evaluate, designs))
    alone = problem.evaluate(designs.reshape(20, 12))
    assert np.array_equal(np.vstack(results), alone)
    print(alone.tolist())
    """
)


def start(cache):
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, "MGEO_CACHE_DIR": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_processes_and_threads_that_start_at_once_share_a_cache(tmp_path):
    processes = [start(tmp_path / "cache") for _ in range(2)]
    outputs = [process.communicate(timeout=300) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], outputs
    for _, log in outputs:  # kernel and driver, each at most once
        assert log.count("compiling the kernel") <= 1
        assert log.count("compiling the driver") <= 1
    third, log = start(tmp_path / "cache").communicate(timeout=300)
    assert log == ""
    assert {third, *(stdout for stdout, _ in outputs)} == {third}


@pytest.mark.parametrize("module", [load_driver, *SMOOTHER])
def test_cached_functions_have_unique_names_and_one_signature(module):
    """See `_compiled`: concurrent compilation shows the contrary once in many runs."""
    loaded = module()
    functions = {each for each in vars(loaded).values() if isinstance(each, Dispatcher)}
    cached = {each for each in functions if not isinstance(each._cache, NullCache)}
    assert cached
    assert all(len(each.signatures) == 1 and not each._can_compile for each in cached)
    while more := {each for one in functions for each in called(one)} - functions:
        functions |= more
    # "In 'NRT_adapt_ndarray_to_python', 'descr' is NULL" after an installation anew
    assert all(isinstance(each._cache, NullCache) for each in functions - cached)
    names = {(each.__module__, each.__qualname__) for each in functions}
    assert len(names) == len(functions)


def called(function):
    """Compiled functions that a compiled function refers to."""
    names = inspect.getclosurevars(function.py_func)
    known = [*names.nonlocals.values(), *names.globals.values()]
    return {each for each in known if isinstance(each, Dispatcher)}


@pytest.mark.parametrize("usable", [True, False])
def test_a_module_is_executed_once_for_all_threads(tmp_path, monkeypatch, usable):
    cache = tmp_path / "cache"
    if not usable:
        cache.write_text("not a folder")
    monkeypatch.setenv("MGEO_CACHE_DIR", str(cache))
    started = threading.Barrier(4)

    def load(_):
        started.wait()
        return load_module("slow", f"import time\ntime.sleep(0.2)\nrun = {usable}", ())

    warned = nullcontext() if usable else pytest.warns(match="cannot be used .* compiling in mem")
    with warned, ThreadPoolExecutor(4) as pool:
        modules = list(pool.map(load, range(4)))
    try:
        assert [module.run for module in modules] == [usable] * 4
        assert all(module is modules[0] for module in modules)
    finally:
        del sys.modules[modules[0].__name__]
