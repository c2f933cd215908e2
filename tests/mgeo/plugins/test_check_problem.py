"""`check_problem`: good problems pass, and each rule has a problem that breaks it."""

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
    """A problem with all optional parts; the classes below break one rule each."""

    var_names = ("a [m]", "b [m]")
    obj_names = ("near [m²]", "far [m²]")
    shown = GoodView

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
        return self.shown(self, X)

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
def test_good_problems_pass(problem):
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
        out["F"][X[:, 0] <= -1.0, 1] = np.nan  # at the lower corner only


class Noisy(Good):
    calls = itertools.count()

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["H"] = out["H"] + next(self.calls)


class Transposed(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"].T.reshape(-1, 2)  # right shape, wrong order


class NoPickle(Good):
    def __init__(self):
        super().__init__()
        self.scale = lambda x: x


class NeedsArguments(Good):
    def __init__(self, shift):
        super().__init__(shift)


class OtherStage(Good):
    def at_fidelity(self, fidelity):
        return Sphere()


class SwapsDominance(Good):
    def map_to_indicator_space(self, F):
        return -F


class UnseededStarts(Good):
    def suggest_initial_designs(self, n, random_state):
        return np.random.default_rng().random((n, 2))


class LosesDesigns(Good):
    def refine(self, X):
        return iter([X[:1]])


class OptionsWithTuple(Good):
    def to_options(self):
        return {"shift": (1.0, 2.0)}


def shown(**methods):
    """A problem whose view has these methods."""
    problem = Good()
    problem.shown = type("Shown", (GoodView,), methods)
    problem.__class__ = type("WithView", (Good,), {"__reduce__": lambda self: (Good, ())})
    return problem


def moved(view):
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
        (OtherStage(), r"at_fidelity\(0\)|evaluate"),
        (SwapsDominance(), "must preserve dominance between points"),
        (
            UnseededStarts(),
            r"suggest_initial_designs\(n, random_state\), called again with the same seed",
        ),
        (
            LosesDesigns(),
            r"refine\(X\) of problem LosesDesigns gives shape \(1, 2\): expected \(2, 2\)",
        ),
        (OptionsWithTuple(), "comes back from JSON as"),
        (shown(describe=lambda view: view.describe), r"describe\(\) .*: expected a DataFrame"),
        (shown(describe=moved), r"describe\(\) of the view must not modify X"),
        (shown(summaries=lambda view: ["fine"]), r"summaries\(\) .*an entry for each of 10"),
        (shown(remarks=lambda view: "one"), r"remarks\(\) .* = 'one': expected a list of texts"),
        (shown(figures=lambda view: 1 / 0), r"figures\(\) of the view: ZeroDivisionError"),
        (shown(front_summary=lambda view, F: {"F": F}), "front_summary.*not JSON serializable"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_each_broken_rule_is_found(problem, message):
    with pytest.raises(CheckError, match=message):
        check_problem(problem)
