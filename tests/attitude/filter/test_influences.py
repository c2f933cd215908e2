"""Biases that follow channels: what a channel is along a plan, and what the filter makes of it."""

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


def test_a_temperature_follows_the_eclipse_with_its_time_constant():
    """Against SciPy's integrator."""
    of = scenario(duration=12000.0)
    environment = Environment.from_scenario(of)
    assert 0 < environment.sunlit.sum() < len(environment.sunlit)
    values = TEMP.compute_values(environment.times, environment.sunlit)
    assert values[0] == 5.0
    goal = np.where(environment.sunlit, 40.0, -20.0)
    y = 5.0
    for k in range(1, 400):
        found = solve_ivp(
            lambda t, u, k=k: (goal[k] - u) / 700.0, (0.0, 5.0), [y], rtol=1e-10, atol=1e-12
        )
        y = found.y[0, -1]
        assert values[k] == pytest.approx(y, abs=1e-7)
    free = dataclasses.replace(TEMP, initial=None).compute_values(
        environment.times, environment.sunlit
    )
    assert free[0] == goal[0]


def test_a_table_is_read_by_lines_and_held_beyond_its_ends():
    found = CURRENT.compute_values(np.array([0.0, 200.0, 600.0, 2000.0]), np.ones(4, dtype=bool))
    np.testing.assert_allclose(found, [0.1, 0.3, 0.15, -0.2])


def test_the_gyro_counts_the_mean_of_a_step_and_a_sensor_its_sample():
    of = scenario(
        (BiasSensitivity("current", 0.01, "A", 0.1),),
        (BiasSensitivity("current", 300.0, "A", 0.1),),
    )
    model = FilterModel.from_scenario(of)
    u = model.channels["current"] - 0.1
    np.testing.assert_array_equal(model.sensitivity_factors[:, 1], u)
    np.testing.assert_allclose(model.sensitivity_factors[1:, 0], 0.5 * (u[1:] + u[:-1]), atol=1e-15)


@pytest.mark.slow
def test_a_channel_that_rests_cannot_be_told_from_the_bias():
    """At one unit above its reference: the bias then is the sum of both."""
    still = HousekeepingChannel(name="temp", times=(0.0,), values=(21.0,))
    sigma = Magnetometer().initial_bias_nt
    of = dataclasses.replace(
        scenario(mag=(BiasSensitivity("temp", sigma, "degC", 20.0),)),
        housekeeping_channels=(still,),
    )
    model = FilterModel.from_scenario(of)
    P = evaluate(model.full_duration_model, DESIGN, covariance=True).covariance[0]
    bias, per = (3 * model.suite.blocks.index(f"mag.{b}") for b in ("bias", "bias_per_temp"))
    half = model.initial_sigma[bias] ** 2 / 2.0
    both = P[bias, bias] + 2.0 * P[bias, per] + P[per, per]
    assert P[bias, bias] == pytest.approx(half, rel=0.01)
    assert P[per, per] == pytest.approx(half, rel=0.01)
    assert both < 1e-3 * half


def test_a_sensors_influence_has_a_limit_and_the_gyros_says_why_not():
    of = scenario(mag=(BiasSensitivity("current", 2000.0, "A"),))
    bound = compute_lower_bound(of)
    X = np.random.default_rng(2).uniform(-1.0, 1.0, (10, 12))
    X[:, 3::4] = 300.0
    found = evaluate(FilterModel.from_scenario(of), X)
    assert (found.trace > np.interp(found.t_end, bound.times, bound.trace)).all()
    with pytest.raises(
        NoLowerBoundError, match=r"gyro\.bias_sensitivities: no lower bound .* effect of temp"
    ):
        compute_lower_bound(scenario((BiasSensitivity("temp", 1e-3),)))


def test_an_influence_of_no_channel_is_refused_with_the_way_out():
    of = scenario(mag=(BiasSensitivity("tmp", 1.0),))
    message = (
        r"sensors\[1\]\.bias_sensitivities\[0\]\.channel = 'tmp': unknown channel; did you mean 'temp'\?.*"
        r"define its values along the plan in \[\[housekeeping_channels\]\], or remove the"
    )
    with pytest.raises(InvalidValue, match=message):
        FilterModel.from_scenario(of)
    with pytest.raises(InvalidValue, match=message):  # before anything is computed
        AttitudeManeuverProblem(of)
    with pytest.raises(
        InvalidValue, match=r"gyro\.bias_sensitivities\[0\].*there are no \[\[housekeeping_channels"
    ):
        FilterModel.from_scenario(
            dataclasses.replace(scenario((BiasSensitivity("tmp", 1.0),)), housekeeping_channels=())
        )
