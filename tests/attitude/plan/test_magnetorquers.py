"""Plans of a satellite with magnetorquers: exported attitude, constraints and predicted
accuracy.
"""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Scenario, evaluate
from mgeo_attitude.criteria.robustness import draw_runs
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.plan.aem import format_aem
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario import MonteCarloSettings
from scipy.spatial.transform import Rotation

from mgeo._text import format_two_digits

DESIGN = (0.1, -0.2, 1.5, 300.0, 0.0, 0.0, 0.0, 200.0, 1.0, 0.0, 0.2, 250.0)


@pytest.fixture(scope="module")
def plan():
    table = {"preset": "cubesat_1u", "duration": 900.0, "maneuvers": {"count": 3}}
    table["convergence"] = {"rule": "trace", "window": 60.0}
    constraint = {"boresight": [0.0, 0.0, 1.0], "half_angle_deg": 10.0, "attitude_sigmas": 0.0}
    constraint |= {"reference": "nadir"}
    return ManeuverPlan(Scenario.from_dict(table | {"path_constraints": [constraint]}), DESIGN)


def test_exported_attitude_equals_simulated_motion(plan):
    model, step = plan.problem.model, plan.scenario.step
    rows = [
        line.split()[1:5]
        for block in format_aem(plan, spacing=step).split("DATA_START\n")[1:]
        for line in block.split("DATA_STOP")[0].splitlines()
    ]
    exported = Rotation.from_quat(np.array(rows, dtype=float)).inv().as_matrix()
    motion = Motion.from_design(model, DESIGN, round(plan.duration / step))
    first, last = motion.attitude[0], motion.attitude[-1]
    np.testing.assert_allclose(exported[[0, -1]], [first, last], rtol=0.0, atol=1e-12)
    assert (
        len(exported) == len(motion.attitude) + len(plan.phases) - 1
    )  # Ends of phases appear twice.


def test_path_constraint_covers_the_whole_motion(plan):
    """The value of the constraint is not above the smallest sampled angle from nadir."""
    (row,) = plan.build_constraint_table().to_dict("records")
    steps = slice(plan.to_steps(plan.t_end) + 1)
    position, boresight = plan.problem.environment.position[steps], plan.attitude[steps, 2]
    nadir = -position / np.linalg.norm(position, axis=1, keepdims=True)
    angles = np.degrees(np.arccos((nadir * boresight).sum(axis=1)))
    assert row["value"] == pytest.approx(angles.min(), abs=2.0 * plan.scenario.step)
    assert row["value"] <= angles.min() + 1e-9


def test_predicted_sigma_is_rms_over_monte_carlo_runs(plan):
    """The runs are evaluated one by one. None of them has the nominal motion."""
    errors = dataclasses.replace(
        MonteCarloSettings(), n_runs=20, seed=MonteCarloSettings().seed + 1
    )
    problem, X = plan.problem, np.array([plan.design])
    variances = [
        np.diag(evaluate(each.model, each.apply_errors(X), 1, covariance=True).covariance[0])
        for each in draw_runs(problem.scenario, problem.model, errors)
    ]
    np.testing.assert_allclose(plan.sigma, np.sqrt(np.mean(variances, axis=0)), rtol=1e-12)
    worst = np.degrees(plan.sigma[:3].max())
    assert plan.attitude_sigma_deg == pytest.approx(worst)
    assert f"attitude {format_two_digits(worst)} deg" in plan.summary
    assert plan.summary == problem.view(X).summaries()[0]
    assert "(1-sigma of Monte Carlo runs, worst body axis)" in plan.summary
    (row,) = problem.view(X).describe()["attitude 1-sigma [deg]"]
    assert row == pytest.approx(worst)
    assert (
        plan.build_accuracy_table().loc[[f"attitude {axis}" for axis in "xyz"], "after"].max()
        == row
    )
