"""Sun sensors whose vectors are normalized, by a simulation of its own."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, Scenario, TwoAxisSunSensor
from mgeo_attitude.settings.base import get_fields
from mgeo_calibration import calibrate, read_telemetry
from mgeo_calibration.telemetry.mapping import SensorChannels, TelemetryMapping

from .flights import PLAN, check_claimed, normalized, short
from .independent import Craft, fly, steady


def two_axis(scenario):
    """The scenario whose Sun sensor measures two angles, as well as it did three numbers."""
    sun, mag = scenario.sensors
    same = {name: getattr(sun, name) for name in get_fields(type(sun))}
    return dataclasses.replace(scenario, sensors=(TwoAxisSunSensor(**same), mag))


SCENARIOS = {
    "paper": short(Scenario.paper(), 3000.0),
    "cubesat_6u": short(Scenario.cubesat_6u(), 3000.0),
}


def flown(name, seed):
    return fly(SCENARIOS[name], steady(PLAN), seed, Craft(unit_vectors=True))


def checked(name, seeds, worst=4.0):
    """How many flights are supported, of which errors are as large as is claimed."""
    scenario, found, supported = two_axis(SCENARIOS[name]), [], 0
    for seed in seeds:
        telemetry = flown(name, seed)
        calibration = calibrate(scenario, telemetry)
        found.append(normalized(calibration, telemetry))
        supported += calibration.is_consistent
    check_claimed(found, worst=worst)
    return supported


@pytest.mark.parametrize("name", SCENARIOS)
def test_normalized_vectors_are_calibrated_as_claimed(name):
    assert checked(name, [1]) == 1


@pytest.mark.cases(1)
@pytest.mark.parametrize("seed", range(6))
def test_directions_with_light_from_the_earth_are_calibrated_as_claimed(seed):
    """The independent truth adds light in all directions, also along the Sun."""
    world = EnvironmentErrors(earth_albedo=0.3, albedo=0.03)
    scenario = dataclasses.replace(two_axis(SCENARIOS["cubesat_6u"]), environment_errors=world)
    telemetry = fly(scenario, steady(PLAN), seed)
    calibration = calibrate(scenario, telemetry)
    assert calibration.is_consistent, calibration.conclusion
    check_claimed([normalized(calibration, telemetry)], 0.999)


def test_three_numbers_whose_noise_is_normalized_away_are_refused_at_once():
    with pytest.raises(ValueError, match=r'sun: .* Use kind = "two-axis-sun-sensor" instead of'):
        calibrate(SCENARIOS["paper"], flown("paper", 1).truncate(100.0))


def test_two_angles_of_a_mounted_sensor_are_read_as_its_directions():
    """In rad, of a sensor whose boresight is the body's -y."""
    scenario, telemetry = two_axis(SCENARIOS["cubesat_6u"]), flown("cubesat_6u", 1).truncate(300.0)
    dcm = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    x, y, z = (telemetry.sensors["sun"] @ np.array(dcm)).T
    seen = z > 0.1
    frame = telemetry.to_frame().drop(columns=["sun_x", "sun_y", "sun_z"])
    frame["a"], frame["b"] = (np.where(seen, np.arctan2(each, z), np.nan) for each in (x, y))
    mapping = TelemetryMapping(
        sensors=(
            SensorChannels(
                name="sun", columns=("a", "b"), unit="rad", dcm=dcm, rotation="sensor-to-body"
            ),
        )
    )
    found = read_telemetry(frame, scenario, mapping).sensors["sun"]
    assert 10 < seen.sum() < len(seen)
    np.testing.assert_allclose(found[seen], telemetry.sensors["sun"][seen], rtol=0, atol=1e-14)
    assert np.isnan(found[~seen]).all()
    with pytest.raises(
        ValueError, match=r"a at row 1, time 1.0+ s = 100 deg: expected less than 90 deg"
    ):
        read_telemetry(frame.assign(a=np.radians(100.0)), scenario, mapping)
    with pytest.raises(ValueError, match=r"columns of sun = .*expected 3 or 2 names"):
        read_telemetry(
            frame, scenario, TelemetryMapping(sensors=(SensorChannels(name="sun", columns=("a",)),))
        )
