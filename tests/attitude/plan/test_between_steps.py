"""Violation of a path constraint between two filter steps, in tables, exports and simulations."""

import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.environment.directions import SatelliteState
from mgeo_attitude.plan import ManeuverPlan, format_aem
from mgeo_calibration import verify
from scipy.spatial.transform import Rotation

TABLE = {
    "preset": "cubesat_6u",
    "step": 2.0,
    "duration": 1200.0,
    "eclipse": False,
    "maneuvers": {"count": 3, "max_rate_deg_s": 5.0},
    "convergence": {"rule": "trace"},
    "initial": {"attitude_deg": 1.0},
}
RATE = np.radians(4.6)
HALF_ANGLE_DEG = 4.0


@pytest.fixture(scope="module")
def crossing_plan():
    """Plan that rotates a camera across the Sun 1 s after a filter step, Sun direction and
    boresight.
    """
    sun = AttitudeManeuverProblem(Scenario.from_dict(TABLE)).environment.sun[0].copy()
    rate = np.cross(sun, [0.0, 0.0, 1.0])
    rate *= RATE / np.linalg.norm(rate)
    camera = Rotation.from_rotvec(-41.0 * rate).apply(sun)
    constraint = {
        "name": "camera",
        "boresight": camera.tolist(),
        "half_angle_deg": HALF_ANGLE_DEG,
        "attitude_sigmas": 0.0,
    }
    scenario = Scenario.from_dict(TABLE | {"path_constraints": [constraint]})
    design = [*np.degrees(rate), 80.0, 0.0, 0.0, 0.0, 60.0, 0.0, 0.0, 0.0, 60.0]
    return ManeuverPlan(scenario, tuple(map(float, design))), sun, camera


@pytest.mark.slow
def test_table_export_and_simulation_report_violation(crossing_plan):
    plan, sun, camera = crossing_plan
    off_at_steps = np.degrees(np.arccos(np.clip(plan.attitude @ sun @ camera, -1.0, 1.0)))
    # The constraint is satisfied at all steps.
    assert off_at_steps.min() == pytest.approx(4.6, abs=0.01)
    row = plan.build_constraint_table().loc["Sun off camera"]
    assert row["value"] == pytest.approx(0.0, abs=0.01)
    assert not row["satisfied"]
    text = format_aem(plan)
    assert "VIOLATED CONSTRAINT: Sun off camera" in text
    quaternions = [line.split()[1:5] for line in text.splitlines() if re.match(r"\d{4}-", line)]
    attitude = Rotation.from_quat(np.array(quaternions, float)).inv()
    exported = np.degrees(np.arccos(np.clip(attitude.apply(sun) @ camera, -1.0, 1.0)))
    assert row["value"] <= exported.min() + 1e-3  # The Sun moves by one degree per day.
    assert exported.min() < 0.01
    violations = verify(plan, 20).path_constraints.loc["Sun off camera"]
    assert violations["steered: runs [%]"] == violations["open loop: runs [%]"] == 100.0


@pytest.mark.slow
def test_sunlight_in_first_step_after_eclipse_counts():
    """The camera crosses the Sun in eclipse, 0.1 s before the step in which the Sun appears."""
    eclipse_table = TABLE | {"eclipse": True, "duration": 600.0}
    environment = AttitudeManeuverProblem(Scenario.from_dict(eclipse_table)).environment
    sunlit = environment.sunlit
    first_sunlit_step = int(np.flatnonzero(~sunlit[:-1] & sunlit[1:])[0])
    sun, eclipse_end = environment.sun[first_sunlit_step].copy(), 2.0 * first_sunlit_step
    rate = np.cross(sun, [0.0, 0.0, 1.0])
    rate *= RATE / np.linalg.norm(rate)
    camera = Rotation.from_rotvec(-(eclipse_end - 0.1) * rate).apply(sun)
    constraint = {
        "name": "camera",
        "boresight": camera.tolist(),
        "half_angle_deg": HALF_ANGLE_DEG,
        "attitude_sigmas": 0.0,
    }
    scenario = Scenario.from_dict(eclipse_table | {"path_constraints": [constraint]})
    design = [*np.degrees(rate), eclipse_end + 20.0, 0.0, 0.0, 0.0, 60.0, 0.0, 0.0, 0.0, 60.0]
    plan = ManeuverPlan(scenario, tuple(map(float, design)))
    times = np.arange(0.0, eclipse_end + 20.0, 0.01)
    at, attitude = (
        SatelliteState.from_times(scenario, times),
        Rotation.from_rotvec(-times[:, None] * rate),
    )
    cosine = attitude.apply(at.sun) @ camera
    seen = np.degrees(np.arccos(np.clip(cosine[at.sunlit], -1.0, 1.0))).min()
    row = plan.build_constraint_table().loc["Sun off camera"]
    # The Sun counts from the start of the step, at most one step of rotation before it appears.
    assert seen - 2.0 * np.degrees(RATE) < row["value"] <= seen < HALF_ANGLE_DEG
    assert not row["satisfied"]
    assert "VIOLATED CONSTRAINT: Sun off camera" in format_aem(plan)
    violations = verify(plan, 10).path_constraints.loc["Sun off camera"]
    assert violations["steered: runs [%]"] == violations["open loop: runs [%]"] == 100.0
