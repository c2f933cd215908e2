"""Limits of a real satellite and objectives beyond the paper's, each against the slow filter."""

import dataclasses
import pickle
from datetime import UTC, datetime

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, SunSensor, reference_run
from mgeo_attitude.fields import InvalidValue
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.scenario import Convergence, KeepOut, ManeuverLimits, Wheels

DURATION = 900.0


def scenario(**changes):
    short = dataclasses.replace(
        Scenario.paper(), duration=DURATION, convergence=Convergence(window=60.0)
    )
    return dataclasses.replace(short, **changes)


def designs(n=8):
    rng = np.random.default_rng(3)
    X = rng.uniform(-1.0, 1.0, (n, 12))
    X[:, 3::4] = rng.uniform(20.0, 150.0, (n, 3))
    return X


def evaluated(problem, X):
    return problem.evaluate(X, return_as_dictionary=True)


LIMITED = scenario(
    maneuvers=ManeuverLimits(max_acceleration_deg_s2=0.02),
    wheels=Wheels(inertia=(0.02, 0.03, 0.04), max_momentum=5e-4, max_torque=1e-5),
    keep_outs=(
        KeepOut(boresight=(0.0, 0.0, 3.0), half_angle_deg=30.0, attitude_sigmas=0.0),
        KeepOut(
            name="second", boresight=(1.0, -1.0, 0.0), half_angle_deg=60.0, attitude_sigmas=0.0
        ),
    ),
    required_sigma={"attitude_deg": np.degrees(0.02), "gyro.bias_deg_h": 3600 * np.degrees(1e-4)},
)


@pytest.fixture(scope="module")
def limited():
    problem = AttitudeManeuverProblem(
        LIMITED,
        objectives=(
            "t_end",
            "trace",
            "normalized_trace",
            "log_det",
            "max_eigenvalue",
            "t_required",
            "trace:attitude,gyro.bias",
        ),
    )
    X = designs()
    return problem, X, evaluated(problem, X), [reference_run(problem.model, x) for x in X]


def test_kernel_flies_the_ramps_that_the_reference_flies(limited):
    _, X, out, runs = limited
    np.testing.assert_array_equal(out["F"][:, 0], [run.t_end for run in runs])
    np.testing.assert_allclose(out["F"][:, 1], [run.trace[-1] for run in runs], rtol=1e-9)
    at_once = dataclasses.replace(
        LIMITED, maneuvers=ManeuverLimits(), wheels=None, required_sigma={}
    )
    assert not np.allclose(evaluated(AttitudeManeuverProblem(at_once), X)["F"], out["F"][:, :2])


def test_no_designs_have_no_values(limited):
    problem, X, out, _ = limited
    found = problem._run(X[:0])
    assert found.shape == (0, out["F"].shape[1] + out["G"].shape[1])
    again = evaluated(problem, X)  # the second time none of them is run
    assert all(np.array_equal(evaluated(problem, X)[key], again[key]) for key in ("F", "G"))


def test_criteria_of_the_covariance(limited):
    problem, _, out, runs = limited
    sigma = problem.model.initial_sigma
    for F, run in zip(out["F"], runs, strict=True):
        scaled = run.covariance / np.outer(sigma, sigma)
        assert F[2] == pytest.approx(np.trace(scaled) / 18, rel=1e-9)
        assert F[3] == pytest.approx(np.log10(np.linalg.det(scaled)) / 18, rel=1e-9)
        assert F[4] == pytest.approx(np.linalg.eigvalsh(scaled)[-1], rel=1e-9)
        assert F[6] == pytest.approx(np.trace(run.covariance[:6, :6]), rel=1e-9)


def test_time_to_required_sigma(limited):
    _, _, out, runs = limited
    found = []
    for run in runs:
        met = (run.sigma[:, :3] <= 0.02).all(axis=1) & (run.sigma[:, 3:6] <= 1e-4).all(axis=1)
        found.append(run.times[met.argmax()] if met.any() else DURATION)
    np.testing.assert_array_equal(out["F"][:, 5], found)
    assert len(set(found)) > 2  # the limit means something here


