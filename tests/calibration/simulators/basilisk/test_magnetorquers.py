"""Basilisk's rigid body and torque rods, against the motion model of plans."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.maneuvers.schedule import build_hold_design
from mgeo_attitude.scenario import InitialConditions, Magnetorquers, Scenario
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.simulators.basilisk.vehicle import MagnetorquerVehicle, Vehicle
from mgeo_calibration.simulators.kinematic import simulate_telemetry as fly_exactly
from scipy.spatial.transform import Rotation

from ...calibration.independent_simulator import integrate_motion, tumbling_motion
from .runs import build_errorless_inputs, check_calibrations, run_basilisk, short

pytestmark = pytest.mark.basilisk

COILS = Magnetorquers(
    max_dipole=(0.2, 0.15, 0.1),
    inertia=(0.0021, 0.0018, 0.0014),
    products_of_inertia=(2e-5, -1e-5, 3e-5),
    rate_tolerance_deg_s=0.3,
    residual_dipole=(1e-5, -2e-5, 1e-5),
)
#: Spin up about z, despin, spin about x.
DESIGN = np.array([0.1, -0.2, 1.5, 300.0, 0.0, 0.0, 0.0, 250.0, 1.0, 0.0, 0.2, 300.0])


def build_cubesat(coils=COILS, duration=850.0):
    scenario = Scenario.cubesat_6u()
    gyro = dataclasses.replace(scenario.gyro, angle_random_walk_deg_per_sqrt_h=1e-9)
    initial = InitialConditions(rate_deg_s=(0.4, -0.3, 0.2), attitude_deg=5.0)
    return short(scenario, duration, gyro=gyro, magnetorquers=coils, initial=initial)


def simulate_errorless(scenario):
    """Return the attitude by Basilisk and by the plan, and the rates of the plan."""
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    motion = Motion.from_design(model, DESIGN, model.n_steps)
    coiled = MagnetorquerVehicle.from_design(model.slew_limits, DESIGN, model.step, model.n_steps)
    found = run_basilisk(scenario, motion, build_errorless_inputs(model), coiled, environment)
    return found.attitude, motion


def compute_angles(one, other):
    return np.degrees(Rotation.from_matrix(one @ other.transpose(0, 2, 1)).magnitude())


def test_free_motion_agrees_with_basilisk():
    still = dataclasses.replace(COILS, rate_tolerance_deg_s=100.0, residual_dipole=(0.0, 0.0, 0.0))
    attitude, motion = simulate_errorless(build_cubesat(still))
    assert np.degrees(np.ptp(motion.rates, axis=0)).min() > 0.05  # The body tumbles.
    assert compute_angles(attitude, motion.attitude).max() < 1e-8


def test_magnetorquer_motion_agrees_with_basilisk():
    """They differ by the change of the field within a second, of which the plan uses the mean."""
    attitude, motion = simulate_errorless(build_cubesat())
    rates = Rotation.from_matrix(attitude[:-1] @ attitude[1:].transpose(0, 2, 1)).as_rotvec()
    assert np.degrees(np.linalg.norm(motion.rates, axis=1)).sum() > 600.0
    assert compute_angles(attitude, motion.attitude).max() < 0.2
    assert np.degrees(np.abs(rates - motion.rates)).max() < 0.01


def test_gyro_reports_mean_rate_of_tumbling_body():
    """With the rotation vector instead of the mean rate, the bias at 4.7 deg/s was wrong by 5
    sigma.
    """
    body = Magnetorquers(max_dipole=(0.2, 0.2, 0.2), inertia=(0.185, 0.144, 0.061))
    initial = InitialConditions(rate_deg_s=(3.0, -2.0, 3.0))
    scenario = dataclasses.replace(build_cubesat(body, 300.0), initial=initial)
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    design = build_hold_design(model.initial_rate)
    coiled = MagnetorquerVehicle.from_design(model.slew_limits, design, 1.0, 300)
    motion = Motion.from_design(model, design, 300)
    found = run_basilisk(scenario, motion, build_errorless_inputs(model), coiled, environment)
    rate = tumbling_motion(body.inertia, initial.rate_deg_s, 300.0)
    mean = integrate_motion(lambda t: rate(t - 1.0), np.arange(301.0))[
        0
    ]  # The motion starts one second earlier.
    np.testing.assert_allclose(found.mean_rates, mean, atol=5e-8)
    assert np.abs(motion.rates - mean).max() > 1e-5  # The rotation vector differs.
    quiet = dataclasses.replace(model.suite.gyro, rate_random_walk=1e-12, initial_bias_deg_s=1e-9)
    own = fly_exactly(dataclasses.replace(scenario, gyro=quiet), [], 1)
    np.testing.assert_allclose(np.radians(own.gyro_deg_s[1:]), mean, atol=5e-8)


def test_magnetorquer_satellites_are_calibrated_within_sigma():
    """The gyro bias is constant, as in Basilisk. The magnetorquers are controlled by the gyro."""
    scenario = build_cubesat()
    gyro = Scenario.cubesat_6u().gyro
    check_calibrations(dataclasses.replace(scenario, gyro=gyro), DESIGN, 3, supported=False)


def test_kinematic_simulator_uses_field_in_true_attitude():
    """Another initial attitude leads to other rates, because the torque depends on the field in
    body axes.
    """
    scenario = build_cubesat()
    one, other = fly_exactly(scenario, DESIGN, 3), fly_exactly(scenario, DESIGN, 3)
    np.testing.assert_array_equal(one.gyro_deg_s, other.gyro_deg_s)
    model = FilterModel.from_scenario(scenario)
    start = one.truth.attitude[0]
    drive = dataclasses.replace(model.slew_limits, initial_attitude=start)
    body = dataclasses.replace(model, slew_limits=drive, initial_attitude=start)
    expected = Motion.from_design(body, DESIGN, model.n_steps)
    assert compute_angles(start[None], model.initial_attitude[None]).max() > 1.0
    np.testing.assert_allclose(one.truth.attitude, expected.attitude, atol=1e-9)


def test_vehicle_with_magnetorquers_raises():
    with pytest.raises(ValueError, match="expected none with magnetorquers"):
        simulate_telemetry(build_cubesat(), DESIGN, 1, vehicle=Vehicle.amazonia())
