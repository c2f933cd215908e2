"""Values of the lower bound, its distance to plans, and scenarios without a lower bound."""

import dataclasses

import numpy as np
import pydantic.dataclasses
import pytest
from mgeo_attitude import FilterModel, Scenario, compute_lower_bound, evaluate
from mgeo_attitude.geometry.vector import Vec3
from mgeo_attitude.lower_bound.curves import apply_water_filling
from mgeo_attitude.lower_bound.gyro import (
    GyroErrorDynamics,
    bound_through_attitude,
    bound_with_known_attitude,
)
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.sensors.vector_sensors import VectorSensor
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from .plans import build_hard_scenarios, coarsen_scenario


@pytest.fixture(scope="module")
def paper():
    return compute_lower_bound(Scenario.paper())


@pytest.mark.parametrize(
    ("time", "trace"),
    [
        (300, 4.23e-5),
        (1560, 7.01e-6),
        (7600, 1.54e-6),
    ],
)
def test_trace_bound_of_the_paper_scenario(paper, time, trace):
    assert float(f"{paper.trace[time]:.2e}") == trace


def test_bound_at_end_includes_convergence_rule(paper):
    assert np.isinf(paper.trace_at_end[:300]).all()
    assert paper.trace_at_end[500] == pytest.approx(0.95 * paper.trace[200])
    assert paper.trace_at_end[7600] == paper.trace[7600]
    assert paper.trace_at_end[-1] == paper.trace[-1]
    scenario = Scenario.from_dict({"preset": "paper", "convergence": {"rule": "settling"}})
    settling = compute_lower_bound(coarsen_scenario(scenario, 20.0))
    assert (settling.trace_at_end == settling.trace).all()


def test_required_sigma_has_earliest_time():
    required = {"sun.misalignment_deg": 0.03, "attitude_deg": 0.05, "gyro.bias_deg_h": 1e-6}
    scenario = Scenario.from_dict({"preset": "paper", "required_sigma": required})
    bound = compute_lower_bound(scenario)
    assert bound.earliest_times["sun.misalignment_deg"] == 6661.0
    assert np.degrees(bound.compute_sigma("sun.misalignment")[6660]) > 0.03
    assert 0.0 < bound.earliest_times["attitude_deg"] < 1000.0
    assert bound.earliest_times["gyro.bias_deg_h"] == np.inf


@pytest.mark.slow
def test_gyro_bias_at_rest_approaches_lower_bound():
    scenario = build_hard_scenarios()["constant bias"]
    model = FilterModel.from_scenario(scenario)
    bound = compute_lower_bound(scenario, model)
    result = evaluate(model.full_duration_model, np.zeros((1, 4)), history=True)
    ratio = result.variances[0, 1:, 3:6].sum(axis=1) / bound.variance_sum["gyro.bias"][1:]
    assert ratio.min() >= 1.0
    assert ratio[-1] < 1.12
    assert ratio.max() < 3.0


def test_attitude_with_calibrated_sensors_approaches_lower_bound():
    scenario = build_hard_scenarios()["calibrated"]
    model = FilterModel.from_scenario(scenario)
    bound = compute_lower_bound(scenario, model)
    result = evaluate(model.full_duration_model, np.array([[0.1, 0.0, 0.0, 100.0]]), history=True)
    ratio = result.variances[0, :, :3].sum(axis=1) / bound.variance_sum["attitude"]
    assert ratio[1] == pytest.approx(1.0, rel=1e-3)
    assert ratio.max() < 6.0


@pytest.mark.slow
def test_bound_of_considered_errors_is_exact():
    scenario = build_hard_scenarios()["considered"]
    model = FilterModel.from_scenario(scenario)
    bound = compute_lower_bound(scenario, model)
    result = evaluate(model.full_duration_model, np.array([[0.3, -0.2, 0.1, 500.0]]), history=True)
    for block in ("gyro.bias", "sun.bias"):
        own = 3 * model.suite.blocks.index(block)
        variances = result.variances[0, :, own : own + 3].sum(axis=1)
        np.testing.assert_allclose(variances, bound.variance_sum[block], rtol=1e-9)


