"""Table of commands, from which a plan can be reconstructed."""

import dataclasses
import io

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import evaluate
from mgeo_attitude.plan import ManeuverPlan, list_commands, to_uplink_csv, write_plan
from mgeo_attitude.scenario import InitialConditions

from .conftest import DESIGN


def test_plan_is_reconstructed_from_file(plan, tmp_path):
    """Rates and durations of the file form a design with the same objectives."""
    write_plan(plan, tmp_path / "plan.uplink.csv")
    text = (tmp_path / "plan.uplink.csv").read_text(encoding="utf-8")
    assert text == to_uplink_csv(plan)
    table = pd.read_csv(io.StringIO(text), dtype=str)
    numbers = [name for name in table if name.endswith(("_s", "_deg"))]
    table = table.astype(dict.fromkeys(numbers, float))
    assert table["label"].tolist() == ["maneuver 1", "maneuver 3", "constant-rate hold"]
    rates = [f"rate_{axis}_deg_s" for axis in "xyz"]
    design = table[[*rates, "duration_s"]].to_numpy()[:2]
    read_design = np.concatenate([design[0], [0, 0, 0, 0], design[1]])
    problem = plan.problem
    result = evaluate(problem.model, np.array([read_design]))
    assert result.t_end[0] == plan.t_end
    assert result.trace[0] == pytest.approx(plan.trace, rel=1e-9)
    assert table["start_s"].tolist() == [0.0, 100.0, table["start_s"].iloc[2]]
    assert table["start_utc"].iloc[1] == "2018-06-05T00:01:40.000000"
    assert table["duration_s"].sum() == plan.duration


@pytest.mark.parametrize("back", [False, True])
def test_ramp_belongs_to_following_command(problem, back):
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


def test_maneuver_shorter_than_its_ramp_is_commanded(problem):
    """Without its command, the ramp of the third maneuver would start earlier and from another
    rate.
    """
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
    read_design = table.loc[:2, [*(f"rate_{axis}_deg_s" for axis in "xyz"), "duration_s"]]
    assert read_design.to_numpy().ravel().tolist() == design.tolist()
