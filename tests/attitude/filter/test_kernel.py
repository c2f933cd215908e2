"""Cache of compiled modules, with concurrent processes and threads and with an unusable folder."""

import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import pytest
from mgeo_attitude.filter.kernel import load_module

SCRIPT = textwrap.dedent(
    """
    import dataclasses
    from concurrent.futures import ThreadPoolExecutor
    import numpy as np
    from mgeo_attitude import AttitudeManeuverProblem, Scenario, StarTracker
    from mgeo_attitude.scenario import Convergence
    # The smallest suite compiles fastest.
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


def start_process(cache):
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, "MGEO_CACHE_DIR": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_concurrent_processes_and_threads_share_cache(tmp_path):
    processes = [start_process(tmp_path / "cache") for _ in range(2)]
    outputs = [process.communicate(timeout=300) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], outputs
    for _, log in outputs:  # Kernel and driver are compiled at most once each.
        assert log.count("compiling the kernel") <= 1
        assert log.count("compiling the driver") <= 1
    third, log = start_process(tmp_path / "cache").communicate(timeout=300)
    assert log == ""
    assert {third, *(stdout for stdout, _ in outputs)} == {third}


@pytest.mark.parametrize("usable", [True, False])
def test_module_is_executed_once_for_all_threads(tmp_path, monkeypatch, usable):
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
