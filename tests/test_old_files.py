"""What older versions have written is read, or refused with what reads it."""

import json
import shutil
from pathlib import Path

import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.plan import read_json as read_plan
from mgeo_calibration import read_telemetry
from mgeo_calibration.calibration import read_json as read_calibration
from typer.testing import CliRunner

from mgeo import read_record
from mgeo.cli import app
from mgeo.store import read_run
from mgeo.studies import read_comparison, read_study

OLD = Path(__file__).parent / "old"


@pytest.fixture(params=[path.name for path in OLD.iterdir()])
def old(request, tmp_path):
    """A copy of all that one version has written."""
    return shutil.copytree(OLD / request.param, tmp_path / "old")


def mgeo(*arguments):
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_a_run(old):
    run = read_run(old / "run")
    assert run.versions["mgeo"].startswith("0.")
    assert len(run.outcome.X) == json.loads((old / "run" / "run.json").read_text())["solutions"]
    mgeo("report", old / "run")
    assert "solution" in mgeo("attitude", "show", old / "run")


def test_a_run_goes_on(old):
    mgeo("resume", old / "run", "--evaluations", 300, "-q")
    assert read_run(old / "run").outcome.evaluations >= 300


def test_a_record(old):
    record = read_record(old / "run" / "evaluations")
    assert len(record) >= 200


@pytest.mark.slow
def test_a_plan(old):
    plan = read_plan(old / "plan.json")
    said = json.loads((old / "plan.json").read_text())
    assert list(plan.design) == said["design"]
    assert plan.trace == pytest.approx(said["predicted"]["trace [-]"], rel=1e-9)
    mgeo("attitude", "show", old / "plan.json")


def test_telemetry(old):
    telemetry = read_telemetry(old / "telemetry.csv", Scenario.from_toml(old / "scenario.toml"))
    assert len(telemetry.times) == 61


@pytest.mark.slow
def test_a_calibration_and_the_truth_of_a_flight_are_gone_on_from(old):
    assert read_calibration(old / "calibration.json").time == 1500.0
    again = old / "again"
    budget = ["--evaluations", 30, "-q", "--out", again]
    mgeo("solve", "attitude", "--after", old / "calibration.json", *budget)
    flown = ["--after", old / "truth.json", "--until", 10, "--out", old / "flown.csv"]
    mgeo("attitude", "fly", again, *flown)


def test_a_study(old):
    comparison = read_comparison(old / "study")
    assert len(comparison.overview()) == 2
    assert read_study(old / "study" / "study.toml").seeds == (1, 2)
