"""Gyros whose bias is larger than the body rate."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate

from .independent_simulator import TrueErrors, coning_motion, constant_rates, simulate_readings
from .runs import PLAN, check_errors, normalize_error, short

SCENARIO = short(Scenario.cubesat_6u(), 1500.0)
MOTIONS = {"plan": constant_rates(PLAN), "turning": coning_motion(0.5, 0.05)}


def allow_gyro_bias(deg_s):
    """Return a scenario with a given initial 1-sigma of the gyro bias."""
    gyro = dataclasses.replace(SCENARIO.gyro, initial_bias_deg_s=deg_s)
    return dataclasses.replace(SCENARIO, gyro=gyro)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("bias", "step"), [((0.5, 1.0, -0.5), 1.0), ((3.0, -3.0, 3.0), 1.0), ((2.0, 2.0, -2.0), 4.0)]
)
def test_large_bias_within_prior_is_estimated(bias, step):
    """Such telemetry resembles rates in deg/h."""
    scenario = allow_gyro_bias(max(bias))
    craft = TrueErrors(gyro_bias_deg_s=bias)
    telemetry = simulate_readings(
        scenario, MOTIONS["turning"], 3, craft, duration=1500.0, step=step
    )
    found = calibrate(scenario, telemetry)
    assert found.is_consistent, found.conclusion
    check_errors([normalize_error(found, telemetry)], 0.98)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_constant_turn_on_bias_is_estimated_with_preset(seed):
    scenario = dataclasses.replace(allow_gyro_bias(0.08), duration=9000.0)
    craft = TrueErrors(gyro_bias_deg_s=(0.08, -0.05, 0.03), walk=0.0)
    telemetry = simulate_readings(scenario, MOTIONS["plan"], seed, craft, duration=9000.0)
    found = calibrate(scenario, telemetry)
    assert found.is_consistent, found.conclusion
    _, x = normalize_error(found, telemetry)
    assert np.abs(x[3:6]).max() < 3.0


def test_large_known_bias_is_not_reported_as_wrong_unit():
    """After a calibration, the 1-sigma is small, and only the estimate tells the size of the
    bias.
    """
    scenario = allow_gyro_bias(2.0)
    craft = TrueErrors(gyro_bias_deg_s=(2.0, -2.0, 2.0))
    telemetry = simulate_readings(scenario, MOTIONS["plan"], 3, craft, duration=1500.0)
    half = calibrate(scenario, telemetry.truncate(800.0))
    after = half.build_followup_scenario({"duration": 700.0})
    rest = dataclasses.replace(telemetry, times=telemetry.times - half.time, truth=None)
    again = calibrate(after, rest)
    assert again.is_consistent, again.conclusion
