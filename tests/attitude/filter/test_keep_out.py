"""Keep-out cones with a margin for the attitude: by hand, as code, and along whole runs."""

import dataclasses
from math import sqrt

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, evaluate, reference_run
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.filter.keep_out import (
    angle_sigma,
    arc,
    cone_constants,
    sun_clearance,
    sun_excess,
)
from mgeo_attitude.filter.symbols import Code, Symbol, Triangle
from mgeo_attitude.scenario import Convergence, InitialConditions, KeepOut
from mgeo_attitude.vector import Vec3
from scipy.spatial.transform import Rotation

#: A long way from the Sun at the start, so that only what is flown decides.
CAMERA = KeepOut(name="camera", boresight=(0.0, 0.2, -1.0), half_angle_deg=50.0)


def scenario(*keep_outs, **changes):
    short = dataclasses.replace(
        Scenario.cubesat_6u(),
        duration=900.0,
        convergence=Convergence(window=60.0),
        keep_outs=keep_outs,
    )
    return dataclasses.replace(short, **changes)


def unit(rng, n=1):
    v = rng.standard_normal((n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def covariances(rng, n):
    roots = rng.standard_normal((n, 3, 3))
    return roots @ roots.transpose(0, 2, 1)


def value(symbol, **names):
    """What a symbol stands for."""
    names |= {"sqrt": sqrt}
    exec("\n".join(symbol.code.lines), names)
    return names[symbol.name]


def test_the_margin_is_how_far_turns_of_one_sigma_move_the_sun():
    """A finite turn by a millionth changes the angle by what the formula says of its variance."""
    rng = np.random.default_rng(1)
    axis, sun = unit(rng)[0], unit(rng, 20)
    for v, turn in zip(sun, 1e-6 * unit(rng, 20), strict=True):
        one_direction = np.outer(turn, turn)[None]
        turned = Rotation.from_rotvec(-turn).as_matrix() @ v
        change = np.arccos(turned @ axis) - np.arccos(v @ axis)
        sigma = angle_sigma(axis, v[None], one_direction)[0]
        assert sigma == pytest.approx(abs(change), rel=1e-4, abs=1e-12)


def test_parallel_takes_the_largest_sigma_across_the_axis():
    axis, sun = np.array([0.0, 0.0, 1.0]), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    P = np.diag([0.01, 0.04, 9.0])  # turns about the axis itself change no angle
    np.testing.assert_allclose(angle_sigma(axis, sun, np.array([P, P])), 0.2, rtol=1e-12)
    found = sun_clearance(axis, 3.0, sun, np.array([P, P]))
    np.testing.assert_allclose(found, [-0.6, np.pi - 0.6], rtol=1e-12)


def test_no_sun_no_margin():
    assert sun_clearance(np.eye(3)[0], 3.0, np.zeros((1, 3)), np.eye(3)[None]) == np.inf


def test_the_arc_is_exact_at_every_angle():
    code = Code()
    result = arc(Symbol("s", code), Symbol("c", code))
    angles = [0.0, 1e-9, 1e-3, np.pi / 2, 3.0, np.pi - 1e-9, *np.linspace(0.0, np.pi, 500)]
    for angle in angles:
        s, c = np.sin(angle), np.cos(angle)
        assert value(result, s=s, c=c) == pytest.approx(np.arctan2(s, c), rel=1e-15, abs=1e-15)


@pytest.mark.parametrize("sigmas", [0.5, 3.0])
def test_the_code_says_what_its_twin_says(sigmas):
    rng = np.random.default_rng(2)
    axis = unit(rng)[0]
    across = np.cross(axis, unit(rng)[0])
    across /= np.linalg.norm(across)
    near = axis + 1e-5 * across
    sun = np.vstack([unit(rng, 50), axis, -axis, near / np.linalg.norm(near)])
    P = 0.01 * covariances(rng, len(sun))
    code = Code()
    C = cone_constants(axis[None], np.array([sigmas]))
    frame = [Vec3(*(Symbol(f"C[{3 * i + k}]", code) for k in range(3))) for i in range(3)]
    v = Vec3(*(Symbol(f"v[{k}]", code) for k in range(3)))
    given = Symbol("C[9]", code), v, Triangle(code), Symbol("dark", code)
    result = sun_excess(frame, *given)
    W = P[:, *np.tril_indices(3)]
    found = [value(result, C=C, v=v, W=w, dark=-7.0) for v, w in zip(sun, W, strict=True)]
    np.testing.assert_allclose(found, -sun_clearance(axis, sigmas, sun, P), rtol=0, atol=1e-10)
    assert value(result, C=C, v=np.zeros(3), W=W[0], dark=-7.0) == -7.0


@pytest.fixture(scope="module")
def watched():
    """Two cones with margins and one without, through the end of the night."""
    others = (
        KeepOut(name="side", boresight=(1.0, -1.0, 0.2), half_angle_deg=40.0, attitude_sigmas=1.5),
        KeepOut(name="sure", boresight=(1.0, -1.0, 0.2), half_angle_deg=40.0, attitude_sigmas=0.0),
    )
    problem = AttitudeManeuverProblem(scenario(CAMERA, *others))
    rng = np.random.default_rng(3)
    X = rng.uniform(-1.0, 1.0, (8, 12))
    X[:, 3::4] = rng.uniform(20.0, 150.0, (8, 3))
    return problem, X


def sun_clearances(model, run):
    """`sun_clearance` of every watched axis along a run of the reference filter."""
    sun = np.einsum("kij,kj->ki", run.attitude, model.sun[: len(run.times)])
    cones = zip(model.cones, model.cone_sigmas, strict=True)
    clearances = [sun_clearance(axis, k, sun, run.predicted_attitude) for axis, k in cones]
    return np.column_stack(clearances)


def test_kernel_keeps_the_cones_that_the_reference_keeps(watched):
    problem, X = watched
    model = problem.model
    assert not model.sun[0].any()
    assert model.sun[-1].any()
    result = evaluate(model, X)
    runs = [reference_run(model, x) for x in X]
    clearances = [sun_clearances(model, run) for run in runs]
    least = np.array([c.min(axis=0) for c in clearances])
    least[:, 2] = np.minimum(least[:, 2], np.pi / 2)  # so far the Sun is of itself, in the dark
    np.testing.assert_allclose(result.sun_angle, least, rtol=0, atol=1e-9)
    assert (result.sun_angle[:, 1] < result.sun_angle[:, 2] - 1e-3).any()
    G = problem.evaluate(X, return_values_of=["G"])
    half = np.radians([50.0, 40.0, 40.0])
    np.testing.assert_allclose(G, 1.0 - result.sun_angle / half, rtol=1e-12, atol=1e-12)
    assert (G[:, :2] > 0.0).any()
    assert (G[:, :2] < 0.0).any()


def test_margins_do_not_depend_on_what_else_is_run(watched):
    problem, X = watched
    batch = np.repeat(X[:2], 12, axis=0)
    batch[np.arange(24), np.tile(np.arange(12), 2)] *= 0.9
    together = evaluate(problem.model, batch).sun_angle
    alone = [evaluate(problem.model, x[None]).sun_angle[0] for x in batch]
    np.testing.assert_array_equal(together, alone)


def test_a_cone_at_rest_by_hand():
    """Nothing turns: the margin is largest at the start, but for a step's drift of the gyro."""
    day = dataclasses.replace(CAMERA, half_angle_deg=30.0)
    problem = AttitudeManeuverProblem(
        scenario(day, eclipse=False, initial=InitialConditions(attitude_deg=8.0))
    )
    sun, axis = problem.environment.sun[0], np.array([0.0, 0.2, -1.0]) / np.hypot(0.2, 1.0)
    at_start = np.arccos(sun @ axis) - 3.0 * np.radians(8.0)
    found = evaluate(problem.model, np.zeros((1, 12))).sun_angle[0, 0]
    assert found == pytest.approx(at_start, abs=1e-6)


def test_no_margin_is_the_angle_alone():
    bare = dataclasses.replace(CAMERA, attitude_sigmas=0.0)
    problem = AttitudeManeuverProblem(scenario(bare, eclipse=False))
    X = np.array([[0.3, -0.7, 0.2, 100.0, -0.9, 0.1, 0.4, 80.0, 0.5, 0.5, -0.5, 60.0]])
    run = reference_run(problem.model, X[0])
    sun = np.einsum("kij,kj->ki", run.attitude, problem.model.sun[: len(run.times)])
    angle = np.arccos((sun @ bare.axis()).max())
    assert evaluate(problem.model, X).sun_angle[0, 0] == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: dataclasses.replace(CAMERA, attitude_sigmas=-1.0), "attitude_sigmas = -1.0"),
        (
            lambda: scenario(CAMERA, dataclasses.replace(CAMERA, attitude_sigmas=13.0)),
            r"keep_outs\[1\].attitude_sigmas = 13.0: expected less than 13: "
            r"with initial.attitude_deg = 10.0 .* half_angle_deg = 50.0",
        ),
    ],
)
def test_bad_margins_are_named(make, message):
    with pytest.raises(InvalidValue, match=message):
        make()


def test_a_cone_that_no_plan_keeps_is_refused():
    """The attitude at the start is given: there the Sun is 67.5 deg from z."""
    cone = KeepOut(name="camera", boresight=(0.0, 0.0, 1.0), half_angle_deg=38.0)
    sunlit = scenario(cone, eclipse=False)
    message = r"keep_outs\[0\]\.half_angle_deg = 38\.0: expected at most 37\.5\d*, .* 67\.5\d* deg"
    with pytest.raises(InvalidValue, match=message):
        AttitudeManeuverProblem(sunlit)
    surer = dataclasses.replace(cone, attitude_sigmas=2.5)
    for kept in (scenario(surer, eclipse=False), scenario(cone)):  # it starts at night
        assert AttitudeManeuverProblem(kept).model.cone_sigmas > 0.0
