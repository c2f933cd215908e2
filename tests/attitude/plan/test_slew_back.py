"""Plans with a slew back: tables, files, constraints and simulations."""

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
from .test_aem import rotation_matrix, to_epoch

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
def plan_without_slew_back():
    table = TABLE | {"maneuvers": {"max_acceleration_deg_s2": 0.05}}
    return ManeuverPlan(Scenario.from_dict(table), DESIGN)


def test_slew_back_does_not_affect_convergence(plan, plan_without_slew_back):
    """Results until convergence are equal; only the plan is longer."""
    assert (plan.t_end, plan.trace) == (plan_without_slew_back.t_end, plan_without_slew_back.trace)
    assert plan_without_slew_back.duration == plan_without_slew_back.t_end < plan.duration
    X = np.array([DESIGN])
    F = [
        each.problem.evaluate(X, return_values_of=["F"]) for each in (plan, plan_without_slew_back)
    ]
    np.testing.assert_array_equal(*F)
    for name in ("build_accuracy_table", "compute_uncertainty_by_phase", "find_least_observable"):
        assert getattr(plan, name)().equals(getattr(plan_without_slew_back, name)())
    assert plan.compare_with_designs().equals(plan_without_slew_back.compare_with_designs())


def test_exported_plan_ends_nadir_pointing(plan):
    aem = brahe.ccsds.AEM.from_str(format_aem(plan, version="2.0"))
    last = len(aem.segments) - 1
    assert len(aem.segments) == len(plan.phases)
    body = rotation_matrix(aem.segment_to_attitude_trajectory(last), to_epoch(plan, plan.duration))
    scenario = plan.scenario
    position, velocity = scenario.orbit.propagate(scenario.epoch, np.array([plan.duration]))
    radial, along, _ = brahe.rotation_eci_to_rtn(np.append(position, velocity))
    np.testing.assert_allclose(body @ radial, [0.0, 0.0, -1.0], atol=1e-9)
    np.testing.assert_allclose(body @ along, [1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.slow
def test_simulated_runs_slew_back(plan):
    """A run without errors ends at the attitude law. With errors the filter remains consistent."""
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
    hold = Motion.from_design(model, DESIGN, 900)
    assert np.abs(hold.attitude[n] - law).max() > 0.1
    assert runs.t_end == short.t_end
    for time in (short.t_end, short.duration, 900.0):
        nees = runs.nees[:, runs.find_sample(time)].mean() / runs.n_states
        assert nees == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / (60 * runs.n_states)))
    # The prediction includes the slew back instead of a hold of the last rate.
    k = runs.find_sample(900.0)
    assert runs.rms[k] / runs.predicted_sigma[k] == pytest.approx(1.0, abs=0.45)


@pytest.mark.slow
def test_path_constraints_are_evaluated_during_slew_back(plan):
    axis = (0.0, 1.0, 0.0)
    constraints = (
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
    constrained_plan = ManeuverPlan(
        dataclasses.replace(plan.scenario, path_constraints=constraints), DESIGN
    )
    scenario, first, last = constrained_plan.scenario, round(plan.t_end), round(plan.duration)
    long = Environment.from_scenario(dataclasses.replace(scenario, duration=float(last)))
    distance = np.linalg.norm(long.position, axis=1)[first:]
    sun, down = (
        np.einsum("kij,kj->ki", constrained_plan.attitude[first:], vectors)
        for vectors in (long.sun[first:], -long.position[first:] / distance[:, None])
    )
    off = np.degrees(np.arccos(sun[:, 1]))
    normal = np.cross(axis, sun) / np.linalg.norm(np.cross(axis, sun), axis=1)[:, None]
    covariance = plan.history.covariance[:3, :3]
    sigma = np.degrees(np.sqrt(np.einsum("ki,ij,kj->k", normal, covariance, normal)))
    limb = np.degrees(np.arccos(down[:, 0]) - np.arcsin(6378136.3 / distance))
    expected = {
        "Sun off payload": (off.min(), off.min() - 10.0),
        "Sun off sure": ((off - 2.0 * sigma).min(), (off - 2.0 * sigma).min() - 10.0),
        "Earth in dish": (limb.max(), 100.0 - limb.max()),
    }
    table = constrained_plan.build_constraint_table()
    for label, (value, margin) in expected.items():
        row = table.loc[f"{label} in the slew back"]
        assert row["value"] == pytest.approx(value, abs=1e-6)
        assert row["margin"] == pytest.approx(margin, abs=1e-6)
        assert row["satisfied"] == (margin >= 0.0)
    assert table.index.name == "constraint"
    assert from_json(to_json(constrained_plan)) == constrained_plan


@pytest.mark.slow
def test_final_attitude_uncertainty_is_constrained(plan):
    """The value equals that of filterpy, whether or not the slew back ends within the duration."""
    found = []
    for duration in (900.0, 2000.0):
        table = TABLE | {"duration": duration}
        maneuvers = TABLE["maneuvers"] | {"end_tolerance_deg": 1.0}
        ended = ManeuverPlan(Scenario.from_dict(table | {"maneuvers": maneuvers}), DESIGN)
        # Directions are interpolated over the duration, so that both runs need the same duration.
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


def test_slew_back_that_does_not_fit_violates_constraint():
    table = {"preset": "cubesat_6u", "duration": 600.0, "initial": {"pointing": "nadir"}}
    table |= {"maneuvers": {"count": 3, "max_rate_deg_s": 0.065, "slew_back": True}}
    table["convergence"] = {"rule": "trace"}
    table["path_constraints"] = [{"boresight": [0.0, 0.0, -1.0], "half_angle_deg": 1.0}]
    design = np.zeros(12)
    row = (
        AttitudeManeuverProblem(Scenario.from_dict(table)).view([design]).constraints()[0].iloc[-1]
    )
    assert (row.name, row["value"], row["bound_value"]) == ("time of the slew back", np.inf, 600.0)
    assert row["margin"] < 0.0


def test_wheel_budget_is_evaluated_during_slew_back(plan):
    """The load equals that of a run which is long enough to contain the slew back."""
    wheels = Wheels(
        inertia=(3.0, 2.0, 1.0),
        initial_momentum=(0.02, -0.01, 0.03),
        gravity_gradient=True,
        max_momentum=0.15,
        max_torque=0.01,
        ramp_share=0.5,
    )
    loaded = ManeuverPlan(dataclasses.replace(plan.scenario, wheels=wheels), DESIGN)
    slew_back, step = loaded.slew_back, loaded.scenario.step
    long = dataclasses.replace(loaded.scenario, duration=slew_back.end + 10.0)
    model = FilterModel.from_scenario(long)
    schedule = model.build_schedule(slew_back.design)
    table, ends = loaded.build_constraint_table(), np.array([round(slew_back.end / step)])
    whole = compute_wheel_loads(model.momentum_budget, schedule, ends, step, 1)[0]
    until = compute_wheel_loads(
        model.momentum_budget, schedule, np.array([round(slew_back.start / step)]), step, 1
    )[0]
    for column, label in enumerate(("wheel momentum", "wheel torque")):
        row = table.loc[f"{label} in the slew back"]
        assert max(row["value"], until[column]) == pytest.approx(whole[column], rel=1e-12)
        assert row["margin"] == pytest.approx(row["bound_value"] - row["value"], rel=1e-12)
    assert 0.0 < row["value"] <= 0.01 * 1.5
