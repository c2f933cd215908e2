"""Figures of the limit, what it gives away, and what it refuses."""

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

from .plans import coarse, hard


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
def test_trace_of_the_paper_by_a_prototype(paper, time, trace):
    assert float(f"{paper.trace[time]:.2e}") == trace


def test_a_plan_that_converges_has_fallen_but_little(paper):
    assert np.isinf(paper.trace_at_end[:300]).all()
    assert paper.trace_at_end[500] == pytest.approx(0.95 * paper.trace[200])
    assert paper.trace_at_end[7600] == paper.trace[7600]
    assert paper.trace_at_end[-1] == paper.trace[-1]
    scenario = Scenario.from_dict({"preset": "paper", "convergence": {"rule": "settling"}})
    settling = compute_lower_bound(coarse(scenario, 20.0))
    assert (settling.trace_at_end == settling.trace).all()


def test_what_is_required_has_an_earliest_time():
    required = {"sun.misalignment_deg": 0.03, "attitude_deg": 0.05, "gyro.bias_deg_h": 1e-6}
    scenario = Scenario.from_dict({"preset": "paper", "required_sigma": required})
    found = compute_lower_bound(scenario)
    assert found.earliest_times["sun.misalignment_deg"] == 6661.0
    assert np.degrees(found.compute_sigma("sun.misalignment")[6660]) > 0.03
    assert 0.0 < found.earliest_times["attitude_deg"] < 1000.0
    assert found.earliest_times["gyro.bias_deg_h"] == np.inf


@pytest.mark.slow
def test_a_gyro_at_rest_comes_near_its_limit():
    scenario = hard()["constant bias"]
    model = FilterModel.from_scenario(scenario)
    found = compute_lower_bound(scenario, model)
    ran = evaluate(model.full_duration_model, np.zeros((1, 4)), history=True)
    ratio = ran.variances[0, 1:, 3:6].sum(axis=1) / found.variance_sum["gyro.bias"][1:]
    assert ratio.min() >= 1.0
    assert ratio[-1] < 1.12
    assert ratio.max() < 3.0


def test_an_attitude_whose_instruments_are_calibrated_comes_near_its_limit():
    scenario = hard()["calibrated"]
    model = FilterModel.from_scenario(scenario)
    found = compute_lower_bound(scenario, model)
    ran = evaluate(model.full_duration_model, np.array([[0.1, 0.0, 0.0, 100.0]]), history=True)
    ratio = ran.variances[0, :, :3].sum(axis=1) / found.variance_sum["attitude"]
    assert ratio[1] == pytest.approx(1.0, rel=1e-3)
    assert ratio.max() < 6.0


@pytest.mark.slow
def test_considered_errors_are_what_no_plan_changes():
    scenario = hard()["considered"]
    model = FilterModel.from_scenario(scenario)
    found = compute_lower_bound(scenario, model)
    ran = evaluate(model.full_duration_model, np.array([[0.3, -0.2, 0.1, 500.0]]), history=True)
    for block in ("gyro.bias", "sun.bias"):
        own = 3 * model.suite.blocks.index(block)
        variances = ran.variances[0, :, own : own + 3].sum(axis=1)
        np.testing.assert_allclose(variances, found.variance_sum[block], rtol=1e-9)


@pydantic.dataclasses.dataclass(frozen=True)
class Nodding(VectorSensor):
    """One that tells the more of its bias the nearer its vector is to the body's z."""

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


def test_what_cannot_be_bounded_says_so():
    scenario = coarse(Scenario.paper(), 20.0)
    other = dataclasses.replace(scenario, sensors=(Nodding(name="odd"), scenario.sensors[1]))
    with pytest.raises(
        NoLowerBoundError, match=r"^odd: no lower bound .* about odd\.bias depends on the atti"
    ):
        compute_lower_bound(other)


@pytest.mark.slow
def test_criteria_begin_at_the_start_and_weights_count():
    scenario = dataclasses.replace(
        coarse(Scenario.paper(), 20.0), trace_weights={"attitude": 2.0, "mag.bias": 0.0}
    )
    found = compute_lower_bound(scenario)
    assert found.criteria["normalized_trace"][0] == pytest.approx(1.0)
    assert found.criteria["log_det"][0] == pytest.approx(0.0, abs=1e-12)
    assert found.criteria["max_eigenvalue"][0] == pytest.approx(1.0)
    names = {"attitude": 2.0, "gyro.bias": 1.0, "sun.misalignment": 1.0, "sun.bias": 1.0}
    expected = found.variance_sum["mag.misalignment"] + sum(
        weight * found.variance_sum[name] for name, weight in names.items()
    )
    np.testing.assert_allclose(found.trace, expected, rtol=1e-12)


def test_information_of_a_given_trace_fills_up_what_is_known_least():
    known, gained = np.diag([5.0, 1.0, 2.0]), np.array([0.0, 0.5, 3.0, 30.0])
    found = apply_water_filling(known, gained).sum(axis=1)

    def trace(factor, most):
        K = factor.reshape(3, 3) @ factor.reshape(3, 3).T
        return np.trace(np.linalg.inv(known + most / np.trace(K) * K))

    starts = np.random.default_rng(2).standard_normal((5, 9))
    for total, most in zip(found, gained, strict=True):
        best = min(minimize(trace, start, most, method="BFGS").fun for start in starts)
        assert total == pytest.approx(best, rel=1e-5)
        assert total <= best * (1.0 + 1e-12)


@pytest.mark.parametrize(("decay", "walk"), [(0.0, 0.0), (1e-3, 0.0), (0.0, 1e-8), (1e-2, 1e-6)])
def test_a_bias_under_a_known_attitude_is_that_of_kalman_and_bucy(decay, walk):
    times, noise = np.array([0.0, 10.0, 300.0, 2000.0]), 1e-3

    def riccati(_, p):
        return -2.0 * decay * p + walk - p * p / noise

    exact = solve_ivp(riccati, (0.0, 2000.0), [4e-4], t_eval=times, rtol=1e-10, atol=1e-16).y[0]
    found = bound_with_known_attitude(
        times, GyroErrorDynamics(1.0, decay, walk), np.eye(3) / 4e-4, noise
    )
    np.testing.assert_allclose(found, exact[:, None].repeat(3, axis=1), rtol=1e-6)


def test_a_bias_seen_by_an_attitude_at_rest_is_that_of_a_line():
    """Without walks the slope of a straight line through readings, and its offset's prior."""
    times = np.arange(0.0, 50.0)
    told = np.where(times > 0.0, 3.0 / 0.1**2, 0.0)
    found = bound_through_attitude(
        times, GyroErrorDynamics(1.0, 0.0, 0.0), np.eye(3) * 4.0, told, 3.0 * 9.0, 1e-30
    )
    design = np.column_stack([np.ones_like(times), times])[1:] / 0.1
    exact = np.linalg.inv(design.T @ design + np.diag([9.0, 4.0]))[1, 1]
    np.testing.assert_allclose(found[-1], exact, rtol=1e-9)
