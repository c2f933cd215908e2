"""Monte Carlo simulations: reproducible, consistent, and inconsistent with a wrong filter model."""

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


def shorten(scenario, duration=600.0, **changes):
    return dataclasses.replace(
        scenario, duration=duration, convergence=Convergence(window=200.0), **changes
    )


@pytest.fixture(scope="module")
def paper():
    """The paper's scenario with a duration of 600 s, and its environment."""
    scenario = shorten(Scenario.paper())
    return scenario, Environment.from_scenario(scenario)


@pytest.fixture(scope="module")
def brief():
    """The paper's scenario with a duration of 200 s, and its environment."""
    scenario = shorten(Scenario.paper(), 200.0)
    return scenario, Environment.from_scenario(scenario)


def run(paper, n_runs=60, **options):
    scenario, environment = paper
    return simulate(scenario, PLAN, n_runs, seed=7, environment=environment, **options)


@pytest.mark.slow
def test_run_does_not_depend_on_number_of_runs(brief):
    five, many = run(brief, 5), run(brief, RUNS_PER_BATCH + 1)
    single = run(brief, 1)
    for name in ("errors", "sigma", "nees", "nis", "n_innovations"):
        np.testing.assert_array_equal(getattr(five, name), getattr(many, name)[:5])
        np.testing.assert_array_equal(getattr(single, name), getattr(five, name)[:1])
    assert not np.array_equal(five.errors[0], five.errors[1])
    np.testing.assert_array_equal(five.predicted_sigma, many.predicted_sigma)


@pytest.mark.slow
@pytest.mark.parametrize("considered", [(), ("field_error",)])
def test_varying_errors_are_consistent_when_estimated_or_considered(paper, considered):
    scenario, environment = paper
    environment_errors = EnvironmentErrors(
        albedo=0.05,
        albedo_correlation_time=60.0,
        field_error_nt=1000.0,
        field_error_correlation_time=30.0,
        orbit_error_m=(5000.0, 5000.0, 5000.0),
        considered=considered,
    )
    result = run(
        (dataclasses.replace(scenario, environment_errors=environment_errors), environment), 40
    )
    assert result.blocks[2:5] == (
        "environment_errors.albedo",
        "environment_errors.field_error",
        "environment_errors.orbit_error",
    )
    report = evaluate_consistency(result, start_time=200.0)
    assert report.loc["nees", "passed"], report
    assert report.loc["nis sun", "passed"], report
    # Innovations of a filter with considered states are not independent, so that the bounds do not
    # apply.
    assert considered or report.loc["nis mag", "passed"], report


@pytest.mark.slow
def test_errors_are_consistent_with_filter_covariance(paper):
    report = evaluate_consistency(run(paper, 200), start_time=200.0)
    assert report["passed"].all(), report


@pytest.mark.slow
def test_underestimated_noise_fails_consistency_tests(paper):
    scenario, _ = paper
    noisy_sensors = tuple(
        dataclasses.replace(
            s, **{k: 1.3 * getattr(s, k) for k in ("noise_deg", "noise_nt") if hasattr(s, k)}
        )
        for s in scenario.sensors
    )
    report = evaluate_consistency(
        run(paper, truth=dataclasses.replace(scenario, sensors=noisy_sensors)), start_time=200.0
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
def test_truth_with_other_states_or_sensors_raises(paper, changes, message):
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
def test_invalid_arguments_raise(paper, arguments, options, message):
    scenario, environment = paper
    with pytest.raises(ValueError, match=message):
        simulate(scenario, *arguments, environment=environment, **options)
