"""Plans that a hand changes: what is told at once, and the file that is saved."""

import numpy as np
import pytest
from mgeo_attitude import AttitudeManeuverProblem, Scenario
from mgeo_attitude.plan import ManeuverPlan, from_json
from mgeo_attitude.view.plans import Plans

from mgeo import View
from mgeo.explore import Explorer
from mgeo.report import compare_html
from mgeo.store.atomic import to_json
from mgeo.store.run_folder import write_run
from mgeo.store.solution_file import is_solution, solution_document, solution_of

from .small_run import small_run


@pytest.fixture(scope="module")
def problem():
    return AttitudeManeuverProblem(Scenario.paper(), threads=1)


def test_a_glance_is_of_one_run_of_the_filter(problem, monkeypatch):
    """And what it says is what is told of plans at length."""
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (3, problem.n_var))
    described = problem.view(X).describe()
    monkeypatch.setattr(Plans, "_over_others", lambda *given: 1 / 0)  # flights
    found = problem.view(X).glance()
    assert [name for name in described if name not in found] == [
        *("kept t_end [s]", "kept trace [-]"),
    ]
    for name in found:
        assert (found[name] == described[name]).all()
    assert View.glance is not type(problem.view(X)).glance


def test_a_saved_plan_is_the_plans_file(problem):
    x = np.random.default_rng(2).uniform(problem.xl, problem.xu)
    document = solution_document(problem, "attitude", x)
    assert is_solution(document)
    plan = from_json(to_json(document).decode())
    assert plan == ManeuverPlan(problem.scenario, tuple(x.tolist()))
    again, _, design = solution_of(document)
    np.testing.assert_array_equal(design, x)
    assert again.scenario == problem.scenario


@pytest.mark.slow
def test_a_run_is_explored_and_a_plan_of_it_saved(problem, tmp_path):
    folder = tmp_path / "run"
    write_run(folder, small_run(problem))
    explorer = Explorer(folder)
    front = explorer.front()
    names = [column["name"] for column in front["columns"]]
    assert names[:2] == ["t_end [s]", "trace [-]"]
    assert "gyro bias 1-sigma [deg/h]" in names
    place = front["numbers"].index(front["first"])
    x = explorer.design(front["designs"][place])
    # alone or among others: to rounding
    np.testing.assert_allclose(explorer.glance(x)["numbers"], front["rows"][place], rtol=1e-9)
    assert {"rates", "motion", "trace"} <= explorer.figures(x)["figures"].keys()
    titles = [section["title"] for section in explorer.review(x)["sections"]]
    assert "Error budget, 1-sigma of the worst body axis" in titles
    changed = x.copy()
    changed[3] = 0.5 * (x[3] + problem.xu[3])
    explorer.save(changed, "plan.json", overwrite=False)
    plan = from_json((folder / "plan.json").read_text())
    html = compare_html(folder, folder / "plan.json")  # as a person does next
    assert "<h2>Fronts</h2>" in html
    assert "Timeline" in html
    assert html.count("<h3>Gyro and sensors</h3>") == 1  # said once of both
    numbers = dict(zip(names, explorer.glance(changed)["numbers"], strict=True))
    assert plan.t_end == numbers["t_end [s]"]
    np.testing.assert_allclose(plan.trace, numbers["trace [-]"], rtol=1e-9)
