"""`check_problem` accepts valid problems and detects the violation of each rule."""

import itertools

import numpy as np
import pandas as pd
import pytest
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.problems.multi import BNH

from mgeo import ProblemMixin, View
from mgeo.testing import CheckError, check_problem


class GoodView(View):
    def describe(self):
        return pd.DataFrame(self.X, columns=self.problem.var_names)

    def front_summary(self, F):
        return {"points": len(F)}


class Good(ProblemMixin, Problem):
    """Problem with all optional methods; each derived class violates one rule."""

    var_names = ("a [m]", "b [m]")
    obj_names = ("near [m²]", "far [m²]")
    view_class = GoodView

    def __init__(self, shift=2.0):
        self.shift = shift
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=1, n_eq_constr=1, xl=-1.0, xu=[3.0, 4.0])
        self.xu = np.array([3.0, 4.0])

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([(X**2).sum(axis=1), ((X - self.shift) ** 2).sum(axis=1)])
        out["G"] = X[:, :1] - 1.0
        out["H"] = X[:, 1:] - 1.0

    def to_options(self):
        return {"shift": self.shift}

    def map_to_indicator_space(self, F):
        return np.log10(1.0 + F) / 2.0

    def view(self, X):
        return self.view_class(self, X)

    def suggest_initial_designs(self, n, random_state):
        return random_state.uniform(-1.0, 3.0, (n, 2))

    def refine(self, X):
        return iter([X, np.vstack([X, X])])

    def recommend_settings(self):
        return {"initial_designs": 2, "refine": True}

    def at_fidelity(self, fidelity):
        return self if fidelity else Good()


class Sphere(ElementwiseProblem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=1, xl=-1, xu=1)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = (x**2).sum()


@pytest.mark.parametrize("problem", [Good(), Sphere(), BNH()])
def test_valid_problems_pass(problem):
    check_problem(problem)


class TooFewNames(Good):
    var_names = ("a",)


class Raises(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        raise ZeroDivisionError("no such orbit")


class Changes(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        X[0] = 0.0


class NotFinite(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"][X[:, 0] <= -1.0, 1] = np.nan  # Only at the lower bounds.


class Noisy(Good):
    calls = itertools.count()

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["H"] = out["H"] + next(self.calls)


class Transposed(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"].T.reshape(-1, 2)  # The shape is right and the order is wrong.


class NoPickle(Good):
    def __init__(self):
        super().__init__()
        self.scale = lambda x: x


class NeedsArguments(Good):
    def __init__(self, shift):
        super().__init__(shift)


class OtherProblemAtFidelity(Good):
    def at_fidelity(self, fidelity):
        return Sphere()


class SwapsDominance(Good):
    def map_to_indicator_space(self, F):
        return -F


class UnseededDesigns(Good):
    def suggest_initial_designs(self, n, random_state):
        return np.random.default_rng().random((n, 2))


class LosesDesigns(Good):
    def refine(self, X):
        return iter([X[:1]])


class OptionsWithTuple(Good):
    def to_options(self):
        return {"shift": (1.0, 2.0)}


def build_problem_with_view(**methods):
    """Return a problem whose view has the given methods."""
    problem = Good()
    problem.view_class = type("ChangedView", (GoodView,), methods)
    problem.__class__ = type("WithView", (Good,), {"__reduce__": lambda self: (Good, ())})
    return problem


def describe_and_modify(view):
    view.X += 1.0
    return pd.DataFrame(view.X)


@pytest.mark.parametrize(
    ("problem", "message"),
    [
        ("attitude", "'attitude' is not a pymoo Problem"),
        (TooFewNames(), "var_names of TooFewNames = .*expected 2 different names"),
        (Raises(), r"evaluate\(X\): ZeroDivisionError: no such orbit"),
        (Changes(), r"evaluate\(X\) must not modify X"),
        (NotFinite(), "F of 1 of 10 points is not finite"),
        (Noisy(), "H, evaluated again: got"),
        (Transposed(), "F, row 0 evaluated alone: got"),
        (NoPickle(), "pickle the problem"),
        (NeedsArguments(1.0), r"NeedsArguments\(\) must be constructible without arguments"),
        (OtherProblemAtFidelity(), r"at_fidelity\(0\)|evaluate"),
        (SwapsDominance(), "must preserve dominance between points"),
        (
            UnseededDesigns(),
            r"suggest_initial_designs\(n, random_state\), called again with the same seed",
        ),
        (
            LosesDesigns(),
            r"refine\(X\) of problem LosesDesigns returns shape \(1, 2\): expected \(2, 2\)",
        ),
        (OptionsWithTuple(), "comes back from JSON as"),
        (
            build_problem_with_view(describe=lambda view: view.describe),
            r"describe\(\) .*: expected a DataFrame",
        ),
        (
            build_problem_with_view(describe=describe_and_modify),
            r"describe\(\) of the view must not modify X",
        ),
        (
            build_problem_with_view(summaries=lambda view: ["fine"]),
            r"summaries\(\) .*an entry for each of 10",
        ),
        (
            build_problem_with_view(warnings=lambda view: "one"),
            r"warnings\(\) .* = 'one': expected a list of texts",
        ),
        (
            build_problem_with_view(figures=lambda view: 1 / 0),
            r"figures\(\) of the view: ZeroDivisionError",
        ),
        (
            build_problem_with_view(front_summary=lambda view, F: {"F": F}),
            "front_summary.*not JSON serializable",
        ),
    ],
    ids=lambda value: type(value).__name__,
)
def test_each_violated_rule_is_detected(problem, message):
    with pytest.raises(CheckError, match=message):
        check_problem(problem)
