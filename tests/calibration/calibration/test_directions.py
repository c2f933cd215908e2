"""Sun sensors with normalized vectors, by the independent simulator."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, Scenario, TwoAxisSunSensor
from mgeo_attitude.settings.base import get_fields
from mgeo_calibration import calibrate, read_telemetry
from mgeo_calibration.telemetry.mapping import SensorChannels, TelemetryMapping

from .independent_simulator import TrueErrors, constant_rates, simulate_readings
from .runs import PLAN, check_errors, normalize_error, short


def use_two_axis_sensor(scenario):
    """Return a scenario whose Sun sensor measures two angles with the noise of the three-axis
    sensor.
    """
    sun, mag = scenario.sensors
    same = {name: getattr(sun, name) for name in get_fields(type(sun))}
    return dataclasses.replace(scenario, sensors=(TwoAxisSunSensor(**same), mag))


SCENARIOS = {
    "paper": short(Scenario.paper(), 3000.0),
    "cubesat_6u": short(Scenario.cubesat_6u(), 3000.0),
}


def simulate(name, seed):
    return simulate_readings(
        SCENARIOS[name], constant_rates(PLAN), seed, TrueErrors(unit_vectors=True)
    )


def count_consistent(name, seeds, worst=4.0):
    """Return the number of consistent runs, after a check that the errors agree with the
    covariances.
    """
    scenario, found, supported = use_two_axis_sensor(SCENARIOS[name]), [], 0
    for seed in seeds:
        telemetry = simulate(name, seed)
        calibration = calibrate(scenario, telemetry)
        found.append(normalize_error(calibration, telemetry))
        supported += calibration.is_consistent
    check_errors(found, worst=worst)
    return supported


@pytest.mark.parametrize("name", SCENARIOS)
def test_normalized_vectors_are_calibrated_within_sigma(name):
    assert count_consistent(name, [1]) == 1


@pytest.mark.cases(1)
@pytest.mark.parametrize("seed", range(6))
def test_directions_with_albedo_are_calibrated_within_sigma(seed):
    """The true albedo error has all directions, also along the Sun."""
    world = EnvironmentErrors(earth_albedo=0.3, albedo=0.03)
    scenario = dataclasses.replace(
        use_two_axis_sensor(SCENARIOS["cubesat_6u"]), environment_errors=world
    )
    telemetry = simulate_readings(scenario, constant_rates(PLAN), seed)
    calibration = calibrate(scenario, telemetry)
    assert calibration.is_consistent, calibration.conclusion
    check_errors([normalize_error(calibration, telemetry)], 0.999)


def test_unit_vectors_of_three_axis_sensor_raise():
    with pytest.raises(ValueError, match=r'sun: .* Use kind = "two-axis-sun-sensor" instead of'):
        calibrate(SCENARIOS["paper"], simulate("paper", 1).truncate(100.0))


def test_two_angles_of_mounted_sensor_are_read_as_directions():
    """The angles are in rad, and the boresight is -y of the body."""
    scenario, telemetry = (
        use_two_axis_sensor(SCENARIOS["cubesat_6u"]),
        simulate("cubesat_6u", 1).truncate(300.0),
    )
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
        ValueError, match=r"a at row 1, time 1 s = 100 deg: expected less than 90 deg"
    ):
        read_telemetry(frame.assign(a=np.radians(100.0)), scenario, mapping)
    with pytest.raises(ValueError, match=r"columns of sun = .*expected 3 or 2 names"):
        read_telemetry(
            frame, scenario, TelemetryMapping(sensors=(SensorChannels(name="sun", columns=("a",)),))
        )
