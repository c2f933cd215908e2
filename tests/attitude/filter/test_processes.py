"""Gauss-Markov errors in the compiled filter, compared with closed forms; sample intervals."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    EnvironmentErrors,
    FilterModel,
    Magnetometer,
    Scenario,
    Sensor,
    SunSensor,
    evaluate,
)
from mgeo_attitude.scenario import Convergence
from mgeo_attitude.sensors import GaussMarkov
from pydantic.dataclasses import dataclass

from .suites import SUITES

PLAN = np.array([0.5, -0.3, 0.8, 80.0, -0.7, 0.9, 0.1, 60.0, 0.2, 0.4, -0.9, 500.0])


def scenario(duration=240.0, **changes):
    return dataclasses.replace(
        Scenario.paper(), duration=duration, convergence=Convergence(window=duration), **changes
    )


def variances(model, block):
    first = 3 * model.suite.blocks.index(block)
    return evaluate(model, PLAN, history=True).variances[0][:, first : first + 3]


def test_gauss_markov_discretization_equals_closed_form():
    """The mean is e(0) exp(-t / τ), the variance σ² (1 - exp(-2 t / τ)), and steps combine."""
    process = GaussMarkov(0.3, 40.0)
    decay, variance = process.discretize(10.0)
    assert decay == pytest.approx(np.exp(-0.25), rel=1e-15)
    assert variance == pytest.approx(0.09 * (1.0 - np.exp(-0.5)), rel=1e-15)
    half, new = process.discretize(5.0)
    assert half * half == pytest.approx(decay, rel=1e-15)
    assert half**2 * new + new == pytest.approx(variance, rel=1e-15)
    assert process.discretize(1e-12)[1] == pytest.approx(process.noise_density * 1e-12, rel=1e-12)
    assert process.discretize(1e6) == (pytest.approx(0.0, abs=1e-300), 0.3**2)


@pytest.mark.slow
def test_unmeasured_process_has_stationary_variance():
    suite = SUITES["varying errors"]
    model = FilterModel.from_scenario(
        scenario(
            gyro=suite.gyro, sensors=suite.sensors, environment_errors=suite.environment_errors
        )
    )
    blind = dataclasses.replace(model, available=np.zeros_like(model.available))
    np.testing.assert_allclose(variances(blind, "environment_errors.albedo"), 0.05**2, rtol=1e-12)
    np.testing.assert_allclose(
        variances(blind, "environment_errors.field_error"), 0.002**2, rtol=1e-12
    )
    assert (variances(model, "environment_errors.albedo")[1:] < 0.9 * 0.05**2).all()


@dataclass(frozen=True)
class Mean(Sensor):
    """Sensor of the sum of a constant and a Gauss-Markov error, almost without noise."""

    kind = "mean"
    time: float = 20.0

    def states(self):
        return {"constant": 10.0, "error": GaussMarkov(1.0, self.time)}

    def linearize_measurement(self, x, v):
        return x.constant + x.error

    def noise_sigmas(self):
        return (1e-4, 1e-4, 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("time", [2.0, 20.0, 300.0])
def test_mean_of_correlated_samples_has_known_variance(time):
    """The variance from n samples of correlation ρ is σ² (1 + ρ) / (n - (n - 2) ρ).

    E. Parzen, A new approach to the synthesis of optimal smoothing and prediction systems (1960).
    """
    sensors = (Mean(name="own", time=time), Magnetometer())
    actual = variances(FilterModel.from_scenario(scenario(sensors=sensors)), "own.constant")
    n, rho = np.arange(1, 241), np.exp(-1.0 / time)
    mean = (1.0 + rho) / (n - (n - 2.0) * rho)
    expected = 1.0 / (1.0 / mean + 0.01)  # with the initial information
    np.testing.assert_allclose(actual[1:], np.repeat(expected[:, None], 3, 1), rtol=1e-5)


@pytest.mark.slow
def test_sample_interval_makes_result_independent_of_filter_step():
    suite = SUITES["orbit error"]
    sensors = tuple(dataclasses.replace(s, sample_interval=4.0) for s in suite.sensors)
    continuous_sensors = tuple(dataclasses.replace(s, sample_interval=None) for s in suite.sensors)

    def compute_variances(step, these):
        actual = FilterModel.from_scenario(
            scenario(
                gyro=suite.gyro,
                sensors=these,
                environment_errors=suite.environment_errors,
                step=step,
            )
        )
        return evaluate(actual, PLAN, history=True).variances[0][:: round(4.0 / step)]

    finest = compute_variances(1.0, sensors)
    for step in (2.0, 4.0):
        np.testing.assert_allclose(compute_variances(step, sensors), finest, rtol=1e-9)
    np.testing.assert_allclose(compute_variances(4.0, continuous_sensors), finest, rtol=1e-9)
    assert (
        compute_variances(1.0, continuous_sensors)[-1]
        < compute_variances(2.0, continuous_sensors)[-1]
    )[:3].all()
    assert (compute_variances(1.0, continuous_sensors)[-1] < finest[-1])[:3].all()


def test_processes_and_considered_states_have_zero_default_weight():
    sensors, world = (
        (SunSensor(), Magnetometer(considered=("bias",))),
        EnvironmentErrors(albedo=0.05),
    )
    model = FilterModel.from_scenario(scenario(sensors=sensors, environment_errors=world))
    blocks = model.suite.blocks
    weights = dict(zip(blocks, model.weights[::3], strict=True))
    assert [block for block in blocks if not weights[block]] == [
        "environment_errors.albedo",
        "mag.bias",
    ]
    given = scenario(
        sensors=sensors, environment_errors=world, trace_weights={"environment_errors.albedo": 2.0}
    )
    assert FilterModel.from_scenario(given).weights[6:9].tolist() == [2.0] * 3
    assert [blocks[i // 3] for i in model.suite.calibrated_indices[::3]] == [
        block for block in blocks if weights[block]
    ]
