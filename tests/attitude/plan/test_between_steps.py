"""A plan that points at the Sun between two filter steps: all that judge it say so."""

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
def flown():
    """A turn that takes a camera across the Sun 1 s after a step; direction of Sun and camera."""
    sun = AttitudeManeuverProblem(Scenario.from_dict(TABLE)).environment.sun[0].copy()
    rate = np.cross(sun, [0.0, 0.0, 1.0])
    rate *= RATE / np.linalg.norm(rate)
    camera = Rotation.from_rotvec(-41.0 * rate).apply(sun)
    limit = {
        "name": "camera",
        "boresight": camera.tolist(),
        "half_angle_deg": HALF_ANGLE_DEG,
        "attitude_sigmas": 0.0,
    }
    scenario = Scenario.from_dict(TABLE | {"path_constraints": [limit]})
    design = [*np.degrees(rate), 80.0, 0.0, 0.0, 0.0, 60.0, 0.0, 0.0, 0.0, 60.0]
    return ManeuverPlan(scenario, tuple(map(float, design))), sun, camera


@pytest.mark.slow
def test_table_export_and_flights_agree(flown):
    plan, sun, camera = flown
    off_at_steps = np.degrees(np.arccos(np.clip(plan.attitude @ sun @ camera, -1.0, 1.0)))
    assert off_at_steps.min() == pytest.approx(4.6, abs=0.01)  # of which the limit would be kept
    row = plan.build_constraint_table().loc["Sun off camera"]
    assert row["value"] == pytest.approx(0.0, abs=0.01)
    assert not row["satisfied"]
    text = format_aem(plan)
    assert "VIOLATED CONSTRAINT: Sun off camera" in text
    numbers = [line.split()[1:5] for line in text.splitlines() if re.match(r"\d{4}-", line)]
    attitude = Rotation.from_quat(np.array(numbers, float)).inv()
    exported = np.degrees(np.arccos(np.clip(attitude.apply(sun) @ camera, -1.0, 1.0)))
    assert row["value"] <= exported.min() + 1e-3  # the Sun moves by a degree a day
    assert exported.min() < 0.01
    broken = verify(plan, 20).path_constraints.loc["Sun off camera"]
    assert broken["steered: runs [%]"] == broken["open loop: runs [%]"] == 100.0


@pytest.mark.slow
def test_the_first_light_after_a_shadow_counts():
    """The camera crosses the Sun in the dark, 0.1 s before the step in which it appears."""
    night = TABLE | {"eclipse": True, "duration": 600.0}
    environment = AttitudeManeuverProblem(Scenario.from_dict(night)).environment
    lit = environment.sunlit
    dawn = int(np.flatnonzero(~lit[:-1] & lit[1:])[0])
    sun, before = environment.sun[dawn].copy(), 2.0 * dawn
    rate = np.cross(sun, [0.0, 0.0, 1.0])
    rate *= RATE / np.linalg.norm(rate)
    camera = Rotation.from_rotvec(-(before - 0.1) * rate).apply(sun)
    limit = {
        "name": "camera",
        "boresight": camera.tolist(),
        "half_angle_deg": HALF_ANGLE_DEG,
        "attitude_sigmas": 0.0,
    }
    scenario = Scenario.from_dict(night | {"path_constraints": [limit]})
    design = [*np.degrees(rate), before + 20.0, 0.0, 0.0, 0.0, 60.0, 0.0, 0.0, 0.0, 60.0]
    plan = ManeuverPlan(scenario, tuple(map(float, design)))
    times = np.arange(0.0, before + 20.0, 0.01)
    at, attitude = (
        SatelliteState.from_times(scenario, times),
        Rotation.from_rotvec(-times[:, None] * rate),
    )
    cosine = attitude.apply(at.sun) @ camera
    seen = np.degrees(np.arccos(np.clip(cosine[at.sunlit], -1.0, 1.0))).min()
    row = plan.build_constraint_table().loc["Sun off camera"]
    # the Sun counts from the beginning of the step, at most that turn before it is there
    assert seen - 2.0 * np.degrees(RATE) < row["value"] <= seen < HALF_ANGLE_DEG
    assert not row["satisfied"]
    assert "VIOLATED CONSTRAINT: Sun off camera" in format_aem(plan)
    broken = verify(plan, 10).path_constraints.loc["Sun off camera"]
    assert broken["steered: runs [%]"] == broken["open loop: runs [%]"] == 100.0
