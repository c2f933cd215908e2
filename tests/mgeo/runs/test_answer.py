"""The solution that is shown first, and the limits it exceeds although it keeps all constraints."""

import numpy as np
from pymoo.problems import get_problem

from mgeo.algorithms import MGEODirected
from mgeo.plugins.view import build_view
from mgeo.runs.summary import summarize_default_solution
from tests.mgeo.solved import solve

from .test_limits import Told


class Tall(Told):
    """One whose constraints are looser than the limits it tells."""

    def __init__(self):
        super().__init__()
        self.n_eq_constr = 0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 3.0


def answered(problem):
    found = solve(problem, MGEODirected(), 400, seed=1)
    return summarize_default_solution(build_view(problem, found.X, found.F))


def test_a_limit_that_is_exceeded_is_told():
    found = answered(Tall())
    (exceeded,) = found.violations
    assert exceeded == "height: 3 m, at most 2 m: exceeded by 1 m"
    assert str(found) == f"solution 0 of 1, {found.label}: f1 -7; BUT {exceeded}"


def test_without_one_there_is_none():
    class Short(Tall):
        def _evaluate(self, X, out, *args, **kwargs):
            out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 1.5

    for problem in (Short(), get_problem("zdt1")):
        found = answered(problem)
        assert found.violations == ()
        assert "BUT" not in str(found)
        assert np.isfinite(float(found.text.split()[-1]))
