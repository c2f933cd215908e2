"""Telemetry of a magnetometer in orbit, against an affine least-squares fit without a filter."""

from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_calibration import TelemetryMapping, calibrate, calibrate_magnetometers, read_telemetry
from mgeo_calibration.calibration.document import read_json
from mgeo_calibration.commands.app import app
from typer.testing import CliRunner

FOLDER = Path(__file__).parent / "real"
TABLE = FOLDER / "iss_magnetometer.csv"


@pytest.fixture(scope="module")
def scenario():
    return Scenario.from_toml(FOLDER / "iss.toml")


@pytest.fixture(scope="module")
def telemetry(scenario):
    mapping = TelemetryMapping.from_toml(FOLDER / "columns.toml")
    return read_telemetry(TABLE, scenario, mapping)


@pytest.fixture(scope="module")
def affine_bias(scenario, telemetry):
    """Bias [nT] of the least-squares fit m = A B + b for any matrix A, with the field along
    LVLH.
    """
    environment = Environment.from_times(scenario, telemetry.times)
    down = -environment.position
    right = np.cross(down, environment.velocity)
    axes = [np.cross(right, down), right, down]
    unit = [axis / np.linalg.norm(axis, axis=1)[:, None] for axis in axes]
    field = np.column_stack([(environment.field * axis).sum(axis=1) for axis in unit])
    known = np.column_stack([field, np.ones(len(field))])
    return np.linalg.lstsq(known, telemetry.sensors["mag"], rcond=None)[0][3]


def get_magnetometer_bias(table):
    return table[table["block"] == "mag.bias"]["estimate"].to_numpy()


@pytest.mark.slow
def test_bias_agrees_with_affine_fit_and_colored_noise_is_reported(
    scenario, telemetry, affine_bias
):
    assert telemetry.times[0] == pytest.approx(
        -0.542743
    )  # Before the epoch, exact to a microsecond.
    np.testing.assert_allclose(affine_bias, [27600.0, 19700.0, -4300.0], atol=100.0)
    found = calibrate(scenario, telemetry)
    np.testing.assert_allclose(get_magnetometer_bias(found.build_table()), affine_bias, atol=600.0)
    assert not found.is_consistent
    assert "whiteness of mag" in {failure.test for failure in found.failures}


def test_field_strength_calibration_agrees_with_affine_fit(scenario, telemetry, affine_bias):
    found = calibrate_magnetometers(scenario, telemetry)
    rows = found.build_table().query("block == 'mag.bias'")
    correlation = 0.85  # Consecutive residuals are correlated, which reduces their information.
    sigma = rows["sigma"].to_numpy() * np.sqrt((1.0 + correlation) / (1.0 - correlation))
    assert (np.abs(get_magnetometer_bias(found.build_table()) - affine_bias) / sigma).max() < 4.0
    assert 'the test "whiteness of mag" failed (autocorrelation 0.8' in found.conclusion
    assert "misalignments" in found.notes[0]


def test_scenario_continues_from_magnetometer_calibration(tmp_path):
    mapping = tmp_path / "columns.toml"
    mapping.write_text((FOLDER / "columns.toml").read_text().replace("lvlh", "unknown"))
    command = ["calibrate", str(TABLE), "--scenario", str(FOLDER / "iss.toml")]
    options = ["--mapping", str(mapping), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, [*command, *options])
    assert done.exit_code == 3, done.output
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"calibration.csv", "calibration.json", "calibration.html"} <= files
    assert "attitude.csv" not in files
    found = read_json(tmp_path / "out" / "calibration.json")
    after = found.build_followup_scenario({"accept_inconsistent": True})
    first = 3 * after.suite.blocks.index("mag.bias")
    carried = 5e4 * after.prior.estimates[first : first + 3]
    np.testing.assert_allclose(carried, get_magnetometer_bias(found.build_table()))
    assert np.sqrt(np.diag(after.initial_attitude_covariance)).min() > 0.01


def test_invalid_telemetry_leaves_no_files(tmp_path):
    table = tmp_path / "table.csv"
    table.write_text(TABLE.read_text().replace("12.3227", "none"))
    command = ["calibrate", str(table), "--scenario", str(FOLDER / "iss.toml")]
    options = ["--mapping", str(FOLDER / "columns.toml"), "--out", str(tmp_path / "out")]
    refused = CliRunner().invoke(app, [*command, *options])
    assert "mx_uT = 'none': expected a number" in str(refused.exception)
    assert not (tmp_path / "out").exists()
