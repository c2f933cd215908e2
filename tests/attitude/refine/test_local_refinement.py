"""Local refinement of plans by gradients of the objective at their ends."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, compute_lower_bound, refine_plans
from mgeo_attitude.refine.descent import DescentProblem, descend, descend_from_best
from mgeo_attitude.refine.evaluators import FixedTimeEvaluator
from mgeo_attitude.refine.initial_designs import build_receding_horizon_plan
from mgeo_attitude.refine.local_refinement import iterate_refinement
from mgeo_attitude.scenario import MonteCarloSettings, PathConstraint

from .conftest import build_short_problem, parametrize_rule

CAMERA = (
    PathConstraint(name="camera", reference="sun", boresight=(0.0, 0.0, 1.0), half_angle_deg=40.0),
)
SHORT_REFINEMENT = {"max_plans": 3, "max_iterations": 3}


def evaluate_designs(problem, X):
    F, G = problem.evaluate(X, return_values_of=["F", "G"])
    return F, G.max(axis=1, initial=0.0)


def random_designs(problem, n=8, seed=4):
    rng = np.random.default_rng(seed)
    X = problem.xl + (problem.xu - problem.xl) * rng.random((n, problem.n_var))
    X[:, 3::4] *= 0.1
    return X


def test_gradients_equal_central_differences(problem):
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    descent = DescentProblem(evaluator, 400.0, 3)
    # The point lies between the bounds, and maneuvers end between steps of 2 s.
    z = descent.to_variables(build_receding_horizon_plan(evaluator, 3, 400.0) * 0.9)
    z[9:] += [0.0011, 0.0, -0.0007]
    found, gradients = descent.evaluate_gradients(z[None])
    assert gradients.shape == (1, 1, 12)
    (round_to_steps,), _ = evaluator.evaluate_at_steps(descent.to_designs(z), 200)
    assert found[0, 0] == pytest.approx(round_to_steps, abs=0.01)
    for k in range(12):
        ahead, behind = z.copy(), z.copy()
        ahead[k] += 1e-4
        behind[k] -= 1e-4
        up, down = descent.evaluate_gradients(np.array([ahead, behind]))[0][:, 0]
        assert gradients[0, 0, k] == pytest.approx((up - down) / 2e-4, rel=2e-2, abs=2e-3)


def test_excess_over_max_duration_goes_to_other_maneuvers(problem):
    scenario = dataclasses.replace(
        problem.scenario,
        maneuvers=dataclasses.replace(problem.scenario.maneuvers, max_duration=180),
    )
    descent = DescentProblem(FixedTimeEvaluator(scenario, problem.model), 400.0, 3)
    durations = descent.to_designs(np.array([0.5] * 9 + [0.9, 0.1, 0.0]))[0, 3::4]
    assert durations.sum() == pytest.approx(400.0)
    assert durations.max() == pytest.approx(180.0)


def test_descent_fills_the_time_and_reduces_the_trace(problem):
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    initial = np.array(
        [build_receding_horizon_plan(evaluator, 4, 400.0), random_designs(problem, 1)[0]]
    )
    found = descend(evaluator, initial, 400.0, 8)
    assert found[:, 3::4].sum(axis=1) == pytest.approx(400.0)
    before, after = (evaluator.evaluate_at_steps(each, 200)[0] for each in (initial, found))
    assert (after < before - 0.01).all()
    # Parallel descents equal single descents.
    single = [descend(evaluator, design[None], 400.0, 8)[0] for design in initial]
    np.testing.assert_array_equal(found, single)


def test_best_of_several_descents_is_returned(problem):
    evaluator = FixedTimeEvaluator(problem.scenario, problem.model)
    initial = np.vstack(
        [random_designs(problem, 5), build_receding_horizon_plan(evaluator, 4, 400.0)]
    )
    # Two times in parallel equal each of them.
    times, which = np.array([400.0, 300.0]), np.repeat([0, 1], 6)
    found = descend_from_best(evaluator, np.vstack([initial, initial]), times, which, 12)
    for time, one in zip(times, found, strict=True):
        each = descend(evaluator, initial, time, 12)
        assert (one == each).all(axis=1).any()
        value, _ = evaluator.evaluate_at_steps(np.vstack([one, each]), int(time) // 2)
        assert value[0] <= np.sort(value[1:])[1]


@parametrize_rule
def test_no_plan_gets_worse_and_several_improve(problem):
    X = np.vstack(
        [random_designs(problem), problem.suggest_initial_designs(3, np.random.default_rng(1))]
    )
    original = X.copy()
    found = refine_plans(problem, X, **SHORT_REFINEMENT)
    np.testing.assert_array_equal(X, original)
    assert ((found >= problem.xl) & (found <= problem.xu)).all()
    before, after = evaluate_designs(problem, X)[0], evaluate_designs(problem, found)[0]
    assert (after <= before).all()
    assert (after[:, 1] < 0.95 * before[:, 1]).sum() > 4
    np.testing.assert_array_equal(refine_plans(problem, X, **SHORT_REFINEMENT), found)


@pytest.mark.slow
def test_plans_for_additional_times_are_added(problem):
    X = problem.suggest_initial_designs(4, np.random.default_rng(1))
    F = evaluate_designs(problem, X)[0]
    tables = list(iterate_refinement(problem, X, **SHORT_REFINEMENT, add_plans=True))
    sizes = [len(table) for table in tables]
    assert sizes == sorted(sizes)
    assert sizes[-1] > 2 * len(X)
    found = tables[-1]
    np.testing.assert_array_equal(found[:4].shape, X.shape)
    after = evaluate_designs(problem, found)[0]
    assert (after[:4] <= F).all()
    span = F[:, 0].min(), F[:, 0].max()
    assert ((after[:, 0] >= 0.9 * span[0]) & (after[:, 0] <= span[1])).all()
    first_four = evaluate_designs(problem, tables[-1][:4])[0]
    better = [not (first_four <= row).all(axis=1).any() for row in after[4:]]
    assert np.mean(better) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["trace", "end"])
def test_path_constraints_stay_satisfied(rule):
    problem = build_short_problem(3, rule, path_constraints=CAMERA)
    X = np.vstack(
        [random_designs(problem), problem.suggest_initial_designs(4, np.random.default_rng(1))]
    )
    before, violation = evaluate_designs(problem, X)
    assert 0 < (violation > 0.0).sum() < len(X)
    after, violation_after = evaluate_designs(problem, refine_plans(problem, X, **SHORT_REFINEMENT))
    assert (violation_after[violation <= 0.0] <= 0.0).all()
    assert (violation_after <= violation).all()
    assert (after <= before)[violation <= 0.0].all()


@pytest.mark.slow
def test_requirements_stay_satisfied():
    problem = build_short_problem(3, "end", required_sigma={"attitude_deg": 0.5})
    X = problem.suggest_initial_designs(6, np.random.default_rng(1))
    before, violation = evaluate_designs(problem, X)
    after, violation_after = evaluate_designs(problem, refine_plans(problem, X, **SHORT_REFINEMENT))
    satisfied = violation <= 0.0
    assert satisfied.any()
    assert (violation_after[satisfied] <= 0.0).all()
    assert (after[satisfied] <= before[satisfied]).all()


@pytest.mark.parametrize("name", ["log_det", "max_eigenvalue"])
def test_other_covariance_objectives_are_refined(name):
    problem = build_short_problem(3, "end", objectives=(name, "t_end"))
    X = random_designs(problem, 4)
    before, after = (
        evaluate_designs(problem, X)[0],
        evaluate_designs(problem, refine_plans(problem, X, **SHORT_REFINEMENT))[0],
    )
    assert (after <= before).all()
    assert (after[:, 0] < before[:, 0]).any()


def test_refined_plans_are_accepted_by_monte_carlo_runs():
    problem = build_short_problem(3, "end", monte_carlo=MonteCarloSettings(n_runs=8, quantile=0.75))
    X = random_designs(problem, 4)
    before, after = (
        evaluate_designs(problem, X)[0],
        evaluate_designs(problem, refine_plans(problem, X, **SHORT_REFINEMENT))[0],
    )
    assert (after <= before).all()
    assert (after[:, 1] < before[:, 1]).any()


@pytest.mark.parametrize("names", [("t_end",), ("t_end", "angle"), ("t_end", "trace", "angle")])
def test_other_objectives_are_rejected(names):
    problem = build_short_problem(2, "end", objectives=names)
    with pytest.raises(ValueError, match=r"objectives = \['t_end'.*local refinement needs"):
        refine_plans(problem, random_designs(problem, 2))


def test_empty_and_shortest_plans_are_accepted(problem):
    assert refine_plans(problem, np.empty((0, problem.n_var))).shape == (0, problem.n_var)
    shortest = np.zeros((1, problem.n_var))
    assert (
        evaluate_designs(problem, refine_plans(problem, shortest, **SHORT_REFINEMENT))[0]
        <= evaluate_designs(problem, shortest)[0]
    ).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rule", "times", "ratio"),
    [("end", (1000, 1560, 2785), 1.08), ("trace", (1325, 1560), 1.1)],
)
def test_ten_maneuvers_approach_the_lower_bound(rule, times, ratio):
    scenario = Scenario.paper()
    convergence = dataclasses.replace(scenario.convergence, rule=rule)
    scenario = dataclasses.replace(scenario, convergence=convergence)
    problem = AttitudeManeuverProblem(scenario, n_maneuvers=10)
    X = problem.suggest_initial_designs(12, np.random.default_rng(1))
    durations = X[:, 3::4].sum(axis=1)
    plans = []
    for time in times:
        nearest = X[np.abs(np.log(durations / time)).argmin()].reshape(10, 4).copy()
        nearest[:, 3] *= time / nearest[:, 3].sum() if rule == "end" else 1.0
        plans.append(nearest.ravel())
    found = evaluate_designs(problem, refine_plans(problem, plans, max_iterations=40))[0]
    least = compute_lower_bound(scenario)
    for F in found:
        assert F[1] / least.trace_at_end[round(F[0])] < ratio