def test_sun_keep_out_binds_where_the_reference_sees_the_sun(limited):
    problem, _, out, runs = limited
    for cone, (axis, half_angle) in enumerate(
        [((0.0, 0.0, 1.0), 30.0), ((np.sqrt(0.5), -np.sqrt(0.5), 0.0), 60.0)]
    ):
        for G, run in zip(out["G"], runs, strict=True):
            sun = np.einsum("kij,kj->ki", run.attitude, problem.model.sun[: len(run.times)])
            angle = np.degrees(np.arccos((sun @ axis).max()))
            assert G[1 + cone] == pytest.approx(1.0 - angle / half_angle, abs=1e-9)
    assert (out["G"][:, 1] > 0.0).any()
    assert (out["G"][:, 1] < 0.0).any()


def test_no_sun_no_keep_out():
    """Where the Sun never shines there is nothing to stay off."""
    problem = AttitudeManeuverProblem(dataclasses.replace(LIMITED, eclipse=True))
    dark = dataclasses.replace(problem.model, sun=np.zeros_like(problem.model.sun))
    assert np.degrees(evaluate(dark, designs(2)).sun_angle.min()) >= 90.0


def test_wheel_momentum_binds_on_the_fastest_heaviest_axis(limited):
    problem, X, out, _ = limited
    plan = problem.model.schedule(X)
    flown = np.where(plan.flown()[:, :, None], plan.rates, 0.0)
    greatest = np.abs(flown * [0.02, 0.03, 0.04]).max(axis=(1, 2))
    np.testing.assert_allclose(out["G"][:, 0], greatest / 5e-4 - 1.0, rtol=1e-12)
    assert (out["G"][:, 0] > 0.0).any()
    assert (out["G"][:, 0] < 0.0).any()


def test_required_sigma_binds(limited):
    _, _, out, runs = limited
    for G, run in zip(out["G"], runs, strict=True):
        worst = max(run.sigma[-1, :3].max() / 0.02, run.sigma[-1, 3:6].max() / 1e-4)
        assert G[3] == pytest.approx(worst - 1.0, rel=1e-9)
    assert (out["G"][:, 3] > 0.0).any() or (out["G"][:, 3] < 0.0).any()


def test_each_limit_is_a_constraint_with_a_name(limited):
    problem = limited[0]
    assert problem.constraint_names == (
        "wheel momentum",
        "Sun off payload",
        "Sun off second",
        "required 1-sigma",
    )
    assert AttitudeManeuverProblem(scenario()).constraint_names == ()


@pytest.mark.parametrize("limit", ["field of view", "eclipse"])
def test_what_a_sensor_does_not_see_it_cannot_calibrate(limit):
    """Variances only grow, and do so while the satellite is in the shadow it starts in."""
    X = designs(4)
    night = {"epoch": datetime(2018, 6, 5, 0, 35, tzinfo=UTC)}
    narrow = tuple(
        dataclasses.replace(s, field_of_view_deg=40.0) if isinstance(s, SunSensor) else s
        for s in Scenario.paper().sensors
    )
    changes = {"sensors": narrow} if limit == "field of view" else {"eclipse": True}
    blind, seeing = (
        evaluate(AttitudeManeuverProblem(scenario(**night, **change)).model, X, history=True)
        for change in (changes, {})
    )
    both = np.isfinite(blind.variances) & np.isfinite(seeing.variances)
    assert (blind.variances[both] >= seeing.variances[both] * (1.0 - 1e-9)).all()
    assert (blind.variances[both] > 2.0 * seeing.variances[both]).any()


def test_third_objectives_by_hand():
    problem = AttitudeManeuverProblem(
        scenario(), n_maneuvers=2, objectives=("trace", "angle", "rate_change")
    )
    F = evaluated(problem, np.array([[0.3, 0.4, 0.0, 100.0, 0.0, 0.0, -1.0, 50.0]]))["F"]
    assert F[0, 1] == pytest.approx(0.5 * 100.0 + 50.0)
    assert F[0, 2] == pytest.approx(0.5 + np.sqrt(0.25 + 1.0))
    assert problem.obj_names[1] == "angle turned [deg]"
    assert problem.indicator_space(F).shape == (1, 3)


def test_sharing_prefixes_does_not_change_monitored_runs(limited):
    problem, X, _, _ = limited
    batch = np.repeat(X[:2], 12, axis=0)
    batch[np.arange(24), np.tile(np.arange(12), 2)] *= 0.9
    together = evaluated(problem, batch)
    evaluated(problem, X[2:3])  # which now is the batch before
    alone = [evaluated(problem, x[None]) for x in batch]
    np.testing.assert_array_equal(together["F"], np.vstack([out["F"] for out in alone]))
    np.testing.assert_array_equal(together["G"], np.vstack([out["G"] for out in alone]))


