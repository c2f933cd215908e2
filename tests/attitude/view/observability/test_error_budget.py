"""Error budgets, improvements and measurement times of plans."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import FilterModel, Scenario, run_filter
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.sensors.suite import list_block_units

DESIGN = (0.4, -0.2, 0.1, 300.0, 0.3, 0.5, -0.4, 200.0, -0.6, 0.1, 0.2, 100.0)


@pytest.fixture(scope="module")
def plan():
    changes = {"eclipse": True, "duration": 2400.0, "step": 4.0}
    scenario = dataclasses.replace(Scenario.paper(), **changes)
    end = dataclasses.replace(scenario.convergence, rule="settling", factor=1.0 + 1e-9)
    return ManeuverPlan(dataclasses.replace(scenario, convergence=end), DESIGN)


def test_squares_of_contributions_add_up_to_worst_axis(plan):
    table = plan.compute_error_budget()
    parts, total = table.iloc[:-1].to_numpy(), table.loc["all"].to_numpy()
    np.testing.assert_allclose((parts**2).sum(axis=0), total**2, rtol=1e-12)
    worst = plan.build_accuracy_table()["after"].to_numpy().reshape(-1, 3).max(axis=1)
    np.testing.assert_allclose(total, worst, rtol=1e-9)


def compute_worst_sigma(model, design, t_end):
    """Return the worst-axis 1-sigmas of a design at a time by the filter history, in display
    units.
    """
    history = run_filter(model.full_duration_model, design)
    sigma = history.sigma[round(t_end / model.step)].reshape(-1, 3).max(axis=1)
    return sigma * [unit.factor for unit in list_block_units(model.suite)]


def test_improvements_equal_runs_of_changed_scenarios(plan):
    """Each change is made in the scenario instead of the filter model."""
    scenario, table, t_end = plan.scenario, plan.evaluate_improvements(), plan.t_end
    sun, mag = scenario.sensors
    gyro = scenario.gyro
    changed = {
        "unchanged": {},
        "initial attitude": {"initial": dataclasses.replace(scenario.initial, attitude_deg=2.5)},
        "Sun sensor noise": {"sensors": (dataclasses.replace(sun, noise_deg=1.0), mag)},
        "gyro noise": {"gyro": dataclasses.replace(gyro, angle_random_walk_deg_per_sqrt_h=0.005)},
        "gyro bias drift": {"gyro": dataclasses.replace(gyro, rate_random_walk=1.5e-8)},
    }
    for name, changes in changed.items():
        model = FilterModel.from_scenario(dataclasses.replace(scenario, **changes))
        np.testing.assert_allclose(
            table.loc[name], compute_worst_sigma(model, DESIGN, t_end), rtol=1e-9
        )


def test_additional_rotation_is_an_additional_maneuver(plan):
    scenario = dataclasses.replace(
        plan.scenario, convergence=dataclasses.replace(plan.scenario.convergence, rule="end")
    )
    short = ManeuverPlan(scenario, DESIGN)
    assert short.t_end == 600.0
    table, max_rate = short.evaluate_improvements(), scenario.maneuvers.max_rate_deg_s
    for name, more in {
        "last rate": (*DESIGN[-4:-1], 300.0),
        "about y": (0.0, max_rate, 0.0, 300.0),
    }.items():
        expected = compute_worst_sigma(short.problem.model, (*DESIGN, *more), 900.0)
        np.testing.assert_allclose(table.loc[f"300 s more, {name}"], expected, rtol=1e-9)


def test_sun_sensor_measures_only_outside_eclipse(plan):
    times = plan.compute_measurement_times()
    assert times["duration [s]"].sum() == pytest.approx(plan.t_end)
    sunlit = plan.problem.environment.sunlit[1 : len(plan.history.times)].sum() * 4.0
    assert times["sun [s]"].sum() == pytest.approx(sunlit)
    assert 0.0 < sunlit < plan.t_end
    assert (times["mag [s]"] == times["duration [s]"]).all()
