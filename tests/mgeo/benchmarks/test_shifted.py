"""Test problems with wider bounds, so that no optimum lies on a bound."""

import pickle

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.problems import get_problem

from mgeo.benchmarks.shifted import EXTENSION_ABOVE, EXTENSION_BELOW, ShiftedProblem
from mgeo.plugins.problems import load_problem

DISTANCE = {"zdt4": 0.0, "dtlz6": 0.0, "dtlz7": 0.0} | {f"zdt{i}": 0.0 for i in (1, 2, 3, 6)}
DISTANCE |= {f"dtlz{i}": 0.5 for i in range(1, 6)}
WFG = [f"wfg{i}" for i in range(1, 10)]


def load_original_and_shifted(name):
    options = {"n_var": 10, "n_obj": 2} if name.startswith("wfg") else {}
    return get_problem(name, **options), load_problem(f"shifted:{name}", options)


@pytest.mark.parametrize("name", [*DISTANCE, *WFG])
def test_values_inside_original_bounds_are_unchanged(name):
    original, shifted = load_original_and_shifted(name)
    X = original.xl + np.random.default_rng(1).random((50, original.n_var)) * (
        original.xu - original.xl
    )
    assert np.array_equal(shifted.evaluate(X), original.evaluate(X))
    width = original.xu - original.xl
    assert shifted.xl == pytest.approx(original.xl - EXTENSION_BELOW * width)
    assert shifted.xu == pytest.approx(original.xu + EXTENSION_ABOVE * width)
    argument = X.copy()
    shifted.evaluate(argument)
    assert np.array_equal(argument, X)
    assert np.array_equal(pickle.loads(pickle.dumps(shifted)).evaluate(X), original.evaluate(X))


@pytest.mark.parametrize("name", [*DISTANCE, *WFG])
def test_values_outside_original_bounds_are_mirrored(name):
    original, shifted = load_original_and_shifted(name)
    rng, width = np.random.default_rng(2), original.xu - original.xl
    out, side = rng.random((50, original.n_var)), rng.random((50, original.n_var)) < 0.5
    inside = np.where(
        side,
        original.xl + EXTENSION_BELOW * out * width,
        original.xu - EXTENSION_ABOVE * out * width,
    )
    beyond = np.where(
        side,
        original.xl - EXTENSION_BELOW * out * width,
        original.xu + EXTENSION_ABOVE * out * width,
    )
    assert shifted.evaluate(beyond) == pytest.approx(shifted.evaluate(inside), rel=1e-9)
    assert not np.array_equal(shifted.evaluate(beyond), original.evaluate(np.clip(beyond, 0, 1)))


@pytest.mark.parametrize("name", DISTANCE)
def test_solutions_are_away_from_bounds_and_reach_front(name):
    original, shifted = load_original_and_shifted(name)
    X = np.full((101, original.n_var), DISTANCE[name])  # Optimum of the distance variables.
    X[:, : original.n_obj - 1] = np.linspace(0.0, 1.0, 101)[:, None]
    margin = 0.09 * (shifted.xu - shifted.xl)
    assert np.array_equal(np.clip(X, shifted.xl + margin, shifted.xu - margin), X)
    F = shifted.evaluate(X)
    if original.n_obj == 2:  # Fronts in closed form (Zitzler, Deb & Thiele 2000).
        f = F[:, 0]
        expected = {
            "zdt2": 1 - f**2,
            "zdt3": 1 - np.sqrt(f) - f * np.sin(10 * np.pi * f),
            "zdt6": 1 - f**2,
        }.get(name, 1 - np.sqrt(f))
        assert F[:, 1] == pytest.approx(expected, abs=1e-12)
    elif name == "dtlz1":
        assert F.sum(axis=1) == pytest.approx(np.full(101, 0.5))
    elif name != "dtlz7":
        assert (F**2).sum(axis=1) == pytest.approx(np.ones(101))


@pytest.mark.parametrize("name", [*DISTANCE, *WFG])
def test_no_new_bound_is_near_an_optimum(name):
    # `optimum` is the optimum of a distance variable as a fraction of its range (for WFG: Huband et
    # al. 2006).
    original, shifted = load_original_and_shifted(name)
    optimum = 0.5 if name == "zdt4" else DISTANCE.get(name, 0.35)
    for bound in (shifted.xl, shifted.xu):
        share = (shifted.mirror(bound[None])[0] - original.xl) / (original.xu - original.xl)
        assert (np.abs(share - optimum) > 0.19).all()
    middle = 0.5 * (shifted.xl + shifted.xu)
    share = (middle - original.xl) / (original.xu - original.xl)
    assert (np.abs(share - optimum) > 0.09).all()


@pytest.mark.parametrize(
    "inner",
    [Problem(n_var=2, n_obj=2, xl=0, xu=1, vtype=bool), Problem(n_var=2, n_obj=2)],
    ids=["binary", "without bounds"],
)
def test_problems_without_bounded_real_variables_are_rejected(inner):
    with pytest.raises(ValueError, match="cannot be shifted: expected bounded real variables"):
        ShiftedProblem(inner)
