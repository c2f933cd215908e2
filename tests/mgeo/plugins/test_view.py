"""The default view of a problem, and views that problems define."""

import numpy as np
from pymoo.core.problem import Problem

from mgeo import View, build_view
from mgeo.plugins.protocol import call_optional, has_override
from mgeo.plugins.view import EQUALITY_TOLERANCE

X = np.array([[0.5, 0.25], [0.75, 1.0], [1.0, 0.0]])


class Plain(Problem):
    var_names = ("a [m]", "b")

    def __init__(self):
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=1, n_eq_constr=1, xl=0, xu=1)
        self.seen = []

    def _evaluate(self, X, out, *args, **kwargs):
        self.seen.append(len(X))
        out["F"] = np.column_stack([X[:, 0], X[:, 1] ** 2])
        out["G"], out["H"] = X[:, :1] - 0.75, X[:, 1:]


class Counted(View):
    def warnings(self):
        return [f"{len(self.X)} of {self.problem.n_var}"]


class WithView(Plain):
    def view(self, X):
        return Counted(self, X)


def test_default_view_evaluates_problem_once():
    problem = Plain()
    view = build_view(problem, X)
    assert type(view) is View
    table = view.describe()
    assert list(table.columns) == ["f1", "f2", "a [m]", "b"]
    np.testing.assert_array_equal(table, np.column_stack([X[:, 0], X[:, 1] ** 2, X]))
    assert view.summaries()[0] == "f1 0.5, f2 0.0625"
    limits = view.constraints()[2]
    assert limits.index.tolist() == ["g1", "h1"]
    assert limits["margin"].tolist() == [-0.25, EQUALITY_TOLERANCE]
    assert list(view.figures()) == ["front"]
    assert view.solution_figures() == [{}, {}, {}]
    assert problem.seen == [3]


def test_given_objectives_are_not_evaluated_again():
    problem, F = Plain(), np.array([[5.0, 6.0], [7.0, 8.0], [9.0, 10.0]])
    view = build_view(problem, X, F)
    assert view.select([2, 0]).summaries() == ["f1 9, f2 10", "f1 5, f2 6"]
    assert problem.seen == []


def test_view_of_problem_replaces_default_view():
    view = build_view(WithView(), X)
    assert call_optional(view, View.warnings) == ["3 of 2"]
    assert has_override(view, View.warnings)
    assert not has_override(view, View.describe)
    assert view.select([1]).warnings() == ["1 of 2"]
    assert build_view(WithView()).warnings() == ["0 of 2"]


def test_default_review_contains_description_and_constraints():
    review = build_view(Plain(), X[:1]).review()
    assert (review.title, review.summary) == ("Plain", "f1 0.5, f2 0.0625")
    values, constraints = (section.table for section in review.sections)
    assert values["value"].to_dict() == {"f1": 0.5, "f2": 0.0625, "a [m]": 0.5, "b": 0.25}
    assert constraints["margin"].to_dict() == {"g1": 0.25, "h1": EQUALITY_TOLERANCE - 0.25}
