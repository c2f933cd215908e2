import json

import numpy as np
import pytest

from mgeo.runs import Recipe, prepare
from mgeo.runs.algorithms import complete_parameters

pytestmark = pytest.mark.usefixtures("stand_in")


def test_a_recipe_states_everything():
    recipe = prepare("cantilever", {"preset": "heavy"}, parameters={"n_runs": 5}).recipe
    assert recipe.to_dict() == {
        "problem": "cantilever",
        "options": {"load": 2000.0},  # what the preset meant
        "algorithm": "mgeo-real",
        "parameters": complete_parameters("mgeo-real", {"n_runs": 5}),
        "evaluations": 1000 * 5 * 2,
        "seed": 1,
    }


def test_the_same_recipe_gives_the_same_front_after_a_trip_through_json():
    prepared = prepare(
        "cantilever",
        {"load": 1234.5},
        parameters={"sigma": (0.003, 0.1), "n_runs": 3},
        evaluations=300,
        seed=7,
    )
    recipe = Recipe.from_dict(json.loads(json.dumps(prepared.recipe.to_dict())))
    assert recipe == prepared.recipe
    once, again, rebuilt = prepared.solve(), prepared.solve(), recipe.prepare().solve()
    assert np.array_equal(once.X, again.X)
    assert np.array_equal(once.X, rebuilt.X)
    assert np.array_equal(once.F, rebuilt.F)


def test_a_problem_without_options_is_rebuilt_from_those_given():
    recipe = prepare("zdt1", {"n_var": 4}, algorithm="nsga2").recipe
    assert recipe.options == {"n_var": 4}
    assert recipe.prepare().problem.n_var == 4


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"sigma": [0.1, 0.2, 0.3]}, "sigma of length 3.* 2 variables"),
        ({"sigma": -1.0}, "sigma = -1"),
        ({"n_runs": 0}, "n_runs = 0"),
        ({"perturbation": "big"}, "perturbation = 'big'"),
        ({"population": 10}, "'mgeo-real' has no parameter 'population'"),
    ],
)
def test_what_the_algorithm_refuses_is_refused_before_the_run(parameters, message):
    with pytest.raises(ValueError, match=message):
        prepare("cantilever", parameters=parameters)


@pytest.mark.parametrize("value", [{1, 2}, float("nan")])
def test_options_that_cannot_be_written_are_refused_before_the_run(value, monkeypatch):
    monkeypatch.setattr("stand_in.Cantilever.options", lambda self: {"load": value})
    with pytest.raises(ValueError, match="options of 'cantilever' are no JSON values"):
        prepare("cantilever")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": None}, "seed = None: expected an integer"),
        ({"seed": True}, "seed = True: expected an integer"),
        ({"evaluations": "10"}, "evaluations = '10': expected an integer"),
        ({"options": []}, r"options = \[\]: expected a table"),
        ({"sed": 1}, "sed is unknown"),
    ],
)
def test_a_damaged_recipe_is_refused(change, message):
    data = prepare("cantilever").recipe.to_dict()
    with pytest.raises((ValueError, TypeError), match=message):
        Recipe.from_dict(data | change)


def test_a_recipe_with_a_missing_key_is_refused():
    data = prepare("cantilever").recipe.to_dict()
    del data["algorithm"]
    with pytest.raises(ValueError, match="algorithm is missing: expected a string"):
        Recipe.from_dict(data)
