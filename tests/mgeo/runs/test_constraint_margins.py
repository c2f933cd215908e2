"""Constraint margins, reported by the view of a problem or computed from its constraints."""

import numpy as np
import pandas as pd
import pytest
from pymoo.core.problem import Problem
from pymoo.problems.multi import OSY

from mgeo import View, build_view
from mgeo.plugins.view import EQUALITY_TOLERANCE
from mgeo.runs.summary import list_constraint_margins


def compute_margins(problem, X):
    return list_constraint_margins(build_view(problem, X))


class Column(Problem):
    """Column with a limited height, whose two dimensions must be equal."""

    constraint_names = ("buckling",)

    def __init__(self):
        super().__init__(n_var=2, n_obj=1, n_ieq_constr=1, n_eq_constr=1, xl=0.0, xu=4.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X.sum(axis=1)
        out["G"] = X[:, :1] / 2.0 - 1.0
        out["H"] = X[:, :1] - X[:, 1:]


class HeightView(View):
    def constraints(self):
        return [
            pd.DataFrame(
                {
                    "unit": ["m"],
                    "value": [x],
                    "bound_type": ["at most"],
                    "bound_value": [2.0],
                    "margin": [2 - x],
                },
                index=["height"],
            )
            for x in self.X[:, 0]
        ]


class ColumnWithView(Column):
    view_class = HeightView

    def view(self, X):
        return self.view_class(self, X)


def test_margins_of_problem_without_view_are_constraint_values():
    satisfied, violated = compute_margins(Column(), np.array([[1.0, 1.0], [3.0, 1.0]]))
    assert [(margin.name, margin.margin) for margin in satisfied] == [
        ("buckling", 0.5),
        ("h1", EQUALITY_TOLERANCE),
    ]
    assert [margin.is_satisfied for margin in violated] == [False, False]
    assert [margin.margin for margin in violated] == [-0.5, pytest.approx(EQUALITY_TOLERANCE - 2.0)]
    assert str(satisfied[0]) == "buckling: margin 0.5"
    assert str(violated[0]) == "buckling: exceeded by 0.5"
    problem = OSY()
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (20, 6))
    computed = np.array(
        [[each.margin for each in margins] for margins in compute_margins(problem, X)]
    )
    np.testing.assert_array_equal(computed, -problem.evaluate(X, return_values_of=["G"]))


def test_margins_of_view_have_units():
    ((satisfied,), (violated,)) = compute_margins(
        ColumnWithView(), np.array([[1.5, 1.0], [3.0, 1.0]])
    )
    assert str(satisfied) == "height: 1.5 m, at most 2 m: margin 0.5 m"
    assert str(violated) == "height: 3 m, at most 2 m: exceeded by 1 m"
    assert compute_margins(ColumnWithView(), np.empty((0, 2))) == []
