"""Animated attitude of a plan against the attitude of the reference filter."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.scenario import InitialConditions
from mgeo_attitude.view.figures.curves import project_directions
from scipy.spatial.transform import Rotation


def build_problem(scenario, **changes):
    maneuvers = dataclasses.replace(scenario.maneuvers, **changes.pop("maneuvers", {}))
    return AttitudeManeuverProblem(
        dataclasses.replace(scenario, duration=2400.0, maneuvers=maneuvers, **changes)
    )


@pytest.fixture(scope="module")
def problem_without_ramps():
    return build_problem(Scenario.paper())


@pytest.fixture(scope="module")
def problem_with_ramps():
    return build_problem(Scenario.paper(), maneuvers={"max_acceleration_deg_s2": 0.02})


def orientation(rotation, time):
    """Return the orientation of a rotating figure at a time, shape (3, 3), as report pages compute
    it.
    """
    total = Rotation.identity()
    vectors = np.column_stack([rotation["x"], rotation["y"], rotation["z"]])
    for start, end, vector in zip(
        rotation["times"][:-1], rotation["times"][1:], vectors, strict=True
    ):
        share = min((time - start) / (end - start), 1.0)
        if share > 0.0:
            total = total * Rotation.from_rotvec(share * vector, degrees=True)
    return total.as_matrix()


def angle_between(one, other):
    """Return the angle between two orientations [deg]."""
    return np.degrees(Rotation.from_matrix(one.T @ other).magnitude())


def get_motion(problem, x):
    (figures,) = problem.view(x[None]).solution_figures()
    return figures["motion"], figures["motion"].layout.meta["motion"]


@pytest.mark.parametrize(
    ("name", "tolerance"), [("problem_without_ramps", 1e-9), ("problem_with_ramps", 1.0)]
)
@pytest.mark.parametrize("row", [0, 1])
def test_body_attitude_equals_that_of_the_filter(request, X, name, tolerance, row):
    problem = request.getfixturevalue(name)
    plan = ManeuverPlan.from_design(problem, X[row])
    _, motion = get_motion(problem, X[row])
    rotation, attitude = motion["rotations"]["body"], plan.history.attitude
    assert motion["end"] == rotation["times"][-1] == plan.t_end
    samples = np.linspace(0, len(attitude) - 1, 40).astype(int)
    off = [
        angle_between(orientation(rotation, k * problem.model.step), attitude[k].T) for k in samples
    ]
    assert max(off) < tolerance
    assert angle_between(orientation(rotation, plan.t_end), attitude[-1].T) < 1e-6


def test_body_starts_at_initial_attitude_of_scenario(X):
    problem = build_problem(Scenario.paper(), initial=InitialConditions(pointing="nadir"))
    plan = ManeuverPlan.from_design(problem, X[0])
    figure, motion = get_motion(problem, X[0])
    attitude = plan.history.attitude
    tips = np.array([next((t.x[1], t.y[1], t.z[1]) for t in figure.data if t.name == axis)
                     for axis in "xyz"])  # fmt: skip
    np.testing.assert_allclose(tips / np.linalg.norm(tips[0]), attitude[0], atol=1e-12)
    for k in (0, 77, 800, len(attitude) - 1):
        rotated = tips @ orientation(motion["rotations"]["body"], k * problem.model.step).T
        np.testing.assert_allclose(rotated / np.linalg.norm(tips[0]), attitude[k], atol=1e-9)
    (figures,) = problem.view(X[:1]).solution_figures()
    sun = next(trace for trace in figures["directions"].data if trace.name == "Sun")
    seen = project_directions(attitude[:1] @ problem.environment.sun[0])
    assert (sun.x[0], sun.y[0]) == (seen[0][0], seen[1][0])


@pytest.mark.parametrize("name", ["sun", "field"])
def test_sun_and_field_directions_equal_environment(problem_without_ramps, X, name):
    figure, motion = get_motion(problem_without_ramps, X[0])
    environment = problem_without_ramps.environment
    label = {"sun": "Sun", "field": "magnetic field"}[name]
    trace = next(trace for trace in figure.data if trace.name == label)
    tip = np.array([trace.x[1], trace.y[1], trace.z[1]])
    vectors = getattr(environment, name)
    for k in (0, 7, 500, 1234):
        seen = orientation(motion["rotations"][trace.meta["rotation"]], environment.times[k]) @ tip
        exact = vectors[k] / np.linalg.norm(vectors[k])
        assert np.degrees(np.arccos(np.clip(seen @ exact, -1.0, 1.0))) < 0.05
