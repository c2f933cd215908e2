"""Runs from different initial attitudes and rates."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    FilterModel,
    Scenario,
    evaluate,
    run_reference_filter,
)
from mgeo_attitude.scenario import PathConstraint
from mgeo_attitude.settings.errors import InvalidValue
from scipy.spatial.transform import Rotation

from .agreement import assert_agrees, designs

PYRAMID = [[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]]
INERTIAL = {"quaternion": [0.5, -0.1, 0.7, 0.5]}
INITIAL_CONDITIONS = {
    "inertial": INERTIAL,
    "nadir": {"pointing": "nadir", "axis": [0.0, 0.6, 0.8], "clock_deg": 40.0},
    "spinning": {"pointing": "sun", "axis": [1.0, 0.0, 0.0], "rate_deg_s": [0.9, -0.2, 0.4]},
}


def scenario(initial, **changes):
    """Return a scenario with ramps and a field of view, which depend on the attitude."""
    table = {
        "preset": "cubesat_6u",
        "duration": 1200.0,
        "step": 2.0,
        "convergence": {"rule": "trace", "window": 60.0, "relative_decrease": 0.05},
        "initial": {"attitude_deg": 8.0, **initial},
        "maneuvers": {"count": 3, "max_acceleration_deg_s2": 0.05},
        "sensors": [{"kind": "sun-sensor", "half_angle_deg": 80.0}, {"kind": "magnetometer"}],
    }
    return Scenario.from_dict(table | changes)


@pytest.mark.parametrize("name", INITIAL_CONDITIONS)
def test_filters_agree_for_initial_conditions(name):
    model = FilterModel.from_scenario(scenario(INITIAL_CONDITIONS[name]))
    assert not np.allclose(model.initial_attitude, np.eye(3), atol=0.1)
    assert_agrees(model, designs(np.random.default_rng(5), 6, max_duration=300.0))


def test_nadir_pointing_starts_in_orbital_frame_with_orbital_rate():
    """The first ramp starts at the orbital rate, and the body is then at rest in GCRS."""
    nadir = scenario({"pointing": "nadir"})
    model = FilterModel.from_scenario(nadir)
    x = np.tile([0.0, 0.0, 0.0, 100.0], 3)
    history = run_reference_filter(model, x)
    position, velocity = nadir.orbit.propagate(nadir.epoch, np.zeros(1))
    nadir_direction = -position[0] / np.linalg.norm(position[0])
    np.testing.assert_allclose(history.attitude[0] @ nadir_direction, [0.0, 0.0, 1.0], atol=1e-14)
    assert history.attitude[0][0] @ velocity[0] > 0.999 * np.linalg.norm(velocity[0])
    # A rate of 0.06 deg/s is stopped by 0.05 deg/s² in 1.2 s of the first step.
    rate = model.initial_rate
    assert np.degrees(np.linalg.norm(rate)) == pytest.approx(0.06, rel=0.01)
    time = np.abs(np.degrees(rate)).max() / 0.05
    expected = Rotation.from_rotvec(-0.5 * time * rate).as_matrix() @ history.attitude[0]
    np.testing.assert_allclose(
        history.attitude[1:], np.repeat(expected[None], len(history.times) - 1, 0)
    )
    instant_model = FilterModel.from_scenario(
        scenario({"pointing": "nadir"}, maneuvers={"count": 3})
    )
    np.testing.assert_allclose(
        run_reference_filter(instant_model, x).attitude[-1], history.attitude[0], atol=1e-15
    )


def test_rate_change_includes_change_from_initial_rate():
    spinning = scenario(
        INITIAL_CONDITIONS["spinning"], maneuvers={"count": 3}, objectives=["t_end", "rate_change"]
    )
    problem = AttitudeManeuverProblem(spinning)
    x = np.array([0.9, -0.2, 0.4, 100.0, 0.0, 0.0, 0.0, 50.0, 0.0, 0.0, 0.3, 50.0])
    expected = np.sqrt(0.9**2 + 0.2**2 + 0.4**2) + 0.3
    assert problem.evaluate(x, return_values_of=["F"])[1] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("initial", "changes", "message"),
    [
        (
            {"rate_deg_s": [0.0, -1.5, 0.2]},
            {},
            "initial.rate_deg_s = (0.0, -1.5, 0.2): expected at most maneuvers.max_rate_deg_s = "
            "1.0 about each axis, not 1.5 about y",
        ),
        (
            {"rate_deg_s": [0.0, 0.0, 0.5]},
            {"wheels": {"inertia": [0.1, 0.1, 0.2], "max_momentum": 5e-4, "axes": PYRAMID}},
            # Four wheels at 45 deg share the momentum: √2 / 4 of 0.00175.
            "initial.rate_deg_s = (0.0, 0.0, 0.5): expected at most wheels.max_momentum = 0.0005 "
            "N m s in each wheel, not 0.000617",
        ),
        (
            {"pointing": "sun"},
            {"path_constraints": [{"name": "eye", "boresight": [0, 0, 1], "half_angle_deg": 10.0}]},
            "path_constraints[0].half_angle_deg = 10.0: expected another attitude in [initial]: "
            "at the start Sun is ",
        ),
    ],
)
def test_initial_state_that_violates_constraint_is_rejected(initial, changes, message):
    with pytest.raises(InvalidValue) as caught:
        AttitudeManeuverProblem(scenario(initial, eclipse=False, **changes))
    assert str(caught.value).startswith(message)


def test_initial_attitude_determines_path_constraint_at_start():
    """A camera on -z is allowed while z points at the Sun, and a camera on z is not."""
    camera = {"name": "eye", "boresight": [0.0, 0.0, -1.0], "half_angle_deg": 60.0}
    sun_pointing = scenario({"pointing": "sun"}, eclipse=False, path_constraints=[camera])
    problem = AttitudeManeuverProblem(sun_pointing)
    assert [limit.build_cone().axis for limit in problem.model.path_constraints] == [
        (0.0, 0.0, -1.0)
    ]
    at_rest = np.tile([0.0, 0.0, 0.0, 100.0], 3)
    angle = evaluate(problem.model, at_rest).path_angle[0, 0]
    assert angle == pytest.approx(np.pi - 3.0 * np.radians(8.0), abs=1e-6)
    opposite = PathConstraint(name="eye", boresight=(0.0, 0.0, 1.0), half_angle_deg=60.0)
    with pytest.raises(InvalidValue, match=r"expected another attitude.* boresight of 'eye'"):
        AttitudeManeuverProblem(dataclasses.replace(sun_pointing, path_constraints=(opposite,)))
