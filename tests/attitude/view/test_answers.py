"""The line that a plan comes to, against the slow filter's run of it."""

import re

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario, reference_run
from mgeo_attitude.view.describe import two_digits

DEG = 180.0 / np.pi


@pytest.fixture(scope="module")
def problem():
    table = {"preset": "cubesat_6u", "step": 4.0, "convergence": {"rule": "trace"}}
    return AttitudeManeuverProblem(Scenario.from_dict(table))


@pytest.fixture(scope="module")
def X(problem):
    rng = np.random.default_rng(4)
    return rng.uniform(problem.xl, problem.xu, (3, problem.n_var))


def in_seconds(text):
    seconds = {"h": 3600, "min": 60, "s": 1}
    return sum(int(value) * seconds[unit] for value, unit in re.findall(r"(\d+) (\w+)", text))


@pytest.mark.slow
def test_numbers_are_those_of_the_reference_filter(problem, X):
    for x, line in zip(X, problem.view(X).answers(), strict=True):
        history = reference_run(problem.model, x)
        found = re.fullmatch(
            r"(.*); then attitude (\S+) deg, gyro bias (\S+) deg/h, sun bias (\S+) arcmin, "
            r"mag bias (\S+) nT \(1-sigma, worst body axis\); "
            r"9 of 10 Monte Carlo runs converge within (.*)",
            line,
        )
        assert found, line
        assert in_seconds(found[1]) == history.t_end
        assert in_seconds(found[6]) == problem.view(x[None]).promises()["kept t_end [s]"][0]
        sigma = history.sigma[-1].reshape(-1, 3).max(axis=1)
        expected = [DEG * sigma[0], DEG * 3600 * sigma[1], DEG * 60 * sigma[3], 50e3 * sigma[5]]
        shown = [float(text) for text in found.groups()[1:5]]
        np.testing.assert_allclose(shown, expected, rtol=0.05)  # of two digits


@pytest.mark.parametrize("objectives", [["t_end", "trace"], ["t_end", "trace", "rate_change"]])
def test_where_the_end_is_the_plans_own_what_is_kept_is_how_well_the_attitude_is_known(objectives):
    table = {"preset": "cubesat_6u", "duration": 600.0, "maneuvers": {"count": 1}}
    scenario = Scenario.from_dict(table | {"objectives": objectives})
    view = AttitudeManeuverProblem(scenario).view([[1.0, 0.2, -0.5, 60.0], [1.0, 0.2, -0.5, 599.0]])
    assert view.exactly.t_end.tolist() == [60.0, 599.0]
    for line, kept in zip(view.answers(), view.kept_sigma_deg, strict=True):
        assert line.endswith(f"; attitude {two_digits(kept)} deg in 9 of 10 Monte Carlo runs")
        assert "converge" not in line
    ratio = view.promises()["kept / promised trace [-]"]
    (line, *_) = view.remarks()
    assert f"trace [-] in these runs to the plan's is {ratio.median():.3g} in" in line
