"""Speed of the kernel, run with ``pytest tests/benchmarks -m benchmark`` on an idle machine."""

import time

import llvmlite.binding
import numpy as np
import pytest
from mgeo_attitude import run_reference_filter

from . import cases, speed, textbook

#: AVX-512 has 32 registers. With the 16 of AVX2 more values of a step stay in memory.
WIDE = bool(llvmlite.binding.get_host_cpu_features().get("avx512f"))


def test_filterpy_and_numpy_loops_agree_with_the_reference_filter():
    paper = cases.model(cases.PAPER)
    n_steps, omega_deg_s = 400, [0.5, -0.3, 0.8]
    history = run_reference_filter(paper, [*omega_deg_s, n_steps])
    given = textbook.matrices(paper, np.radians(omega_deg_s), n_steps)
    expected = history.sigma[n_steps] ** 2
    np.testing.assert_allclose(np.diag(textbook.run_filterpy(given)), expected, rtol=1e-9)
    np.testing.assert_allclose(np.diag(textbook.run_numpy(given)), expected, rtol=1e-9)


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("n", [1, 12, 360])
def test_batch(benchmark, n):
    task = speed.kernel(cases.model(cases.PAPER), cases.designs(n), threads=1)
    benchmark.extra_info["useful steps"] = task.steps
    benchmark(task.run)


@pytest.mark.benchmark
def test_kernel_is_hundreds_of_times_faster_than_filterpy():
    measured = speed.compare(speed.step_tasks(), rounds=9)
    ratio = measured["filterpy"].processor / measured["kernel"].processor
    assert ratio >= (250.0 if WIDE else 100.0)
