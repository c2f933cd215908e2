"""Quaternions in another order are named, where a sensor that is right was blamed."""

import dataclasses

import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.sensors import StarTracker
from mgeo_calibration import simulate_telemetry
from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.estimation.axis_mistakes import QUATERNION_CONVENTIONS, find_axis_mistakes
from mgeo_calibration.estimation.batch import build_batch

DESIGN = (0.3, -0.2, 0.1, 200.0, -0.2, 0.3, 0.2, 200.0, 0.1, 0.2, -0.3, 200.0)
#: What somebody sends who means these.
SENT = {
    "scalar first": lambda q: q[:, [3, 0, 1, 2]],
    "from the body to GCRF": lambda q: q * [-1.0, -1.0, -1.0, 1.0],
    "scalar first, from the body to GCRF": lambda q: (q * [-1.0, -1.0, -1.0, 1.0])[:, [3, 0, 1, 2]],
}


def sent(scenario, seed=1):
    return simulate_telemetry(scenario, DESIGN, seed)


@pytest.fixture(scope="module")
def scenario():
    cubesat = Scenario.cubesat_6u()
    return dataclasses.replace(
        cubesat,
        duration=900.0,
        sensors=(*cubesat.sensors, StarTracker(initial_misalignment_deg=1.0)),
    )


def reordered(telemetry, order):
    sensors = dict(telemetry.sensors)
    sensors["tracker"] = SENT[order](sensors["tracker"])
    return dataclasses.replace(telemetry, sensors=sensors)


def test_another_order_is_named_and_not_the_sun_sensor(scenario):
    order = "from the body to GCRF"
    message = rf"^tracker: its quaternions agree .* as {order}: expected scalar last, from GCRF"
    with pytest.raises(ValueError, match=message):
        calibrate(scenario, reordered(sent(scenario), order))


@pytest.mark.parametrize("order", [words for words, *_ in QUATERNION_CONVENTIONS])
def test_beside_a_gyro_alone_the_turns_tell(scenario, order):
    alone = dataclasses.replace(scenario, sensors=scenario.sensors[-1:])
    data = build_batch(alone, reordered(sent(alone), order))
    (cause,) = find_axis_mistakes(data)
    assert f"read as {order}: " in cause


def test_a_large_bias_of_the_gyro_is_no_other_order(scenario):
    large = dataclasses.replace(
        scenario, gyro=dataclasses.replace(scenario.gyro, initial_bias_deg_s=1.0)
    )
    telemetry = sent(large)
    assert calibrate(large, telemetry).is_consistent
    with pytest.raises(ValueError, match="read as scalar first: "):
        calibrate(large, reordered(telemetry, "scalar first"))
