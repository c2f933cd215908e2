"""Description of a satellite against known properties of its scenario."""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.scenario import PathConstraint
from mgeo_attitude.view.satellite import ascending_node_solar_time, describe_satellite


def test_solar_time_of_ascending_node():
    """The time is 12 h below the Sun, and 18 h a quarter of a revolution east of it."""
    pole, node = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    velocity = np.array([0.0, np.cos(1.7), np.sin(1.7)])  # The orbit is retrograde.
    for sun_at, hours in ((0.0, 12.0), (-90.0, 18.0), (90.0, 6.0), (180.0, 0.0)):
        sun = np.array([np.cos(np.radians(sun_at)), np.sin(np.radians(sun_at)), 0.2])
        assert ascending_node_solar_time(node, velocity, sun) == pytest.approx(hours, abs=1e-9)
    assert pole @ np.cross(node, velocity) < 0.0


def test_description_of_paper_satellite():
    scenario = dataclasses.replace(Scenario.paper(), eclipse=True)
    description = describe_satellite(AttitudeManeuverProblem(scenario))
    assert description["satellite"] == "paper"
    assert description["time span"] == "2018-06-05T00:00:00 UTC, 3 h 19 min 44 s"
    assert (
        "22:30 apparent local" in description["ascending node"]
    )  # This value is in the scenario file.
    assert "inclination 98.4" in description["orbit"]
    low, high = map(float, re.findall(r"(\d+) to (\d+) km", description["orbit"])[0])
    a, e = 7130.982, 0.001111
    assert (low, high) == pytest.approx((a * (1 - e) - 6378.1, a * (1 + e) - 6378.1), abs=1.0)
    problem = AttitudeManeuverProblem(scenario)
    share = 100.0 * (1.0 - problem.environment.sunlit.mean())
    assert description["eclipses"].startswith(f"{share:.0f} % of the time")
    assert description["initial errors"].startswith("in the range")
    assert "constraint" not in description


def test_description_of_a_start_in_eclipse():
    scenario = dataclasses.replace(Scenario.paper(), eclipse=True)
    problem = AttitudeManeuverProblem(scenario)
    end = int(np.argmax(problem.environment.sunlit)) * scenario.step
    assert end > 0.0
    (stamp,) = format_time_stamps(scenario.epoch, np.array([end]))
    assert stamp[11:19] in describe_satellite(problem)["eclipses"].partition("start")[2]
    later = AttitudeManeuverProblem(scenario.shift_start(end + 60.0))
    assert later.environment.sunlit[0]
    assert "start" not in describe_satellite(later)["eclipses"]


def test_description_warns_of_initial_errors_beyond_the_validity_of_the_covariance():
    scenario = Scenario.from_dict({"preset": "paper", "initial": {"attitude_deg": 60.0}})
    description = describe_satellite(AttitudeManeuverProblem(scenario))
    assert description["initial errors"].startswith("outside of the range")


def test_margin_at_rest_includes_attitude_uncertainty():
    problem = AttitudeManeuverProblem(
        dataclasses.replace(
            Scenario.paper(),
            duration=600.0,
            path_constraints=(
                PathConstraint(name="eye", boresight=(0.0, 0.0, 1.0), half_angle_deg=20.0),
            ),
        )
    )
    sun = problem.environment.sun @ problem.model.initial_attitude[2]
    nearest = np.degrees(np.arccos(sun.max())) - 3.0 * 5.0
    description = describe_satellite(problem)
    assert "at least 20 deg" in description["constraint"]
    assert f"without maneuvers at worst {nearest:.3g} deg" in description["constraint"]


def test_monte_carlo_runs_are_described():
    problem = AttitudeManeuverProblem(n_runs=16, quantile=0.8)
    text = describe_satellite(problem)["Monte Carlo runs"]
    assert text.startswith("16 ")
    assert "0.8-quantile" in text


def test_each_bound_of_a_constraint_is_described():
    required = {"attitude_deg": 0.17, "gyro.bias_deg_h": 2.0}
    scenario = Scenario.from_dict({"preset": "cubesat_6u", "required_sigma": required})
    description = describe_satellite(AttitudeManeuverProblem(scenario))["constraint"]
    assert "1-sigma of attitude at most 0.17 deg" in description
    assert "1-sigma of gyro bias at most 2 deg/h" in description


def test_actuators_and_slew_back_are_described_if_present():
    paper = describe_satellite(AttitudeManeuverProblem(Scenario.paper()))
    assert {"actuators", "slew back"}.isdisjoint(paper)
    wheels = {"inertia": [0.13, 0.1, 0.05], "max_torque": 1e-3, "max_momentum": 3e-3}
    maneuvers = {"slew_back": True, "max_rate_deg_s": 0.7}
    scenario = Scenario.from_dict({"preset": "paper", "wheels": wheels, "maneuvers": maneuvers})
    description = describe_satellite(AttitudeManeuverProblem(scenario))
    assert description["actuators"] == "wheels"
    assert "slew back" in description
    assert "0.7 deg/s" in description["body rates"]
