"""Vehicles for Basilisk and unsupported states. These tests do not need Basilisk."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, Gyro, Magnetometer, Scenario, Suite, SunSensor
from mgeo_attitude.scenario import Wheels
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration.simulators.basilisk.telemetry import validate_suite
from mgeo_calibration.simulators.basilisk.vehicle import Vehicle

WHEELS = Wheels(inertia=(3.0, 2.0, 1.0), max_torque=0.1, max_momentum=0.5)
PYRAMID = ((1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1))


def build_vehicle(*axes, **changes):
    return Vehicle(wheels=dataclasses.replace(WHEELS, axes=axes, **changes))


def test_wheel_pyramid_acceleration_is_limited_by_most_loaded_wheel():
    """The axes are (±1, ±1, 1)/√3. For a torque (t, t, t), the wheel along it needs t (1 + 1 + 1)
    √3 / 4.
    """
    limits = build_vehicle(*PYRAMID).compute_slew_limits(np.zeros(3))
    assert limits.max_torque == pytest.approx(0.1 * 4.0 / (3.0 * np.sqrt(3.0)), rel=1e-12)


def test_vehicle_comes_from_scenario_wheels_or_name():
    paper = Scenario.paper()
    assert Vehicle.from_scenario(paper) == Vehicle.amazonia()
    assert Vehicle.from_scenario(dataclasses.replace(paper, wheels=WHEELS)) == Vehicle(
        wheels=WHEELS
    )
    assert Vehicle.from_scenario(paper, "cubesat_6u") == Vehicle.cubesat_6u()
    assert Vehicle.from_scenario(Scenario.cubesat_6u_full()) == Vehicle.cubesat_6u()
    with pytest.raises(InvalidValue, match=r"vehicle = 'shuttle'.*cubesat_6u"):
        Vehicle.from_scenario(paper, "shuttle")
    with pytest.raises(InvalidValue, match=r"wheels = None: expected wheels.*paper, cubesat_6u"):
        Vehicle.from_scenario(dataclasses.replace(paper, name="mine"))


def test_initial_wheel_momentum_cancels_body_momentum_unless_declared():
    rate = np.array([0.01, -0.02, 0.03])
    vehicle = build_vehicle(*PYRAMID)
    total = vehicle.wheels.normalized_axes().T @ vehicle.compute_initial_momentum(rate) + [
        0.03,
        -0.04,
        0.03,
    ]
    np.testing.assert_allclose(total, 0.0, atol=1e-16)
    given = (0.1, 0.0, -0.2, 0.3)
    assert build_vehicle(*PYRAMID, initial_momentum=given, ramp_share=0.5).compute_initial_momentum(
        rate
    ).tolist() == [*given]


@pytest.mark.parametrize(
    ("suite", "message"),
    [
        (
            Suite(Gyro(), (SunSensor(), Magnetometer(initial_scale_factor=0.1))),
            r"sensors\[1\].scale_factor = 0.1: expected no such state: Basilisk's magnetometer has "
            "only bias, misalignment",
        ),
        (
            Suite(Gyro(initial_nonorthogonality_deg=0.1), ()),
            r"gyro.nonorthogonality = 0.0017\d*: expected no such state: Basilisk's gyro has only",
        ),
        (
            Suite(Gyro(), (), EnvironmentErrors(albedo=0.03)),
            "environment_errors = .*: expected none",
        ),
    ],
)
def test_states_that_basilisk_lacks_raise(suite, message):
    with pytest.raises(InvalidValue, match=message):
        validate_suite(suite)
