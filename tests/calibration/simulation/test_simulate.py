"""Monte Carlo runs as a whole: reproducible, consistent, and not so when the filter is broken."""

import dataclasses
import json
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from mgeo_attitude import (
    Environment,
    Gyro,
    Scenario,
    SunSensor,
    World,
)
from mgeo_attitude.maneuvers.motion import Motion
from mgeo_attitude.scenario.convergence import Convergence
from mgeo_calibration import consistency, simulate
from mgeo_calibration.estimation.taylor import Taylor
from mgeo_calibration.simulation.flights import RUNS, planned
from pydantic.dataclasses import dataclass

PLANS = json.loads((Path(__file__).parent / "plans.json").read_text(encoding="utf-8"))
SCENARIOS = Path(__file__).parents[3] / "docs" / "scenarios"  # as they were when these were found
PLAN = np.array([0.5, -0.3, 0.8, 80.3, -0.7, 0.9, 0.1, 60.0, 0.2, 0.4, -0.9, 500.0])


def short(scenario, duration=600.0, **changes):
    return dataclasses.replace(
        scenario, duration=duration, convergence=Convergence(window=200.0), **changes
    )


@pytest.fixture(scope="module")
def paper():
    """The paper's scenario cut short, with its environment."""
    scenario = short(Scenario.paper())
    return scenario, Environment.from_scenario(scenario)


@pytest.fixture(scope="module")
def brief():
    """The same, cut shorter: for what shows from the first step on."""
    scenario = short(Scenario.paper(), 200.0)
    return scenario, Environment.from_scenario(scenario)


def run(paper, n_runs=60, **options):
    scenario, environment = paper
    return simulate(scenario, PLAN, n_runs, seed=7, environment=environment, **options)


@pytest.mark.slow
def test_a_run_is_the_same_however_many_run_beside_it(brief):
    one, two = run(brief, 5), run(brief, RUNS + 1)
    alone = run(brief, 1)
    for name in ("errors", "sigma", "nees", "nis", "updates"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name)[:5])
        np.testing.assert_array_equal(getattr(alone, name), getattr(one, name)[:1])
    assert not np.array_equal(one.errors[0], one.errors[1])
    np.testing.assert_array_equal(one.predicted, two.predicted)


@pytest.mark.slow
@pytest.mark.parametrize("considered", [(), ("field_error",)])
def test_errors_that_vary_are_estimated_or_considered_consistently(paper, considered):
    scenario, environment = paper
    world = World(
        albedo=0.05,
        albedo_correlation_time=60.0,
        field_error_nt=1000.0,
        field_error_correlation_time=30.0,
        orbit_error_m=(5000.0, 5000.0, 5000.0),
        considered=considered,
    )
    result = run((dataclasses.replace(scenario, world=world), environment), 40)
    assert result.blocks[2:5] == ("world.albedo", "world.field_error", "world.orbit_error")
    report = consistency(result, since=200.0)
    assert report["nees"].passed, report.table()
    assert report["nis sun"].passed, report.table()
    # innovations of a filter that leaves an error as it is are not independent: no bounds hold
    assert considered or report["nis mag"].passed, report.table()


@pytest.mark.slow
def test_errors_are_what_the_filter_claims(paper):
    report = consistency(run(paper, 200), since=200.0)
    assert report.passed, report.table()


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize(
    ("preset", "file"),
    [
        pytest.param("paper", "paper-1-percent", marks=pytest.mark.campaign),
        ("cubesat_6u", "cubesat-6u-with-rises"),
    ],
    ids=["paper", "cubesat_6u"],
)
def test_plans_of_a_front_are_consistent(preset, file):
    """Two orbits of a plan, 30 runs; docs/consistency.md has all plans with 200."""
    plan = PLANS["scenarios"][preset][2]
    scenario = Scenario.from_toml(SCENARIOS / f"{file}.toml")
    result = simulate(scenario, plan["design"], 30, seed=11)
    assert result.t_end == plan["t_end"]
    report = consistency(result)
    assert report["nees"].passed, report.table()
    assert all(report[f"nis {sensor}"].passed for sensor in result.sensors), report.table()


