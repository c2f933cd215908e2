"""Bias sensitivities to housekeeping channels: channel values, and their use in the filter."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    BiasSensitivity,
    Environment,
    FilterModel,
    Magnetometer,
    NoLowerBoundError,
    Scenario,
    compute_lower_bound,
    evaluate,
)
from mgeo_attitude.scenario import HousekeepingChannel
from mgeo_attitude.settings.errors import InvalidValue
from scipy.integrate import solve_ivp

TEMP = HousekeepingChannel(
    name="temp", in_sunlight=40.0, in_shadow=-20.0, time_constant=700.0, initial=5.0
)
CURRENT = HousekeepingChannel(name="current", times=(100.0, 300.0, 900.0), values=(0.1, 0.5, -0.2))
DESIGN = np.array([0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0])


def scenario(gyro=(), mag=(), duration=1500.0, **changes):
    base = Scenario.paper()
    sun, field = base.sensors
    return dataclasses.replace(
        base,
        duration=duration,
        step=5.0,
        eclipse=True,
        housekeeping_channels=(TEMP, CURRENT),
        gyro=dataclasses.replace(base.gyro, bias_sensitivities=gyro),
        sensors=(sun, dataclasses.replace(field, bias_sensitivities=mag)),
        **changes,
    )


def test_temperature_follows_eclipse_with_time_constant():
    """The expected values are integrated by SciPy."""
    modified = scenario(duration=12000.0)
    environment = Environment.from_scenario(modified)
    assert 0 < environment.sunlit.sum() < len(environment.sunlit)
    values = TEMP.compute_values(environment.times, environment.sunlit)
    assert values[0] == 5.0
    goal = np.where(environment.sunlit, 40.0, -20.0)
    y = 5.0
    for k in range(1, 400):
        actual = solve_ivp(
            lambda t, u, k=k: (goal[k] - u) / 700.0, (0.0, 5.0), [y], rtol=1e-10, atol=1e-12
        )
        y = actual.y[0, -1]
        assert values[k] == pytest.approx(y, abs=1e-7)
    free = dataclasses.replace(TEMP, initial=None).compute_values(
        environment.times, environment.sunlit
    )
    assert free[0] == goal[0]


def test_channel_table_is_interpolated_and_constant_outside():
    actual = CURRENT.compute_values(np.array([0.0, 200.0, 600.0, 2000.0]), np.ones(4, dtype=bool))
    np.testing.assert_allclose(actual, [0.1, 0.3, 0.15, -0.2])


def test_gyro_uses_mean_over_step_and_sensor_uses_sample():
    modified = scenario(
        (BiasSensitivity("current", 0.01, "A", 0.1),),
        (BiasSensitivity("current", 300.0, "A", 0.1),),
    )
    model = FilterModel.from_scenario(modified)
    u = model.channels["current"] - 0.1
    np.testing.assert_array_equal(model.sensitivity_factors[:, 1], u)
    np.testing.assert_allclose(model.sensitivity_factors[1:, 0], 0.5 * (u[1:] + u[:-1]), atol=1e-15)


@pytest.mark.slow
def test_constant_channel_is_not_distinguishable_from_bias():
    """At one unit above the reference, the bias is the sum of bias and sensitivity."""
    constant = HousekeepingChannel(name="temp", times=(0.0,), values=(21.0,))
    sigma = Magnetometer().initial_bias_nt
    modified = dataclasses.replace(
        scenario(mag=(BiasSensitivity("temp", sigma, "degC", 20.0),)),
        housekeeping_channels=(constant,),
    )
    model = FilterModel.from_scenario(modified)
    P = evaluate(model.full_duration_model, DESIGN, covariance=True).covariance[0]
    bias, sensitivity = (
        3 * model.suite.blocks.index(f"mag.{b}") for b in ("bias", "bias_per_temp")
    )
    half = model.initial_sigma[bias] ** 2 / 2.0
    sum_variance = P[bias, bias] + 2.0 * P[bias, sensitivity] + P[sensitivity, sensitivity]
    assert P[bias, bias] == pytest.approx(half, rel=0.01)
    assert P[sensitivity, sensitivity] == pytest.approx(half, rel=0.01)
    assert sum_variance < 1e-3 * half


def test_lower_bound_exists_for_sensor_but_not_for_gyro_sensitivity():
    modified = scenario(mag=(BiasSensitivity("current", 2000.0, "A"),))
    bound = compute_lower_bound(modified)
    X = np.random.default_rng(2).uniform(-1.0, 1.0, (10, 12))
    X[:, 3::4] = 300.0
    result = evaluate(FilterModel.from_scenario(modified), X)
    assert (result.trace > np.interp(result.t_end, bound.times, bound.trace)).all()
    with pytest.raises(
        NoLowerBoundError, match=r"gyro\.bias_sensitivities: no lower bound .* effect of temp"
    ):
        compute_lower_bound(scenario((BiasSensitivity("temp", 1e-3),)))


def test_sensitivity_to_unknown_channel_is_rejected():
    modified = scenario(mag=(BiasSensitivity("tmp", 1.0),))
    message = (
        r"sensors\[1\]\.bias_sensitivities\[0\]\.channel = 'tmp': unknown channel; "
        r"did you mean 'temp'\?.*define its values along the plan in "
        r"\[\[housekeeping_channels\]\], or remove the"
    )
    with pytest.raises(InvalidValue, match=message):
        FilterModel.from_scenario(modified)
    with pytest.raises(InvalidValue, match=message):
        AttitudeManeuverProblem(modified)
    with pytest.raises(
        InvalidValue, match=r"gyro\.bias_sensitivities\[0\].*there are no \[\[housekeeping_channels"
    ):
        FilterModel.from_scenario(
            dataclasses.replace(scenario((BiasSensitivity("tmp", 1.0),)), housekeeping_channels=())
        )
