"""The view of any problem, and of a problem that has one itself."""

import numpy as np
from pymoo.core.problem import Problem

from mgeo import View, view_of
from mgeo.plugins.protocol import ask, is_own
from mgeo.plugins.view import TOLERANCE

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
    def remarks(self):
        return [f"{len(self.X)} of {self.problem.n_var}"]


class Own(Plain):
    def view(self, X):
        return Counted(self, X)


def test_any_problem_has_a_view_that_evaluates_it_once():
    problem = Plain()
    view = view_of(problem, X)
    assert type(view) is View
    table = view.describe()
    assert list(table.columns) == ["f1", "f2", "a [m]", "b"]
    np.testing.assert_array_equal(table, np.column_stack([X[:, 0], X[:, 1] ** 2, X]))
    assert view.answers()[0] == "f1 0.5, f2 0.0625"
    limits = view.limits()[2]
    assert limits.index.tolist() == ["g1", "h1"]
    assert limits["margin"].tolist() == [-0.25, TOLERANCE]
    assert list(view.figures()) == ["front"]
    assert view.solution_figures() == [{}, {}, {}]
    assert problem.seen == [3]


def test_objectives_of_a_run_are_not_evaluated_again():
    problem, F = Plain(), np.array([[5.0, 6.0], [7.0, 8.0], [9.0, 10.0]])
    view = view_of(problem, X, F)
    assert view.take([2, 0]).answers() == ["f1 9, f2 10", "f1 5, f2 6"]
    assert problem.seen == []


def test_a_problem_s_own_view_is_used():
    view = view_of(Own(), X)
    assert ask(view, View.remarks) == ["3 of 2"]
    assert is_own(view, View.remarks)
    assert not is_own(view, View.describe)
    assert view.take([1]).remarks() == ["1 of 2"]
    assert view_of(Own()).remarks() == ["0 of 2"]


def test_the_review_of_one_solution_has_its_description_and_its_margins():
    review = view_of(Plain(), X[:1]).review()
    assert (review.title, review.answer) == ("Plain", "f1 0.5, f2 0.0625")
    assert [section.title for section in review.sections] == ["Solution", "Limits"]
