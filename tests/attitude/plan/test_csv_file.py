"""CSV that has every digit of the timeline, ramps included."""

import dataclasses

import pandas as pd
import pytest
from mgeo_attitude.plan import ManeuverPlan, to_csv, write_csv

from .conftest import DESIGN


@pytest.fixture(scope="module")
def ramped(problem):
    """A plan whose rates change along ramps."""
    maneuvers = dataclasses.replace(problem.scenario.maneuvers, max_acceleration_deg_s2=0.05)
    return ManeuverPlan(dataclasses.replace(problem.scenario, maneuvers=maneuvers), DESIGN)


@pytest.mark.parametrize("fixture", ["plan", "ramped"])
def test_the_file_has_the_timeline_to_the_last_digit(fixture, request, tmp_path):
    plan = request.getfixturevalue(fixture)
    path = tmp_path / "plan.csv"
    write_csv(plan, path)
    assert path.read_text(encoding="utf-8") == to_csv(plan)
    table = pd.read_csv(path, dtype=str)
    n = len(plan.phases)
    assert table.pop("row").tolist() == [f"{i}/{n}" for i in range(1, n + 1)]
    expected = plan.timeline()
    pd.testing.assert_frame_equal(table.astype(expected.dtypes), expected, check_exact=True)
    assert ("ramp to maneuver 1" in set(table["phase"])) == (fixture == "ramped")
