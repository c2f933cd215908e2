"""Summary of a front and of its recommended solution."""

import re

import numpy as np
import pandas as pd
from pymoo.problems import get_problem
from pymoo.problems.multi import ZDT1

from mgeo.algorithms import MGEODirected
from mgeo.plugins.view import View, build_view
from mgeo.runs.summary import summarize_front
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
    return summarize_front(build_view(problem, outcome.X, outcome.F))


def test_violated_constraint_of_view_is_a_warning():
    summary = summarize(LooseColumn())
    (height,) = summary.constraints["value"]
    assert height > 2.5
    assert summary.overview["constraints"].table["margin"].to_dict() == {"height": 2.0 - height}
    assert [line for line in summary.warnings if "height" in line]
    assert summary.front["violated"].tolist() == [["height"]] * len(summary.front)


def test_satisfied_constraints_are_no_warning():
    class StrictColumn(LooseColumn):
        def _evaluate(self, X, out, *args, **kwargs):
            out["F"], out["G"] = -X.sum(axis=1), X[:, :1] - 1.5

    for problem in (StrictColumn(), get_problem("zdt1")):
        assert summarize(problem).warnings == []


def test_rows_of_the_front_are_those_of_the_problem():
    problem = get_problem("zdt1")
    outcome = solve(problem, MGEODirected(), 400, seed=1)
    summary = summarize_front(build_view(problem, outcome.X, outcome.F))
    np.testing.assert_array_equal(summary.front[["f1", "f2"]], outcome.F[summary.front.index])
    assert summary.front["label"].iloc[0] == "min-f1"
    assert summary.front["label"].iloc[-1] == "min-f2"
    assert summary.front["label"][summary.recommended.row] == summary.recommended.label


def test_warning_names_a_solution_that_satisfies_all_constraints():
    class WidthView(View):
        """View whose constraint excludes the solutions from the knee on."""

        def constraints(self):
            bound = {"unit": "m", "value": 0.0, "bound_type": "at most", "bound_value": 0.1}
            widths = self.X[:, 0].tolist()
            return [pd.DataFrame(bound | {"margin": 0.1 - w}, index=["width"]) for w in widths]

    class Width(ZDT1):
        def view(self, X):
            return WidthView(self, X)

    summary = summarize(Width())
    names = summary.front["violated"]
    assert names[summary.recommended.row] == ["width"]
    (warning,) = summary.warnings
    (row,) = re.findall(r"solution (\d+), which satisfies", warning)
    assert names[int(row)] == []
