"""Limits as the problem tells them, or else its constraints as they are."""

import numpy as np
import pandas as pd
import pytest
from pymoo.core.problem import Problem
from pymoo.problems.multi import OSY

from mgeo import View, build_view
from mgeo.plugins.view import EQUALITY_TOLERANCE
from mgeo.runs.summary import list_constraint_margins as limits_of


def limits(problem, X):
    return limits_of(build_view(problem, X))


class Column(Problem):
    """A column: its height is limited, and its foot must be round."""

    constraint_names = ("buckling",)

    def __init__(self):
        super().__init__(n_var=2, n_obj=1, n_ieq_constr=1, n_eq_constr=1, xl=0.0, xu=4.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X.sum(axis=1)
        out["G"] = X[:, :1] / 2.0 - 1.0
        out["H"] = X[:, :1] - X[:, 1:]


class Heights(View):
    def constraints(self):
        return [
            pd.DataFrame(
                {
                    "unit": ["m"],
                    "value": [x],
                    "bound": ["at most"],
                    "limit": [2.0],
                    "margin": [2 - x],
                },
                index=["height"],
            )
            for x in self.X[:, 0]
        ]


class Told(Column):
    shown = Heights

    def view(self, X):
        return self.shown(self, X)


def test_constraints_are_told_as_they_are_computed():
    kept, broken = limits(Column(), np.array([[1.0, 1.0], [3.0, 1.0]]))
    assert [(limit.name, limit.margin) for limit in kept] == [
        ("buckling", 0.5),
        ("h1", EQUALITY_TOLERANCE),
    ]
    assert [limit.is_satisfied for limit in broken] == [False, False]
    assert [limit.margin for limit in broken] == [-0.5, pytest.approx(EQUALITY_TOLERANCE - 2.0)]
    assert str(kept[0]) == "buckling: margin 0.5"
    assert str(broken[0]) == "buckling: exceeded by 0.5"
    problem = OSY()
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (20, 6))
    found = np.array([[limit.margin for limit in each] for each in limits(problem, X)])
    np.testing.assert_array_equal(found, -problem.evaluate(X, return_values_of=["G"]))


def test_the_problems_own_units_come_first():
    ((kept,), (broken,)) = limits(Told(), np.array([[1.5, 1.0], [3.0, 1.0]]))
    assert str(kept) == "height: 1.5 m, at most 2 m: margin 0.5 m"
    assert str(broken) == "height: 3 m, at most 2 m: exceeded by 1 m"
    assert limits(Told(), np.empty((0, 2))) == []
