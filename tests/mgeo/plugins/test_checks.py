"""The shipped checks: good plugins pass, and each rule has a plugin that breaks it."""

import copy
import itertools

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.problems.many import DTLZ2
from pymoo.problems.multi import BNH, OSY, ZDT1

from mgeo import MGEOReal, View
from mgeo.testing.algorithm import Bowls, check_algorithm
from mgeo.testing.problem import CheckError, check_problem


class GoodView(View):
    """All of a view; the classes below break one rule each."""

    def describe(self):
        return pd.DataFrame(self.X, columns=self.problem.var_names)

    def answers(self):
        return [f"x = {x}" for x in self.X]

    def front_summary(self, F):
        return {"points": len(F)}

    def figures(self):
        return {"front": go.Figure()}

    def solution_figures(self):
        return [{"bar": go.Figure()} for _ in self.X]


class Good(Problem):
    """The whole protocol; the classes below break one rule each."""

    var_names = ("a [m]", "b [m]")
    obj_names = ("near [m²]", "far [m²]")

    def __init__(self, shift=2.0, shown=GoodView):
        self.shift, self.shown = shift, shown
        super().__init__(n_var=2, n_obj=2, n_ieq_constr=1, n_eq_constr=1, xl=-1.0, xu=[3.0, 4.0])
        self.xu = np.array([3.0, 4.0])

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.column_stack([(X**2).sum(axis=1), ((X - self.shift) ** 2).sum(axis=1)])
        out["G"] = X[:, :1] - 1.0
        out["H"] = X[:, 1:] - 1.0

    def options(self):
        return {"shift": self.shift}

    def indicator_space(self, F):
        return np.log10(1.0 + F) / 2.0

    def view(self, X):
        return self.shown(self, X)


class FromOptions(Good):
    @classmethod
    def from_options(cls, options):
        return cls(**{"shift": 2.0, **options})


class Staged(Good):
    """Judged by another problem before its last stage."""

    judge = Good

    def at_stage(self, k):
        return self if k else self.judge()


@pytest.mark.parametrize(
    "problem", [Good(), Good(1.0), FromOptions(), Staged(), Bowls(), ZDT1(), DTLZ2(), BNH(), OSY()]
)
def test_good_problems_pass(problem):
    check_problem(problem)
    check_problem(problem, seed=5, n_points=3)


class NoBounds(Good):
    def __init__(self):
        super().__init__()
        self.xu = None


class CrossedBounds(Good):
    def __init__(self):
        super().__init__()
        self.xl = np.array([5.0, 0.0])


class TooFewNames(Good):
    var_names = ("a",)


class NoNames(Good):
    obj_names = ("", "b")


class SameNames(Good):
    obj_names = ("a", "a")


