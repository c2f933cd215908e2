"""Flights by Basilisk from another attitude than GCRS's axes, and with a rate."""

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

from ...calibration.flights import check_claimed, normalized
from .flights import PLAN, errorless, seen

pytestmark = pytest.mark.basilisk


def starting(initial, duration=600.0, **changes):
    """A cubesat that starts so, with a gyro that hears no noise."""
    table = {
        "preset": "cubesat_6u",
        "duration": duration,
        "initial": initial,
        "convergence": {"window": 300.0},
        "gyro": {"angle_random_walk_deg_per_sqrt_h": 1e-9},
    }
    return Scenario.from_dict(table | changes)


def flown(scenario, design, vehicle=None):
    """The planned motion, and what Basilisk logs of a flight without errors."""
    environment = Environment.from_scenario(scenario)
    model = FilterModel.from_scenario(scenario, environment)
    vehicle = vehicle or Vehicle.from_scenario(scenario)
    limits = vehicle.compute_slew_limits(model.initial_rate)
    ramped = dataclasses.replace(model, slew_limits=limits)
    motion = Motion.from_design(ramped, design, model.n_steps)
    return environment, motion, seen(scenario, motion, errorless(model), vehicle, environment)


def rates_of(attitude):
    """Mean body rate of every step of 1 s."""
    return Rotation.from_matrix(attitude[:-1] @ attitude[1:].transpose(0, 2, 1)).as_rotvec()


def test_who_starts_nadir_and_turns_as_the_orbit_stays_nadir():
    """The plan holds the orbital rate: no ramp, no transient, and z looks down ever after."""
    scenario = starting({"pointing": "nadir"})
    model = FilterModel.from_scenario(scenario)
    design = np.tile([*np.degrees(model.initial_rate), 200.0], 3)
    environment, _, found = flown(scenario, design)
    down = -environment.position / np.linalg.norm(environment.position, axis=1)[:, None]
    off = np.arccos(np.clip(np.einsum("ki,ki->k", found.attitude[:, 2], down), -1.0, 1.0))
    assert np.degrees(off.max()) < 0.03  # the orbit is not quite a circle
    assert np.degrees(np.abs(model.initial_rate).max()) > 0.05
    np.testing.assert_allclose(rates_of(found.attitude), np.tile(model.initial_rate, (600, 1)),
                               rtol=0, atol=np.radians(1e-4))  # fmt: skip


def test_a_second_flight_is_that_of_the_same_satellite():
    """Attitude, rate and errors at its start are those at the end of the first, and it turns on at
    the rate that it has, by a gyro whose bias of 6e-5 rad/s is known by now."""
    scenario = starting({"pointing": "nadir"}, 900.0)
    first = simulate_telemetry(scenario, PLAN, 5)
    found = calibrate(scenario, first)
    after = found.build_followup_scenario({"duration": 600.0})
    design = [*after.prior.rate_deg_s, 50.0, *PLAN[:8]]  # turns on first
    second = simulate_telemetry(after, design, 6, initial_truth=first.truth)
    np.testing.assert_allclose(second.truth.attitude[0], first.truth.attitude[-1], atol=1e-12)
    np.testing.assert_array_equal(second.truth.states[0], first.truth.states[-1])
    before, rates = (rates_of(one.truth.attitude) for one in (first, second))
    np.testing.assert_allclose(rates[:49], np.tile(before[-1], (49, 1)), atol=2e-5)
    check_claimed([normalized(calibrate(after, second), second)], 0.998)
