"""Test problems with their optima off the bounds: the same problem, in a wider box."""

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


def pair(name):
    options = {"n_var": 10, "n_obj": 2} if name.startswith("wfg") else {}
    return get_problem(name, **options), load_problem(f"shifted:{name}", options)


@pytest.mark.parametrize("name", [*DISTANCE, *WFG])
def test_within_the_former_bounds_it_is_the_same_problem(name):
    plain, shifted = pair(name)
    X = plain.xl + np.random.default_rng(1).random((50, plain.n_var)) * (plain.xu - plain.xl)
    assert np.array_equal(shifted.evaluate(X), plain.evaluate(X))
    width = plain.xu - plain.xl
    assert shifted.xl == pytest.approx(plain.xl - EXTENSION_BELOW * width)
    assert shifted.xu == pytest.approx(plain.xu + EXTENSION_ABOVE * width)
    given = X.copy()
    shifted.evaluate(given)
    assert np.array_equal(given, X)
    assert np.array_equal(pickle.loads(pickle.dumps(shifted)).evaluate(X), plain.evaluate(X))


@pytest.mark.parametrize("name", [*DISTANCE, *WFG])
def test_beyond_them_it_is_mirrored(name):
    plain, shifted = pair(name)
    rng, width = np.random.default_rng(2), plain.xu - plain.xl
    out, side = rng.random((50, plain.n_var)), rng.random((50, plain.n_var)) < 0.5
    inside = np.where(
        side, plain.xl + EXTENSION_BELOW * out * width, plain.xu - EXTENSION_ABOVE * out * width
    )
    beyond = np.where(
        side, plain.xl - EXTENSION_BELOW * out * width, plain.xu + EXTENSION_ABOVE * out * width
    )
    assert shifted.evaluate(beyond) == pytest.approx(shifted.evaluate(inside), rel=1e-9)
    assert not np.array_equal(shifted.evaluate(beyond), plain.evaluate(np.clip(beyond, 0, 1)))


@pytest.mark.parametrize("name", DISTANCE)
def test_solutions_lie_off_the_bounds_and_reach_the_front(name):
    plain, shifted = pair(name)
    X = np.full((101, plain.n_var), DISTANCE[name])  # of every variable but those of position
    X[:, : plain.n_obj - 1] = np.linspace(0.0, 1.0, 101)[:, None]
    margin = 0.09 * (shifted.xu - shifted.xl)
    assert np.array_equal(np.clip(X, shifted.xl + margin, shifted.xu - margin), X)
    F = shifted.evaluate(X)
    if plain.n_obj == 2:  # in closed form (Zitzler, Deb & Thiele 2000), no better point nearby
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
    # The optimum of a distance variable, as a fraction of its range (WFG: Huband et al. 2006).
    plain, shifted = pair(name)
    optimum = 0.5 if name == "zdt4" else DISTANCE.get(name, 0.35)
    for bound in (shifted.xl, shifted.xu):
        share = (shifted.mirror(bound[None])[0] - plain.xl) / (plain.xu - plain.xl)
        assert (np.abs(share - optimum) > 0.19).all()
    middle = 0.5 * (shifted.xl + shifted.xu)
    share = (middle - plain.xl) / (plain.xu - plain.xl)
    assert (np.abs(share - optimum) > 0.09).all()


@pytest.mark.parametrize(
    "inner",
    [Problem(n_var=2, n_obj=2, xl=0, xu=1, vtype=bool), Problem(n_var=2, n_obj=2)],
    ids=["binary", "without bounds"],
)
def test_only_bounded_real_variables_are_moved(inner):
    with pytest.raises(ValueError, match="cannot be shifted: expected bounded real variables"):
        ShiftedProblem(inner)
