"""Commands ``mgeo suite``, and ``mgeo solve suite``."""

import dataclasses
import json

import mgeo_suite
import numpy as np
import pytest
import tomlkit
from mgeo_suite import SensorSuiteProblem
from mgeo_suite.front_summary import find_best_suites, find_lowest_prices
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.store.run_folder import read_run


@pytest.fixture(scope="module")
def file(tmp_path_factory, scenario, table):
    """Path of a scenario file that names a scenario and a catalog in the same folder."""
    folder = tmp_path_factory.mktemp("suite")
    scenario.save(folder / "short.toml")
    (folder / "catalog.toml").write_text(tomlkit.dumps(table))
    path = folder / "suite.toml"
    path.write_text('scenario = "short.toml"\ncatalog = "catalog.toml"\n')
    return path


def mgeo(*arguments, code=0):
    done = CliRunner().invoke(app, list(map(str, arguments)), prog_name="mgeo")
    assert done.exit_code == code, done.output + done.stderr
    return done


@pytest.fixture(scope="module")
def run(file):
    folder = file.parent / "run"
    mgeo("solve", "suite", "--scenario", file, "--evaluations", 700, "-q", "--out", folder)
    return folder


@pytest.mark.slow
def test_run_uses_mgeo_directed_and_can_be_resumed(run):
    solved = read_run(run)
    assert solved.configuration.algorithm == "mgeo-directed"
    assert solved.versions["mgeo-suite"] == mgeo_suite.__version__
    before = solved.outcome.F
    mgeo("resume", run, "--evaluations", 1200, "-q")
    after = read_run(run).outcome.F
    assert all((after <= row).all(axis=1).any() for row in before)


def test_conclude_names_the_best_suite_within_a_budget(run, problem):
    solved = read_run(run)
    document = json.loads(mgeo("suite", "conclude", run, "--budget", 3, "--json").stdout)
    price, accuracy = solved.outcome.F.T
    (best,) = document["budgets"]
    assert best["attitude_1sigma_deg"] == accuracy[price <= 3].min()
    assert price[best["solution"]] == best["price_keur"] <= 3
    text = mgeo("suite", "conclude", run).stdout
    for budget in (10, 30, 60):
        assert f"\n- {budget} kEUR: " in text


def test_summary_of_a_front_has_prices_with_and_without_a_star_tracker(problem, points):
    suite_problem = SensorSuiteProblem(problem.scenario, problem.catalog, ("price", "attitude"))
    X = points[:4].copy()
    X[:, 2] = [0, 0, 1, 1]  # Only the last two suites have a star tracker.
    F = np.array([[1.0, 0.9], [2.0, 0.5], [9.0, 0.09], [12.0, 0.05]])
    none, affordable = find_best_suites(suite_problem, X, F, [0.5, 5.0])
    assert none["suite"] is None
    assert (affordable["solution"], affordable["attitude_1sigma_deg"]) == (1, 0.5)
    prices = {p.pop("attitude_1sigma_deg"): p for p in find_lowest_prices(suite_problem, X, F)}
    assert list(prices[1.0].values()) == [1.0, 1.0]
    assert list(prices[0.1].values()) == [9.0, None]
    assert list(prices[0.03].values()) == [None, None]


def test_catalog_is_printed_with_its_sources(file):
    document = json.loads(mgeo("suite", "catalog", "--json").stdout)
    assert {grade["name"] for grade in document["gyros"]} == {"mems", "mems-tactical", "fog"}
    assert "invented" in mgeo("suite", "catalog", file.with_name("catalog.toml")).stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('catalog = "none.toml"\n', "none.toml"),
        ('preset = "paper"\n', "preset = 'paper': unknown preset (known: 'cubesat'"),
    ],
)
def test_error_for_invalid_file_has_no_traceback(tmp_path, text, message):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    done = mgeo("solve", "suite", "--scenario", path, code=2)
    assert message in done.output.replace("\n", " ")
    assert "Traceback" not in done.output


@pytest.mark.slow
def test_infeasible_requirement_is_named(scenario, table, tmp_path):
    demanding = dataclasses.replace(scenario, required_sigma={"attitude_deg": 1e-6})
    demanding.save(tmp_path / "demanding.toml")
    small_catalog = table | {"faces": ["+x"], "gyros": table["gyros"][:1]}
    (tmp_path / "catalog.toml").write_text(tomlkit.dumps(small_catalog))
    path = tmp_path / "infeasible.toml"
    path.write_text('scenario = "demanding.toml"\ncatalog = "catalog.toml"\n')
    done = mgeo(
        "solve", "suite", "--scenario", path, "--evaluations", 300, "--out", tmp_path / "r", code=3
    )
    assert "1-sigma of attitude" in done.stdout


def test_folder_without_a_run_is_refused(tmp_path):
    done = mgeo("suite", "conclude", tmp_path, code=2)
    assert "holds no run" in done.stderr
