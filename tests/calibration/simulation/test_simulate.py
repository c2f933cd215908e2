"""Monte Carlo runs as a whole: reproducible, consistent, and not so when the filter is broken."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import (
    Environment,
    EnvironmentErrors,
    Gyro,
    Scenario,
    SunSensor,
)
from mgeo_attitude.scenario.criteria import Convergence
from mgeo_calibration import evaluate_consistency, simulate
from mgeo_calibration.simulation.simulate import RUNS_PER_BATCH

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
    one, two = run(brief, 5), run(brief, RUNS_PER_BATCH + 1)
    alone = run(brief, 1)
    for name in ("errors", "sigma", "nees", "nis", "n_innovations"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name)[:5])
        np.testing.assert_array_equal(getattr(alone, name), getattr(one, name)[:1])
    assert not np.array_equal(one.errors[0], one.errors[1])
    np.testing.assert_array_equal(one.predicted_sigma, two.predicted_sigma)


@pytest.mark.slow
@pytest.mark.parametrize("considered", [(), ("field_error",)])
def test_errors_that_vary_are_estimated_or_considered_consistently(paper, considered):
    scenario, environment = paper
    world = EnvironmentErrors(
        albedo=0.05,
        albedo_correlation_time=60.0,
        field_error_nt=1000.0,
        field_error_correlation_time=30.0,
        orbit_error_m=(5000.0, 5000.0, 5000.0),
        considered=considered,
    )
    result = run((dataclasses.replace(scenario, environment_errors=world), environment), 40)
    assert result.blocks[2:5] == (
        "environment_errors.albedo",
        "environment_errors.field_error",
        "environment_errors.orbit_error",
    )
    report = evaluate_consistency(result, start_time=200.0)
    assert report.loc["nees", "passed"], report
    assert report.loc["nis sun", "passed"], report
    # innovations of a filter that leaves an error as it is are not independent: no bounds hold
    assert considered or report.loc["nis mag", "passed"], report


@pytest.mark.slow
def test_errors_are_what_the_filter_claims(paper):
    report = evaluate_consistency(run(paper, 200), start_time=200.0)
    assert report["passed"].all(), report


@pytest.mark.slow
def test_a_filter_that_believes_in_too_little_noise_is_found_out(paper):
    scenario, _ = paper
    loud = tuple(
        dataclasses.replace(
            s, **{k: 1.3 * getattr(s, k) for k in ("noise_deg", "noise_nt") if hasattr(s, k)}
        )
        for s in scenario.sensors
    )
    report = evaluate_consistency(
        run(paper, truth=dataclasses.replace(scenario, sensors=loud)), start_time=200.0
    )
    assert not report.loc["nees", "passed"]
    assert report.loc["nis sun", "value"] == pytest.approx(1.3**2, rel=0.05)
    assert report.loc["nis mag", "value"] == pytest.approx(1.3**2, rel=0.05)
    assert not report["passed"].all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gyro": Gyro(initial_scale_factor=1e-3)}, "truth has the states .*scale_factor"),
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