class Raises(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        raise ZeroDivisionError("no such orbit")


class WrongShape(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X[:, 0]


class Changes(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        X[0] = 0.0


class NotFinite(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"][X[:, 0] <= -1.0, 1] = np.nan  # at the lower corner only


class NeverSet(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        del out["G"]


class Noisy(Good):
    calls = itertools.count()

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["H"] = out["H"] + next(self.calls)


class Transposed(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"].T.reshape(-1, 2)  # right shape, wrong order


class LooksAside(Good):
    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"] / np.abs(X).max()


class NoPickle(Good):
    def __init__(self):
        super().__init__()
        self.scale = lambda x: x


class NumberedNotNamed(Good):
    instance_of = 3


class ForgetsItself(Good):
    def __getstate__(self):
        return {**self.__dict__, "shift": 0.0}


class NeedsArguments(Good):
    def __init__(self, shift):
        super().__init__(shift)


class OneObjective(Problem):
    def __init__(self):
        super().__init__(n_var=2, n_obj=1, xl=-1.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X[:, :1]


class JudgesOtherwise(Staged):
    judge = OneObjective


class JudgesByNothing(Staged):
    judge = dict


class ForgetsItsStages(Staged):
    def at_stage(self, k):
        self.shift += 1.0
        return self


class IndicatorSwaps(Good):
    def indicator_space(self, F):
        return -F


class IndicatorMutates(Good):
    def indicator_space(self, F):
        F /= 2.0
        return F


class IndicatorShape(Good):
    def indicator_space(self, F):
        return F[:, 0]


class IndicatorNotFinite(Good):
    def indicator_space(self, F):
        return F * np.nan


class DescribesAsDict(GoodView):
    def describe(self):
        return {"a": self.X}


class DescribesTooLittle(GoodView):
    def describe(self):
        return pd.DataFrame(self.X[:1])


class DescribeMutates(GoodView):
    def describe(self):
        self.X += 1.0
        return pd.DataFrame(self.X)


class AnswersTooLittle(GoodView):
    def answers(self):
        return ["fine"]


class AnswersNothing(GoodView):
    def answers(self):
        return [""] * len(self.X)


class LimitsWithoutUnits(GoodView):
    def limits(self):
        return [pd.DataFrame({"value": [1.0], "limit": [2.0]}, index=["height"])] * len(self.X)


class LimitsOfNoKind(GoodView):
    def limits(self):
        table = {"unit": ["m"], "value": [1.0], "bound": ["<"], "limit": [2.0], "margin": [1.0]}
        return [pd.DataFrame(table, index=["height"])] * len(self.X)


class SummaryOfArrays(GoodView):
    def front_summary(self, F):
        return {"F": F}


class SummaryNotOfJson(GoodView):
    def front_summary(self, F):
        return {"points": np.int64(len(F))}


class SummaryAsList(GoodView):
    def front_summary(self, F):
        return [1.0]


class OneForAll(GoodView):
    def solution_figures(self):
        return [{"bar": go.Figure()}]


class NoDicts(GoodView):
    def solution_figures(self):
        return [go.Figure() for _ in self.X]


class FiguresAsList(GoodView):
    def figures(self):
        return [go.Figure()]


class NoFigure(GoodView):
    def figures(self):
        return {"front": "picture.png"}


class NoView(Good):
    def view(self, X):
        return pd.DataFrame(X)


class OptionsWithTuple(Good):
    def options(self):
        return {"shift": (1.0, 2.0)}


class OptionsOfAnother(Good):
    def options(self):
        return {"shift": 2.0 * self.shift}


class OptionsIncomplete(Good):
    def options(self):
        return {}


class OptionsUnknown(Good):
    def options(self):
        return {"shfit": 2.0}


BROKEN = [
    (NoBounds(), "xu = None: expected 2 finite numbers"),
    (CrossedBounds(), "expected xl <= xu"),
    (TooFewNames(), "var_names = .*expected 2 nonempty strings"),
    (NoNames(), "obj_names = .*expected 2 nonempty strings"),
    (SameNames(), "obj_names = .*distinct"),
    (Raises(), r"evaluate\(X\): ZeroDivisionError: no such orbit"),
    (WrongShape(), r"evaluate\(X\): Exception: .*F can not be set, expected shape"),
    (Changes(), r"evaluate\(X\) must not modify X"),
    (NotFinite(), "F of 1 of 10 points is not finite"),
    (NeverSet(), "G of 10 of 10 points is not finite"),
    (Noisy(), "H, evaluated again: got"),
    (Transposed(), "F, row 0 evaluated alone: got"),
    (LooksAside(), "F, row 0 evaluated alone: got"),
    (NoPickle(), "pickle the problem"),
    (JudgesOtherwise(), r"F of at_stage\(0\) of shape \(10, 1\): \(10, 2\)"),
    (JudgesByNothing(), r"at_stage\(0\) is no pymoo Problem: {}"),
    (ForgetsItsStages(), r"evaluated after at_stage\(k\)"),
    (NumberedNotNamed(), "instance_of: PluginError: instance_of of problem NumberedNotNamed = 3"),
    (ForgetsItself(), "F, evaluated by a pickled copy"),
    (NeedsArguments(1.0), r"NeedsArguments\(\) must be constructible without arguments"),
    (IndicatorSwaps(), "must keep which points dominate which"),
    (IndicatorMutates(), r"indicator_space\(F\) must not modify F"),
    (IndicatorShape(), r"indicator_space\(F\) of shape \(10,\): not \(10, 2\)"),
    (IndicatorNotFinite(), r"indicator_space\(F\) must be finite"),
    (
        Good(shown=DescribesAsDict),
        r"(?s)describe\(\) of problem Good gives .*: expected a DataFrame of 10 rows",
    ),
    (
        Good(shown=DescribesTooLittle),
        r"(?s)describe\(\) of problem Good gives .*\(1, 2\): expected a DataFrame of 10 rows",
    ),
    (Good(shown=DescribeMutates), r"describe of view\(X\) must not modify X"),
    (
        Good(shown=AnswersTooLittle),
        r"answers\(\) of problem \w+ gives \['fine'\]: expected a list of 10 texts",
    ),
    (
        Good(shown=AnswersNothing),
        r"answers\(\) of problem \w+ gives \[''.*: expected a list of 10 texts",
    ),
    (
        Good(shown=LimitsWithoutUnits),
        "(?s)limits.*10 DataFrames with the columns unit, value, bound, limit, mar",
    ),
    (
        Good(shown=LimitsOfNoKind),
        "(?s)limits.*10 DataFrames with the columns unit, value, bound, limit, margin",
    ),
    (Good(shown=SummaryOfArrays), "expected a dict of numbers"),
    (
        Good(shown=SummaryAsList),
        r"front_summary\(F\) of problem Good gives \[1.0\]: expected a dict of numbers",
    ),
    (Good(shown=OneForAll), r"(?s)solution_figures\(\) of .*: expected 10 dicts of plotly figures"),
    (Good(shown=NoDicts), r"(?s)solution_figures\(\) of .*: expected 10 dicts of plotly figures"),
    (Good(shown=FiguresAsList), r"(?s)figures\(\) of .*: expected a dict of plotly figures"),
    (
        Good(shown=NoFigure),
        r"(?s)figures\(\) of .*picture.png.*: expected a dict of plotly figures",
    ),
    (Good(shown=SummaryNotOfJson), "front_summary.*not JSON serializable"),
    (NoView(), r"view\(X\) of problem NoView gives .*: expected a View"),
    (OptionsWithTuple(), "comes back from JSON as"),
    (OptionsOfAnother(), r"has other options\(\)"),
    (OptionsIncomplete(1.0), r"F, evaluated by a problem built from options\(\)"),
    (OptionsUnknown(), r"build the problem from its options\(\): TypeError"),
    ("attitude", "'attitude' is not a pymoo Problem"),
]


@pytest.mark.parametrize(("problem", "message"), BROKEN, ids=lambda v: type(v).__name__)
def test_each_broken_rule_of_problems_is_found(problem, message):
    with pytest.raises(CheckError, match=message):
        check_problem(problem)


def test_rounding_between_groupings_is_tolerated_only_if_asked():
    class Rounds(Good):
        def _evaluate(self, X, out, *args, **kwargs):
            super()._evaluate(X, out)
            out["F"] = out["F"] * (1.0 + 4e-16 * (len(X) > 1))

    Rounds.__qualname__ = Rounds.__name__ = "Rounds"
    globals()["Rounds"] = Rounds  # pickle looks it up by name
    check_problem(Rounds())
    with pytest.raises(CheckError, match="evaluated alone"):
        check_problem(Rounds(), rtol=0)


@pytest.mark.parametrize("algorithm", [MGEOReal(n_walkers=2), NSGA2(pop_size=12)])
def test_good_algorithms_pass(algorithm):
    check_algorithm(algorithm)


def test_algorithms_may_be_checked_for_what_they_claim_only():
    check_algorithm(DE(pop_size=10), n_obj=(1,))
    check_algorithm(NeverReports(pop_size=12), n_obj=(2,), constraints=False)
    with pytest.raises(CheckError):
        check_algorithm(DE(pop_size=10), n_obj=(2,))


class Unseeded(NSGA2):
    def _infill(self):
        infills = super()._infill()
        noise = np.random.default_rng().uniform(0, 1e-9, infills[0].X.shape)
        infills[0].X = np.clip(infills[0].X + noise, -2, 2)
        return infills


class Global(NSGA2):
    def _infill(self):
        np.random.random()  # noqa: NPY002
        return super()._infill()


class Deaf(NSGA2):
    def setup(self, problem, **options):
        return super().setup(problem, **{**options, "seed": 5})


class Outside(NSGA2):
    def _infill(self):
        infills = super()._infill()
        infills[0].X = infills[0].X + 9.0
        return infills


class Uncounted(NSGA2):
    def _advance(self, infills=None, **kwargs):
        self.problem.evaluate(infills.get("X"))
        return super()._advance(infills, **kwargs)


class KeepsDominated(NSGA2):
    def _set_optimum(self):
        self.opt = self.pop[self.pop.get("feas")]


class TellsTales(NSGA2):
    def result(self):
        result = super().result()
        result.F = result.F + 1.0
        return result


class Sticky(NSGA2):
    def __deepcopy__(self, memo):
        return self


class Tangled(NSGA2):
    """Random state shared with copies."""

    def __deepcopy__(self, memo):
        clone = object.__new__(type(self))
        for key, value in self.__dict__.items():
            shared = key in ("random_state", "pop", "opt")
            clone.__dict__[key] = value if shared else copy.deepcopy(value, memo)
        return clone


class Unpicklable(NSGA2):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.hook = lambda: None


class Optimist(NSGA2):
    """Takes no constraint seriously."""

    def result(self):
        result = super().result()
        if self.problem.has_constraints() and result.X is not None:
            result.X[:, 0] = -1.0
        return result


class Blind(NSGA2):
    def _set_optimum(self):
        self.opt = None


class NeverReports(NSGA2):
    def _set_optimum(self):
        super()._set_optimum()
        if not self.opt.get("feas").any():
            self.opt = None


class RunsOnlyByItself(NSGA2):
    def next(self):
        self.by_next = True
        super().next()
        self.by_next = False

    def _infill(self):
        if not getattr(self, "by_next", False):
            self.random_state.random()
        return super()._infill()


@pytest.mark.parametrize(
    ("cls", "message"),
    [
        (Unseeded, "same seed, same points: got"),
        (Global, "global random state was used"),
        (Deaf, "another seed, the same points"),
        (Outside, "out of bounds were evaluated"),
        (Uncounted, "n_eval = 60 after 108 evaluations"),
        (KeepsDominated, "points of res.F are dominated"),
        (TellsTales, "res.F must be the objectives of res.X"),
        (Sticky, "minimize must leave the algorithm as it was"),
        (Tangled, "the copy of a run made midway"),
        (Unpicklable, "pickle the algorithm"),
        (Optimist, "infeasible points returned"),
        (Blind, "nothing was found"),
        (NeverReports, "return_least_infeasible: expected a point"),
        (RunsOnlyByItself, "ask and tell, as minimize"),
    ],
)
def test_each_broken_rule_of_algorithms_is_found(cls, message):
    with pytest.raises(CheckError, match=message):
        check_algorithm(cls(pop_size=12), n_obj=(2,))


def test_only_fresh_algorithms_are_checked():
    with pytest.raises(CheckError, match="has been set up"):
        check_algorithm(NSGA2(pop_size=12).setup(ZDT1()))
    with pytest.raises(CheckError, match="is not a pymoo Algorithm"):
        check_algorithm("nsga2")


def test_wrong_shapes_with_one_objective_are_found():
    class Rows(NSGA2):
        def result(self):
            result = super().result()
            result.X = result.X[None, :]
            return result

    with pytest.raises(CheckError, match=r"res.X of shape \(1, 4\)"):
        check_algorithm(Rows(pop_size=12), n_obj=(1,))


def test_elementwise_problems_pass():
    class Sphere(ElementwiseProblem):
        def __init__(self):
            super().__init__(n_var=3, n_obj=1, xl=-1, xu=1)

        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = (x**2).sum()

    Sphere.__qualname__ = "ElementwiseSphere"
    globals()["ElementwiseSphere"] = Sphere
    check_problem(Sphere())


class Forgetful(MGEOReal):
    """Its way depends on an attribute that its state does not hold."""

    turn = 0

    def accept(self, F, violation):
        self.turn += 1
        return super().accept(F if self.turn % 3 else -F, violation)


def test_a_member_of_the_family_that_forgets_is_caught():
    with pytest.raises(CheckError, match="a run that was kept and restored midway: X"):
        check_algorithm(Forgetful(n_walkers=3))


class Unkept(Forgetful):
    def __init__(self, unkept=None, **options):
        super().__init__(**options)
        self.unkept = object()


def test_one_that_says_so_need_not_be_kept():
    check_algorithm(Unkept(n_walkers=3), n_obj=(2,))
