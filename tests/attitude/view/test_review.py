"""Review document of a plan against the tables of the plan."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.plan.tables import TABLES

DESIGN = (0.4, -0.2, 0.1, 300.0, 0.3, 0.5, -0.4, 200.0, -0.6, 0.1, 0.2, 100.0)


@pytest.fixture(scope="module")
def plan():
    scenario = dataclasses.replace(
        Scenario.paper(),
        duration=2400.0,
        step=4.0,
        required_sigma={"attitude_deg": 2.0},
        convergence=dataclasses.replace(Scenario.paper().convergence, rule="end"),
    )
    return ManeuverPlan(scenario, DESIGN)


@pytest.fixture(scope="module")
def sections(plan):
    return {section.title: section for section in plan.view.review().sections}


@pytest.mark.parametrize(
    "key", ["error_budget", "improvements", "measurement_times", "accuracy", "comparison"]
)
def test_sections_equal_tables_of_the_plan(plan, sections, key):
    table = TABLES[key]
    shown, expected = (
        each.select_dtypes(float) for each in (sections[table.title].table, table.table(plan))
    )
    np.testing.assert_allclose(shown, expected)


def test_uncertainty_by_phase_shows_the_worst_axis(plan, sections):
    shown, expected = (
        sections["Uncertainty reduction by phase"].table,
        plan.compute_uncertainty_by_phase(),
    )
    axes = [f"attitude {axis} [deg]" for axis in "xyz"]
    np.testing.assert_array_equal(shown["attitude [deg]"], expected[axes].max(axis=1))
