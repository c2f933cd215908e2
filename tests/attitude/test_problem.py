"""Attitude problem as a problem of pymoo and as a plugin of mgeo."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, run_reference_filter
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.optimize import minimize

from mgeo.testing import check_problem


@pytest.fixture(scope="module")
def problem():
    return AttitudeManeuverProblem()


def random_designs(problem, n, seed=0):
    return np.random.default_rng(seed).uniform(problem.xl, problem.xu, (n, problem.n_var))


def test_problem_follows_plugin_protocol():
    short = dataclasses.replace(Scenario.paper(), duration=1200.0, step=4.0)
    check_problem(AttitudeManeuverProblem(short), n_points=6)


@pytest.mark.slow
def test_objectives_are_convergence_time_and_trace(problem):
    X = random_designs(problem, 3)
    for x, (t_end, trace) in zip(X, problem.evaluate(X), strict=True):
        history = run_reference_filter(problem.model, x)
        assert t_end == history.times[-1]
        assert trace == pytest.approx(np.trace(history.covariance), rel=1e-9)


def test_pymoo_minimizes_the_problem(problem):
    result = minimize(problem, NSGA2(pop_size=12), ("n_eval", 60), seed=1)
    assert len(result.F) >= 1
    np.testing.assert_array_equal(problem.evaluate(result.X), result.F)


def test_indicator_space_equals_that_of_the_paper(problem):
    F = [[0.0, 1e-6], [11984.0, 1e-1], [5992.0, 10**-3.5]]
    np.testing.assert_allclose(
        problem.map_to_indicator_space(F), [[0.0, 0.0], [1.0, 1.0], [0.5, 0.5]], atol=1e-12
    )


def test_options_rebuild_the_problem():
    problem = AttitudeManeuverProblem(Scenario.cubesat_6u(), n_maneuvers=2)
    again = AttitudeManeuverProblem.from_options(problem.to_options())
    assert again.scenario == problem.scenario
    assert again.n_var == 8
    assert AttitudeManeuverProblem.from_options({}).scenario == Scenario.paper()
    preset = AttitudeManeuverProblem.from_options({"preset": "cubesat_6u"})
    assert preset.scenario == Scenario.cubesat_6u()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"scenario": "paper"}, TypeError, "scenario = 'paper': expected a Scenario"),
        ({"n_maneuvers": 0}, ValueError, r"count = 0: expected an integer >= 1 and <= 100"),
        ({"n_maneuvers": 2.5}, ValueError, "count = 2.5: expected an integer"),
        ({"threads": 0}, ValueError, "threads = 0: expected an integer >= 1"),
    ],
)
def test_invalid_arguments_are_rejected(arguments, error, message):
    with pytest.raises(error, match=message):
        AttitudeManeuverProblem(**arguments)


def test_selected_view_shares_cached_results(problem, monkeypatch):
    view = problem.view(random_designs(problem, 4))
    table, monte_carlo_objectives = view.describe(), view.monte_carlo_objectives
    monkeypatch.setattr(problem.__class__, "evaluate_nominal", None)
    monkeypatch.setattr("mgeo_attitude.problem.evaluate", None)
    selection = view.select([2, 0])
    pd.testing.assert_frame_equal(selection.describe(), table.iloc[[2, 0]].reset_index(drop=True))
    np.testing.assert_array_equal(selection.monte_carlo_objectives, monte_carlo_objectives[[2, 0]])
    assert selection.constraints()[0].empty


def test_robust_problem_has_the_settings_of_the_scenario_with_a_warning():
    robust = AttitudeManeuverProblem().to_robust().scenario.monte_carlo
    problem = AttitudeManeuverProblem(n_runs=16)
    with pytest.warns(UserWarning, match=rf"16 runs. .* {robust.n_runs} runs"):
        assert problem.to_robust().scenario.monte_carlo.n_runs == 16
