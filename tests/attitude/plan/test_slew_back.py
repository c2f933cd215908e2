"""A plan that ends with a slew back: in its tables, files and figures, and in simulated flights."""

import dataclasses

import brahe
import brahe.ccsds
import numpy as np
import pytest
from mgeo_attitude import (
    AttitudeManeuverProblem,
    Environment,
    FilterModel,
    Scenario,
    run_reference_filter,
)
from mgeo_attitude.filter.wheel_load import compute_wheel_loads
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.plan.aem import format_aem
from mgeo_attitude.plan.files import from_json, to_json
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario import PathConstraint, Wheels
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.view.margins import END_ATTITUDE
from mgeo_calibration import simulate

from ...calibration.simulators.runs import build_zero_errors, simulate_motion
from .conftest import DESIGN
from .test_aem import instant, matrix

TABLE = {
    "preset": "paper",
    "duration": 900.0,
    "initial": {"pointing": "nadir"},
    "maneuvers": {"slew_back": True, "max_acceleration_deg_s2": 0.05},
}


@pytest.fixture(scope="module")
def plan():
    return ManeuverPlan(Scenario.from_dict(TABLE), DESIGN)


@pytest.fixture(scope="module")
def without():
    table = TABLE | {"maneuvers": {"max_acceleration_deg_s2": 0.05}}
    return ManeuverPlan(Scenario.from_dict(table), DESIGN)


def test_the_filter_does_not_see_it(plan, without):
    """Neither t_end nor trace, nor what was learned; the plan is longer."""
    assert (plan.t_end, plan.trace) == (without.t_end, without.trace)
    assert without.duration == without.t_end < plan.duration
    X = np.array([DESIGN])
    F = [each.problem.evaluate(X, return_values_of=["F"]) for each in (plan, without)]
    np.testing.assert_array_equal(*F)
    for name in ("build_accuracy_table", "compute_uncertainty_by_phase", "find_least_observable"):
        assert getattr(plan, name)().equals(getattr(without, name)())
    assert plan.compare_with_designs().equals(without.compare_with_designs())


def test_its_end_is_read_back_as_looking_down(plan):
    aem = brahe.ccsds.AEM.from_str(format_aem(plan, version="2.0"))
    last = len(aem.segments) - 1
    assert len(aem.segments) == len(plan.phases)
    body = matrix(aem.segment_to_attitude_trajectory(last), instant(plan, plan.duration))
    scenario = plan.scenario
    position, velocity = scenario.orbit.propagate(scenario.epoch, np.array([plan.duration]))
    radial, along, _ = brahe.rotation_eci_to_rtn(np.append(position, velocity))
    np.testing.assert_allclose(body @ radial, [0.0, 0.0, -1.0], atol=1e-9)
    np.testing.assert_allclose(body @ along, [1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.slow
def test_flights_slew_back_too(plan):
    """A flight without errors ends at the law; with them the filter stays as good as it claims."""
    early = {"convergence": {"window": 60.0, "relative_decrease": 0.3}}
    scenario = Scenario.from_dict(TABLE | early)
    short = ManeuverPlan(scenario, DESIGN)
    assert short.t_end < short.duration < 900.0
    model, n = short.problem.model, round(short.duration)
    exact = simulate_motion(model, short.slew_back.design, build_zero_errors(model, 900))
    np.testing.assert_allclose(
        (exact.motion.attitude @ exact.initial_rotation)[: n + 1],
        short.attitude,
        rtol=0,
        atol=1e-12,
    )
    law, rate = scenario.initial.evaluate_law(scenario, short.duration)
    np.testing.assert_allclose(exact.motion.attitude[n], law, rtol=0, atol=1e-9)
    np.testing.assert_allclose(exact.motion.rates[n:], np.tile(rate, (900 - n, 1)), atol=1e-15)

    runs = simulate(scenario, DESIGN, n_runs=60, seed=3)
    held = Motion.from_design(model, DESIGN, 900)
    assert np.abs(held.attitude[n] - law).max() > 0.1
    assert runs.t_end == short.t_end
    for time in (short.t_end, short.duration, 900.0):
        nees = runs.nees[:, runs.find_sample(time)].mean() / runs.n_states
        assert nees == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / (60 * runs.n_states)))
    # what the plan predicts is of the flight with the slew, not of the rate that is held
    k = runs.find_sample(900.0)
    assert runs.rms[k] / runs.predicted_sigma[k] == pytest.approx(1.0, abs=0.45)


