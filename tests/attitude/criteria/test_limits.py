"""Limits of a real satellite and objectives beyond the paper's, each against the slow filter."""

import dataclasses
import pickle
from datetime import UTC, datetime

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, SunSensor, evaluate, reference_run
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.maneuvers.motion import phases
from mgeo_attitude.scenario.actuators import Wheels
from mgeo_attitude.scenario.settings import NAMES, Convergence, ManeuverLimits, PathLimit
from mgeo_attitude.settings.errors import InvalidValue

from ..between import worst_excess

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
    path_limits=(
        PathLimit(boresight=(0.0, 0.0, 3.0), half_angle_deg=30.0, attitude_sigmas=0.0),
        PathLimit(
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


@pytest.mark.slow
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
    none = evaluated(problem, X[:0])
    assert none["F"].shape == (0, out["F"].shape[1])
    assert none["G"].shape == (0, out["G"].shape[1])
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
        found.append(met_from(run, {"attitude": 0.02, "gyro.bias": 1e-4})[1])
    np.testing.assert_array_equal(out["F"][:, 5], found)
    assert len(set(found)) > 2  # the limit means something here


def met_from(run, required):
    """When requirements are met for the first time, and for good: `DURATION` for never."""
    met = np.ones(len(run.times), dtype=bool)
    for block, limit in required.items():
        at = 3 * run.blocks.index(block)
        met &= (run.sigma[:, at : at + 3] <= limit).all(axis=1)
    first = run.times[met.argmax()] if met.any() else DURATION
    missed = np.flatnonzero(~met)
    if not missed.size:
        return first, 0.0
    return first, (DURATION if missed[-1] == len(met) - 1 else run.times[missed[-1] + 1])


@pytest.mark.slow
def test_a_required_sigma_that_is_lost_again_does_not_count():
    """The run goes on in the Earth's shadow, in which the attitude grows worse at times."""
    dark = dataclasses.replace(
        LIMITED,
        epoch=datetime(2018, 6, 5, 1, 0, tzinfo=UTC),
        eclipse=True,
        gyro=Scenario.cubesat_6u().gyro,
        convergence=Convergence(window=60.0, relative_decrease=1e-6),
        required_sigma={
            "attitude_deg": np.degrees(0.0032),
            "gyro.bias_deg_h": 3600 * np.degrees(1e-4),
        },
    )
    problem = AttitudeManeuverProblem(dark, objectives=("t_end", "t_required"))
    X = designs(12)[:4]
    F = evaluated(problem, X)["F"]
    runs = [reference_run(problem.model, x) for x in X]
    required = {"attitude": 0.0032, "gyro.bias": 1e-4}  # rad, rad/s
    first, for_good = np.array([met_from(run, required) for run in runs]).T
    np.testing.assert_array_equal(F[:, 0], [run.t_end for run in runs])
    np.testing.assert_array_equal(F[:, 1], for_good)
    regained = (for_good > first) & (for_good < DURATION)
    lost = (for_good > first) & (for_good == DURATION)
    assert regained.any()
    assert lost.any()


def test_a_required_sigma_may_be_met_from_the_start():
    loose = dataclasses.replace(
        LIMITED, required_sigma={"attitude_deg": 57.0, "gyro.bias_deg_h": 2e5}
    )
    problem = AttitudeManeuverProblem(loose, objectives=("t_required",))
    assert (evaluated(problem, designs(2))["F"] == 0.0).all()


@pytest.mark.slow
def test_sun_keep_out_binds_where_the_reference_sees_the_sun(limited):
    problem, _, out, runs = limited
    for cone, (axis, half_angle) in enumerate(
        [((0.0, 0.0, 1.0), 30.0), ((np.sqrt(0.5), -np.sqrt(0.5), 0.0), 60.0)]
    ):
        for G, run in zip(out["G"], runs, strict=True):
            sun, _ = problem.model.direction("sun", slice(len(run.times)))
            angle = -np.degrees(worst_excess(run.attitude, sun, axis))
            assert G[1 + cone] == pytest.approx(1.0 - angle / half_angle, abs=1e-9)
    assert (out["G"][:, 1] > 0.0).any()
    assert (out["G"][:, 1] < 0.0).any()


@pytest.mark.slow
def test_no_sun_no_keep_out():
    """Where the Sun never shines there is nothing to stay off."""
    problem = AttitudeManeuverProblem(dataclasses.replace(LIMITED, eclipse=True))
    dark = dataclasses.replace(problem.model, directions=np.zeros_like(problem.model.directions))
    assert np.degrees(evaluate(dark, designs(2)).path_angle.min()) >= 90.0


def test_wheel_momentum_binds_on_the_fastest_heaviest_axis(limited):
    problem, X, out, _ = limited
    greatest = []
    for x in X.reshape(len(X), 3, 4):
        rate, momenta = np.zeros(3), []
        edges = np.ceil(np.append(0.0, np.cumsum(x[:, 3])))
        edges[-1] = np.inf  # the last ramp is not cut short
        for target, time in zip(np.radians(x[:, :3]), np.diff(edges), strict=True):
            change = target - rate
            rate = rate + change * min(1.0, time / problem.model.slew_limits.ramp_time(change))
            momenta.append(np.abs(rate * [0.02, 0.03, 0.04]).max())
        greatest.append(max(momenta))
    greatest = np.array(greatest)
    np.testing.assert_allclose(out["G"][:, 0], greatest / 5e-4 - 1.0, rtol=1e-12)
    assert (out["G"][:, 0] > 0.0).any()
    assert (out["G"][:, 0] < 0.0).any()


@pytest.mark.parametrize("acceleration", [None, 0.02])
def test_wheels_hold_no_momentum_of_maneuvers_after_the_end(acceleration):
    """The second begins when the run is over; so does what is left of a ramp."""
    problem = AttitudeManeuverProblem(
        dataclasses.replace(
            LIMITED,
            maneuvers=ManeuverLimits(count=2, max_acceleration_deg_s2=acceleration),
            wheels=Wheels(inertia=(0.02, 0.03, 0.04), max_momentum=5e-4),
        )
    )
    slow, fast = [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]
    X = np.array([[*slow, DURATION, *fast, 100.0], [*slow, DURATION - 1.0, *fast, 100.0]])
    momentum = 5e-4 * (evaluated(problem, X)["G"][:, 0] + 1.0)
    assert momentum[0] == pytest.approx(0.02 * np.radians(0.5), rel=1e-12)
    if acceleration is None:  # for a last second it is flown
        assert momentum[1] == pytest.approx(0.04 * np.radians(1.0), rel=1e-12)


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


@pytest.mark.cases(0)
@pytest.mark.parametrize("limit", ["field of view", "eclipse"])
def test_what_a_sensor_does_not_see_it_cannot_calibrate(limit):
    """Variances only grow, and do so while the satellite is in the shadow it starts in."""
    X = designs(4)
    night = {"epoch": datetime(2018, 6, 5, 0, 35, tzinfo=UTC)}
    narrow = tuple(
        dataclasses.replace(s, half_angle_deg=40.0) if isinstance(s, SunSensor) else s
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
    X = np.array([[0.3, 0.4, 0.0, 100.0, 0.0, 0.0, -1.0, 50.0]])
    F = evaluated(problem, X)["F"]
    t_end = evaluate(problem.model, X).t_end[0]
    assert F[0, 1] == pytest.approx(0.5 * 100.0 + t_end - 100.0)  # the last rate is held
    assert F[0, 2] == pytest.approx(0.5 + np.sqrt(0.25 + 1.0))
    assert problem.obj_names[1] == "angle turned [deg]"
    assert problem.indicator_space(F).shape == (1, 3)


NOT_FLOWN = [
    # no time for anything but the last rate
    ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0], 3**0.5 * DURATION, 3**0.5),
    # a maneuver that is over before the step at which it would begin
    ([0.5, 0.0, 0.0, 100.5, -1.0, 0.0, 0.0, 0.2, 0.5, 0.0, 0.0, 50.0], 0.5 * DURATION, 0.5),
    # one that would begin after the end
    ([0.5, 0.0, 0.0, 800.0, 0.0, 0.0, 0.0, 150.0, 1.0, 0.0, 0.0, 9.0], 400.0, 1.0),
]


@pytest.mark.parametrize(("design", "angle", "rate_change"), NOT_FLOWN)
def test_only_what_is_flown_until_t_end_is_turned_through(design, angle, rate_change):
    endless = scenario(convergence=Convergence(window=60.0, relative_decrease=1e-9))
    problem = AttitudeManeuverProblem(endless, objectives=("t_end", "angle", "rate_change"))
    F = evaluated(problem, np.array([design]))["F"][0]
    assert F.tolist() == pytest.approx([DURATION, angle, rate_change], rel=1e-12)


def test_ramps_count_in_angle_and_rate_change():
    """0.02 deg/s²: 20 s up to 0.4 deg/s, down by 0.2 deg/s in 10 s, up by 0.3 deg/s in 15."""
    limits = ManeuverLimits(max_acceleration_deg_s2=0.02)
    ramped = scenario(
        maneuvers=limits, convergence=Convergence(window=60.0, relative_decrease=1e-9)
    )
    problem = AttitudeManeuverProblem(ramped, objectives=("t_end", "angle", "rate_change"))
    design = [0.4, 0.0, 0.0, 100.0, -0.1, 0.0, 0.0, 10.0, 0.5, 0.0, 0.0, 50.0]
    F = evaluated(problem, np.array([design]))["F"][0]
    angle = 0.2 * 20.0 + 0.4 * 80.0 + 0.3 * 10.0 + 0.35 * 15.0 + 0.5 * (DURATION - 125.0)
    assert F.tolist() == pytest.approx([DURATION, angle, 0.4 + 0.2 + 0.3], rel=1e-12)


@pytest.mark.parametrize("acceleration", [None, 0.02])
def test_angle_is_what_the_phases_of_the_plan_sweep(acceleration):
    limits = ManeuverLimits(max_acceleration_deg_s2=acceleration)
    problem = AttitudeManeuverProblem(
        scenario(maneuvers=limits), objectives=("t_end", "angle", "rate_change")
    )
    X = designs(30)
    X[10:20, 3::4] *= np.random.default_rng(5).random((10, 3)) > 0.4
    X[20:, 3::4] *= 0.05
    F = evaluated(problem, X)["F"]
    slew_limits = problem.model.slew_limits
    swept = [
        sum(phase.swept_deg for phase in phases(x, t_end, 1.0, slew_limits))
        for x, t_end in zip(X, F[:, 0], strict=True)
    ]
    np.testing.assert_allclose(F[:, 1], swept, rtol=1e-12)
    alone = [evaluated(problem, x[None])["F"][0] for x in X]
    np.testing.assert_array_equal(F, alone)  # to the last bit, whatever is beside it
    assert (problem.indicator_space(F) <= 1.0).all()


def test_a_design_without_result_has_no_angle_either():
    problem = AttitudeManeuverProblem(scenario(), objectives=("angle", "rate_change"))
    result = evaluate(problem.model, designs(2))
    lost = dataclasses.replace(result, t_end=np.array([np.nan, 300.0]))
    for name in problem.objectives:
        found = OBJECTIVES[name].value(problem.model, lost)
        assert np.isnan(found).tolist() == [True, False]


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
        (("t_end", "tracce"), ValueError, r"objectives\[1\] = 'tracce': .*did you mean 'trace'"),
        (("trace:atitude",), ValueError, "unknown state block 'atitude'; did you mean 'attitude'"),
        (("trace:",), ValueError, "unknown state block ''"),
        ("trace", ValueError, "objectives = 'trace': expected a list of"),
        (("trace", 3), ValueError, r"objectives\[1\] = 3: expected a string"),
        ((), ValueError, r"objectives = \[\]: expected at least one name"),
        (("trace", "trace"), ValueError, r"objectives\[1\] = 'trace': expected each one once"),
        (("t_required",), ValueError, "no required_sigma"),
    ],
)
def test_bad_objectives(objectives, error, message):
    with pytest.raises(error, match=message):
        AttitudeManeuverProblem(objectives=objectives)
    with pytest.raises(error, match=message):
        Scenario.from_dict({"preset": "paper", "objectives": objectives})