def test_problem_survives_pickling_and_its_options(limited):
    problem, X, out, _ = limited
    again = AttitudeManeuverProblem.from_options(problem.options())
    assert again.objectives == problem.objectives
    for copy in (again, pickle.loads(pickle.dumps(problem))):
        np.testing.assert_array_equal(evaluated(copy, X[:2])["F"], out["F"][:2])


@pytest.mark.parametrize(
    ("objectives", "error", "message"),
    [
        (("t_end", "tracce"), ValueError, "did you mean 'trace'"),
        (("trace:atitude",), ValueError, "unknown block 'atitude', did you mean 'attitude'"),
        ("trace", TypeError, "expected a list of names"),
        ((), TypeError, "expected a list of names"),
        (("trace", "trace"), ValueError, "each one once"),
        (("t_required",), ValueError, "no required_sigma"),
    ],
)
def test_bad_objectives(objectives, error, message):
    with pytest.raises(error, match=message):
        AttitudeManeuverProblem(objectives=objectives)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: KeepOut(boresight=(0.0, 0.0, 0.0), half_angle_deg=10.0), "not zero"),
        (lambda: KeepOut(boresight=(1.0, 0.0, 0.0), half_angle_deg=90.0), r"in \(0, 90\) deg"),
        (
            lambda: Wheels(inertia=(1.0, 1.0, 1.0), products_of_inertia=(2.0, 0.0, 0.0)),
            "positive definite",
        ),
        (lambda: Wheels(inertia=(1.0, 0.0, 1.0)), "inertia"),
        (lambda: scenario(required_sigma={"attitude_deg": 0.0}), "required_sigma.attitude_deg"),
        (lambda: scenario(required_sigma={"atitude_deg": 1.0}), "did you mean 'attitude_deg'"),
    ],
)
def test_bad_limits(make, message):
    with pytest.raises(InvalidValue, match=message):
        make()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("attitude", "attitude_deg"),
        ("gyro.bias", "gyro.bias_deg_h"),
        ("gyro.bias_deg_s", "gyro.bias_deg_h"),
        ("sun.misalignment", "sun.misalignment_deg"),
        ("mag.bias", "mag.bias_nt"),
    ],
)
def test_a_requirement_without_its_unit_names_the_key_that_has_it(old, new):
    with pytest.raises(InvalidValue) as caught:
        Scenario.from_dict({"preset": "paper", "required_sigma": {old: 0.1}})
    message = str(caught.value)
    assert message.startswith(f"required_sigma.{old} = 0.1: unknown")
    assert f"did you mean '{new}'?" in message
    assert "\n" not in message


def test_requirements_are_in_the_unit_of_their_key():
    """Keys ending as those of the sensors do; what the filter has is rad, rad/s and 50 µT."""
    required = {
        "attitude_deg": 0.1,
        "gyro": {"bias_deg_h": 2.0},
        "sun.misalignment_deg": 0.2,
        "sun.bias": 0.003,
        "mag.bias_nt": 25.0,
    }
    table = {"preset": "paper", "required_sigma": required}
    model = AttitudeManeuverProblem(Scenario.from_dict(table)).model
    np.testing.assert_allclose(
        model.required_sigma[::3],
        [np.radians(0.1), np.radians(2.0 / 3600.0), np.radians(0.2), 0.003, np.inf, 25.0 / 50e3],
        rtol=1e-15,
    )


def test_every_block_declares_the_unit_of_its_key():
    """What is asked of a block is shown in the unit that its key has."""
    tracker = {"kind": "star-tracker"}
    table = Scenario.paper().to_dict()
    table["gyro"] |= {"scale_factor": 1e-3, "misalignment_deg": 0.1}
    text = Scenario.from_dict(table | {"sensors": [*table["sensors"], tracker]}).to_toml()
    keys = text.partition("[required_sigma]")[2].partition("The blocks: ")[2].splitlines()[0]
    assert keys.split(", ") == [
        "attitude_deg",
        "gyro.bias_deg_h",
        "gyro.scale_factor",
        "gyro.misalignment_deg",
        "sun.misalignment_deg",
        "sun.bias",
        "mag.misalignment_deg",
        "mag.bias_nt",
        "tracker.misalignment_deg",
    ]


def test_limits_survive_toml():
    assert Scenario.from_toml(LIMITED.to_toml()) == LIMITED
    assert Scenario.from_dict(LIMITED.to_dict()) == LIMITED
