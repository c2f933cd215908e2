"""Basilisk's orbit, field, eclipses and rigid body, against `Environment` and closed forms."""

import dataclasses
import subprocess
import sys

import numpy as np
import ppigrf
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.frames import gcrs_to_itrs, rotate
from mgeo_attitude.environment.sun_moon import sun_position, visible_sun_fraction
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import InitialConditions, ManeuverBounds, Orbit, Wheels
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.simulators.basilisk.vehicle import Vehicle
from mgeo_calibration.simulators.kinematic import simulate_telemetry as fly_exactly
from scipy.spatial.transform import Rotation

from .runs import PLAN, build_errorless_inputs, run_basilisk, short

pytestmark = pytest.mark.basilisk

ORBITS = {
    "two bodies": {},
    "mean elements": {"orbit": dataclasses.replace(Scenario.paper().orbit, propagator="j2")},
    "eccentric": {
        "orbit": Orbit(
            semi_major_axis=9e6,
            eccentricity=0.25,
            inclination_deg=40.0,
            raan_deg=10.0,
            argument_of_perigee_deg=20.0,
            true_anomaly_deg=-60.0,
        )
    },
}


def simulate_at_rest(scenario):
    """Return environment and recorded results of a simulation without errors or rotation."""
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    motion = Motion.from_design(model, np.zeros(12), model.n_steps)
    vehicle = Vehicle.amazonia()
    return environment, run_basilisk(
        scenario, motion, build_errorless_inputs(model), vehicle, environment
    )


@pytest.mark.parametrize("orbit", ORBITS)
def test_orbit_and_field_agree_with_environment(orbit):
    """The expected field is IGRF to degree 12, by ppigrf; the environment has one more degree."""
    scenario = short(Scenario.paper(), 3000.0, step=2.0, **ORBITS[orbit])
    environment, found = simulate_at_rest(scenario)
    np.testing.assert_allclose(found.position, environment.position, rtol=0, atol=1e-4)

    to_itrs = gcrs_to_itrs(compute_julian_dates(scenario.epoch, environment.times))
    x, y, z = rotate(to_itrs, environment.position).T
    radius, colatitude = np.hypot(np.hypot(x, y), z), np.arctan2(np.hypot(x, y), z)
    longitude = np.arctan2(y, x)
    date = scenario.epoch.replace(tzinfo=None)
    outward, south, east = ppigrf.igrf_gc(
        radius / 1e3, np.degrees(colatitude), np.degrees(longitude), date, max_degree=12
    )
    up = np.stack([x, y, z], axis=1) / radius[:, None]
    to_east = np.stack([-np.sin(longitude), np.cos(longitude), 0.0 * z], axis=1)
    in_itrs = outward.T * up + east.T * to_east + south.T * np.cross(to_east, up)
    expected = rotate(np.swapaxes(to_itrs, 1, 2), in_itrs)
    np.testing.assert_allclose(found.field, expected, rtol=0, atol=0.05)  # nT
    assert np.abs(found.field - environment.field).max() < 5.0


def test_sun_sensor_reports_only_in_full_sunlight():
    scenario = short(Scenario.cubesat_6u(), 6000.0)
    environment, found = simulate_at_rest(scenario)
    sun = sun_position(compute_julian_dates(scenario.epoch, environment.times))
    lit = visible_sun_fraction(environment.position, sun) == 1.0
    reported = np.isfinite(found.sensors[0][:, 0, 0])
    differ = np.flatnonzero(reported[1:] != lit[1:])
    assert len(differ) <= 2  # Basilisk's Sun is smaller by a thousandth: 0.01 s of penumbra.
    assert 1500 < (~lit).sum() < 2500
    dark = short(Scenario.paper(), 6000.0, eclipse=False)
    assert np.isfinite(simulate_at_rest(dark)[1].sensors[0][1:]).all()


