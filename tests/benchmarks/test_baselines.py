"""The yardsticks themselves: they must do the same work, and be counted and timed rightly."""

import math
import re

import llvmlite.binding
import numpy as np
import pytest
from mgeo_attitude import evaluate, reference_run
from mgeo_attitude.filter.kernel import lanes

from . import cases, measure, peak, speed, table, textbook
from .count import Count, count_step, count_text
from .measure import interleaved, used_by_others
from .scalar import evaluate_scalar


@pytest.fixture(scope="module")
def paper():
    return cases.model(cases.PAPER)


@pytest.mark.campaign
@pytest.mark.slow  # it is compiled for this
def test_scalar_loop_gives_what_the_kernel_gives(paper):
    X = cases.designs(24)
    X[0, 3::4] = 0.0
    X[1, 3::4] = [0.5, 1000.25, 0.0]
    X[2, 3::4] = 2000.0
    t_end, trace = evaluate_scalar(paper, X)
    result = evaluate(paper, X)
    np.testing.assert_array_equal(t_end, result.t_end)
    np.testing.assert_allclose(trace, result.trace, rtol=1e-9)


def test_textbook_loops_give_what_the_reference_filter_gives(paper):
    n_steps, omega_deg_s = 400, [0.5, -0.3, 0.8]
    history = reference_run(paper, [*omega_deg_s, n_steps])
    given = textbook.matrices(paper, np.radians(omega_deg_s), n_steps)
    expected = history.sigma[n_steps] ** 2
    np.testing.assert_allclose(np.diag(textbook.run_filterpy(given)), expected, rtol=1e-9)
    np.testing.assert_allclose(np.diag(textbook.run_numpy(given)), expected, rtol=1e-9)


@pytest.mark.slow
def test_useful_steps_end_with_each_design(paper):
    X = cases.designs(3)
    assert speed.useful_steps(paper, X) == sum(len(reference_run(paper, x).times) - 1 for x in X)


def test_a_value_computed_twice_is_counted_once():
    text = """
a = x * y + z
b = x * y - z
x = 2.0
c = x * y
d = 1.0 / sqrt(-c)
"""
    assert count_text(text) == Count(multiplications=2, additions=2, divisions=1, roots=1)


def test_every_turn_of_a_loop_is_counted():
    text = """
for i in range(0, 3, 1):
    t = W[i] * W[3]
    W[i + 4 if i >= 1 else 9] = t + x
W[5] = W[0] * W[3]
"""
    assert count_text(text) == Count(multiplications=3, additions=3, divisions=0, roots=0)


def test_what_is_no_arithmetic_cannot_be_counted():
    with pytest.raises(ValueError, match="x @ y"):
        count_text("a = x @ y")


def test_multiplications_of_the_paper_suite_by_hand(paper):
    n = 18
    turn, rotated_vector, trace = 27, 9, n
    # F has rows of 6 (attitude) and 1 (bias); F P, of which (F P) Fᵀ needs neither the bias rows in
    # the columns of the attitude nor the upper triangle of the bias; then its lower triangle
    predict = n * (3 * 6 + 3 * 1) - (9 + 3) + (6 * 6 + 9 * 1 + 6 * 1)
    # a row of H has 2 products: P Hᵀ, H P Hᵀ; factor; G (3 scaled, 3 eliminated); P - G Gᵀ
    update = n * 6 + 6 * 2 + 7 + n * 6 + n * (n + 1) // 2 * 3
    assert (
        count_step(paper).multiplications == turn + predict + 2 * (rotated_vector + update) + trace
    )
    assert count_step(paper).divisions == count_step(paper).roots == 6


def test_peak_loop_multiplies_and_adds_in_vector_registers():
    features = llvmlite.binding.get_host_cpu_features()
    if not (features.get("fma") or features.get("neon")):
        pytest.skip("no vector multiply-add on this processor")
    (assembly,) = peak.multiply_adds.inspect_asm().values()
    found = re.findall(r"\b(vfmadd\d+pd|fmla)\b.*", assembly)
    assert len(found) >= peak.CHAINS
    if lanes() == 8:
        assert re.search(r"vfmadd\d+pd\s+%zmm\d+, %zmm\d+, %zmm\d+", assembly)


def test_peak_loop_computes_its_chains():
    start = sum(range(peak.CHAINS)) * lanes()
    assert peak.multiply_adds(0) == start
    # a ← a / 2 + 1 has the fixed point 2
    assert peak.multiply_adds(100) == pytest.approx(2.0 * peak.CHAINS * lanes(), rel=1e-15)


class Clock:
    """Two clocks that go only when told: tests of time must not depend on the time they take."""

    def __init__(self):
        self.wall = self.processor = 0.0

    def perf_counter(self):
        return self.wall

    def process_time(self):
        return self.processor

    def work(self, wall, processor):
        self.wall += wall
        self.processor += processor


def test_tasks_take_turns_and_the_least_time_counts(monkeypatch):
    clock, calls = Clock(), []
    monkeypatch.setattr(measure, "time", clock)
    durations = {"a": iter([9.0, 0.2, 0.5, 0.3]), "b": iter([9.0, 0.04, 0.03, 0.03, *[0.02] * 4])}

    def task(name):
        calls.append(name)
        wall = next(durations[name])
        clock.work(wall, wall / 2)

    timings = interleaved({"a": lambda: task("a"), "b": lambda: task("b")}, rounds=2)
    # once to warm up, once to find how often 0.1 s holds it, then by turns
    assert "".join(calls) == "aabb" + "abbb" * 2
    assert timings["a"] == measure.Timing(processor=pytest.approx(0.15), wall=pytest.approx(0.3))
    assert timings["b"] == measure.Timing(processor=pytest.approx(0.01), wall=pytest.approx(0.02))


def test_other_programs_are_told_from_this_one(monkeypatch, tmp_path):
    clock, counters = Clock(), tmp_path / "stat"
    monkeypatch.setattr(measure, "time", clock)
    monkeypatch.setattr(measure.os, "sysconf", {"SC_CLK_TCK": 100}.__getitem__, raising=False)
    # ticks: user, nice, system, idle, waiting, interrupts, soft interrupts, steal, guest
    counters.write_text("cpu  300 20 100 9999 9999 5 15 60 7 0\ncpu0 1 1 1 1 1 1 1 1 1 1\n")
    clock.work(wall=9.0, processor=1.5)
    assert used_by_others(counters) == pytest.approx(5.0 - 1.5)
    assert math.isnan(used_by_others(tmp_path / "none"))


def test_tables_go_between_their_marks():
    text = f"before\n{table.BEGIN}\nold\n{table.END}\nafter\n"
    assert table.with_tables(text, "| new |") == (
        f"before\n{table.BEGIN}\n| new |\n{table.END}\nafter\n"
    )
    with pytest.raises(ValueError, match="expected the lines"):
        table.with_tables("no marks", "| new |")


def test_the_document_has_the_marks():
    assert "| new |" in table.with_tables(table.DOCUMENT.read_text(encoding="utf-8"), "| new |")
