"""States and noise that a calibration asks for are added, and both are compared."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.added import addable, beside, calibrate_with, noise_of

from .faults import MOTION, SCENARIO
from .independent import Craft, fly

SCALE = np.array([0.01, -0.004, 0.002])


@pytest.fixture(scope="module")
def flight():
    telemetry = fly(SCENARIO, MOTION, 2)
    sensors = {**telemetry.sensors, "mag": telemetry.sensors["mag"] * (1.0 + SCALE)}
    return dataclasses.replace(telemetry, sensors=sensors)


@pytest.fixture(scope="module")
def first(flight):
    sun, mag = SCENARIO.sensors
    loud = dataclasses.replace(sun, noise_deg=1.5 * sun.noise_deg)
    return calibrate(dataclasses.replace(SCENARIO, sensors=(loud, mag)), flight)


@pytest.mark.slow
def test_scale_factors_and_noise_are_found_and_both_are_compared(flight, first):
    assert first.failures[0].startswith("mag.scale_factor is ")
    found = calibrate_with(first, flight, ["mag.scale_factor", "noise"])
    assert found.supported, found.conclusion
    scale = found.table().set_index("block").loc["mag.scale_factor"]
    assert np.abs((scale["estimate"] - 1e6 * SCALE) / scale["sigma"]).max() < 4.0
    table = beside(first, found).loc["mag.scale_factor"]
    assert table["sigma before"].isna().all()
    assert table["moved"].abs().max() > 20.0
    noise = found.scenario.sensors[0].noise_deg
    assert noise == pytest.approx(SCENARIO.sensors[0].noise_deg, rel=0.02)
    assert f"sun.noise_deg = {noise:.4g}" in noise_of(found)


@pytest.mark.slow
def test_what_cannot_be_added_is_refused(flight, first):
    options = addable(first.scenario)
    assert {"mag.scale_factor", "mag.nonorthogonality", "gyro.misalignment"} <= set(options)
    for key in ("mag.bias", "mag.scale", "", "other.scale_factor"):
        with pytest.raises(InvalidValue, match=r"fit = .*: expected something that can be added"):
            calibrate_with(first, flight, [key])
    going_on = dataclasses.replace(
        first, scenario=first.scenario_after({"accept_unsupported": True})
    )
    with pytest.raises(InvalidValue, match=r"fit = 'mag\.scale_factor': expected no earlier"):
        calibrate_with(going_on, flight, ["mag.scale_factor"])


@pytest.mark.slow
def test_a_delay_that_was_told_is_found():
    telemetry = fly(SCENARIO, MOTION, 5, Craft(late={"mag": 0.2}))
    first = calibrate(SCENARIO, telemetry)
    assert first.failures[0].endswith(": mag.initial_delay_s")
    found = calibrate_with(first, telemetry, ["mag.delay"])
    assert found.supported, found.conclusion
    delay = found.table().set_index("block").loc[["mag.delay"]].iloc[0]
    assert abs(delay["estimate"] - 0.2) < 4.0 * delay["sigma"]
    assert delay["sigma"] < 0.05