@pytest.mark.slow
def test_path_limits_are_looked_at_until_the_end(plan):
    """Angles on the way back, in the plan's own table."""
    axis = (0.0, 1.0, 0.0)
    limits = (
        PathConstraint(boresight=axis, half_angle_deg=10.0, attitude_sigmas=0.0),
        PathConstraint(name="sure", boresight=axis, half_angle_deg=10.0, attitude_sigmas=2.0),
        PathConstraint(
            name="dish",
            reference="earth",
            sense="keep-in",
            boresight=(1.0, 0.0, 0.0),
            half_angle_deg=100.0,
            attitude_sigmas=0.0,
        ),
    )
    watched = ManeuverPlan(dataclasses.replace(plan.scenario, path_constraints=limits), DESIGN)
    scenario, first, last = watched.scenario, round(plan.t_end), round(plan.duration)
    long = Environment.from_scenario(dataclasses.replace(scenario, duration=float(last)))
    distance = np.linalg.norm(long.position, axis=1)[first:]
    sun, down = (
        np.einsum("kij,kj->ki", watched.attitude[first:], vectors)
        for vectors in (long.sun[first:], -long.position[first:] / distance[:, None])
    )
    off = np.degrees(np.arccos(sun[:, 1]))
    normal = np.cross(axis, sun) / np.linalg.norm(np.cross(axis, sun), axis=1)[:, None]
    known = plan.history.covariance[:3, :3]
    sigma = np.degrees(np.sqrt(np.einsum("ki,ij,kj->k", normal, known, normal)))
    limb = np.degrees(np.arccos(down[:, 0]) - np.arcsin(6378136.3 / distance))
    expected = {
        "Sun off payload": (off.min(), off.min() - 10.0),
        "Sun off sure": ((off - 2.0 * sigma).min(), (off - 2.0 * sigma).min() - 10.0),
        "Earth in dish": (limb.max(), 100.0 - limb.max()),
    }
    table = watched.build_constraint_table()
    for label, (value, margin) in expected.items():
        row = table.loc[f"{label} in the slew back"]
        assert row["value"] == pytest.approx(value, abs=1e-6)
        assert row["margin"] == pytest.approx(margin, abs=1e-6)
        assert row["satisfied"] == (margin >= 0.0)
    assert table.index.name == "constraint"
    assert from_json(to_json(watched)) == watched


@pytest.mark.slow
def test_the_attitude_at_the_end_is_within_a_tolerance(plan):
    """Of what filterpy knows at the end of the slew, beyond the duration or not."""
    found = []
    for duration in (900.0, 2000.0):
        table = TABLE | {"duration": duration}
        maneuvers = TABLE["maneuvers"] | {"end_tolerance_deg": 1.0}
        ended = ManeuverPlan(Scenario.from_dict(table | {"maneuvers": maneuvers}), DESIGN)
        # directions are interpolated over the duration: those of the same, to the last step
        longest = max(duration, ended.duration)
        whole = FilterModel.from_scenario(Scenario.from_dict(table | {"duration": longest}))
        until_end = whole.select_samples(slice(0, round(ended.duration / whole.step) + 1))
        run = run_reference_filter(until_end.full_duration_model, ended.trajectory.commanded_design)
        expected = 3.0 * np.degrees(np.sqrt(np.linalg.eigvalsh(run.covariance[:3, :3])[-1]))
        row = ended.build_constraint_table().loc[END_ATTITUDE]
        assert row["value"] == pytest.approx(expected, rel=1e-9)
        assert row["satisfied"] == (expected < 1.0)
        maneuvers = maneuvers | {"end_tolerance_deg": 0.99 * expected}
        ended = ManeuverPlan(Scenario.from_dict(table | {"maneuvers": maneuvers}), DESIGN)
        assert any(END_ATTITUDE in each for each in ended.list_violations())
        found.append(ended.duration > duration)
    assert found == [True, False]
    with pytest.raises(InvalidValue, match=r"end_tolerance_deg = 0.5: .*without slew_back"):
        Scenario.from_dict({"preset": "paper", "maneuvers": {"end_tolerance_deg": 0.5}})


def test_a_plan_that_cannot_slew_back_in_time_exceeds_a_limit():
    table = {"preset": "cubesat_6u", "duration": 600.0, "initial": {"pointing": "nadir"}}
    table |= {"maneuvers": {"count": 3, "max_rate_deg_s": 0.065, "slew_back": True}}
    table["convergence"] = {"rule": "trace"}
    table["path_constraints"] = [{"boresight": [0.0, 0.0, -1.0], "half_angle_deg": 1.0}]
    still = np.zeros(12)
    row = AttitudeManeuverProblem(Scenario.from_dict(table)).view([still]).constraints()[0].iloc[-1]
    assert (row.name, row["value"], row["bound_value"]) == ("time of the slew back", np.inf, 600.0)
    assert row["margin"] < 0.0


def test_wheels_with_a_budget_are_looked_at_until_the_end(plan):
    """Their load on the way back, from a run that is long enough to end with it."""
    wheels = Wheels(
        inertia=(3.0, 2.0, 1.0),
        initial_momentum=(0.02, -0.01, 0.03),
        gravity_gradient=True,
        max_momentum=0.15,
        max_torque=0.01,
        ramp_share=0.5,
    )
    loaded = ManeuverPlan(dataclasses.replace(plan.scenario, wheels=wheels), DESIGN)
    back, step = loaded.slew_back, loaded.scenario.step
    long = dataclasses.replace(loaded.scenario, duration=back.end + 10.0)
    model = FilterModel.from_scenario(long)
    flown = model.build_schedule(back.design)
    table, ends = loaded.build_constraint_table(), np.array([round(back.end / step)])
    whole = compute_wheel_loads(model.momentum_budget, flown, ends, step, 1)[0]
    until = compute_wheel_loads(
        model.momentum_budget, flown, np.array([round(back.start / step)]), step, 1
    )[0]
    for column, label in enumerate(("wheel momentum", "wheel torque")):
        row = table.loc[f"{label} in the slew back"]
        assert max(row["value"], until[column]) == pytest.approx(whole[column], rel=1e-12)
        assert row["margin"] == pytest.approx(row["bound_value"] - row["value"], rel=1e-12)
    assert 0.0 < row["value"] <= 0.01 * 1.5