#: Four wheels whose momenta cancel in part and have a resultant.
PYRAMID = Wheels(
    inertia=(310.0, 310.0, 170.0),
    axes=((1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (0.0, 1.0, 1.0), (0.0, -1.0, 1.0)),
    max_torque=0.2,
    max_momentum=12.0,
    initial_momentum=(4.0, 2.0, -3.0, -1.0),
    ramp_share=0.5,
)
SPINNING = InitialConditions(pointing="nadir", axis=(0.0, 0.6, 0.8), rate_deg_s=(0.2, -0.1, 0.1))


def remove_gyro_noise(scenario):
    """Return a scenario with negligible gyro noise."""
    gyro = dataclasses.replace(scenario.gyro, angle_random_walk_deg_per_sqrt_h=1e-9)
    return dataclasses.replace(scenario, gyro=gyro)


@pytest.mark.parametrize("wheels", [PYRAMID, dataclasses.replace(PYRAMID, initial_momentum=())])
def test_rotating_start_with_spinning_wheels_follows_plan(wheels):
    """The wheels have arbitrary axes, and a gyroscopic torque of up to 8 N m acts along the
    ramps.
    """
    limits = ManeuverBounds(max_acceleration_deg_s2=0.01)
    scenario = remove_gyro_noise(
        short(Scenario.paper(), 900.0, maneuvers=limits, wheels=wheels, initial=SPINNING)
    )
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    slow = PLAN * np.tile([0.5, 0.5, 0.5, 1.0], 3)
    motion = Motion.from_design(model, slow, model.n_steps)
    found = run_basilisk(
        scenario,
        motion,
        build_errorless_inputs(model),
        Vehicle.from_scenario(scenario),
        environment,
    )
    np.testing.assert_allclose(found.attitude[0], model.initial_attitude, rtol=0, atol=1e-12)
    off = Rotation.from_matrix(found.attitude @ motion.attitude.transpose(0, 2, 1)).magnitude()
    assert np.degrees(off.max()) < 0.05
    assert np.abs(np.degrees(motion.rates)).max() > 0.3


def test_torque_and_momentum_stay_within_wheel_limits():
    """There is no external torque, so that body and wheels exchange momentum."""
    wheels = Wheels(inertia=(3.0, 2.0, 1.0), max_torque=2e-3, max_momentum=0.02)
    vehicle = Vehicle(wheels=wheels)
    scenario = short(Scenario.paper(), 900.0, step=0.5)
    C = simulate_telemetry(scenario, PLAN, 1, vehicle=vehicle).truth.attitude
    rates = Rotation.from_matrix(C[:-1] @ C[1:].transpose(0, 2, 1)).as_rotvec() / 0.5
    momentum = rates @ wheels.inertia_matrix()
    # A wheel stops at the first step beyond its limit.
    assert np.abs(momentum).max() == pytest.approx(0.02, rel=0.06)
    # In body axes: the torque, and the gyroscopic term of a momentum that is constant in space.
    torque = np.diff(np.einsum("kji,kj->ki", C[:-1], momentum), axis=0) / 0.5
    in_body = np.einsum("kij,kj->ki", C[1:-1], torque)
    gyroscopic = np.linalg.norm(np.cross(rates[1:], momentum[1:]), axis=1).max()
    assert 1.5e-3 < np.abs(in_body).max() < 2e-3 + gyroscopic


def test_equal_seeds_give_equal_telemetry_and_kinematic_errors():
    scenario = short(Scenario.cubesat_6u(), 120.0)
    one, again, other = (simulate_telemetry(scenario, PLAN, seed) for seed in (5, 5, 6))
    assert one.to_frame().equals(again.to_frame())
    assert not one.to_frame().equals(other.to_frame())
    exact = fly_exactly(scenario, PLAN, 5)
    np.testing.assert_array_equal(one.truth.states, exact.truth.states)
    np.testing.assert_allclose(one.truth.attitude[0], exact.truth.attitude[0], atol=1e-14)
    assert not np.allclose(one.gyro_deg_s[1:], exact.gyro_deg_s[1:])


def test_simulation_attempts_no_download():
    code = """
import socket

def refused(*args, **kwargs):
    raise AssertionError("the network was asked for")

socket.socket.connect = socket.create_connection = socket.getaddrinfo = refused
import sys
import numpy as np
from mgeo_attitude import Scenario
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_attitude.scenario import Convergence
import dataclasses

scenario = dataclasses.replace(
    Scenario.cubesat_6u(), duration=20.0, convergence=Convergence(window=20.0)
)
telemetry = simulate_telemetry(scenario, np.zeros(12), 1)
assert np.isfinite(telemetry.sensors["mag"][1:]).all()
assert not {"pooch", "requests"} & set(sys.modules), "what fetches data was imported"
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
