import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer, Real
from pymoo.operators.sampling.lhs import LHS
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar
from mgeo.algorithms import MOST_REAL

PROBLEM = ZDT1(n_var=3)


@pytest.mark.parametrize(
    ("parameters", "error", "message"),
    [
        ({"sigma": 0}, ValueError, "sigma = 0: expected a finite number > 0"),
        ({"sigma": np.nan}, ValueError, "sigma = nan"),
        ({"sigma": [1.0, -2.0]}, ValueError, r"sigma\[1\] = -2.0"),
        ({"sigma": "wide"}, TypeError, "sigma = 'wide'"),
        ({"sigma": True}, TypeError, "sigma = True"),
        ({"sigma": np.ones((2, 2))}, TypeError, r"sigma\[0\] = array"),
        ({"tau": -0.5}, ValueError, "tau = -0.5: expected a finite number >= 0"),
        ({"tau": np.inf}, ValueError, "tau = inf"),
        ({"tau": None}, TypeError, "tau = None"),
        ({"n_walkers": 0}, ValueError, "n_walkers = 0: expected an integer from 1 to 100,000"),
        ({"n_walkers": 30.0}, TypeError, "n_walkers = 30.0"),
        ({"n_walkers": True}, TypeError, "n_walkers = True"),
        ({"perturbation": "relativ"}, ValueError, "'relativ'.*did you mean 'relative'"),
        ({"perturbation": 3}, ValueError, "perturbation = 3: expected one of 'absolute'"),
        ({"bounds": None}, ValueError, "bounds = None: expected one of 'clip', 'reflect', 'resam"),
        ({"archive_size": 0}, ValueError, "archive_size = 0"),
        ({"archive_size": 2.5}, TypeError, "archive_size = 2.5"),
        ({"n_walker": 4}, TypeError, "unknown keyword 'n_walker'; did you mean 'n_walkers'"),
        (
            {"pop_size": 4},
            TypeError,
            "MGEOReal got an unknown keyword 'pop_size': n_walkers is the",
        ),
        ({"repair": None}, TypeError, "keyword 'repair': repair the design within the problem"),
        ({"eliminate_duplicates": True}, TypeError, "'eliminate_duplicates': of equal objective"),
        ({"mutation": None}, TypeError, "'mutation': the algorithm's own parameters"),
        ({"x0": np.zeros(3)}, TypeError, r"'x0': sampling=\[x0\]"),
    ],
)
def test_constructor_refuses(parameters, error, message):
    with pytest.raises(error, match=message):
        MGEOReal(**parameters)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"save_histroy": True}, "unknown keyword 'save_histroy'; did you mean 'save_history'"),
        ({"n_gen": 5}, r"unknown keyword 'n_gen': termination=\('n_gen', ...\)"),
        ({"disp": False}, "unknown keyword 'disp': verbose=True"),
        ({"sigma": 0.1}, r"sigma is a parameter of MGEOReal\(...\), not of a run"),
        ({"n_walkers": 3}, "n_walkers is a parameter"),
    ],
)
def test_minimize_refuses_what_pymoo_would_swallow(options, message):
    with pytest.raises(TypeError, match=message):
        minimize(PROBLEM, MGEOReal(), seed=1, **options)
    with pytest.raises(TypeError, match=message):
        MGEOReal().setup(PROBLEM, **options)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"sigma": [0.1, 0.2]}, "sigma of length 2: expected one number, or one for each of the 3"),
        ({"archive_size": 3}, "archive_size = 3: .*expected at least 4"),
        ({"sampling": np.zeros((2, 4))}, r"sampling of shape \(2, 4\): expected .* n_var = 3 num"),
        ({"sampling": np.zeros(3)}, r"sampling of shape \(3,\): expected one row"),
        ({"sampling": np.zeros((0, 3))}, r"sampling of shape \(0, 3\)"),
        (
            {"sampling": np.zeros((31, 3))},
            r"sampling of 31 points: expected at most .* n_walkers = 30 walkers \(n_walkers=31 st",
        ),
        (
            {"n_walkers": 1, "sampling": [[0.5, 1.5, 0.5]]},
            r"sampling\[0, 1\] = 1.5: .*\[0.0, 1.0\]",
        ),
        ({"n_walkers": 1, "sampling": [[0.5, 0.5, np.nan]]}, r"sampling\[0, 2\] = nan"),
    ],
)
def test_parameters_that_do_not_fit_the_problem_are_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        MGEOReal(**parameters).setup(PROBLEM)