@pytest.mark.slow
def test_a_filter_that_believes_in_too_little_noise_is_found_out(paper):
    scenario, _ = paper
    loud = tuple(
        dataclasses.replace(
            s, **{k: 1.3 * getattr(s, k) for k in ("noise_deg", "noise_nt") if hasattr(s, k)}
        )
        for s in scenario.sensors
    )
    report = consistency(run(paper, truth=dataclasses.replace(scenario, sensors=loud)), since=200.0)
    assert not report["nees"].passed
    assert report["nis sun"].value == pytest.approx(1.3**2, rel=0.05)
    assert report["nis mag"].value == pytest.approx(1.3**2, rel=0.05)
    assert not report.passed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"duration": 700.0}, r"truth\.duration = 700\.0: expected the scenario's 600\.0"),
        ({"gyro": Gyro(initial_scale_factor=1e-3)}, "truth has the states .*scale_factor"),
        ({"sensors": Scenario.paper().sensors[:1]}, r"truth has the sensors \['sun'\]: expected"),
        (
            {"sensors": (SunSensor(name="s"), *Scenario.paper().sensors[1:])},
            r"truth has the sensors \['s', 'mag'\]: expected the scenario's \['sun', 'mag'\]",
        ),
    ],
)
def test_what_truth_and_estimator_share_is_named(paper, changes, message):
    scenario, _ = paper
    with pytest.raises(ValueError, match=message):
        run(paper, 1, truth=dataclasses.replace(scenario, **changes))


@dataclass(frozen=True)
class Backwards(SunSensor):
    """A Sun sensor whose innovation has its derivative's sign wrong, and all else right."""

    kind: ClassVar[str] = "backwards"

    def innovation(self, measured: Any, predicted: Any) -> Taylor:
        return measured - 2.0 * predicted.value.T + predicted


@pytest.mark.slow
def test_a_wrong_sign_of_one_jacobian_is_found_out(paper):
    scenario, environment = paper
    broken = dataclasses.replace(scenario, sensors=(Backwards(),))
    report = consistency(run((broken, environment), 20), since=200.0)
    assert report["nees"].value > 10.0
    assert not report.passed


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((PLAN, 0), {}, "n_runs = 0"),
        ((np.stack([PLAN, PLAN]), 1), {}, r"design of shape \(2, 12\)"),
        ((PLAN[:5], 1), {}, "expected 4 columns"),
    ],
)
def test_bad_arguments_are_named(paper, arguments, options, message):
    scenario, environment = paper
    with pytest.raises(ValueError, match=message):
        simulate(scenario, *arguments, environment=environment, **options)


@pytest.mark.slow
def test_coils_fly_each_flight_as_the_field_of_its_attitude_lets_them():
    """Not at the plan's rates; and a run is the same whatever others are beside it."""
    scenario = short(Scenario.cubesat_1u(), 300.0)
    design = np.array([1.0, -2.0, 0.5, 100.0, -1.0, 1.0, 2.0, 100.0, 0.0, 0.0, 1.0, 100.0])
    of = planned(scenario, design, 2, None, None)
    flights = [of.flight(generator) for generator in np.random.default_rng(1).spawn(2)]
    for flight in flights:
        true = of.model.turned(flight.start.T)
        expected = Motion.of(true, design, of.model.n_steps)
        np.testing.assert_array_equal(flight.motion.rates, expected.rates)
        assert np.degrees(np.abs(flight.motion.rates - of.motion.rates).max()) > 0.01
    two, three = (simulate(scenario, design, n, 1) for n in (2, 3))
    np.testing.assert_array_equal(two.errors, three.errors[:2])
