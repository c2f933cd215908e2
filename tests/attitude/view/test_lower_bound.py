"""Texts and curves that compare plans with the lower bound over all maneuvers."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate
from mgeo_attitude.scenario import MonteCarloSettings
from mgeo_attitude.view.lower_bound import compute_bound_curves, is_valid_for_monte_carlo

from mgeo.plugins.view import build_view

DESIGN = np.array([[0.4, -0.2, 0.1, 700.0, 0.3, 0.5, -0.4, 500.0, -0.6, 0.1, 0.2, 300.0]])


def build_scenario(**required):
    keys = {name.replace("__", "."): value for name, value in required.items()}
    table = {"preset": "paper", "step": 8.0, "convergence": {"window": 304.0}}
    return Scenario.from_dict(table | {"required_sigma": keys})


def test_infeasible_requirement_is_reported_with_its_lower_bound():
    (line,) = build_view(
        AttitudeManeuverProblem(build_scenario(sun__misalignment_deg=0.05))
    ).infeasibility_reasons()
    problem = AttitudeManeuverProblem(
        build_scenario(sun__misalignment_deg=0.05, mag__bias_nt=1000.0)
    )
    assert build_view(problem).infeasibility_reasons() == [line]
    least = np.degrees(problem.lower_bound.compute_sigma("sun.misalignment").min())
    assert "sun misalignment" in line
    assert f"more than {np.ceil(least * 1e4) / 1e4:.4f} deg" in line


def test_feasible_requirements_are_not_reported():
    assert (
        build_view(
            AttitudeManeuverProblem(build_scenario(sun__misalignment_deg=0.07))
        ).infeasibility_reasons()
        == []
    )
    assert build_view(AttitudeManeuverProblem(Scenario.paper())).infeasibility_reasons() == []


@pytest.mark.parametrize(
    ("monte_carlo", "gyro", "is_valid"),
    [
        ({}, {}, True),
        ({"start_delay": 60.0}, {}, False),
        ({"noise_spread": 0.1}, {}, False),
        ({}, {"initial_scale_factor": 1e-3}, False),
    ],
)
def test_lower_bound_is_valid_only_for_some_monte_carlo_settings(monte_carlo, gyro, is_valid):
    scenario = dataclasses.replace(
        build_scenario(sun__misalignment_deg=0.05),
        monte_carlo=MonteCarloSettings(n_runs=4, **monte_carlo),
    )
    scenario = dataclasses.replace(scenario, gyro=dataclasses.replace(scenario.gyro, **gyro))
    assert is_valid_for_monte_carlo(scenario) == is_valid
    problem = AttitudeManeuverProblem(scenario)
    assert bool(build_view(problem).infeasibility_reasons()) == is_valid
    curve = compute_bound_curves(problem, np.array([800.0, 4000.0]))
    assert bool(len(curve)) == is_valid
    if is_valid:
        times, trace, sigma = curve.T
        assert (np.diff(sigma) <= 0.0).all()
        assert (times[0], times[-1]) == (640.0, 4000.0)
        assert (np.diff(trace) <= 0.0).all()


def test_no_monte_carlo_run_is_below_the_plotted_bound():
    scenario = dataclasses.replace(
        build_scenario(mag__bias_nt=1e4), monte_carlo=MonteCarloSettings(n_runs=8)
    )
    problem = AttitudeManeuverProblem(scenario)
    times, trace, _ = compute_bound_curves(problem, np.array([304.0, 11984.0])).T
    for run in problem.monte_carlo_runs:
        result = evaluate(run.model, run.apply_errors(DESIGN))
        assert result.trace[0] > np.interp(result.t_end[0], times, trace)
