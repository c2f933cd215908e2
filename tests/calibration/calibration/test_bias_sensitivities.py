"""Biases that depend on housekeeping channels: simulation, reading, estimation, tests and
additions.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import BiasSensitivity, Scenario
from mgeo_attitude.scenario import HousekeepingChannel
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import (
    calibrate,
    simulate_telemetry,
)
from mgeo_calibration.calibration.recalibration import recalibrate
from mgeo_calibration.estimation.kinematics import discretize_dynamics
from scipy.linalg import expm

from .runs import PLAN, check_errors, normalize_error, short

TEMP = HousekeepingChannel(
    name="temp", in_sunlight=40.0, in_shadow=-10.0, time_constant=900.0, initial=0.0
)
CURRENT = HousekeepingChannel(
    name="current",
    times=tuple(100.0 * np.arange(31)),
    values=tuple(np.random.default_rng(3).uniform(0.0, 0.5, 31)),
)
GYRO = (BiasSensitivity("temp", 5e-4, "degC", 20.0),)
MAG = (BiasSensitivity("current", 1000.0, "A"), BiasSensitivity("temp", 5.0, "degC", 20.0))


def build_scenario(duration, gyro=GYRO, mag=MAG):
    base = short(Scenario.cubesat_6u(), duration, housekeeping_channels=(TEMP, CURRENT))
    sun, field = base.sensors
    return dataclasses.replace(
        base,
        gyro=dataclasses.replace(base.gyro, bias_sensitivities=gyro),
        sensors=(sun, dataclasses.replace(field, bias_sensitivities=mag)),
    )


FOLLOWING, PLAIN = build_scenario(1500.0), build_scenario(1500.0, (), ())


@pytest.fixture(scope="module")
def telemetry():
    return simulate_telemetry(FOLLOWING, PLAN, 1)


def test_sensitivities_are_calibrated_within_sigma(telemetry):
    calibration = calibrate(FOLLOWING, telemetry)
    check_errors([normalize_error(calibration, telemetry)])
    assert calibration.is_consistent, calibration.conclusion
    table = calibration.build_table().set_index("block")
    assert (table.loc["mag.bias_per_current", "sigma"] < 100.0).all()  # from 1000 nT per A
    assert (table.loc["gyro.bias_per_temp", "sigma"] < 0.36).all()  # deg/h per degC, from 1.8
    sent = calibration.compute_corrections()["mag"]["bias_sensitivities"]["current"]
    assert sent["unit"] == "nT per A"
    np.testing.assert_allclose(
        sent["bias_per_unit"], table.loc["mag.bias_per_current", "estimate"], rtol=1e-12
    )


def test_missing_sensitivity_is_identified_and_can_be_added(telemetry):
    first = calibrate(PLAIN, telemetry)
    assert not first.is_consistent
    assert any(
        failure.cause.startswith("mag.bias depends on ")
        and "set mag.bias_sensitivities" in failure.action
        for failure in first.failures
    )
    again = recalibrate(first, telemetry, ["mag.current", "mag.temp", "gyro.temp"])
    assert again.is_consistent, again.conclusion
    added = {each.channel: each for each in again.scenario.sensors[1].bias_sensitivities}
    bias = PLAIN.sensors[1].initial_bias_nt
    assert added["current"].initial_sigma == pytest.approx(
        10.0 * bias / np.ptp(telemetry.housekeeping["current"])
    )
    truth = telemetry.truth.states[0]
    place = 3 * FOLLOWING.suite.blocks.index("mag.bias_per_current")
    found = again.build_table().set_index("block").loc["mag.bias_per_current"]
    off = (found["estimate"] - 50_000.0 * truth[place : place + 3]) / found["sigma"]
    assert np.abs(off).max() < 4.0
    names = {test.name for test in again.model_tests}
    assert "mag.temp" not in names
    assert "sun.temp" in names
    with pytest.raises(InvalidValue, match=r"fit = 'sun\.heat'.*'sun\.temp'"):
        recalibrate(first, telemetry, ["sun.heat"])


def test_discretization_agrees_with_matrix_exponential():
    """SciPy's exponential at various rates, channel values and durations."""
    suite, rng = FOLLOWING.suite, np.random.default_rng(2)
    suite = dataclasses.replace(suite, gyro=dataclasses.replace(suite.gyro, bias_decay=1e-3))
    rates, durations = 0.02 * rng.standard_normal((5, 3)), rng.uniform(0.5, 4.0, 5)
    values = rng.standard_normal((5, 1))
    F, _ = discretize_dynamics(suite, rates, durations, [values])
    k = suite.n_kinematic
    for step, rate, duration, value in zip(F, rates, durations, values, strict=True):
        expected = expm(suite.dynamics_matrix(rate, value.tolist())[:k, :k] * duration)
        np.testing.assert_allclose(step[:k, :k], expected, rtol=0, atol=1e-13)
