"""Speed of the kernel; run with ``pytest tests/benchmarks -m benchmark`` on an idle machine."""

import time

import llvmlite.binding
import numpy as np
import pytest
from mgeo_attitude import run_reference_filter

from . import cases, speed, textbook

#: AVX-512 has 32 registers. With the 16 registers of AVX2, more values of a step stay in memory.
HAS_AVX512 = bool(llvmlite.binding.get_host_cpu_features().get("avx512f"))


def test_filterpy_and_numpy_loops_equal_reference_filter():
    paper = cases.build_model(cases.PAPER)
    n_steps, omega_deg_s = 400, [0.5, -0.3, 0.8]
    history = run_reference_filter(paper, [*omega_deg_s, n_steps])
    matrices = textbook.build_matrices(paper, np.radians(omega_deg_s), n_steps)
    expected = history.sigma[n_steps] ** 2
    np.testing.assert_allclose(np.diag(textbook.run_filterpy(matrices)), expected, rtol=1e-9)
    np.testing.assert_allclose(np.diag(textbook.run_numpy(matrices)), expected, rtol=1e-9)


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("n", [1, 12, 360])
def test_batch_speed(benchmark, n):
    task = speed.build_kernel_task(cases.build_model(cases.PAPER), cases.draw_designs(n), threads=1)
    benchmark.extra_info["useful steps"] = task.steps
    benchmark(task.run)


@pytest.mark.benchmark
def test_kernel_is_hundreds_of_times_faster_than_filterpy():
    measured = speed.time_tasks(speed.build_step_tasks(), rounds=9)
    ratio = measured["filterpy"].processor / measured["kernel"].processor
    assert ratio >= (250.0 if HAS_AVX512 else 100.0)
