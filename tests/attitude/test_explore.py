"""Explorer of a run: quick metrics and saved plans."""

import json

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, from_json
from selenium.webdriver import Keys
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.report import build_comparison_html
from mgeo.store.atomic import encode_json
from mgeo.store.run_folder import write_run
from mgeo.store.solution_file import build_solution_document, parse_solution

from ..browser import opened
from ..mgeo.explore.test_server import served
from .small_run import small_run


@pytest.fixture(scope="module")
def problem():
    return AttitudeManeuverProblem(Scenario.paper(), threads=1)


def test_quick_metrics_are_columns_of_the_full_table(problem):
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (3, problem.n_var))
    described = problem.view(X).describe()
    quick = problem.view(X).quick_metrics()
    assert [name for name in described if name not in quick] == [
        *("Monte Carlo t_end [s]", "Monte Carlo trace [-]"),
    ]
    for name in quick:
        assert (quick[name] == described[name]).all()


def test_saved_plan_is_a_plan_file(problem):
    x = np.random.default_rng(2).uniform(problem.xl, problem.xu)
    document = build_solution_document(problem, "attitude", x)
    plan = from_json(encode_json(document).decode())
    assert plan == ManeuverPlan(problem.scenario, tuple(x.tolist()))
    again, _, design = parse_solution(document)
    np.testing.assert_array_equal(design, x)
    assert again.scenario == problem.scenario


@pytest.mark.slow
def test_slider_changes_covariance_and_saved_plan(problem, tmp_path):
    folder = tmp_path / "run"
    write_run(folder, small_run(problem))
    sigma = "[...document.querySelectorAll('#numbers tbody tr')].map((row) => row.textContent)"
    with served(folder) as url, opened(url, 1400) as page:
        page.until("document.querySelectorAll('#figures .main-svg').length > 6")
        before = page.evaluate(sigma)
        assert any(text.startswith("gyro bias 1-sigma [deg/h]") for text in before)
        slider = page.driver.find_element("css selector", "[role=slider]")
        is_positive = float(slider.get_attribute("aria-valuenow")) > 0.0
        slider.send_keys(Keys.HOME if is_positive else Keys.END)
        page.until(f"{sigma}.join() !== {json.dumps(','.join(before))}")
        page.until("document.querySelector('#file').value === 'plan.json'")
        page.driver.find_element("id", "save").click()
        page.until("document.querySelector('#saved').textContent.includes('plan.json')")
        assert page.errors() == []
        after = page.evaluate(sigma)
    plan = from_json((folder / "plan.json").read_text())
    assert plan.design[0] == (problem.xl[0] if is_positive else problem.xu[0])
    assert any(f"{plan.t_end:.5g}" in text for text in after)
    shown = CliRunner().invoke(app, ["attitude", "show", str(folder / "plan.json"), "--json"])
    assert shown.exit_code == 0, shown.output
    html = build_comparison_html(folder, folder / "plan.json")
    assert "Timeline" in html
