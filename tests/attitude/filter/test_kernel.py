"""Where kernels are kept, and what happens when they cannot be."""

import inspect
import os
import re
import stat
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
    import dataclasses, sys, warnings
    import numpy as np
    from mgeo_attitude import FilterModel, Gyro, Scenario, StarTracker, evaluate
    from mgeo_attitude.scenario import Convergence
    # the smallest suite: the test is about the cache, not the compile
    scenario = dataclasses.replace(
        Scenario.paper(), duration=100.0, sensors=(StarTracker(),),
        convergence=Convergence(window=10.0),
    )
    result = evaluate(FilterModel.from_scenario(scenario), [0.1, 0.2, 0.3, 20.0])
    print(repr(float(result.t_end[0])), repr(float(result.trace[0])))
    """
)

#: What is compiled does not matter to who may write where.
SMALL = textwrap.dedent(
    """
    from mgeo_attitude.filter.kernel import load_module
    source = "from numba import njit\\nfrom mgeo_attitude._compiled import kept\\n"
    source += "@njit('f8(f8)', cache=True)\\ndef f(x):\\n    return x\\n"
    source += "@kept('f8(f8)')\\ndef g(x):\\n    return x\\n"
    module = load_module("kernel", source, [])
    print(module.f(1.0), module.g(2.0))
    """
)

THREADS = textwrap.dedent(
    """
    import dataclasses
    from concurrent.futures import ThreadPoolExecutor
    import numpy as np
    from mgeo_attitude import AttitudeManeuverProblem, Scenario, StarTracker
    from mgeo_attitude.scenario import Convergence
    scenario = dataclasses.replace(
        Scenario.paper(), duration=100.0, sensors=(StarTracker(),),
        convergence=Convergence(window=10.0),
    )
    problem = AttitudeManeuverProblem(scenario)
    designs = np.random.default_rng(0).uniform(problem.xl, problem.xu, (8, 5, 12)) / 50.0
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(problem.evaluate, designs))
    alone = AttitudeManeuverProblem(scenario).evaluate(designs.reshape(40, 12))
    assert np.array_equal(np.vstack(results), alone)
    """
)


def run(cache, script=SCRIPT):
    return subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "MGEO_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )


@pytest.mark.campaign
@pytest.mark.slow
def test_two_processes_that_start_at_once_compile_and_a_third_has_no_need_to(tmp_path):
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "MGEO_CACHE_DIR": str(tmp_path / "cache")},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    outputs = [process.communicate(timeout=300) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], outputs
    assert any("compiling" in stderr for _, stderr in outputs)
    third = run(tmp_path / "cache")
    assert third.stderr == ""
    assert {third.stdout, *(stdout for stdout, _ in outputs)} == {third.stdout}


@pytest.mark.campaign
@pytest.mark.slow
def test_threads_that_start_at_once_do_not_trip_whether_the_kernel_is_there_or_not(tmp_path):
    cold = run(tmp_path / "cache", THREADS)
    assert cold.stderr.count("compiling") == 2  # kernel and driver, each once
    assert len(re.findall(rf"^compiled in \d+\.\d s, kept in {tmp_path}", cold.stderr, re.M)) == 2
    assert run(tmp_path / "cache", THREADS).stderr == ""


@pytest.mark.parametrize("module", [load_driver, *SMOOTHER])
def test_what_is_kept_of_one_process_fits_what_is_kept_of_another(module):
    """See `_compiled`: a test that lets processes compile shows the contrary once in many runs."""
    loaded = module()
    functions = {each for each in vars(loaded).values() if isinstance(each, Dispatcher)}
    kept = {each for each in functions if not isinstance(each._cache, NullCache)}
    assert kept
    assert all(len(each.signatures) == 1 and not each._can_compile for each in kept)
    while more := {each for one in functions for each in called(one)} - functions:
        functions |= more
    # "In 'NRT_adapt_ndarray_to_python', 'descr' is NULL" after an installation anew
    assert all(isinstance(each._cache, NullCache) for each in functions - kept)
    names = {(each.__module__, each.__qualname__) for each in functions}
    assert len(names) == len(functions)


def called(function):
    """Compiled functions that another knows."""
    names = inspect.getclosurevars(function.py_func)
    known = [*names.nonlocals.values(), *names.globals.values()]
    return {each for each in known if isinstance(each, Dispatcher)}


@pytest.mark.parametrize("usable", [True, False])
def test_a_module_is_executed_once_before_any_thread_gets_it(tmp_path, monkeypatch, usable):
    """A stand-in for a kernel that takes its time; every thread asks while it is executed."""
    cache = tmp_path / "cache"
    if not usable:
        cache.write_text("not a folder")
    monkeypatch.setenv("MGEO_CACHE_DIR", str(cache))
    started = threading.Barrier(4)

    def load(_):
        started.wait()
        return load_module("slow", f"import time\ntime.sleep(0.2)\nrun = {usable}", ())

    told = nullcontext() if usable else pytest.warns(match="cannot be used .* compiling in memory")
    with told, ThreadPoolExecutor(4) as pool:
        modules = list(pool.map(load, range(4)))
    try:
        assert [module.run for module in modules] == [usable] * 4
        assert all(module is modules[0] for module in modules)
    finally:
        del sys.modules[modules[0].__name__]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "getuid"), reason="POSIX permissions")
def test_a_cache_that_others_can_write_to_is_not_trusted(tmp_path):
    kernels = tmp_path / "cache" / "kernels"
    kernels.mkdir(parents=True)
    kernels.chmod(stat.S_IRWXU | stat.S_IRWXG | stat.S_IRWXO)
    result = run(tmp_path / "cache", SMALL)
    assert "cannot be used" in result.stderr
    assert "compiling in memory" in result.stderr
    assert list(kernels.iterdir()) == []
    assert result.stdout == "1.0 2.0\n"
