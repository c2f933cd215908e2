"""Report of a run of the attitude problem."""

import dataclasses

import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan

from mgeo.report.build import build_report_html
from mgeo.store.run_folder import write_run

from ..browser import opened
from .small_run import small_run


@pytest.mark.slow
def test_report_contains_small_figures_once(tmp_path):
    scenario = dataclasses.replace(
        Scenario.paper(), duration=2400.0, step=4.0, name="</script>short"
    )
    run = small_run(AttitudeManeuverProblem(scenario))
    write_run(tmp_path / "run", run)
    html = build_report_html(tmp_path / "run")
    for title in ("Body rates", "Directions in the body frame", "Gyro bias, predicted 1-sigma"):
        assert html.count(title) == 1  # Titles that all plans share appear once.
    assert html.count("</script>") == 3


#: JavaScript expression for the body axes x, y and z in inertial axes.
_AXES = """[...document.querySelector(".moving .js-plotly-plot").data].slice(-3)
  .map(({ x, y, z }) => [x[1], y[1], z[1]])
  .map((tip) => tip.map((part) => part / Math.hypot(...tip)))"""


@pytest.mark.slow
def test_animation_on_phone_equals_filter_attitude(tmp_path):
    scenario = Scenario.cubesat_6u()
    maneuvers = dataclasses.replace(scenario.maneuvers, max_acceleration_deg_s2=0.02)
    problem = AttitudeManeuverProblem(
        dataclasses.replace(scenario, duration=2400.0, maneuvers=maneuvers)
    )
    run = small_run(problem)
    write_run(tmp_path / "run", run)
    path = tmp_path / "report.html"
    path.write_text(build_report_html(tmp_path / "run"), encoding="utf-8")
    with opened(path, 390, color_scheme="dark") as page:
        page.evaluate("document.querySelector('.moving').scrollIntoView()")
        page.until("document.querySelector('.player') !== null")
        row = int(page.evaluate("document.body.dataset.shown"))
        plan = ManeuverPlan.from_design(problem, run.outcome.X[row])
        for time in (0.0, plan.t_end / 3, plan.t_end):
            step = round(time / problem.model.step)
            page.set(".player input", step * problem.model.step)
            # Within a ramp the animation may be off by up to one degree.
            atol = 0.02 if 0 < time < plan.t_end else 1e-5
            page.until_close(_AXES, plan.history.attitude[step], atol)
        assert page.evaluate("document.documentElement.scrollWidth") == 390
        assert page.errors() == []
