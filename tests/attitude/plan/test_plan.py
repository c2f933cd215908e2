"""Tables of a plan against manual computation and against a run of the reference filter."""

import dataclasses
import pickle

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, run_reference_filter
from mgeo_attitude.plan import ManeuverPlan
from scipy.spatial.transform import Rotation

from .conftest import DESIGN

HALF = np.sqrt(0.5)


def test_timeline_of_90_degree_maneuver_about_z():
    scenario = dataclasses.replace(Scenario.paper(), duration=600.0)
    problem = AttitudeManeuverProblem(scenario, n_maneuvers=1)
    table = ManeuverPlan.from_design(problem, [0.0, 0.0, 0.5, 180.0]).build_timeline()
    assert table["phase"].tolist() == ["maneuver 1", "constant-rate hold"]
    assert table["start [s]"].tolist() == [0.0, 180.0]
    assert table.loc[0, "end UTC"] == table.loc[1, "start UTC"] == "2018-06-05T00:03:00.000000"
    assert table.loc[0, ["rate x [deg/s]", "rate y [deg/s]", "rate z [deg/s]"]].tolist() == [
        *(0.0, 0.0, 0.5)
    ]
    assert table.loc[0, "rotation [deg]"] == 90.0
    first = table.iloc[0]
    np.testing.assert_allclose(first[[f"start q{c}" for c in "123c"]].astype(float), [0, 0, 0, 1])
    np.testing.assert_allclose(
        first[[f"end q{c}" for c in "123c"]].astype(float), [0, 0, HALF, HALF], atol=1e-14
    )


def test_timeline_rates_integrate_to_filter_attitude(plan):
    table = plan.build_timeline()
    assert table["phase"].tolist() == ["maneuver 1", "maneuver 3", "constant-rate hold"]
    q = Rotation.identity()
    for _, row in table.iterrows():
        rates = row[[f"rate {axis} [deg/s]" for axis in "xyz"]].to_numpy(float)
        q = q * Rotation.from_rotvec(rates * row["duration [s]"], degrees=True)
        end = Rotation.from_quat(row[[f"end q{c}" for c in "123c"]].to_numpy(float))
        assert (q.inv() * end).magnitude() < 1e-12
    np.testing.assert_allclose(q.inv().as_matrix(), plan.history.attitude[-1], atol=1e-12)
    assert table["end [s]"].iloc[-1] == plan.t_end


def test_accuracy_equals_that_of_the_reference_filter(plan, problem):
    history = run_reference_filter(problem.model, DESIGN)
    assert plan.t_end == history.t_end
    assert plan.trace == pytest.approx(history.trace[-1], rel=1e-9)
    table = plan.build_accuracy_table()
    assert table.loc["attitude x", ["unit", "before"]].tolist() == ["deg", pytest.approx(5.0)]
    assert table.loc["gyro bias z", ["unit", "before"]].tolist() == ["deg/h", pytest.approx(36.0)]
    assert table.loc["mag bias y", "after"] == pytest.approx(50e3 * history.sigma[-1, 16])
    ratio = history.sigma[-1] / history.sigma[0]
    np.testing.assert_allclose(table["after / before [-]"], ratio, rtol=1e-9)


def test_equality_depends_on_scenario_and_design(plan, problem):
    same = ManeuverPlan(problem.scenario, DESIGN)
    assert same == plan == ManeuverPlan(problem.scenario, np.array(DESIGN))
    assert hash(same) == hash(plan)
    assert ManeuverPlan(problem.scenario, (*DESIGN[:11], 81.0)) != plan
    copy = pickle.loads(pickle.dumps(same))
    assert copy == plan
    assert copy.t_end == plan.t_end


@pytest.mark.parametrize(
    ("design", "message"),
    [
        (DESIGN[:8], r"design = .*expected 12 numbers, 4 for each of the scenario's 3 maneuvers"),
        ((1.1, *DESIGN[1:]), r"design\[0\] = 1\.1: expected -1 to 1 for omega_x_1 \[deg/s\]"),
        (("0.5", *DESIGN[1:]), r"design\[0\] = '0\.5'"),
    ],
)
def test_invalid_designs_are_rejected(problem, design, message):
    with pytest.raises((ValueError, TypeError), match=message):
        ManeuverPlan(problem.scenario, design)
