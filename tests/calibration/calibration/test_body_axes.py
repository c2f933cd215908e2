"""A tracker without misalignment: attitude is its own, and the gyro's misalignment shows."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Gyro, Magnetometer, Scenario, StarTracker
from mgeo_calibration import calibrate, consistency, fly, simulate_calibrations

from .flights import PLAN, short


@pytest.mark.slow
def test_body_axes_are_the_trackers():
    sensors = (StarTracker(initial_misalignment_deg=0.0), Magnetometer())
    gyro = Gyro(initial_misalignment_deg=0.2)
    scenario = short(dataclasses.replace(Scenario.paper(), gyro=gyro, sensors=sensors), 1200.0)
    calibration = calibrate(scenario, fly(scenario, PLAN, 3))
    sigma = np.degrees(np.sqrt(np.diag(calibration.covariance)))[6:9]  # of the gyro's misalignment
    assert calibration.suite.blocks[2] == "gyro.misalignment"
    assert (sigma < 0.02).all()
    assert "dcm" not in calibration.uplink()["tracker"]
    report = consistency(simulate_calibrations(scenario, PLAN, 20, seed=5), since=0.0)
    assert report["nees"].passed, report.table()