@pytest.mark.parametrize(
    "sampling",
    ["x", ["x"] * 30, LHS, object(), [[0.1, 0.2, 0.3], [0.4]], [{"a": 1.0}]],
    ids=["text", "texts", "class", "object", "ragged", "other variables"],
)
def test_a_sampling_that_is_none_is_refused_by_name(sampling):
    with pytest.raises(TypeError, match=r"^sampling = .*: expected None, a pymoo Sampling, a pop"):
        MGEOReal(sampling=sampling).setup(PROBLEM)
    typed = Problem(vars={"a": Real(bounds=(0, 1)), "b": Real(bounds=(0, 1))}, n_obj=2)
    with pytest.raises(TypeError, match=r"^sampling = .*: expected None, a pymoo Sampling, a pop"):
        MGEOReal(sampling=sampling).setup(typed)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_var": 2}, "Problem.xl = None: expected a finite bound"),
        ({"n_var": 2, "xl": 0.0}, "Problem.xu = None"),
        ({"n_var": 2, "xl": 0.0, "xu": np.array([1.0, np.inf])}, r"Problem.xu = \[ 1. inf\]"),
        ({"n_var": 2, "xl": 1.0, "xu": 0.0}, "expected xl <= xu"),
        (
            {"n_var": 2, "xl": [0.0, -1.7e308], "xu": 1.0},
            r"xl\[1\] = -1.7e\+308: .* at most 1e\+150",
        ),
        ({"vars": {"a": Real(bounds=(0, 1.7e308))}}, r"xu\['a'\] = 1.7e\+308: .* at most 1e\+150"),
        (
            {"n_var": 2, "xl": 0, "xu": 9, "vtype": int},
            "<class 'int'>: expected real .*; MGEODirected ",
        ),
        ({"n_var": 2, "xl": 0, "xu": 1, "vtype": bool}, "vtype = <class 'bool'>"),
        (
            {"vars": {"a": Integer(bounds=(0, 3)), "b": Real(bounds=(0, 1))}},
            r"vars\['a'\] is a Integer",
        ),
    ],
)
def test_problems_that_are_not_real_and_bounded_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        MGEOReal().setup(Problem(n_obj=2, **arguments))


@pytest.mark.parametrize(
    "algorithm",
    [*(cls(n_walkers=2) for cls in (MGEOReal2, MGEODirected, MGEOCanonical, MGEOVar)),
     *(MGEOReal(n_walkers=2, perturbation=scale) for scale in ("absolute", "relative", "range"))],
    ids=lambda algorithm: f"{type(algorithm).__name__}-{getattr(algorithm, 'perturbation', '')}",
)  # fmt: skip
def test_the_widest_bounds_allowed_are_computed_with(algorithm):
    class Wide(Problem):
        def __init__(self):
            super().__init__(n_var=3, n_obj=2, xl=-MOST_REAL, xu=MOST_REAL)

        def _evaluate(self, X, out, *args, **kwargs):
            assert np.array_equal(np.clip(X, self.xl, self.xu), X)
            out["F"] = np.column_stack([((X / MOST_REAL - a) ** 2).sum(axis=1) for a in (0.0, 0.5)])

    assert len(minimize(Wide(), algorithm, ("n_gen", 30), seed=1).F) > 1


def test_float_types_are_real():
    for vtype in (None, float, np.float64):
        MGEOReal().setup(Problem(n_var=2, n_obj=2, xl=0, xu=1, vtype=vtype))


def test_given_sigma_and_sampling_are_not_shared():
    sigma = np.array([0.1, 0.2, 0.3])
    algorithm = MGEOReal(sigma)
    sigma[:] = 9.0
    assert algorithm.sigma.tolist() == [0.1, 0.2, 0.3]
