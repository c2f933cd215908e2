"""Summary of the solution that represents a front by default."""

import numpy as np
from pymoo.problems import get_problem

from mgeo.algorithms import MGEODirected
from mgeo.plugins.view import build_view
from mgeo.runs.summary import summarize_default_solution
from tests.mgeo.solved import solve

from .test_constraint_margins import ColumnWithView


class LooseColumn(ColumnWithView):
    """Problem whose constraint is looser than the one reported by its view."""

    def __init__(self):
        super().__init__()
        self.n_eq_constr = 0

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 3.0


def summarize(problem):
    outcome = solve(problem, MGEODirected(), 400, seed=1)
    return summarize_default_solution(build_view(problem, outcome.X, outcome.F))


def test_violated_constraint_of_view_is_reported():
    summary = summarize(LooseColumn())
    (violation,) = summary.violations
    assert violation == "height: 3 m, at most 2 m: exceeded by 1 m"
    assert str(summary) == f"solution 0 of 1, {summary.label}: f1 -7; BUT {violation}"


def test_summary_without_violated_constraints():
    class StrictColumn(LooseColumn):
        def _evaluate(self, X, out, *args, **kwargs):
            out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 1.5

    for problem in (StrictColumn(), get_problem("zdt1")):
        summary = summarize(problem)
        assert summary.violations == ()
        assert "BUT" not in str(summary)
        assert np.isfinite(float(summary.text.split()[-1]))
