"""The turning figure of a plan, against the attitude of the reference filter."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.scenario import InitialConditions
from mgeo_attitude.view.figures.curves import project_directions
from scipy.spatial.transform import Rotation


def shortened(scenario, **changes):
    maneuvers = dataclasses.replace(scenario.maneuvers, **changes.pop("maneuvers", {}))
    return AttitudeManeuverProblem(
        dataclasses.replace(scenario, duration=2400.0, maneuvers=maneuvers, **changes)
    )


@pytest.fixture(scope="module")
def sharp():
    return shortened(Scenario.paper())


@pytest.fixture(scope="module")
def ramped():
    return shortened(Scenario.paper(), maneuvers={"max_acceleration_deg_s2": 0.02})


def orientation(turn, time):
    """Of what turns at a time, shape (3, 3): whole turns, then the share of the one under way."""
    reached = Rotation.identity()
    vectors = np.column_stack([turn["x"], turn["y"], turn["z"]])
    for start, end, vector in zip(turn["times"][:-1], turn["times"][1:], vectors, strict=True):
        share = min((time - start) / (end - start), 1.0)
        if share > 0.0:
            reached = reached * Rotation.from_rotvec(share * vector, degrees=True)
    return reached.as_matrix()


def between(one, other):
    """Angle between two orientations [deg]."""
    return np.degrees(Rotation.from_matrix(one.T @ other).magnitude())


def get_motion(problem, x):
    (figures,) = problem.view(x[None]).solution_figures()
    return figures["motion"], figures["motion"].layout.meta["motion"]


@pytest.mark.parametrize(("name", "most"), [("sharp", 1e-9), ("ramped", 1.0)])
@pytest.mark.parametrize("row", [0, 1])
def test_the_body_stands_as_the_filter_flew_it(request, X, name, most, row):
    problem = request.getfixturevalue(name)
    plan = ManeuverPlan.from_design(problem, X[row])
    _, motion = get_motion(problem, X[row])
    turn, attitude = motion["rotations"]["body"], plan.history.attitude
    assert motion["end"] == turn["times"][-1] == plan.t_end
    samples = np.linspace(0, len(attitude) - 1, 40).astype(int)
    off = [between(orientation(turn, k * problem.model.step), attitude[k].T) for k in samples]
    assert max(off) < most
    assert between(orientation(turn, plan.t_end), attitude[-1].T) < 1e-6


def test_the_body_starts_where_the_scenario_says(X):
    problem = shortened(Scenario.paper(), initial=InitialConditions(pointing="nadir"))
    plan = ManeuverPlan.from_design(problem, X[0])
    figure, motion = get_motion(problem, X[0])
    attitude = plan.history.attitude
    tips = np.array([next((t.x[1], t.y[1], t.z[1]) for t in figure.data if t.name == axis)
                     for axis in "xyz"])  # fmt: skip
    np.testing.assert_allclose(tips / np.linalg.norm(tips[0]), attitude[0], atol=1e-12)
    for k in (0, 77, 800, len(attitude) - 1):
        turned = tips @ orientation(motion["rotations"]["body"], k * problem.model.step).T
        np.testing.assert_allclose(turned / np.linalg.norm(tips[0]), attitude[k], atol=1e-9)
    (figures,) = problem.view(X[:1]).solution_figures()
    sun = next(trace for trace in figures["directions"].data if trace.name == "Sun")
    seen = project_directions(attitude[:1] @ problem.environment.sun[0])
    assert (sun.x[0], sun.y[0]) == (seen[0][0], seen[1][0])


@pytest.mark.parametrize("name", ["sun", "field"])
def test_sun_and_field_stand_where_the_environment_has_them(sharp, X, name):
    figure, motion = get_motion(sharp, X[0])
    environment = sharp.environment
    label = {"sun": "Sun"}.get(name, name)
    trace = next(trace for trace in figure.data if trace.name == label)
    tip = np.array([trace.x[1], trace.y[1], trace.z[1]])
    vectors = getattr(environment, name)
    for k in (0, 7, 500, 1234):
        seen = orientation(motion["rotations"][label], environment.times[k]) @ tip
        exact = vectors[k] / np.linalg.norm(vectors[k])
        assert np.degrees(np.arccos(np.clip(seen @ exact, -1.0, 1.0))) < 0.05
