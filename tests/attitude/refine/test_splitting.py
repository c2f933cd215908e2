"""Plans in more maneuvers than they need, and in fewer."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import remove_ineffective_maneuvers, split_maneuvers

from .conftest import by_each_rule, short


def plans(n, count, seed=3):
    rng = np.random.default_rng(seed)
    X = rng.uniform(-1.0, 1.0, (n, 4 * count))
    X[:, 3::4] = rng.uniform(0.0, 300.0, (n, count))
    return X


@pytest.mark.parametrize("count", [2, 3, 6, 12])
@pytest.mark.parametrize("rule", ["trace", "end"])
def test_a_plan_of_two_is_a_plan_of_more(count, rule):
    X = plans(20, 2)
    X[0, 3::4], X[1, 3::4] = [100.0, 0.0], [301.5, 0.3]
    F = short(2, rule).evaluate(X, return_values_of=["F"])
    more = split_maneuvers(X, count)
    assert more.shape == (20, 4 * count)
    np.testing.assert_array_equal(short(count, rule).evaluate(more, return_values_of=["F"]), F)


def with_limits(scenario, limits):
    return dataclasses.replace(
        scenario, maneuvers=dataclasses.replace(scenario.maneuvers, **limits)
    )


def test_the_longest_maneuver_is_halved():
    (found,) = split_maneuvers([[1.0, 0.0, 0.0, 80.0, 0.0, 1.0, 0.0, 100.0]], 4).reshape(1, 4, 4)
    assert found[:, 3].tolist() == [40.0, 40.0, 50.0, 50.0]
    assert found[:, 0].tolist() == [1.0, 1.0, 0.0, 0.0]


def test_a_plan_of_more_maneuvers_is_no_plan_of_fewer():
    with pytest.raises(
        ValueError, match="designs of 3 maneuvers: expected at most n_maneuvers = 2"
    ):
        split_maneuvers(plans(1, 3), 2)


@by_each_rule
def test_what_was_split_is_joined_again(problem):
    X = split_maneuvers(plans(12, 2), 4)
    before = problem.evaluate(X, return_values_of=["F"])
    found = remove_ineffective_maneuvers(problem, X)
    assert (problem.evaluate(found, return_values_of=["F"]) <= before).all()
    assert (found[:, 3::4] == 0.0).sum() >= 2 * len(X)
    assert ((found >= problem.xl) & (found <= problem.xu)).all()


def test_maneuvers_are_left_out_that_turn_about_as_a_neighbor_does():
    X = plans(100, 2)
    X[:, 3::4] /= 5.0
    found = remove_ineffective_maneuvers(short(2, "end"), X)
    left_out = (found != X).any(axis=1)
    first = (found[:, :3] != X[:, :3]).any(axis=1)  # of the two
    apart = np.abs(X[:, :3] - X[:, 4:7]).max(axis=1)
    turned = apart * np.where(first, X[:, 3], X[:, 7])
    assert left_out.any()
    assert (turned[left_out] <= 20.0).all()


def test_no_maneuver_gets_longer_than_the_longest():
    problem = short(3, "end")
    problem = type(problem)(with_limits(problem.scenario, {"max_duration": 250.0}))
    X = np.tile([0.5, -0.5, 0.2, 200.0], (1, 3))
    np.testing.assert_array_equal(remove_ineffective_maneuvers(problem, X), X)
