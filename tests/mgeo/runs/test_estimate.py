"""How long a run takes, told by its beginning, with a clock that counts evaluations."""

import copy
from collections.abc import Iterator

import numpy as np
import pytest
from pymoo.core.problem import Problem

from mgeo import MGEODirected, MGEOStaged
from mgeo.runs.estimate import estimate


class Dearer(Problem):
    """Takes a design one second in the first stage of a search, 20 in the second, 100 in the last.

    Whoever draws what a stage needs for the first time waits for an hour.
    """

    def __init__(self):
        super().__init__(n_var=3, n_obj=2, xl=0.0, xu=1.0)
        self.took, self.drawn, self.each = [], {1.0}, 1.0

    @property
    def seconds(self):
        return sum(self.took)

    def at_stage(self, stage):
        if stage == 2:
            return self
        judge = copy.copy(self)
        judge.each = (1.0, 20.0)[stage]
        return judge

    def _evaluate(self, X, out, *args, **kwargs):
        self.took.append((self.each not in self.drawn) * 3600.0 + len(X) * self.each)
        self.drawn.add(self.each)
        out["F"] = np.column_stack([X[:, 0], 1.0 - X[:, 0]])


@pytest.fixture
def problem(monkeypatch):
    dearer = Dearer()
    monkeypatch.setitem(
        estimate.__globals__, "_clocks", lambda: (dearer.seconds, 2.0 * dearer.seconds)
    )
    return dearer


def test_every_evaluation_costs_as_much_as_the_first_ones(problem):
    found = estimate(problem, MGEODirected(n_walkers=10), 9_600, 1)
    assert (found.elapsed, found.processor) == pytest.approx((9_600.0, 19_200.0))
    assert found.timed == problem.seconds


@pytest.mark.parametrize("evaluations", [10, 60])
def test_a_run_of_few_evaluations_is_made_whole(problem, evaluations):
    found = estimate(problem, MGEODirected(n_walkers=10), evaluations, 1)
    assert found.elapsed == pytest.approx(max(evaluations, 30))


def test_later_stages_are_timed_by_themselves(problem):
    staged, problem.each = MGEOStaged(stages=(0.5, 0.9)), 100.0
    found = estimate(problem, staged, 10_000, 1)
    search = 0.5 * 10_000 * 1.0 + 0.4 * 10_000 * 20.0 + 0.1 * 10_000 * 100.0
    front = (found.elapsed - search) / (20.0 + 100.0)  # judged anew at the beginning of each
    assert 1 <= front == pytest.approx(round(front))
    assert found.processor == pytest.approx(2.0 * found.elapsed)


class Tables(Iterator):
    """Steps of 50 s, of which the problem says that there will be so many."""

    def __init__(self, problem, X, length):
        self.problem, self.X, self.length = problem, X, length

    def __length_hint__(self):
        return self.length

    def __next__(self):
        self.problem.took.append(50.0)
        return self.X


@pytest.mark.parametrize(("length", "polish"), [(40, 2_000.0), (0, None)])
def test_of_a_polish_the_first_step_is_timed(problem, monkeypatch, length, polish):
    monkeypatch.setattr(Dearer, "refine", lambda self, X: Tables(self, X, length), raising=False)
    found = estimate(problem, MGEODirected(n_walkers=10), 9_600, 1, polish=True)
    assert found.polish == polish
    assert found.elapsed == pytest.approx(9_600.0 + (polish or 0.0))
