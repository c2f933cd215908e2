"""Fixtures: a short scenario, and a plan in it whose second maneuver has no duration."""

import dataclasses

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan

DESIGN = (0.5, -1.0, 0.25, 100.0, -0.125, 0.75, 1.0, 0.0, 0.3, -0.5, 0.875, 80.5)


@pytest.fixture(scope="session")
def problem():
    return AttitudeManeuverProblem(dataclasses.replace(Scenario.paper(), duration=900.0))


@pytest.fixture(scope="session")
def plan(problem):
    return ManeuverPlan.from_design(problem, DESIGN)
