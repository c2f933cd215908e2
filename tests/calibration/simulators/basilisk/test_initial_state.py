"""Basilisk simulations with an initial attitude and an initial rate."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_calibration import calibrate
from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry
from mgeo_calibration.simulators.basilisk.vehicle import Vehicle
from scipy.spatial.transform import Rotation

from ...calibration.runs import check_errors, normalize_error
from .runs import PLAN, build_errorless_inputs, run_basilisk

pytestmark = pytest.mark.basilisk


def build_scenario(initial, duration=600.0, **changes):
    """Return a cubesat scenario with given initial conditions and a noiseless gyro."""
    table = {
        "preset": "cubesat_6u",
        "duration": duration,
        "initial": initial,
        "convergence": {"window": 300.0},
        "gyro": {"angle_random_walk_deg_per_sqrt_h": 1e-9},
    }
    return Scenario.from_dict(table | changes)


def simulate_errorless(scenario, design, vehicle=None):
    """Return environment, planned motion and the recorded results of a simulation without
    errors.
    """
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    vehicle = vehicle or Vehicle.from_scenario(scenario)
    limits = vehicle.compute_slew_limits(model.initial_rate)
    ramped = dataclasses.replace(model, slew_limits=limits)
    motion = Motion.from_design(ramped, design, model.n_steps)
    return (
        environment,
        motion,
        run_basilisk(scenario, motion, build_errorless_inputs(model), vehicle, environment),
    )


def compute_rates(attitude):
    """Return the mean body rate in each step of 1 s."""
    return Rotation.from_matrix(attitude[:-1] @ attitude[1:].transpose(0, 2, 1)).as_rotvec()


def test_nadir_pointing_at_orbital_rate_persists():
    """The plan has the orbital rate from the start: there is no ramp and no transient."""
    scenario = build_scenario({"pointing": "nadir"})
    model = FilterModel.from_scenario(scenario)
    design = np.tile([*np.degrees(model.initial_rate), 200.0], 3)
    environment, _, found = simulate_errorless(scenario, design)
    down = -environment.position / np.linalg.norm(environment.position, axis=1)[:, None]
    off = np.arccos(np.clip(np.einsum("ki,ki->k", found.attitude[:, 2], down), -1.0, 1.0))
    assert np.degrees(off.max()) < 0.03  # The orbit is not exactly circular.
    assert np.degrees(np.abs(model.initial_rate).max()) > 0.05
    np.testing.assert_allclose(compute_rates(found.attitude), np.tile(model.initial_rate, (600, 1)),
                               rtol=0, atol=np.radians(1e-4))  # fmt: skip


def test_followup_run_continues_attitude_rate_and_errors():
    """The second run starts with attitude, rate and errors at the end of the first. Its gyro bias,
    6e-5 rad/s, is known from the calibration.
    """
    scenario = build_scenario({"pointing": "nadir"}, 900.0)
    first = simulate_telemetry(scenario, PLAN, 5)
    found = calibrate(scenario, first)
    after = found.build_followup_scenario({"duration": 600.0})
    design = [*after.prior.rate_deg_s, 50.0, *PLAN[:8]]  # The first maneuver continues the rate.
    second = simulate_telemetry(after, design, 6, initial_truth=first.truth)
    np.testing.assert_allclose(second.truth.attitude[0], first.truth.attitude[-1], atol=1e-12)
    np.testing.assert_array_equal(second.truth.states[0], first.truth.states[-1])
    before, rates = (compute_rates(one.truth.attitude) for one in (first, second))
    np.testing.assert_allclose(rates[:49], np.tile(before[-1], (49, 1)), atol=2e-5)
    check_errors([normalize_error(calibrate(after, second), second)], 0.998)
