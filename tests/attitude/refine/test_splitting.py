"""Division of plans into more maneuvers, and removal of ineffective maneuvers."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import remove_ineffective_maneuvers, split_maneuvers

from .conftest import build_short_problem, parametrize_rule


def random_designs(n, count, seed=3):
    rng = np.random.default_rng(seed)
    X = rng.uniform(-1.0, 1.0, (n, 4 * count))
    X[:, 3::4] = rng.uniform(0.0, 300.0, (n, count))
    return X


@pytest.mark.parametrize("count", [2, 3, 6, 12])
@pytest.mark.parametrize("rule", ["trace", "end"])
def test_split_plans_have_equal_objectives(count, rule):
    X = random_designs(20, 2)
    X[0, 3::4], X[1, 3::4] = [100.0, 0.0], [301.5, 0.3]
    F = build_short_problem(2, rule).evaluate(X, return_values_of=["F"])
    split = split_maneuvers(X, count)
    assert split.shape == (20, 4 * count)
    np.testing.assert_array_equal(
        build_short_problem(count, rule).evaluate(split, return_values_of=["F"]), F
    )


def replace_maneuver_limits(scenario, limits):
    return dataclasses.replace(
        scenario, maneuvers=dataclasses.replace(scenario.maneuvers, **limits)
    )


def test_longest_maneuver_is_halved():
    (result,) = split_maneuvers([[1.0, 0.0, 0.0, 80.0, 0.0, 1.0, 0.0, 100.0]], 4).reshape(1, 4, 4)
    assert result[:, 3].tolist() == [40.0, 40.0, 50.0, 50.0]
    assert result[:, 0].tolist() == [1.0, 1.0, 0.0, 0.0]


def test_splitting_into_fewer_maneuvers_is_rejected():
    with pytest.raises(
        ValueError, match="designs of 3 maneuvers: expected at most n_maneuvers = 2"
    ):
        split_maneuvers(random_designs(1, 3), 2)


@parametrize_rule
def test_split_maneuvers_are_joined_again(problem):
    X = split_maneuvers(random_designs(12, 2), 4)
    before = problem.evaluate(X, return_values_of=["F"])
    result = remove_ineffective_maneuvers(problem, X)
    assert (problem.evaluate(result, return_values_of=["F"]) <= before).all()
    assert (result[:, 3::4] == 0.0).sum() >= 2 * len(X)
    assert ((result >= problem.xl) & (result <= problem.xu)).all()


def test_maneuvers_similar_to_a_neighbor_are_removed():
    X = random_designs(100, 2)
    X[:, 3::4] /= 5.0
    result = remove_ineffective_maneuvers(build_short_problem(2, "end"), X)
    is_changed = (result != X).any(axis=1)
    # Either the first or the second maneuver is removed.
    is_first_removed = (result[:, :3] != X[:, :3]).any(axis=1)
    rate_difference = np.abs(X[:, :3] - X[:, 4:7]).max(axis=1)
    rotation = rate_difference * np.where(is_first_removed, X[:, 3], X[:, 7])
    assert is_changed.any()
    assert (rotation[is_changed] <= 20.0).all()


def test_joined_maneuvers_respect_max_duration():
    problem = build_short_problem(3, "end")
    problem = type(problem)(replace_maneuver_limits(problem.scenario, {"max_duration": 250.0}))
    X = np.tile([0.5, -0.5, 0.2, 200.0], (1, 3))
    np.testing.assert_array_equal(remove_ineffective_maneuvers(problem, X), X)