@pydantic.dataclasses.dataclass(frozen=True)
class AttitudeDependentSensor(VectorSensor):
    """Sensor whose information about its bias increases as the vector approaches body z."""

    kind = "nodding"

    def states(self):
        return {"misalignment": 0.01, "bias": 0.01}

    def linearize_measurement(self, x, v):
        y = super().linearize_measurement(x, v)
        return y + Vec3(*(v.z * component for component in x.bias))

    def noise_sigmas(self):
        return (0.01,) * 3

    def inertial_vector(self, environment):
        return environment.sun


def test_missing_lower_bound_raises_error_with_reason():
    scenario = coarsen_scenario(Scenario.paper(), 20.0)
    other = dataclasses.replace(
        scenario, sensors=(AttitudeDependentSensor(name="odd"), scenario.sensors[1])
    )
    with pytest.raises(
        NoLowerBoundError, match=r"^odd: no lower bound .* about odd\.bias depends on the atti"
    ):
        compute_lower_bound(other)


@pytest.mark.slow
def test_criteria_are_normalized_and_trace_is_weighted():
    scenario = dataclasses.replace(
        coarsen_scenario(Scenario.paper(), 20.0), trace_weights={"attitude": 2.0, "mag.bias": 0.0}
    )
    bound = compute_lower_bound(scenario)
    assert bound.criteria["normalized_trace"][0] == pytest.approx(1.0)
    assert bound.criteria["log_det"][0] == pytest.approx(0.0, abs=1e-12)
    assert bound.criteria["max_eigenvalue"][0] == pytest.approx(1.0)
    names = {"attitude": 2.0, "gyro.bias": 1.0, "sun.misalignment": 1.0, "sun.bias": 1.0}
    expected = bound.variance_sum["mag.misalignment"] + sum(
        weight * bound.variance_sum[name] for name, weight in names.items()
    )
    np.testing.assert_allclose(bound.trace, expected, rtol=1e-12)


def test_water_filling_equals_numerical_minimum():
    initial, max_trace = np.diag([5.0, 1.0, 2.0]), np.array([0.0, 0.5, 3.0, 30.0])
    bound = apply_water_filling(initial, max_trace).sum(axis=1)

    def trace(factor, measured):
        K = factor.reshape(3, 3) @ factor.reshape(3, 3).T
        return np.trace(np.linalg.inv(initial + measured / np.trace(K) * K))

    starts = np.random.default_rng(2).standard_normal((5, 9))
    for total, measured in zip(bound, max_trace, strict=True):
        best = min(minimize(trace, start, measured, method="BFGS").fun for start in starts)
        assert total == pytest.approx(best, rel=1e-5)
        assert total <= best * (1.0 + 1e-12)


@pytest.mark.parametrize(("decay", "walk"), [(0.0, 0.0), (1e-3, 0.0), (0.0, 1e-8), (1e-2, 1e-6)])
def test_bias_with_known_attitude_solves_riccati_equation(decay, walk):
    times, noise = np.array([0.0, 10.0, 300.0, 2000.0]), 1e-3

    def riccati(_, p):
        return -2.0 * decay * p + walk - p * p / noise

    exact = solve_ivp(riccati, (0.0, 2000.0), [4e-4], t_eval=times, rtol=1e-10, atol=1e-16).y[0]
    bound = bound_with_known_attitude(
        times, GyroErrorDynamics(1.0, decay, walk), np.eye(3) / 4e-4, noise
    )
    np.testing.assert_allclose(bound, exact[:, None].repeat(3, axis=1), rtol=1e-6)


def test_bias_at_rest_equals_slope_of_linear_regression():
    """Without random walks, the bias is the slope of a line with a prior of its offset."""
    times = np.arange(0.0, 50.0)
    information = np.where(times > 0.0, 3.0 / 0.1**2, 0.0)
    bound = bound_through_attitude(
        times, GyroErrorDynamics(1.0, 0.0, 0.0), np.eye(3) * 4.0, information, 3.0 * 9.0, 1e-30
    )
    design = np.column_stack([np.ones_like(times), times])[1:] / 0.1
    exact = np.linalg.inv(design.T @ design + np.diag([9.0, 4.0]))[1, 1]
    np.testing.assert_allclose(bound[-1], exact, rtol=1e-9)
