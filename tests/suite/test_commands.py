"""`mgeo solve suite` and the commands `mgeo suite`."""

import dataclasses
import json

import mgeo_suite
import numpy as np
import pytest
import tomlkit
from mgeo_suite.view import summarize_front
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.store.run_folder import read_run


@pytest.fixture(scope="module")
def file(tmp_path_factory, scenario, table):
    """A scenario file that names a scenario and a catalog beside it."""
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
def test_a_run_is_of_the_algorithm_for_mixed_variables_and_can_be_resumed(run):
    found = read_run(run)
    assert found.configuration.algorithm == "mgeo-directed"
    assert found.versions["mgeo-suite"] == mgeo_suite.__version__
    before = found.outcome.F
    mgeo("resume", run, "--evaluations", 1200, "-q")
    after = read_run(run).outcome.F
    assert all((after <= row).all(axis=1).any() for row in before)


def test_the_conclusions_are_those_of_the_front(run, problem):
    found = read_run(run)
    document = json.loads(mgeo("suite", "conclude", run, "--budget", 3, "--json").stdout)
    price, accuracy = found.outcome.F.T
    best = accuracy[price <= 3].min()
    assert document["summary"][0].startswith("Within 3 kEUR the best is ")
    assert float(document["summary"][0].split()[6]) == pytest.approx(best, rel=0.05)
    text = mgeo("suite", "conclude", run).stdout
    assert text.count("Within") == 3


def test_conclusions_say_what_takes_a_star_tracker(problem, points):
    """Of a front that is made up: only designs with a tracker know the attitude."""
    from mgeo_suite import SensorSuiteProblem

    two = SensorSuiteProblem(problem.scenario, problem.catalog, ("price", "attitude"))
    X = points[:4].copy()
    X[:, 2] = [0, 0, 1, 1]
    F = np.array([[1.0, 0.9], [2.0, 0.5], [9.0, 0.09], [12.0, 0.05]])
    lines = summarize_front(two, X, F, np.array([0.5, 5.0]))
    assert lines[0] == "Within 0.5 kEUR there is no suite."
    assert lines[1].startswith("Within 5 kEUR the best is 0.50 deg, for 2: ")
    assert lines[2] == "1 deg takes 1 kEUR, and no star tracker from 1 kEUR on."
    assert lines[3] == "0.1 deg takes 9 kEUR; nothing without a star tracker reaches it."
    assert lines[4] == "Nothing that was found reaches 0.03 deg."


def test_the_catalog_is_printed_with_its_sources(file):
    document = json.loads(mgeo("suite", "catalog", "--json").stdout)
    assert {grade["name"] for grade in document["gyros"]} == {"mems", "mems-tactical", "fog"}
    assert "made up" in mgeo("suite", "catalog", file.with_name("catalog.toml")).stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('catalog = "none.toml"\n', "none.toml"),
        ('preset = "paper"\n', "preset = 'paper': unknown preset (known: 'cubesat'"),
    ],
)
def test_bad_files_end_with_one_line(tmp_path, text, message):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    done = mgeo("solve", "suite", "--scenario", path, code=2)
    assert message in done.output.replace("\n", " ")
    assert "Traceback" not in done.output


@pytest.mark.slow
def test_what_no_suite_can_do_names_the_requirement(scenario, table, tmp_path):
    """The nearest solutions, and what binds them; of few suites, each with a kernel of its own."""
    asked = dataclasses.replace(scenario, required_sigma={"attitude_deg": 1e-6})
    asked.save(tmp_path / "demanding.toml")
    few = table | {"faces": ["+x"], "gyros": table["gyros"][:1]}
    (tmp_path / "catalog.toml").write_text(tomlkit.dumps(few))
    path = tmp_path / "much.toml"
    path.write_text('scenario = "demanding.toml"\ncatalog = "catalog.toml"\n')
    done = mgeo(
        "solve", "suite", "--scenario", path, "--evaluations", 300, "--out", tmp_path / "r", code=3
    )
    assert "required 1-sigma of attitude" in done.stdout


def test_foreign_runs_are_refused(tmp_path):
    done = mgeo("suite", "conclude", tmp_path, code=2)
    assert "holds no run" in done.stderr
