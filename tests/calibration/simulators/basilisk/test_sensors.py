"""Basilisk's sensor modules: misalignments, biases, and declared noise."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    FilterModel,
    Gyro,
    Magnetometer,
    Scenario,
    StarTracker,
    SunSensor,
    TwoAxisSunSensor,
)
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.sensors.environment_errors import FIELD_UNIT_NT
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.simulators.basilisk.vehicle import Vehicle
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from .runs import PLAN, build_errorless_inputs, check_calibrations, run_basilisk, short

pytestmark = pytest.mark.basilisk

QUIET = (
    SunSensor(noise_deg=1e-9),
    Magnetometer(noise_nt=1e-6),
    StarTracker(name="state", noise_arcsec=1e-6, roll_noise_arcsec=1e-6),  # The name of a recorder.
)


@pytest.fixture(scope="module")
def noiseless():
    """Return scenario, environment and model of a satellite at rest whose sensors have no noise."""
    gyro = Gyro(
        angle_random_walk_deg_per_sqrt_h=1e-9,
        rate_random_walk=0.0,
        bias_decay=0.0,
        initial_scale_factor=0.01,
        initial_misalignment_deg=1.0,
    )
    scenario = short(Scenario.paper(), 20.0, sensors=QUIET, gyro=gyro)
    environment = Environment.from_scenario(scenario)
    return scenario, environment, FilterModel.from_scenario(scenario, environment)


def simulate_readings(noiseless, plan=(0.0,) * 12, start=None, **errors):
    """Return the recorded results of a simulation with given sensor states; other states are
    zero.
    """
    scenario, environment, model = noiseless
    drawn = build_errorless_inputs(model)
    for block, value in errors.items():
        first = 3 * model.suite.blocks.index(block.replace("__", "."))
        drawn.true_states[first : first + 3] = value
    if start is not None:
        drawn = dataclasses.replace(drawn, attitude=start)
    bias = np.tile(drawn.true_states[3:6], (model.n_steps, 1))
    drawn = dataclasses.replace(drawn, mean_bias=bias)
    motion = Motion.from_design(model, plan, model.n_steps)
    return run_basilisk(scenario, motion, drawn, Vehicle.amazonia(), environment)


#: Vector of a rotation by 90° about z, and the rotated axes x, y and z.
QUARTER = [0.0, 0.0, 2.0]
TURNED = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def test_misaligned_sun_sensor_reports_rotated_sun(noiseless):
    found = simulate_readings(noiseless, sun__misalignment=QUARTER).sensors[0][1:, 0]
    np.testing.assert_allclose(found, noiseless[1].sun[1:] @ TURNED.T, rtol=0, atol=2e-10)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, rtol=0, atol=2e-10)


def test_misaligned_star_tracker_reports_rotated_gcrs_axes(noiseless):
    found = simulate_readings(noiseless, state__misalignment=QUARTER).sensors[2][1:]
    for axis in range(3):
        expected = np.tile(TURNED[:, axis], (len(found), 1))
        np.testing.assert_allclose(found[:, axis], expected, rtol=0, atol=1e-10)


def test_bias_is_added_after_misalignment(noiseless):
    sun, mag = [0.03, -0.02, 0.01], np.array([2000.0, -1000.0, 500.0])
    found = simulate_readings(
        noiseless,
        sun__misalignment=QUARTER,
        sun__bias=sun,
        mag__misalignment=QUARTER,
        mag__bias=mag / FIELD_UNIT_NT,
    )
    expected = noiseless[1].sun[1:] @ TURNED.T + sun
    np.testing.assert_allclose(found.sensors[0][1:, 0], expected, rtol=0, atol=2e-10)
    expected = found.field[1:] @ TURNED.T + mag
    np.testing.assert_allclose(FIELD_UNIT_NT * found.sensors[1][1:, 0], expected, atol=1e-4)


def test_gyro_applies_misalignment_scale_factor_and_bias(noiseless):
    """The body rotates about x. The gyro is misaligned by 2 arctan(0.1) about z and scaled along
    its own axes.
    """
    scale, bias = np.array([0.03, -0.02, 0.01]), np.array([2e-4, -1e-4, 3e-4])
    plan = np.tile([0.5, 0.0, 0.0, 100.0], 3)
    found = simulate_readings(
        noiseless, plan, gyro__misalignment=[0, 0, 0.2], gyro__scale_factor=scale, gyro__bias=bias
    )
    C = found.attitude
    turns = Rotation.from_matrix(C[:-1] @ C[1:].transpose(0, 2, 1)).as_rotvec()
    # The mean rate is not the rotation vector: coning correction by two steps at a time.
    crossed = np.cross(turns[:-1], turns[1:]) / 24.0
    crossed = np.vstack([crossed[0], crossed[:-1] + crossed[1:], crossed[-1]])
    whole = slice(3, -3)  # Samples with a step before and after.
    angle = 2.0 * np.arctan(0.1)
    axis = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0]])
    expected = (1.0 + scale) * (turns @ np.vstack([axis, [0, 0, 1]]).T) + bias - crossed
    assert turns[-1, 0] > np.radians(0.3)
    np.testing.assert_allclose(found.mean_rates[whole], expected[whole], rtol=0, atol=1e-8)


#: Random walk that is large enough to reveal a bias that is late by one step.
WALK = (5e-6, 2e-5, 1e-5)
NOISE = (0.05, 0.1, 0.2)


@pytest.fixture(scope="module")
def normalized_residuals():
    """Residuals of every channel in a simulation of two orbits, divided by the declared 1-sigma."""
    sensors = (
        SunSensor(noise_deg=1.5),
        Magnetometer(noise_nt=300.0),
        StarTracker(noise_arcsec=10.0, roll_noise_arcsec=60.0, initial_misalignment_deg=20.0),
    )
    gyro = dataclasses.replace(
        Scenario.paper().gyro, rate_random_walk=WALK, angle_random_walk_deg_per_sqrt_h=NOISE
    )
    scenario = dataclasses.replace(Scenario.paper(), sensors=sensors, gyro=gyro)
    environment = Environment.from_scenario(scenario)
    telemetry = simulate_telemetry(scenario, PLAN, 7, environment=environment)
    C, states = telemetry.truth.attitude, telemetry.truth.states
    model = FilterModel.from_scenario(scenario, environment)

    def state(block):
        first = 3 * model.suite.blocks.index(block)
        return states[:, first : first + 3]

    def mount(name):
        g = state(f"{name}.misalignment")[0]
        return Rotation.from_rotvec(
            2.0 * np.arctan(np.linalg.norm(g) / 2.0) * g / np.linalg.norm(g)
        )

    found = {}
    turns = Rotation.from_matrix(C[:-1] @ C[1:].transpose(0, 2, 1)).as_rotvec()
    bias = state("gyro.bias")
    walk = np.radians(NOISE) / 60.0
    found["gyro"] = (
        np.radians(telemetry.gyro_deg_s[1:]) - turns - 0.5 * (bias[:-1] + bias[1:])
    ) / np.sqrt(walk**2 + np.square(WALK) / 12.0)
    in_body = np.einsum("kij,kj->ki", C, environment.sun)
    found["sun"] = (telemetry.sensors["sun"] - mount("sun").apply(in_body) - state("sun.bias"))[
        1:
    ] / np.radians(1.5)
    in_body = np.einsum("kij,kj->ki", C, environment.field)
    bias = FIELD_UNIT_NT * state("mag.bias")
    found["mag"] = (telemetry.sensors["mag"] - mount("mag").apply(in_body) - bias)[1:] / 300.0
    exact = mount("tracker") * Rotation.from_matrix(C[1:])
    q = Rotation.from_quat(telemetry.sensors["tracker"][1:])
    turn = (
        exact * q
    ).as_rotvec()  # The quaternion rotates the axes of GCRS to those of the tracker.
    found["tracker"] = turn / np.radians([10.0 / 3600.0, 10.0 / 3600.0, 60.0 / 3600.0])
    # Change of the gyro bias in a step, by the model of the filter.
    found["drift"] = np.diff(state("gyro.bias"), axis=0) / WALK
    return found


CHANNELS = ("gyro", "sun", "mag", "tracker", "drift")


@pytest.mark.parametrize("channel", CHANNELS)
def test_noise_is_white_with_declared_variance(normalized_residuals, channel):
    """Variance, mean and correlation of 12,000 normal numbers lie within bounds with a false alarm
    rate of 1 in 100,000.
    """
    r = normalized_residuals[channel]
    n = len(r)
    assert n > 11_900
    low, high = chi2.ppf([5e-6, 1 - 5e-6], n) / n
    assert (low < (r**2).mean(axis=0)).all()
    assert ((r**2).mean(axis=0) < high).all()
    assert np.abs(r.mean(axis=0)).max() < 4.42 / np.sqrt(n) + _get_field_model_error(channel)
    assert np.abs((r[1:] * r[:-1]).mean(axis=0)).max() < 4.42 / np.sqrt(n)


def _get_field_model_error(channel):
    """Return the largest mean residual that the field of degree 13 causes: 1.2 nT, in units of the
    noise of 300 nT.
    """
    return 1.2 / 300.0 if channel == "mag" else 0.0


def test_normalized_sun_vectors_are_calibrated_within_sigma():
    """Three runs of 1,500 s with a constant gyro bias, as in Basilisk."""
    gyro = dataclasses.replace(Scenario.paper().gyro, bias_decay=0.0)
    sensors = (TwoAxisSunSensor(noise_deg=2.0), Magnetometer())
    scenario = short(Scenario.paper(), 1500.0, gyro=gyro, sensors=sensors)
    telemetry = check_calibrations(scenario, PLAN, 3)
    lengths = np.linalg.norm(telemetry.sensors["sun"][1:], axis=1)
    np.testing.assert_allclose(lengths, 1.0, rtol=0, atol=1e-12)
