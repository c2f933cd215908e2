"""What docs/basilisk.md shows works as it stands there."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration.calibration import calibrate
from typer.testing import CliRunner

from mgeo.cli import app

pytest.importorskip(
    "Basilisk", reason='flights by Basilisk: pip install "./problems/calibration[basilisk]"'
)

from mgeo_calibration.flight.basilisk import Vehicle, fly

pytestmark = pytest.mark.basilisk

PAGE = (Path(__file__).parents[4] / "docs" / "basilisk.md").read_text(encoding="utf-8")


def test_the_commands_lead_from_a_front_to_a_calibration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (commands,) = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    for line in commands.splitlines():
        done = CliRunner().invoke(app, shlex.split(line)[1:], prog_name="mgeo")
        assert done.exit_code == 0, line + done.output + done.stderr
    assert Path("truth.json").is_file()
    assert Path("calibration/calibration.html").is_file()


def test_python_finds_the_errors():
    scenario = Scenario.cubesat_6u()
    design = [0.5, 0.3, -0.2, 800.0, -0.3, 0.6, 0.2, 1000.0, 0.2, -0.4, 0.7, 1200.0]
    telemetry = fly(scenario, design, seed=2, vehicle=Vehicle.cubesat_6u())
    truth, found = telemetry.truth.states[-1], calibrate(scenario, telemetry)
    errors = (truth - found.states)[3:] / np.sqrt(np.diag(found.covariance))[3:]
    assert np.abs(errors).max() < 4.0
    initial = found.suite.initial_sigma(0.0)[3:]
    assert np.abs(truth[3:] / initial).max() > 1.0
