"""Comparison of simulated runs with the plan, against values computed by hand."""

import dataclasses
import importlib.util

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_calibration import simulate_telemetry
from mgeo_calibration.simulators.plan_comparison import (
    END_ERROR,
    MAX_ERROR,
    MEDIAN_COLUMN,
    QUANTILE_COLUMN,
    START_ERROR,
    VIOLATED_COLUMN,
    WHEEL_MOMENTUM,
    compare_with_plan,
    compute_constraint_values,
    format_gyro_guidance,
    simulate_gyro_guidance,
    summarize_gyro_guidance,
)
from mgeo_calibration.simulators.simulated_run import draw_errors
from mgeo_calibration.telemetry.telemetry import Telemetry
from scipy.spatial.transform import Rotation

DESIGN = (0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0)
#: Constraints without margin, because simulated values have no margin.
LIMITS = [
    {"name": "camera", "boresight": [1.0, 0.0, 0.0], "half_angle_deg": 20.0,
     "attitude_sigmas": 0.0},
    {"name": "array", "boresight": [0.0, 0.0, 1.0], "half_angle_deg": 179.9, "sense": "keep-in",
     "attitude_sigmas": 0.0},
]  # fmt: skip


def build_plan(bias_deg_s=0.01, duration=1500.0, **changes):
    """Return a plan from nadir with three maneuvers and a slew back, by a satellite with three
    wheels.
    """
    table = {
        "preset": "cubesat_6u",
        "duration": duration,
        "initial": {"pointing": "nadir", "attitude_deg": 0.2},
        "maneuvers": {"count": 3, "slew_back": True},
        "convergence": {"rule": "trace"},
        "gyro": {"initial_bias_deg_s": bias_deg_s},
        "wheels": {
            "inertia": [0.185, 0.144, 0.061],
            "max_torque": 0.004,
            "max_momentum": 0.015,
            "initial_momentum": [0.001, -0.002, 0.0015],
            "ramp_share": 0.5,
        },
        "path_constraints": LIMITS,
    }
    return ManeuverPlan(Scenario.from_dict(table | changes), DESIGN)


@pytest.fixture(scope="module")
def plan():
    return build_plan()


@pytest.mark.slow
def test_kinematic_run_deviates_by_initial_attitude_error(plan):
    telemetry = simulate_telemetry(plan.scenario, plan, 3)
    found = compare_with_plan(plan, telemetry)
    assert found.attrs["time_s"] == plan.duration
    n = len(plan.attitude)
    off = Rotation.from_matrix(telemetry.truth.attitude[0] @ plan.attitude[0].T).magnitude()
    for error in (START_ERROR, END_ERROR):
        assert found.loc[error, "simulated"] == pytest.approx(np.degrees(off), rel=1e-9)
    sun, lit = plan.problem.environment.sun[:n], plan.problem.environment.sunlit[:n]
    body = np.einsum("kij,kj->ki", telemetry.truth.attitude[:n], sun)[lit]
    least = np.degrees(np.arccos(body[:, 0])).min()
    assert found.loc["Sun off camera", "simulated"] == pytest.approx(
        least, abs=0.01
    )  # Only at samples.
    greatest = np.degrees(np.arccos(body[:, 2])).max()
    assert found.loc["Sun in array", "simulated"] == pytest.approx(greatest, abs=0.01)
    array = found.loc["Sun in array", ["bound_type", "bound_value", "satisfied"]].tolist()
    assert array == ["at most", 179.9, True]
    shorter = compare_with_plan(plan, telemetry.truncate(200.0))
    with pytest.raises(ValueError, match="no sample until nan s"):
        telemetry.truncate(float("nan"))
    assert shorter.attrs["time_s"] == 200.0
    with pytest.raises(ValueError, match="telemetry has no truth"):
        compare_with_plan(plan, dataclasses.replace(telemetry, truth=None))


def test_gyro_guidance_summary_states_errors_and_violations(plan):
    found = summarize_gyro_guidance(plan, 12, 2)
    assert (found["plan"][[END_ERROR, MAX_ERROR]] == 0.0).all()
    assert found.loc[END_ERROR, QUANTILE_COLUMN] > found.loc[END_ERROR, MEDIAN_COLUMN] > 1.0
    camera = found.loc["Sun off camera"]
    assert camera[QUANTILE_COLUMN] < camera[MEDIAN_COLUMN]  # 90 % of the runs stay above.
    assert np.isnan(found.loc[END_ERROR, VIOLATED_COLUMN])
    (line,) = format_gyro_guidance(found)
    assert f"90 % within {found.loc[END_ERROR, QUANTILE_COLUMN]:.3g} deg" in line
    nearer = LIMITS[0] | {"half_angle_deg": camera["plan"] - 0.5}
    tight = build_plan(path_constraints=[nearer, LIMITS[1]])
    assert tight.list_violations() == []
    (line,) = format_gyro_guidance(summarize_gyro_guidance(tight, 12, 2))
    assert "Sun off camera is violated in " in line


@pytest.mark.slow
@pytest.mark.basilisk
@pytest.mark.skipif(importlib.util.find_spec("Basilisk") is None, reason="needs bsk")
def test_gyro_guidance_agrees_with_basilisk():
    """Both simulations have equal initial errors but independent noise. Pointing errors reach 5 to
    20 deg, although the plan satisfies all constraints.
    """
    from mgeo_calibration.simulators.basilisk.telemetry import simulate_telemetry

    plan, off = build_plan(0.02), []
    assert plan.list_violations() == []
    model, n = plan.problem.model, len(plan.attitude) - 1
    for seed in (0, 3):
        telemetry: Telemetry = simulate_telemetry(plan.scenario, plan, seed)
        found = compare_with_plan(plan, telemetry)["simulated"]
        draws = draw_errors(model, n, np.random.default_rng(seed))
        own = compute_constraint_values(plan, simulate_gyro_guidance(plan, model, draws, n))
        off.append(found[END_ERROR])
        assert found[END_ERROR] == pytest.approx(own[END_ERROR], rel=0.03, abs=0.3)
        assert found["Sun off camera"] == pytest.approx(own["Sun off camera"], abs=0.6)
        assert found[WHEEL_MOMENTUM] == pytest.approx(own[WHEEL_MOMENTUM], rel=0.02)
    assert max(off) > 5.0