def test_objectives_of_a_scenario_are_its_problems_unless_others_are_asked_for():
    names = ("trace:attitude,gyro.bias", "angle")
    problem = AttitudeManeuverProblem(scenario(objectives=names))
    assert problem.objectives == problem.scenario.objectives == names
    assert problem.options()["objectives"] == [*names]
    assert AttitudeManeuverProblem.from_options(problem.options()).scenario == problem.scenario
    other = AttitudeManeuverProblem(problem.scenario, objectives=["t_end", "trace"])
    assert other.objectives == other.scenario.objectives == ("t_end", "trace")
    assert "objectives" not in other.options()


def test_every_objective_has_a_name_that_a_scenario_takes():
    assert [*OBJECTIVES] == [*NAMES]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PathLimit(boresight=(0.0, 0.0, 0.0), half_angle_deg=10.0), "not zero"),
        (lambda: PathLimit(boresight=(1.0, 0.0, 0.0), half_angle_deg=180.0), r"in \(0, 180\)"),
        (
            lambda: PathLimit(name="a\nb", boresight=(1.0, 0.0, 0.0), half_angle_deg=9.0),
            r"name = 'a\\nb': expected printable characters on one line",
        ),
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
    table["gyro"] |= {"initial_scale_factor": 1e-3, "initial_misalignment_deg": 0.1}
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
