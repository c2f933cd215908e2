"""Timings, run with ``pytest tests/benchmarks -m benchmark``, best on an idle machine."""

import os
import time

import llvmlite.binding
import numpy as np
import pytest
from mgeo_attitude import evaluate

from . import cases, speed
from .count import count_step
from .scalar import evaluate_scalar

pytestmark = pytest.mark.benchmark(timer=time.process_time)


#: AVX-512 has 32 registers; with the 16 of AVX2 the step keeps more of its values in memory.
WIDE = bool(llvmlite.binding.get_host_cpu_features().get("avx512f"))


@pytest.fixture(scope="module")
def tasks():
    return speed.step_tasks()


@pytest.fixture(scope="module")
def comparison(tasks):
    return speed.compare(tasks, rounds=9)


@pytest.mark.parametrize("name", ["filterpy", "NumPy", "scalar loop", "kernel"])
def test_step(benchmark, tasks, name):
    benchmark.extra_info["useful steps"] = tasks[name].steps
    benchmark(tasks[name].run)


@pytest.mark.parametrize("n", [1, 12, 360])
def test_batch(benchmark, n):
    task = speed.kernel(cases.model(cases.PAPER), cases.designs(n), threads=1)
    benchmark.extra_info["useful steps"] = task.steps
    benchmark(task.run)


@pytest.mark.parametrize("name", cases.SUITES)
def test_suite(benchmark, name):
    model, X = cases.model(name), cases.designs(24)
    t_end, trace = evaluate_scalar(model, X)
    result = evaluate(model, X)
    np.testing.assert_array_equal(t_end, result.t_end)
    np.testing.assert_allclose(trace, result.trace, rtol=1e-9)
    task = speed.kernel(model, cases.designs(360), threads=1)
    benchmark.extra_info["useful steps"] = task.steps
    benchmark(task.run)


def test_kernel_is_hundreds_of_times_faster_than_filterpy(comparison):
    ratio = comparison.speeds["filterpy"].processor / comparison.speeds["kernel"].processor
    assert ratio >= (200.0 if WIDE else 100.0)


def test_kernel_does_most_of_the_multiply_adds_the_processor_can(comparison):
    fraction = comparison.fraction_of_peak("kernel", count_step(cases.model(cases.PAPER)))
    assert fraction >= (0.6 if WIDE else 0.4)


def test_the_step_of_a_large_suite_stays_in_the_instruction_cache():
    model = cases.model(cases.FULL)
    tasks = {cases.FULL: speed.kernel(model, cases.designs(360), threads=1)}
    fraction = speed.compare(tasks, rounds=9).fraction_of_peak(cases.FULL, count_step(model))
    assert fraction >= (0.5 if WIDE else 0.4)


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one processor")
def test_two_threads_are_nearly_twice_as_fast(comparison):
    one, two = comparison.speeds["kernel"], comparison.speeds["kernel, two threads"]
    if not comparison.undisturbed:
        pytest.skip("the machine is busy: elapsed times mean nothing")
    assert one.wall / two.wall >= 1.8
