"""The report of a run of this problem: a plan for every point, within its size."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario

from mgeo.report import report_html
from mgeo.report.encode import script_json
from mgeo.report.solutions import plans_json
from mgeo.runs import write_run

from .small_run import small_run

_PLOTLY = 4.9e6  # bytes of plotly.js


@pytest.mark.slow
@pytest.mark.parametrize("scenario", [Scenario.paper(), Scenario.cubesat_6u()])
def test_three_hundred_plans_stay_below_eight_megabytes(scenario):
    scenario = dataclasses.replace(
        scenario,
        maneuvers=dataclasses.replace(scenario.maneuvers, max_acceleration_deg_s2=0.01),
    )
    problem = AttitudeManeuverProblem(scenario)
    run = small_run(problem)
    X = run.outcome.X
    found = plans_json(problem, X, np.arange(len(X)))
    each = len(script_json(found["values"])) / len(X)
    common = len(script_json(found["common"]))
    row = 20 * (problem.n_var + problem.n_obj) + 1200  # its line of the table, what is said of it
    assert _PLOTLY + common + 300 * (each + row) < 8e6


def test_each_point_of_the_front_has_its_plan(tmp_path):
    scenario = dataclasses.replace(Scenario.paper(), duration=2400.0, name="</script>short")
    run = small_run(AttitudeManeuverProblem(scenario))
    write_run(tmp_path / "run", run)
    html = report_html(tmp_path / "run")
    for title in ("Body rates", "Sun and field seen from the body", "gyro bias, 1-sigma"):
        assert html.count(title) == 1  # what all plans have in common is there once
    assert html.count("</script>") == 3
