"""Review document of a plan against the tables of the plan."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.plan.tables import SECTIONS
from mgeo_attitude.plan_sections import SECTION_KEYS

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
    return {section.key: section for section in plan.view.review().sections}


def test_first_page_precedes_details(sections):
    keys = [key for key in SECTION_KEYS if key in sections]
    assert [section.key for section in sections.values() if section.key in SECTION_KEYS] == keys
    is_detail = [section.is_detail for section in sections.values()]
    assert is_detail == sorted(is_detail)


@pytest.mark.parametrize("key", ["accuracy", "drivers", "improvements"])
def test_sections_equal_tables_of_the_plan(plan, sections, key):
    shown, expected = (
        each.select_dtypes(float) for each in (sections[key].table, SECTIONS[key].table(plan))
    )
    assert shown.size
    np.testing.assert_array_equal(shown, expected)


def test_shares_of_error_sources_add_up(sections):
    shares = sections["budget"].table.astype(float)
    np.testing.assert_allclose(shares.sum(), 100.0, atol=0.6)  # Rounded to 0.1.


def test_largest_error_sources_come_first(plan, sections):
    drivers, budget = (
        sections["drivers"].table,
        sections["budget"].table["attitude [%]"].astype(float),
    )
    assert drivers["error source"].to_list() == budget.nlargest(3).index.to_list()
    assert (drivers["if halved"] < plan.attitude_sigma_deg).all()


def test_reduction_shows_the_worst_axis(plan, sections):
    shown, expected = sections["reduction"].table, plan.compute_uncertainty_by_phase()
    axes = [f"attitude {axis} [deg]" for axis in "xyz"]
    np.testing.assert_array_equal(shown["attitude [deg]"], expected[axes].max(axis=1))


def test_trace_is_compared_with_the_lower_bound(plan):
    (row,) = plan.compare_trace_with_lower_bound().to_numpy()
    assert row[0] == plan.trace >= row[1]
    assert row[2] == pytest.approx(row[0] / row[1])


def test_every_name_has_a_section():
    assert ("summary", *SECTIONS) == SECTION_KEYS


def test_constraints_name_the_part_of_the_plan():
    """The angle of a path constraint has one label, and constraints after the slew back have no
    label of the maneuvers.
    """
    scenario = Scenario.from_dict(
        {
            "preset": "cubesat_6u",
            "duration": 1200.0,
            "step": 2.0,
            "maneuvers": {"count": 1, "slew_back": True, "end_tolerance_deg": 5.0},
            "path_constraints": [
                {"name": "camera", "boresight": [0.0, 0.0, 1.0], "half_angle_deg": 10.0}
            ],
        }
    )
    table = SECTIONS["constraints"].table(ManeuverPlan(scenario, (0.5, 0.2, 0.1, 200.0)))
    during = table["during"]
    assert during.loc["Sun off camera minus 3 sigma"].tolist() == ["maneuvers", "slew back"]
    assert during.drop("Sun off camera minus 3 sigma").tolist() == ["after slew back"]
