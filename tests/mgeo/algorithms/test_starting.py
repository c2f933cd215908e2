"""Designs that a problem suggests to begin with."""

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

from mgeo import MGEODirected, MGEOReal, MGEOStaged, SuggestedSampling


class Suggesting(ZDT1):
    """Suggests points of its front, and remembers the first batch that it evaluates."""

    first = None

    def starts(self, n, random_state):
        return np.column_stack([random_state.random(n), np.zeros((n, self.n_var - 1))])

    def _evaluate(self, x, out, *args, **kwargs):
        self.first = x.copy() if self.first is None else self.first
        super()._evaluate(x, out, *args, **kwargs)


@pytest.mark.parametrize(
    "algorithm",
    [
        MGEODirected(sampling=SuggestedSampling(5)),
        MGEOReal(sampling=SuggestedSampling(5)),
        MGEOStaged(sampling=SuggestedSampling(5)),
        NSGA2(pop_size=20, sampling=SuggestedSampling(5)),
    ],
)
def test_they_are_evaluated_in_the_first_generation(algorithm):
    problem = Suggesting(n_var=6)
    result = minimize(problem, algorithm, ("n_gen", 1), seed=3)
    suggested = problem.first[:5]
    assert (suggested[:, 1:] == 0.0).all()
    assert len(np.unique(suggested[:, 0])) == 5
    assert np.isin(suggested[:, 0], result.X[:, 0]).all()  # they are of the front
    assert len(result.pop) == len(problem.first) == result.algorithm.evaluator.n_eval


@pytest.mark.parametrize(
    ("n", "starts", "message"),
    [
        (17, None, "starts = 17: expected at most 16, with which it begins"),
        (2, lambda n, rng: np.full((2, 6), 3.0), r"sampling\[0, 0\] = 3.0: expected a number in"),
    ],
)
def test_what_cannot_be_begun_with_is_refused(n, starts, message):
    problem = Suggesting(n_var=6)
    if starts is not None:
        problem.starts = starts
    with pytest.raises(ValueError, match=message):
        MGEODirected(sampling=SuggestedSampling(n)).setup(problem, seed=1)


def test_a_problem_that_suggests_none_is_told():
    with pytest.raises(ValueError, match=r"ZDT1 has no starts\(\): expected a run without"):
        MGEODirected(sampling=SuggestedSampling(2)).setup(ZDT1(n_var=6), seed=1)
