"""What any problem shows as it stands, what its own view shows, and what it showed before."""

import warnings

import numpy as np
import pandas as pd
import pytest
from pymoo.core.problem import Problem
from pymoo.problems.multi import BNH, OSY

from mgeo.plugins.discovery import PluginError
from mgeo.plugins.shown import SHOWN, ask
from mgeo.plugins.view import TOLERANCE, View, is_own, view_of

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
    """Tells how many solutions there are."""

    def remarks(self):
        return [f"{len(self.X)} of {self.problem.n_var}"]


class Own(Plain):
    shown = Counted

    def view(self, X):
        return self.shown(self, X)


def test_any_problem_is_shown_and_evaluated_once():
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
    assert limits["limit"].isna().all()
    assert list(view.figures()) == ["front"]
    assert view.solution_figures() == [{}, {}, {}]
    told = (view.remarks(), view.ways_out(), view.impossible(), view.notes())
    assert told == ([], [], [], [])
    assert view.front_summary(view.F) == {}
    assert problem.seen == [3]
    assert not any(is_own(view, getattr(View, name)) for name in SHOWN)


def test_values_of_a_run_are_not_computed_again():
    problem, F = Plain(), np.array([[5.0, 6.0], [7.0, 8.0], [9.0, 10.0]])
    view = view_of(problem, X, F)
    assert view.take([2, 0]).answers() == ["f1 9, f2 10", "f1 5, f2 6"]
    assert view.describe()["f1"].tolist() == [5.0, 7.0, 9.0]
    assert problem.seen == []


@pytest.mark.parametrize("problem", [OSY(), BNH()])
def test_margins_are_those_of_the_constraints(problem):
    points = np.random.default_rng(1).uniform(problem.xl, problem.xu, (9, problem.n_var))
    G = problem.evaluate(points, return_values_of=["G"])
    np.testing.assert_array_equal(view_of(problem, points).margins, -G)


def test_what_a_problem_has_of_its_own_comes_first():
    view = view_of(Own(), X)
    assert ask(view, View.remarks) == ["3 of 2"]
    assert is_own(view, View.remarks)
    assert not is_own(view, View.describe)
    assert view.take([1]).remarks() == ["1 of 2"]
    assert view_of(Own()).remarks() == ["0 of 2"]


def test_one_solution_may_be_a_row_and_another_shape_is_refused():
    assert View(Plain(), [0.5, 0.25]).X.tolist() == [[0.5, 0.25]]
    with pytest.raises(ValueError, match=r"X of shape \(3, 3\): expected \(n, 2\)"):
        View(Plain(), np.zeros((3, 3)))


@pytest.mark.parametrize("given", ["one", ["one", ""], [1], None])
@pytest.mark.parametrize("name", ["remarks", "ways_out", "impossible", "notes"])
def test_lines_are_texts(given, name):
    class Wrong(Own):
        shown = type("Shown", (View,), {name: lambda self: given})

    with pytest.raises(PluginError, match=rf"{name}\(\) of problem Wrong .*: expected a list of"):
        ask(view_of(Wrong(), X), getattr(View, name))


def test_a_view_that_is_none_or_raises_is_the_problems_fault():
    class Wrong(Plain):
        def view(self, X):
            return self.answer()

    with pytest.raises(PluginError, match="view of problem Wrong raised AttributeError"):
        view_of(Wrong(), X)
    Wrong.answer = lambda self: "a view"
    with pytest.raises(
        PluginError, match=r"view\(X\) of problem Wrong gives 'a view': expected a V"
    ):
        view_of(Wrong(), X)


class Old(Plain):
    """As problems were before there was a `View`."""

    def describe(self, X):
        return pd.DataFrame({"sum": X.sum(axis=1)})

    def notes(self):
        return ["mind"]

    def front_summary(self, F):
        return {"points": len(F)}


def test_attributes_of_old_still_show_and_are_warned_of_once():
    with pytest.warns(
        DeprecationWarning, match="^Old has describe, notes, front_summary of"
    ) as told:
        views = [view_of(Old(), X) for _ in range(3)]
    assert len(told) == 1
    assert "mgeo.View" in str(told[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        view = views[-1].take([1, 0])
    assert ask(view, View.describe)["sum"].tolist() == [1.75, 0.75]
    assert ask(view_of(Old()), View.notes) == ["mind"]
    assert ask(view, View.front_summary, view.F) == {"points": 2}
    assert is_own(view, View.describe)
    assert not is_own(view, View.answers)


def test_attributes_below_a_view_are_older_code_that_still_counts():
    class Below(Own):
        def answers(self, X):
            return ["below"] * len(X)

    with pytest.warns(DeprecationWarning, match="Below has answers of its own"):
        view = view_of(Below(), X)
    assert ask(view, View.answers) == ["below"] * 3
    assert ask(view, View.remarks) == ["3 of 2"]
    assert isinstance(view, Counted)
