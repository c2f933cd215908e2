"""Approximate model with merged filter steps."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, FilterModel, Scenario, evaluate
from mgeo_attitude.filter.variants import coarsen_model

SHORT = {"duration": 1500.0, "maneuvers": {"max_rate_deg_s": 0.5}}


def draw_designs(problem):
    X = np.random.default_rng(5).uniform(problem.xl, problem.xu, (6, problem.n_var))
    X[:, 3::4] = 10.0 * np.round(X[:, 3::4] / 40.0)
    return X


@pytest.mark.parametrize("preset", ["paper", "cubesat_6u"])
def test_coarse_model_approximates_trace(preset):
    problem = AttitudeManeuverProblem(Scenario.from_dict({"preset": preset} | SHORT))
    X = draw_designs(problem)
    exact = evaluate(problem.model, X, end_steps=1500).trace
    coarse = coarsen_model(problem.model, 10)
    assert (coarse.step, coarse.n_steps) == (10.0, 150)
    trace = evaluate(coarse, X, end_steps=150).trace
    np.testing.assert_allclose(trace, exact, rtol=0.03)
    assert coarse.gated == problem.model.gated
    matrix_model = dataclasses.replace(coarse, use_polynomials=False)
    np.testing.assert_allclose(trace, evaluate(matrix_model, X, end_steps=150).trace, rtol=1e-10)


def test_noise_depends_on_number_of_available_samples():
    scenario = Scenario.from_dict({"preset": "paper"} | SHORT)
    sensors = tuple(dataclasses.replace(each, sample_interval=5.0) for each in scenario.sensors)
    model = FilterModel.from_scenario(dataclasses.replace(scenario, sensors=sensors))
    coarse = coarsen_model(model, 10)
    for before, after in zip(sensors, coarse.suite.sensors, strict=True):
        assert after.noise_sigmas() == pytest.approx(
            [sigma / np.sqrt(2.0) for sigma in before.noise_sigmas()]
        )
    X = draw_designs(AttitudeManeuverProblem(scenario))
    exact = evaluate(model, X, end_steps=1500).trace
    np.testing.assert_allclose(evaluate(coarse, X, end_steps=150).trace, exact, rtol=0.03)


def test_coarse_model_supports_axis_noise_and_channels():
    table = Scenario.from_dict({"preset": "cubesat_6u"} | SHORT).to_dict()
    table["housekeeping_channels"] = [
        {"name": "current", "times": [0.0, 1500.0], "values": [0.0, 0.5]}
    ]
    (mag,) = (each for each in table["sensors"] if each["kind"] == "magnetometer")
    mag["noise_nt"] = [100.0, 100.0, 200.0]
    mag["bias_sensitivities"] = [{"channel": "current", "unit": "A", "initial_sigma": 1000.0}]
    problem = AttitudeManeuverProblem(Scenario.from_dict(table))
    X = draw_designs(problem)
    exact = evaluate(problem.model, X, end_steps=1500).trace
    coarse = coarsen_model(problem.model, 10)
    assert len(coarse.sensitivity_factors) == 151
    np.testing.assert_allclose(evaluate(coarse, X, end_steps=150).trace, exact, rtol=0.03)


@pytest.mark.parametrize("preset", ["cubesat_1u"])
def test_model_with_magnetorquer_control_is_unchanged(preset):
    model = AttitudeManeuverProblem(Scenario.from_dict({"preset": preset})).model
    assert coarsen_model(model, 5) is model
    assert coarsen_model(model, 1) is model
