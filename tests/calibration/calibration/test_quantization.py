"""A gyro that reports in steps far above its noise."""

import dataclasses

import numpy as np
from mgeo_attitude import Gyro, Scenario
from mgeo_calibration import calibrate, fly
from mgeo_calibration.estimation.batch import batch

from .flights import PLAN, error, short

STEP = 0.005  # deg/s; noise of 0.01 deg/sqrt(h) is 1.7e-4 in a second


def test_flights_report_in_steps_and_calibrations_count_with_them():
    gyro = Gyro(quantization_deg_per_s=STEP)
    scenario = short(dataclasses.replace(Scenario.paper(), gyro=gyro), 1200.0)
    telemetry = fly(scenario, PLAN, 3)
    steps = telemetry.gyro_deg_s[1:] / STEP
    np.testing.assert_allclose(steps, np.round(steps), rtol=0, atol=1e-9)
    plain = fly(short(Scenario.paper(), 1200.0), PLAN, 3)
    off = telemetry.gyro_deg_s[1:] - plain.gyro_deg_s[1:]
    assert 0.45 * STEP < np.abs(off).max() <= 0.5 * STEP * (1.0 + 1e-9)
    for declared in (scenario, short(Scenario.paper(), 1200.0)):  # known, and seen in the numbers
        calibration = calibrate(declared, telemetry)
        assert calibration.supported
        e = error(calibration, telemetry)
        nees = e @ np.linalg.solve(calibration.covariance, e) / len(e)
        assert 0.3 < nees < 2.0
    exact = dataclasses.replace(telemetry, gyro_deg_s=plain.gyro_deg_s, steps={})
    assert (batch(scenario, exact).added > batch(declared, exact).added).any()
