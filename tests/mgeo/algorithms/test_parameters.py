import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.core.variable import Real
from pymoo.optimize import minimize
from pymoo.problems.multi import ZDT1

from mgeo import MGEOCanonical, MGEODirected, MGEOReal, MGEOReal2, MGEOVar

PROBLEM = ZDT1(n_var=3)


@pytest.mark.parametrize(
    ("variant", "parameters", "error", "message"),
    [
        (MGEOReal, {"sigma": 0}, ValueError, "sigma = 0: expected a finite number > 0"),
        (MGEOReal, {"sigma": [1.0, -2.0]}, ValueError, r"sigma\[1\] = -2.0"),
        (MGEOReal, {"tau": -0.5}, ValueError, "tau = -0.5: expected a finite number >= 0"),
        (MGEOReal, {"tau": "a-geo3"}, ValueError, "tau = 'a-geo3': expected one of 'a-geo1'"),
        (MGEOReal, {"n_walkers": 0}, ValueError, "n_walkers = 0: expected an integer from 1"),
        (MGEOReal, {"perturbation": "relativ"}, ValueError, "did you mean 'relative'"),
        (MGEOReal, {"restart": "sometimes"}, ValueError, "restart = 'sometimes': expected one of"),
        (MGEOReal, {"n_walker": 4}, TypeError, "'n_walker'; did you mean 'n_walkers'"),
        (MGEOReal, {"pop_size": 4}, TypeError, "MGEOReal got an unknown keyword 'pop_size'"),
        (MGEOReal2, {"n_steps": 1}, ValueError, "n_steps = 1: expected an integer of at least 2"),
        (MGEOCanonical, {"bits": 53}, ValueError, "bits = 53: expected an integer from 1 to 52"),
        (MGEOCanonical, {"bits": [8, 2.5]}, TypeError, r"bits\[1\] = 2.5: expected an integer"),
        (MGEOVar, {"coding": "grey"}, ValueError, "coding = 'grey': .*did you mean 'gray'"),
        (MGEODirected, {"tau": "a-geo1"}, TypeError, "tau = 'a-geo1': expected a finite number"),
        (MGEODirected, {"momentum": (0.7, 1.4)}, ValueError, r"momentum\[1\] = 1.4: .*\[0, 1\]"),
        (MGEODirected, {"difference": (0.1,)}, ValueError, r"difference = \(0.1,\): expected two"),
    ],
)
def test_constructors_reject_invalid_parameters(variant, parameters, error, message):
    with pytest.raises(error, match=message):
        variant(**parameters)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"save_histroy": True}, "unknown keyword 'save_histroy'; did you mean 'save_history'"),
        ({"sigma": 0.1}, r"setup \(or minimize\) of MGEOReal got an unknown keyword 'sigma'"),
    ],
)
def test_minimize_rejects_options_that_pymoo_ignores(options, message):
    with pytest.raises(TypeError, match=message):
        minimize(PROBLEM, MGEOReal(), seed=1, **options)


@pytest.mark.parametrize(
    ("parameters", "error", "message"),
    [
        ({"sigma": [0.1, 0.2]}, ValueError, "sigma of length 2: expected one number, or one for"),
        ({"archive_size": 3}, ValueError, "archive_size = 3: .*expected at least 4"),
        ({"sampling": np.zeros((2, 4))}, ValueError, r"sampling of shape \(2, 4\): .* n_var = 3"),
        ({"sampling": np.zeros((31, 3))}, ValueError, r"sampling of shape \(31, 3\): .* = 30"),
        ({"sampling": [[0.5, 1.5, 0.5]]}, ValueError, r"sampling\[0, 1\] = 1.5: .*\[0.0, 1.0\]"),
        ({"sampling": "x"}, TypeError, "sampling = 'x': expected None, a pymoo Sampling"),
    ],
)
def test_parameters_that_do_not_fit_problem_are_rejected(parameters, error, message):
    with pytest.raises(error, match=message):
        MGEOReal(**parameters).setup(PROBLEM)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_var": 2}, r"Problem.xl\[0\] = nan: expected a finite number"),
        ({"n_var": 2, "xl": 0.0, "xu": np.array([1.0, np.inf])}, r"Problem.xu\[1\] = inf"),
        ({"n_var": 2, "xl": 1.0, "xu": 0.0}, "expected xl <= xu"),
        ({"vars": {"a": Real(bounds=(0, 1.7e308))}}, r"xu\['a'\] = 1.7e\+308: .* at most 1e\+150"),
        ({"n_var": 2, "xl": 0, "xu": 9, "vtype": int}, "expected real .*MGEODirected "),
    ],
)
def test_problems_without_bounded_real_variables_are_rejected(arguments, message):
    with pytest.raises(ValueError, match=message):
        MGEOReal().setup(Problem(n_obj=2, **arguments))
