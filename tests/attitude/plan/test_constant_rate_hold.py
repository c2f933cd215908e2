"""Constant-rate hold of plans whose convergence time is evaluated over Monte Carlo runs."""

import numpy as np
import pytest
from ccsds_ndm.ndm_io import NdmIo
from mgeo_attitude import Scenario
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.plan import ManeuverPlan, format_aem, list_commands, to_csv
from mgeo_calibration.simulators.kinematic import simulate_telemetry
from scipy.spatial.transform import Rotation

from .test_aem import read_version_2, rotation_matrix, to_epoch

DESIGN = (-0.476, 0.393, -1.0, 624.0, 1.0, -0.456, 0.1, 500.0, 0.07, 0.715, 1.0, 16.0)
RATE = np.array(DESIGN[8:11])
TABLE = {"preset": "paper", "duration": 3600.0, "step": 4.0, "monte_carlo": {"n_runs": 8}}
LATE_HOLD = "constant-rate hold, after nominal convergence"


@pytest.fixture(scope="module")
def plan():
    return ManeuverPlan(Scenario.from_dict(TABLE), DESIGN)


@pytest.fixture(scope="module")
def slew_back_plan():
    table = TABLE | {"maneuvers": {"slew_back": True}}
    return ManeuverPlan(Scenario.from_dict(table), DESIGN)


def test_last_rate_is_commanded_until_robust_time(plan):
    predicted = plan.compare_with_monte_carlo().loc["t_end [s]", "predicted"]
    assert plan.t_end < predicted
    table = list_commands(plan)
    *_, hold, late_hold = table.itertuples()
    assert (hold.label, late_hold.label) == ("constant-rate hold", LATE_HOLD)
    assert hold.start_s + hold.duration_s == late_hold.start_s == plan.t_end
    assert late_hold.start_s + late_hold.duration_s == predicted == plan.duration
    rates = table.iloc[-2:, -3:].to_numpy(float)
    np.testing.assert_array_equal(rates, [RATE, RATE])
    assert f',"{LATE_HOLD}",{plan.t_end},{plan.duration},' in to_csv(plan)


@pytest.mark.slow
def test_ephemeris_includes_constant_rate_hold(plan):
    text = format_aem(plan)
    comment = f"COMMENT {plan.describe_hold()[0]}"
    assert comment in text.splitlines()
    assert f"({plan.t_end:.6g} s)" in comment
    assert f"({plan.duration:.6g} s)" in comment
    message = read_version_2(plan)
    segment = message.segment_to_attitude_trajectory(len(message.segments) - 1)
    times = np.array([plan.t_end, plan.duration])
    before, after = (rotation_matrix(segment, to_epoch(plan, time)) for time in times)
    rotation = Rotation.from_rotvec(-np.radians(RATE) * np.diff(times)).as_matrix()
    np.testing.assert_allclose(after, rotation @ before, atol=1e-9)
    first_edition = NdmIo().from_string(text)
    *_, last = first_edition.body.segment
    assert last.metadata.start_time == format_time_stamps(plan.scenario.epoch, plan.t_end)[0]
    assert last.metadata.stop_time == format_time_stamps(plan.scenario.epoch, plan.duration)[0]


def test_slew_back_starts_after_constant_rate_hold(slew_back_plan):
    """The table of commands and simulated telemetry agree."""
    assert slew_back_plan.t_end < slew_back_plan.hold_end < slew_back_plan.duration
    table = list_commands(slew_back_plan).set_index("label")
    assert table.loc[LATE_HOLD, "start_s"] == slew_back_plan.t_end
    assert table.loc["slew back", "start_s"] == slew_back_plan.hold_end
    telemetry = simulate_telemetry(slew_back_plan.scenario, slew_back_plan, seed=1)
    is_holding = (telemetry.times > slew_back_plan.t_end) & (
        telemetry.times <= slew_back_plan.hold_end
    )
    is_slewing = telemetry.times > slew_back_plan.hold_end
    # The difference contains bias and noise of the gyro.
    off = np.abs(telemetry.gyro_deg_s - RATE).max(axis=1)
    assert off[is_holding].max() < 0.1
    assert off[is_slewing].min() > 0.3
    law = slew_back_plan.scenario.initial.evaluate_law(
        slew_back_plan.scenario, slew_back_plan.duration
    )[0]
    np.testing.assert_allclose(slew_back_plan.attitude[-1], law, atol=1e-9)


@pytest.mark.slow
def test_path_constraints_are_evaluated_during_hold(plan):
    first, last = plan.to_steps([plan.t_end, plan.duration])
    sun = plan.problem.environment.sun
    seen = np.einsum("kij,kj->ki", plan.attitude, sun[: last + 1])
    angle = np.degrees(np.arccos(np.clip(seen @ seen[last], -1.0, 1.0)))
    nearest = angle[first:].min()
    assert nearest < 1e-3 < angle[:first].min()
    axis = tuple(seen[last] / np.linalg.norm(seen[last]))
    constraint = {"boresight": axis, "half_angle_deg": 0.5, "attitude_sigmas": 0.0}
    constrained_plan = ManeuverPlan(
        Scenario.from_dict(TABLE | {"path_constraints": [constraint]}), DESIGN
    )
    row = constrained_plan.build_constraint_table().loc["Sun off payload in the constant-rate hold"]
    assert row["value"] == pytest.approx(nearest, abs=1e-3)
    assert not row["satisfied"]
    assert any("in the constant-rate hold" in line for line in constrained_plan.list_violations())


def test_hold_lasts_until_scenario_end_if_too_few_runs_converge(plan):
    short = ManeuverPlan(Scenario.from_dict(TABLE | {"duration": plan.t_end + 40.0}), DESIGN)
    assert np.isinf([short.view.robust_t_end, short.view.monte_carlo_t_end]).all()
    assert short.t_end == plan.t_end
    assert short.duration == plan.t_end + 40.0
    assert list_commands(short)["label"].iloc[-1] == LATE_HOLD
