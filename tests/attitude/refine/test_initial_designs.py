"""Initial designs of a search."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, compute_lower_bound
from mgeo_attitude.refine.evaluators import FixedTimeEvaluator
from mgeo_attitude.refine.initial_designs import (
    append_converging_rate,
    beam_search,
    build_rate_grid,
    build_receding_horizon_plan,
)
from mgeo_attitude.scenario import PathConstraint

from .conftest import build_short_problem, parametrize_rule


def test_each_stage_has_the_rate_with_the_smallest_trace(problem):
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    plan = build_receding_horizon_plan(evaluator, 3, 360.0).reshape(3, 4)
    assert plan[:, 3].tolist() == [120.0] * 3
    rates = build_rate_grid(1.0)
    assert len(rates) == 343
    for stage in range(3):
        candidates = np.tile(plan[: stage + 1], (len(rates), 1, 1))
        candidates[:, -1, :3] = rates
        values, _ = evaluator.evaluate_at_steps(
            candidates.reshape(len(rates), -1), 60 * (stage + 1)
        )
        (own,) = np.flatnonzero((rates == plan[stage, :3]).all(axis=1))
        assert values[own] == values.min()


def test_beam_as_wide_as_the_grid_finds_the_optimum(problem):
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    plans = beam_search(evaluator, 3, 360.0, n_levels=2, width=512)
    assert plans.shape == (512, 12)
    assert len(np.unique(plans, axis=0)) == 512  # There are eight corners and three stages.
    assert (plans[:, 3::4] == 120.0).all()
    values, _ = evaluator.evaluate_at_steps(plans, 180)
    assert (np.diff(values) >= 0.0).all()
    narrow_beam = beam_search(evaluator, 3, 360.0, n_levels=2, width=20)
    few, _ = evaluator.evaluate_at_steps(narrow_beam, 180)
    assert len(few) == 20
    assert (
        values[0]
        <= few[0]
        < evaluator.evaluate_at_steps(beam_search(evaluator, 3, 360.0, n_levels=2), 180)[0][0]
        + 1e-12
    )


def test_final_rates_are_nondominated():
    problem = build_short_problem(4, "trace")
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    plan = build_receding_horizon_plan(evaluator, 3, 360.0)
    found = append_converging_rate(evaluator, plan)
    assert (found[:, :12] == plan).all()
    F = problem.evaluate(found, return_values_of=["F"])
    every = np.array([[*plan, *rate, 0.0] for rate in build_rate_grid(1.0)])
    other = problem.evaluate(every, return_values_of=["F"])
    worse = (other[:, None] >= F).all(axis=2).any(axis=1)
    assert worse.all()  # No rate of the grid dominates a returned rate.
    assert len(F) == len(np.unique(F, axis=0))
    deviation = abs(F[:, 0] - 360.0 - 100.0)  # The window of the rule is 100 s.
    assert deviation[0] == deviation.min()


@parametrize_rule
def test_initial_designs_dominate_random_designs(problem):
    found = problem.suggest_initial_designs(6, np.random.default_rng(1))
    assert found.shape == (6, problem.n_var)
    assert ((found >= problem.xl) & (found <= problem.xu)).all()
    F = problem.evaluate(found, return_values_of=["F"])
    assert (np.diff(F[:, 0]) > -100.0).all()  # End times ascend, up to the window of the rule.
    rng = np.random.default_rng(2)
    X = problem.xl + (problem.xu - problem.xl) * rng.random((200, problem.n_var))
    X[:, 3::4] *= 0.15
    other = problem.evaluate(X, return_values_of=["F"])
    better = (other <= F[:, None]).all(axis=2).mean(axis=1)
    assert better.max() < 0.05


def test_initial_designs_repeat_with_their_seed(problem):
    first, again, other = (
        problem.suggest_initial_designs(3, np.random.default_rng(s)) for s in (5, 5, 6)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    assert problem.suggest_initial_designs(0, np.random.default_rng(1)).shape == (0, problem.n_var)
    with pytest.raises(ValueError, match=r"n = -1: expected a number of designs >= 0"):
        problem.suggest_initial_designs(-1, np.random.default_rng(1))


@pytest.mark.parametrize("rule", ["trace", "end"])
def test_initial_designs_satisfy_path_constraints(rule):
    constraints = (
        PathConstraint(
            name="camera", reference="sun", boresight=(0.0, 0.0, 1.0), half_angle_deg=40.0
        ),
    )
    free = build_short_problem(4, rule).suggest_initial_designs(5, np.random.default_rng(1))
    problem = build_short_problem(4, rule, path_constraints=constraints)
    found = problem.suggest_initial_designs(5, np.random.default_rng(1))
    assert (problem.evaluate(free, return_values_of=["G"]) > 0.0).any()
    assert (problem.evaluate(found, return_values_of=["G"]) <= 0.0).all()


def test_magnetorquer_designs_assume_instantaneous_rate_changes():
    small = {"preset": "cubesat_1u", "duration": 1200.0, "maneuvers": {"count": 2}}
    scenario = Scenario.from_dict(small)
    problem_without_magnetorquers = AttitudeManeuverProblem(
        dataclasses.replace(scenario, magnetorquers=None)
    )
    problem = AttitudeManeuverProblem(scenario)
    found = problem.suggest_initial_designs(2, np.random.default_rng(1))
    np.testing.assert_array_equal(
        found, problem_without_magnetorquers.suggest_initial_designs(2, np.random.default_rng(1))
    )
    F, other = (
        each.evaluate(found, return_values_of=["F"])
        for each in (problem, problem_without_magnetorquers)
    )
    assert (F[:, 1] != other[:, 1]).all()


@pytest.mark.parametrize("count", [1, 2])
def test_initial_designs_of_few_maneuvers_are_finite(count):
    problem = build_short_problem(count, "trace")
    F = problem.evaluate(
        problem.suggest_initial_designs(3, np.random.default_rng(1)), return_values_of=["F"]
    )
    assert np.isfinite(F).all()


@pytest.mark.slow
def test_ten_stages_are_within_a_fifth_of_the_lower_bound():
    problem = AttitudeManeuverProblem(Scenario.paper(), n_maneuvers=10)
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    bound = compute_lower_bound(problem.scenario)
    for time in (1000, 1560):
        design = build_receding_horizon_plan(evaluator, 10, float(time))
        value, _ = evaluator.evaluate_at_steps(design[None], time)
        assert 1.0 < np.exp(value[0]) / bound.trace[time] < 1.2
