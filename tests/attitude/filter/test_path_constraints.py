"""Path constraints with a margin for the attitude uncertainty."""

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
from mgeo_attitude.criteria.constraints import list_constraints
from mgeo_attitude.environment.directions import DIRECTIONS, Cone, DirectionMotion, SatelliteState
from mgeo_attitude.filter.path_constraints import compute_monitored_angle
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario import Convergence, InitialConditions, PathConstraint
from scipy.spatial.transform import Rotation

from . import path_constraint_reference as reference

#: Constraint that is satisfied at the start, far from the Sun.
CAMERA = PathConstraint(name="camera", boresight=(0.0, 0.2, -1.0), half_angle_deg=50.0)


def scenario(*path_constraints, **changes):
    short = dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=900.0,
        convergence=Convergence(window=60.0),
        path_constraints=path_constraints,
    )
    return dataclasses.replace(short, **changes)


def draw_unit_vectors(rng, n=1):
    v = rng.standard_normal((n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def draw_covariances(rng, n):
    roots = rng.standard_normal((n, 3, 3))
    return roots @ roots.transpose(0, 2, 1)


def test_margin_is_angle_change_for_rotation_of_one_sigma():
    """A rotation by 1e-6 rad changes the angle by the 1-sigma of its variance."""
    rng = np.random.default_rng(1)
    axis, sun = draw_unit_vectors(rng)[0], draw_unit_vectors(rng, 20)
    for v, turn in zip(sun, 1e-6 * draw_unit_vectors(rng, 20), strict=True):
        one_direction = np.outer(turn, turn)[None]
        turned = Rotation.from_rotvec(-turn).as_matrix() @ v
        change = np.arccos(turned @ axis) - np.arccos(v @ axis)
        actual = compute_monitored_angle(
            build_cone(axis), 1.0, *build_fixed_motion(v[None]), one_direction
        )[0]
        sigma = (
            actual
            - compute_monitored_angle(
                build_cone(axis), 0.0, *build_fixed_motion(v[None]), one_direction
            )[0]
        )
        assert sigma == pytest.approx(abs(change), rel=1e-4, abs=1e-12)


def build_cone(axis, inside=False):
    return Cone("sun", tuple(axis), 0.0, inside)


def build_fixed_motion(directions, radius=0.0):
    """Return zero rotations and the motion of fixed directions."""
    radii = np.full(len(directions), radius)
    appears = np.zeros(len(directions), dtype=bool)
    return np.zeros_like(directions), DirectionMotion(directions, directions, radii, radii, appears)


def test_margin_of_parallel_direction_is_largest_perpendicular_sigma():
    axis, sun = np.array([0.0, 0.0, 1.0]), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    P = np.diag([0.01, 0.04, 9.0])  # Rotations about the axis change no angle.
    actual = compute_monitored_angle(
        build_cone(axis), 3.0, *build_fixed_motion(sun), np.array([P, P])
    )
    np.testing.assert_allclose(actual, [0.6, 0.6 - np.pi], rtol=1e-12)
    actual = compute_monitored_angle(
        build_cone(axis, inside=True), 3.0, *build_fixed_motion(sun, 0.2), np.array([P, P])
    )
    np.testing.assert_allclose(actual, [0.4, np.pi + 0.4], rtol=1e-12)


@pytest.mark.parametrize(
    ("sigmas", "inside", "radius"), [(0.5, False, 0.0), (3.0, True, 1.1), (0.0, True, 0.0)]
)
def test_monitored_angle_equals_independent_formulas(sigmas, inside, radius):
    rng = np.random.default_rng(2)
    axis = draw_unit_vectors(rng)[0]
    across = np.cross(axis, draw_unit_vectors(rng)[0])
    across /= np.linalg.norm(across)
    near = axis + 1e-5 * across
    sun = np.vstack([draw_unit_vectors(rng, 100), axis, -axis, near / np.linalg.norm(near)])
    turn = rng.uniform(0.0, 0.5, (len(sun), 1)) * draw_unit_vectors(rng, len(sun))
    turn[::5] = 0.0
    turn[-3:] = 0.0
    before = sun + 0.02 * rng.uniform(0.0, 1.0, (len(sun), 1)) * draw_unit_vectors(rng, len(sun))
    before = before / np.linalg.norm(before, axis=1, keepdims=True)
    before[::2], before[-3:] = sun[::2], sun[-3:]  # Some directions are fixed.
    start = radius and radius + 1e-3
    appears = np.arange(len(sun)) % 6 == 2  # Some fixed directions appear.
    radii = np.where(appears, radius, start), np.full(len(sun), radius)
    passage = DirectionMotion(before, sun, *radii, appears)
    P, cone = 0.01 * draw_covariances(rng, len(sun)), build_cone(axis, inside)
    expected = reference.compute_monitored_angle(cone, sigmas, turn, passage, P)
    stays = passage._replace(appears=np.zeros(len(sun), dtype=bool))
    assert (reference.compute_monitored_angle(cone, sigmas, turn, stays, P) < expected - 1e-3).any()
    # The chord of a moving direction is corrected to the arc to second order.
    actual = compute_monitored_angle(cone, sigmas, turn, passage, P)
    np.testing.assert_allclose(actual, expected, rtol=0, atol=2e-9)
    dark = DirectionMotion(*np.zeros((2, 1, 3)), *np.zeros((2, 1)), np.zeros(1, dtype=bool))
    assert compute_monitored_angle(cone, sigmas, turn[:1], dark, P[:1]) == -np.inf


@pytest.fixture(scope="module")
def constrained():
    """Model with path constraints of all directions, with and without margins."""
    others = (
        PathConstraint(
            name="side", boresight=(1.0, -1.0, 0.2), half_angle_deg=40.0, attitude_sigmas=1.5
        ),
        PathConstraint(
            name="sure", boresight=(1.0, -1.0, 0.2), half_angle_deg=40.0, attitude_sigmas=0.0
        ),
        *(
            PathConstraint(
                name=f"{reference} {sense} {sigmas}",
                reference=reference,
                sense=sense,
                boresight=(0.3, 1.0, -0.4),
                half_angle_deg=70.0,
                attitude_sigmas=sigmas,
            )
            for reference in DIRECTIONS
            for sense in ("keep-out", "keep-in")
            for sigmas in (0.0, 2.0)
        ),
    )
    model = FilterModel.from_scenario(scenario(CAMERA, *others))
    rng = np.random.default_rng(3)
    X = rng.uniform(-1.0, 1.0, (8, 12))
    X[:, 3::4] = rng.uniform(20.0, 150.0, (8, 3))
    return model, X


@pytest.mark.slow
def test_compiled_path_angles_equal_reference(constrained):
    model, X = constrained
    sun, _ = model.select_direction("sun")
    assert not sun[0].any()
    assert sun[-1].any()
    result = evaluate(model, X)
    expected = np.array(
        [reference.path_angles(model, run_reference_filter(model, x), x) for x in X]
    )
    np.testing.assert_allclose(result.path_angle, expected, rtol=0, atol=1e-9)
    assert (result.path_angle[:, 1] < result.path_angle[:, 2] - 1e-3).any()
    asked = list_constraints(scenario(*model.path_constraints))
    G = np.column_stack([entry.compute_violations(result).max(axis=0) for entry in asked])
    keep_in = np.array([limit.keep_in for limit in model.path_constraints])
    half = np.radians([limit.half_angle_deg for limit in model.path_constraints])
    share = result.path_angle / half
    np.testing.assert_allclose(G, np.where(keep_in, share - 1.0, 1.0 - share), rtol=0, atol=1e-12)
    assert ((G > 0.0).any(axis=0) & (G < 0.0).any(axis=0)).sum() > 8


#: Number of instants in a step, including both ends.
DENSE = 101


def simulate_densely(problem, x):
    """Return state, attitude and attitude covariance at `DENSE` instants of each step.

    The attitude error is constant in inertial axes throughout a step.
    """
    run, model, step = run_reference_filter(problem.model, x), problem.model, problem.model.step
    n, part = len(run.times) - 1, np.linspace(0.0, step, DENSE)
    at = SatelliteState.from_times(problem.scenario, (run.times[:-1, None] + part).ravel())
    at = at if problem.scenario.eclipse else at.without_eclipses()

    def turned(times):
        rotations = Rotation.from_rotvec(
            (times * Motion.from_design(model, x, model.n_steps).rates[:n, None]).reshape(-1, 3)
        )
        return rotations.as_matrix()

    attitude = turned(-part[:, None]) @ np.repeat(run.attitude[:-1], DENSE, axis=0)
    back = turned(step - part[:, None])
    P = back @ np.repeat(run.predicted_attitude_covariance[1:], DENSE, axis=0) @ back.swapaxes(1, 2)
    return at, attitude, P


def compute_dense_angles(problem, limit, flown):
    """Return the angles of a path constraint and their 1-sigmas, shapes (n_steps, `DENSE`)."""
    at, attitude, P = flown
    direction, axis = DIRECTIONS[limit.build_cone().direction], np.array(limit.build_cone().axis)
    vectors = np.einsum("kij,kj->ki", attitude, direction.vectors(at, problem.scenario.epoch))
    normal = np.cross(axis, vectors)
    sine = np.linalg.norm(normal, axis=1)
    angle = np.arctan2(sine, vectors @ axis)
    if direction.radius is not None:
        angle -= direction.radius(at)
    normal /= sine[:, None]
    sigma = np.sqrt(np.einsum("ki,kij,kj->k", normal, P, normal))
    return angle.reshape(-1, DENSE), sigma.reshape(-1, DENSE)


@pytest.mark.slow
@pytest.mark.parametrize("step", [1.0, 10.0])
def test_path_angle_includes_extremes_between_samples(step):
    """During a fast rotation the extreme angle is between two samples."""
    limits = tuple(
        PathConstraint(
            reference=reference,
            sense=sense,
            boresight=(0.3, 1.0, -0.4),
            half_angle_deg=80.0,
            attitude_sigmas=0.0,
        )
        for reference in DIRECTIONS
        for sense in ("keep-out", "keep-in")
    )
    problem = AttitudeManeuverProblem(
        scenario(eclipse=False, step=step, duration=60.0 * max(step, 2.0))
    )
    usual = problem.scenario
    fast = dataclasses.replace(usual.maneuvers, max_rate_deg_s=5.0)
    problem.scenario = dataclasses.replace(usual, maneuvers=fast, path_constraints=limits)
    problem.model = FilterModel.from_scenario(problem.scenario)
    rng, blind = np.random.default_rng(8), []
    for _ in range(4):
        x = np.append(rng.uniform(-3.0, 3.0, 3), usual.duration)
        flown = simulate_densely(problem, x)
        for limit, actual in zip(limits, evaluate(problem.model, x).path_angle[0], strict=True):
            angles, _ = compute_dense_angles(problem, limit, flown)
            worst, sampled = (
                a.max() if limit.keep_in else a.min() for a in (angles, angles[:, -1])
            )
            assert actual == pytest.approx(worst, abs=1e-5 if step == 1.0 else 2e-4)
            blind.append(abs(worst - sampled))
    assert max(blind) > np.radians(0.01 * step)  # The samples alone miss the extremes.


@pytest.mark.slow
def test_margin_is_valid_between_samples():
    """The margin is evaluated only at the extreme angle and at the end of a step."""
    limit = dataclasses.replace(CAMERA, half_angle_deg=1.0)
    problem = AttitudeManeuverProblem(
        scenario(limit, eclipse=False, duration=200.0, initial=InitialConditions(attitude_deg=1.0))
    )
    rng = np.random.default_rng(9)
    for _ in range(3):
        x = np.append(rng.uniform(-1.0, 1.0, 3), 200.0)
        actual = evaluate(problem.model, x).path_angle[0, 0]
        angle, sigma = compute_dense_angles(problem, limit, simulate_densely(problem, x))
        worst = (angle - 3.0 * sigma).min()
        assert actual == pytest.approx(worst, abs=np.radians(0.05))
