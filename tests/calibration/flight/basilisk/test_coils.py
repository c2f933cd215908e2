"""Basilisk's rigid body and torque rods against the motion that plans are made of."""

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

from ...calibration.independent import tumble, turned
from .flights import check_calibrated, errorless, seen, short

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


def one_unit(coils=COILS, duration=850.0):
    scenario = Scenario.cubesat_6u()
    gyro = dataclasses.replace(scenario.gyro, angle_random_walk_deg_per_sqrt_h=1e-9)
    initial = InitialConditions(rate_deg_s=(0.4, -0.3, 0.2), attitude_deg=5.0)
    return short(scenario, duration, gyro=gyro, magnetorquers=coils, initial=initial)


def flown(scenario):
    """Attitude by Basilisk and by the plan, and rates of the plan's steps."""
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    motion = Motion.from_design(model, DESIGN, model.n_steps)
    coiled = MagnetorquerVehicle.from_design(model.slew_limits, DESIGN, model.step, model.n_steps)
    found = seen(scenario, motion, errorless(model), coiled, environment)
    return found.attitude, motion


def angle(one, other):
    return np.degrees(Rotation.from_matrix(one @ other.transpose(0, 2, 1)).magnitude())


def test_free_motion_is_basilisk_s():
    still = dataclasses.replace(COILS, rate_tolerance_deg_s=100.0, residual_dipole=(0.0, 0.0, 0.0))
    attitude, motion = flown(one_unit(still))
    assert np.degrees(np.ptp(motion.rates, axis=0)).min() > 0.05  # it tumbles
    assert angle(attitude, motion.attitude).max() < 1e-8


def test_coils_do_what_basilisk_s_torque_rods_do():
    """But for what the field changes in a second, of which a plan takes the mean."""
    attitude, motion = flown(one_unit())
    rates = Rotation.from_matrix(attitude[:-1] @ attitude[1:].transpose(0, 2, 1)).as_rotvec()
    assert np.degrees(np.linalg.norm(motion.rates, axis=1)).sum() > 600.0
    assert angle(attitude, motion.attitude).max() < 0.2
    assert np.degrees(np.abs(rates - motion.rates)).max() < 0.01


def test_the_gyro_of_a_tumble_tells_the_mean_of_its_rate():
    """It told the turn: of 4.7 deg/s, the gyro's bias ended 5 sigma off, supported."""
    body = Magnetorquers(max_dipole=(0.2, 0.2, 0.2), inertia=(0.185, 0.144, 0.061))
    initial = InitialConditions(rate_deg_s=(3.0, -2.0, 3.0))
    scenario = dataclasses.replace(one_unit(body, 300.0), initial=initial)
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    design = build_hold_design(model.initial_rate)
    coiled = MagnetorquerVehicle.from_design(model.slew_limits, design, 1.0, 300)
    motion = Motion.from_design(model, design, 300)
    found = seen(scenario, motion, errorless(model), coiled, environment)
    rate = tumble(body.inertia, initial.rate_deg_s, 300.0)
    mean = turned(lambda t: rate(t - 1.0), np.arange(301.0))[0]  # it begins a second before
    np.testing.assert_allclose(found.mean_rates, mean, atol=5e-8)
    assert np.abs(motion.rates - mean).max() > 1e-5  # what it told
    quiet = dataclasses.replace(model.suite.gyro, rate_random_walk=1e-12, initial_bias_deg_s=1e-9)
    own = fly_exactly(dataclasses.replace(scenario, gyro=quiet), [], 1)
    np.testing.assert_allclose(np.radians(own.gyro_deg_s[1:]), mean, atol=5e-8)


def test_satellites_without_wheels_are_calibrated_as_claimed():
    """A bias of the gyro that Basilisk lets stay what it is; coils know no better than the gyro."""
    scenario = one_unit()
    gyro = Scenario.cubesat_6u().gyro
    check_calibrated(dataclasses.replace(scenario, gyro=gyro), DESIGN, 3, supported=False)


def test_own_flights_move_by_the_field_that_they_see():
    """From another attitude than planned coils make other rates: those of that attitude."""
    scenario = one_unit()
    one, other = fly_exactly(scenario, DESIGN, 3), fly_exactly(scenario, DESIGN, 3)
    np.testing.assert_array_equal(one.gyro_deg_s, other.gyro_deg_s)
    model = FilterModel.from_scenario(scenario)
    start = one.truth.attitude[0]
    drive = dataclasses.replace(model.slew_limits, initial_attitude=start)
    body = dataclasses.replace(model, slew_limits=drive, initial_attitude=start)
    expected = Motion.from_design(body, DESIGN, model.n_steps)
    assert angle(start[None], model.initial_attitude[None]).max() > 1.0
    np.testing.assert_allclose(one.truth.attitude, expected.attitude, atol=1e-9)


def test_a_vehicle_is_refused_for_a_satellite_that_coils_turn():
    with pytest.raises(ValueError, match="expected none with magnetorquers"):
        simulate_telemetry(one_unit(), DESIGN, 1, vehicle=Vehicle.amazonia())
