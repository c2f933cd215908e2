"""Where kernels are kept, and what happens when they cannot be."""

import os
import stat
import subprocess
import sys
import textwrap

import pytest

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


def run(cache):
    return subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, "MGEO_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )


@pytest.mark.slow
def test_kernel_is_compiled_once_per_machine(tmp_path):
    first = run(tmp_path / "cache")
    assert "compiling" in first.stderr
    second = run(tmp_path / "cache")
    assert second.stderr == ""
    assert second.stdout == first.stdout


@pytest.mark.slow
def test_two_processes_that_start_at_once_do_not_trip(tmp_path):
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
    assert outputs[0][0] == outputs[1][0]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "getuid"), reason="POSIX permissions")
def test_a_cache_that_others_can_write_to_is_not_trusted(tmp_path):
    kernels = tmp_path / "cache" / "kernels"
    kernels.mkdir(parents=True)
    kernels.chmod(stat.S_IRWXU | stat.S_IRWXG | stat.S_IRWXO)
    result = run(tmp_path / "cache")
    assert "cannot be used" in result.stderr
    assert list(kernels.iterdir()) == []
    assert result.stdout


@pytest.mark.slow
def test_a_cache_that_is_a_file_falls_back_to_memory(tmp_path):
    (tmp_path / "cache").write_text("not a folder")
    result = run(tmp_path / "cache")
    assert "compiling in memory" in result.stderr
    assert result.stdout
