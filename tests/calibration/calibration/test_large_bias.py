"""Gyros that are off by more than the body turns."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import calibrate

from .flights import PLAN, check_claimed, normalized, short
from .independent import Craft, coning, fly, steady

SCENARIO = short(Scenario.cubesat_6u(), 1500.0)
MOTIONS = {"plan": steady(PLAN), "turning": coning(0.5, 0.05)}


def believed(deg_s):
    """With a gyro whose bias may be so large, 1-sigma."""
    gyro = dataclasses.replace(SCENARIO.gyro, initial_bias_deg_s=deg_s)
    return dataclasses.replace(SCENARIO, gyro=gyro)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("bias", "step"), [((0.5, 1.0, -0.5), 1.0), ((3.0, -3.0, 3.0), 1.0), ((2.0, 2.0, -2.0), 4.0)]
)
def test_a_large_bias_that_is_believed_possible_is_found(bias, step):
    """They were refused as rates in deg/h, or did not settle."""
    scenario = believed(max(bias))
    craft = Craft(gyro_bias_deg_s=bias)
    telemetry = fly(scenario, MOTIONS["turning"], 3, craft, duration=1500.0, step=step)
    found = calibrate(scenario, telemetry)
    assert found.is_consistent, found.conclusion
    check_claimed([normalized(found, telemetry)], 0.98)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_constant_turn_on_bias_is_found_with_a_preset(seed):
    scenario = dataclasses.replace(believed(0.08), duration=9000.0)
    craft = Craft(gyro_bias_deg_s=(0.08, -0.05, 0.03), walk=0.0)
    telemetry = fly(scenario, MOTIONS["plan"], seed, craft, duration=9000.0)
    found = calibrate(scenario, telemetry)
    assert found.is_consistent, found.conclusion
    _, x = normalized(found, telemetry)
    assert np.abs(x[3:6]).max() < 3.0


def test_a_large_bias_that_is_known_is_no_other_unit():
    """After a calibration little is left of its 1-sigma; only the estimate says how large it is."""
    scenario = believed(2.0)
    craft = Craft(gyro_bias_deg_s=(2.0, -2.0, 2.0))
    telemetry = fly(scenario, MOTIONS["plan"], 3, craft, duration=1500.0)
    half = calibrate(scenario, telemetry.truncate(800.0))
    after = half.build_followup_scenario({"duration": 700.0})
    rest = dataclasses.replace(telemetry, times=telemetry.times - half.time, truth=None)
    again = calibrate(after, rest)
    assert again.is_consistent, again.conclusion
