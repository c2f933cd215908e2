"""The table of commands: the plan can be flown from it alone."""

import dataclasses
import io

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import evaluate
from mgeo_attitude.plan import ManeuverPlan, list_commands, to_uplink_csv, write_plan
from mgeo_attitude.scenario import InitialConditions

from .conftest import DESIGN


def test_the_plan_follows_from_the_file(plan, tmp_path):
    """Rates and durations as read back are a design with the same objectives."""
    write_plan(plan, tmp_path / "plan.uplink.csv")
    text = (tmp_path / "plan.uplink.csv").read_text(encoding="utf-8")
    assert text == to_uplink_csv(plan)
    table = pd.read_csv(io.StringIO(text), dtype=str)
    numbers = [name for name in table if name.endswith(("_s", "_deg"))]
    table = table.astype(dict.fromkeys(numbers, float))
    assert table["label"].tolist() == ["maneuver 1", "maneuver 3", "constant-rate hold"]
    rates = [f"rate_{axis}_deg_s" for axis in "xyz"]
    design = table[[*rates, "duration_s"]].to_numpy()[:2]
    again = np.concatenate([design[0], [0, 0, 0, 0], design[1]])
    problem = plan.problem
    found = evaluate(problem.model, np.array([again]))
    assert found.t_end[0] == plan.t_end
    assert found.trace[0] == pytest.approx(plan.trace, rel=1e-9)
    assert table["start_s"].tolist() == [0.0, 100.0, table["start_s"].iloc[2]]
    assert table["start_utc"].iloc[1] == "2018-06-05T00:01:40.000000"
    assert table["duration_s"].sum() == plan.duration


@pytest.mark.parametrize("back", [False, True])
def test_a_ramp_belongs_to_the_command_it_is_flown_for(problem, back):
    paper = problem.scenario
    limits = dataclasses.replace(paper.maneuvers, max_acceleration_deg_s2=0.05, slew_back=back)
    initial = InitialConditions(pointing="nadir") if back else paper.initial
    scenario = dataclasses.replace(paper, maneuvers=limits, initial=initial)
    plan = ManeuverPlan(scenario, DESIGN)
    table, phases = list_commands(plan), {phase.label: phase for phase in plan.phases}
    third = table.set_index("label").loc["maneuver 3"]
    ramp, maneuver = phases["ramp to maneuver 3"], phases["maneuver 3"]
    assert third["start_s"] == ramp.start
    assert third["start_s"] + third["duration_s"] == maneuver.end
    np.testing.assert_array_equal(third[-3:].astype(float), DESIGN[8:11])
    ends = (table["start_s"] + table["duration_s"]).to_numpy()
    np.testing.assert_allclose(ends, [*table["start_s"].iloc[1:], plan.duration])
    assert not table["label"].str.startswith("ramp").any()
    assert ("slew back" in set(table["label"])) == back


def test_a_maneuver_that_is_over_before_its_ramp_is_commanded(problem):
    """Without it the third's ramp would begin earlier, and from another rate."""
    paper = problem.scenario
    limits = dataclasses.replace(paper.maneuvers, max_acceleration_deg_s2=0.01)
    design = np.array([0.0, 0.0, 0.5, 100.0, 0.5, 0.0, 0.0, 20.0, 0.0, 0.0, 0.5, 100.0])
    plan = ManeuverPlan(dataclasses.replace(paper, maneuvers=limits), tuple(design.tolist()))
    assert "maneuver 2" not in {phase.label for phase in plan.phases}
    table = list_commands(plan)
    assert table["label"].tolist() == [
        "maneuver 1",
        "maneuver 2",
        "maneuver 3",
        "constant-rate hold",
    ]
    again = table.loc[:2, [*(f"rate_{axis}_deg_s" for axis in "xyz"), "duration_s"]]
    assert again.to_numpy().ravel().tolist() == design.tolist()
