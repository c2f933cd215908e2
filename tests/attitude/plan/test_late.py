"""What is flown of a plan that promises a time over flights: its last rate until then."""

import numpy as np
import pytest
from ccsds_ndm.ndm_io import NdmIo
from mgeo_attitude import Scenario
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.plan import ManeuverPlan, format_aem, list_commands, to_csv
from mgeo_calibration.simulators.kinematic import simulate_telemetry
from scipy.spatial.transform import Rotation

from .test_aem import instant, matrix, read_2

DESIGN = (-0.476, 0.393, -1.0, 624.0, 1.0, -0.456, 0.1, 500.0, 0.07, 0.715, 1.0, 16.0)
RATE = np.array(DESIGN[8:11])
TABLE = {"preset": "paper", "duration": 3600.0, "step": 4.0, "monte_carlo": {"n_runs": 8}}
LATE = "constant-rate hold, for late convergence"


@pytest.fixture(scope="module")
def plan():
    return ManeuverPlan(Scenario.from_dict(TABLE), DESIGN)


@pytest.fixture(scope="module")
def back():
    table = TABLE | {"maneuvers": {"slew_back": True}}
    return ManeuverPlan(Scenario.from_dict(table), DESIGN)


def test_the_last_rate_is_commanded_until_the_robust_time(plan):
    promised = plan.compare_with_monte_carlo().loc["t_end [s]", "predicted"]
    assert plan.t_end < promised
    table = list_commands(plan)
    *_, held, late = table.itertuples()
    assert (held.label, late.label) == ("constant-rate hold", LATE)
    assert held.start_s + held.duration_s == late.start_s == plan.t_end
    assert late.start_s + late.duration_s == promised == plan.duration
    rates = table.iloc[-2:, -3:].to_numpy(float)
    np.testing.assert_array_equal(rates, [RATE, RATE])
    assert f',"{LATE}",{plan.t_end},{plan.duration},' in to_csv(plan)


@pytest.mark.slow
def test_the_ephemeris_goes_on_turning_at_the_last_rate(plan):
    text = format_aem(plan)
    told = f"COMMENT {plan.describe_hold()[0]}"
    assert told in text.splitlines()
    assert f"({plan.t_end:.6g} s)" in told
    assert f"({plan.duration:.6g} s)" in told
    message = read_2(plan)
    segment = message.segment_to_attitude_trajectory(len(message.segments) - 1)
    times = np.array([plan.t_end, plan.duration])
    before, after = (matrix(segment, instant(plan, time)) for time in times)
    turned = Rotation.from_rotvec(-np.radians(RATE) * np.diff(times)).as_matrix()
    np.testing.assert_allclose(after, turned @ before, atol=1e-9)
    first_edition = NdmIo().from_string(text)
    *_, last = first_edition.body.segment
    assert last.metadata.start_time == format_time_stamps(plan.scenario.epoch, plan.t_end)[0]
    assert last.metadata.stop_time == format_time_stamps(plan.scenario.epoch, plan.duration)[0]


def test_the_slew_back_waits_for_late_flights(back):
    """In the table of commands, and in what a flight sends down."""
    assert back.t_end < back.hold_end < back.duration
    table = list_commands(back).set_index("label")
    assert table.loc[LATE, "start_s"] == back.t_end
    assert table.loc["slew back", "start_s"] == back.hold_end
    telemetry = simulate_telemetry(back.scenario, back, seed=1)
    turning = (telemetry.times > back.t_end) & (telemetry.times <= back.hold_end)
    slewing = telemetry.times > back.hold_end
    off = np.abs(telemetry.gyro_deg_s - RATE).max(axis=1)  # bias and noise of the gyro
    assert off[turning].max() < 0.1
    assert off[slewing].min() > 0.3
    law = back.scenario.initial.evaluate_law(back.scenario, back.duration)[0]
    np.testing.assert_allclose(back.attitude[-1], law, atol=1e-9)


@pytest.mark.slow
def test_path_limits_are_looked_at_while_the_rate_is_held(plan):
    """What breaks a limit only then is a violation."""
    first, last = plan.to_steps([plan.t_end, plan.duration])
    sun = plan.problem.environment.sun
    seen = np.einsum("kij,kj->ki", plan.attitude, sun[: last + 1])
    angle = np.degrees(np.arccos(np.clip(seen @ seen[last], -1.0, 1.0)))
    nearest = angle[first:].min()
    assert nearest < 1e-3 < angle[:first].min()
    axis = tuple(seen[last] / np.linalg.norm(seen[last]))
    limit = {"boresight": axis, "half_angle_deg": 0.5, "attitude_sigmas": 0.0}
    watched = ManeuverPlan(Scenario.from_dict(TABLE | {"path_constraints": [limit]}), DESIGN)
    row = watched.build_constraint_table().loc["Sun off payload in the constant-rate hold"]
    assert row["value"] == pytest.approx(nearest, abs=1e-3)
    assert not row["satisfied"]
    assert any("in the constant-rate hold" in line for line in watched.list_violations())


def test_a_plan_too_few_flights_of_which_converge_is_flown_to_the_end(plan):
    short = ManeuverPlan(Scenario.from_dict(TABLE | {"duration": plan.t_end + 40.0}), DESIGN)
    assert np.isinf([short.view.robust_t_end, short.view.monte_carlo_t_end]).all()
    assert short.t_end == plan.t_end
    assert short.duration == plan.t_end + 40.0
    assert list_commands(short)["label"].iloc[-1] == LATE
