"""Tables, tests, corrections, files and figures of a calibration."""

import dataclasses
import json
from datetime import timedelta

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude.plan import ManeuverPlan
from mgeo_calibration import calibrate
from mgeo_calibration.calibration.consistency_tests import (
    SIGNIFICANCE,
    compute_correlation_bound,
    compute_max_autocorrelation,
    compute_nis_bounds,
)
from mgeo_calibration.calibration.document import from_json, read_json, to_json
from mgeo_calibration.calibration.report import build_report
from mgeo_calibration.estimation.residuals import Innovations
from plotly.offline import get_plotlyjs
from scipy.spatial.transform import Rotation

from ...browser import opened
from .runs import PLAN

#: Initial 1-sigma of the Sun sensor bias of the preset ``paper``, 0.02 rad [arcmin].
SUN_BIAS = 60.0 * np.degrees(0.02)


def test_table_has_one_row_per_parameter_and_axis(calibration, telemetry):
    table = calibration.build_table()
    assert list(table) == ["block", "axis", "unit", "estimate", "sigma", "prior_sigma"]
    assert list(table["axis"]) == list("xyz") * 5
    first = table.drop_duplicates("block").set_index("block")
    assert first["unit"].to_dict() == {
        "gyro.bias": "deg/h",
        "sun.misalignment": "deg",
        "sun.bias": "arcmin",
        "mag.misalignment": "deg",
        "mag.bias": "nT",
    }
    np.testing.assert_allclose(first["prior_sigma"], [36.0, 1.0, SUN_BIAS, 1.0, 2000.0], rtol=1e-12)
    truth = telemetry.truth.states[-1]
    true = {
        "gyro.bias": 3600.0 * np.degrees(truth[3:6]),
        "sun.bias": 60.0 * np.degrees(truth[9:12]),
        "mag.bias": 5e4 * truth[15:18],
        "mag.misalignment": Rotation.from_quat([*(0.5 * truth[12:15]), 1.0]).as_rotvec(True),
    }
    for block, expected in true.items():
        rows = table[table["block"] == block]
        assert (np.abs(rows["estimate"] - expected) < 4.0 * rows["sigma"]).all()
        assert (rows["sigma"] < rows["prior_sigma"]).all()


def test_conclusion_is_consistent_or_states_failed_test(scenario, telemetry, calibration):
    assert calibration.is_consistent
    assert "statistically consistent" in calibration.conclusion
    assert calibration.build_test_table()["is_passed"].all()
    none = dataclasses.replace(calibration, tests=(), prior_tests=(), model_tests=())
    assert none.is_consistent  # All of a few readings may be outliers.
    assert (
        not len(none.build_sensor_test_table())
        + len(none.build_prior_test_table())
        + len(none.build_model_test_table())
    )
    table = calibration.build_sensor_test_table()
    assert (table["rms_before"] > 1.05 * table["rms_after"]).all()
    np.testing.assert_allclose(table["rms_after"], table["rms_noise"], rtol=0.05)
    quiet = dataclasses.replace(scenario.sensors[0], noise_deg=1.2)
    optimist = dataclasses.replace(scenario, sensors=(quiet, *scenario.sensors[1:]))
    wrong = calibrate(optimist, telemetry)
    assert not wrong.is_consistent
    assert 'the test "noise of sun" failed (NIS ' in wrong.conclusion
    assert not wrong.build_test_table().loc["noise of sun", "is_passed"]
    drift = telemetry.sensors["mag"] + 1000.0 * np.sin(telemetry.times / 20.0)[:, None]
    sensors = {**telemetry.sensors, "mag": drift}
    drifting = calibrate(scenario, dataclasses.replace(telemetry, sensors=sensors))
    assert "whiteness of mag" in {failure.test for failure in drifting.failures}


def test_requirements_are_compared_with_worst_axes(scenario, telemetry):
    required = {"attitude_deg": 0.001, "mag.bias_nt": 400.0, "sun.bias": 0.01}
    demanding = dataclasses.replace(scenario, required_sigma=required)
    found = calibrate(demanding, telemetry)
    table = found.build_requirement_table()
    assert table["satisfied"].to_dict() == {
        "attitude": False,
        "sun.bias": True,
        "mag.bias": True,
    }
    assert table["required"].to_list() == pytest.approx([0.001, SUN_BIAS / 2.0, 400.0])
    sigmas = found.build_table().groupby("block")["sigma"].max()
    blocks = ["sun.bias", "mag.bias"]
    np.testing.assert_allclose(table.loc[blocks, "achieved"], sigmas[blocks])
    assert table.loc["attitude", "achieved"] == pytest.approx(found.attitude_sigma_deg)
    assert "1 of 3 required 1-sigmas" in build_report(found)
    wrong = dataclasses.replace(found, data_faults=("frozen samples",))
    assert not wrong.build_requirement_table()["satisfied"].any()
    assert calibrate(scenario, telemetry).build_requirement_table().empty


def test_false_alarm_rate_equals_significance_level():
    """Innovations of white noise fail in 1 % of the cases over all tests."""
    rng, failed, runs = np.random.default_rng(0), 0, 2000
    for _ in range(runs):
        white = Innovations(np.arange(300), rng.standard_normal((300, 3)))
        low, high = compute_nis_bounds(900, 2)
        passes = low < white.nis.mean() / 3.0 < high
        failed += not (
            passes and compute_max_autocorrelation(white) < compute_correlation_bound(900, 2)
        )
    assert abs(failed / runs - SIGNIFICANCE) < 4.0 * np.sqrt(SIGNIFICANCE / runs)
    w = np.random.default_rng(1).standard_normal((2000, 3))
    w[1:] = 0.3 * w[:-1] + np.sqrt(1 - 0.09) * w[1:]
    assert compute_max_autocorrelation(Innovations(np.arange(2000), w)) == pytest.approx(
        0.3, abs=0.04
    )


def test_json_round_trip_is_exact(calibration, tmp_path):
    text = to_json(calibration)
    (tmp_path / "c.json").write_text(text)
    found = read_json(tmp_path / "c.json")
    assert to_json(found) == text
    assert found.scenario == calibration.scenario
    np.testing.assert_array_equal(found.covariance, calibration.covariance)
    np.testing.assert_array_equal(found.states, calibration.states)
    pd.testing.assert_frame_equal(found.build_table(), calibration.build_table(), check_exact=True)
    assert found.tests == calibration.tests
    assert found.outliers == calibration.outliers
    with pytest.raises(ValueError, match="no history of the attitude"):
        found.attitude  # noqa: B018
    assert list(found.draw_figures()) == ["parameters"]


def edit_json(text, **changes):
    return json.dumps(json.loads(text) | changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"version": 1}, "version = 1: expected 2"),
        (
            {"quaternion": [1.0, 1.0, 0.0, 0.0]},
            "quaternion = .*: expected four numbers of unit length",
        ),
        ({"states": {}}, r"states = \[\]: expected gyro.bias"),
        ({"covariance": [[0.0] * 18] * 18}, "symmetric positive definite"),
        ({"sensor_tests": [{}]}, r"sensor_tests\[0\].sensor is missing"),
    ],
)
def test_invalid_calibration_files_raise(calibration, changes, message):
    with pytest.raises((ValueError, TypeError), match=message):
        from_json(edit_json(to_json(calibration), **changes))


def test_comparison_with_plan_predicts_achieved_sigma(scenario, calibration):
    plan = ManeuverPlan(scenario, PLAN)
    found = calibration.compare(plan)
    assert list(found) == ["unit", "predicted", "achieved", "ratio"]
    assert found.loc["mag bias x", "unit"] == "nT"
    # Prior attitude and true path differ slightly.
    assert found["ratio"].between(0.6, 1.4).all()
    other = dataclasses.replace(scenario, sensors=scenario.sensors[:1])
    with pytest.raises(ValueError, match="the plan has the states"):
        calibration.compare(ManeuverPlan(other, PLAN))
    later = dataclasses.replace(scenario, epoch=scenario.epoch + timedelta(hours=1))
    with pytest.raises(
        ValueError, match=r"the plan has the epoch .* expected the epoch of the calibration"
    ):
        calibration.compare(ManeuverPlan(later, PLAN))


@pytest.mark.slow
def test_figures_and_report_contain_results(scenario, telemetry, calibration):
    figures = calibration.draw_figures()
    assert list(figures) == ["parameters", "innovations", "attitude"]
    drawn = [point for trace in figures["parameters"].data for point in trace.x]
    table = calibration.build_table()
    np.testing.assert_allclose(drawn, table["estimate"] / table["prior_sigma"])
    html = build_report(calibration, calibration.compare(ManeuverPlan(scenario, PLAN)))
    assert html.count('class="plotly-graph-div"') == 3
    assert "statistically consistent" in html
    assert "Predicted and achieved 1-sigma" in html
    assert "<th scope=row class=text>mag bias</th>" in html
    ours = html.replace(get_plotlyjs(), "")  # plotly.js contains addresses.
    assert len(ours) < len(html)
    for source in ("http://", "https://"):
        assert f'src="{source}' not in ours
    named = dataclasses.replace(scenario, name="<script>x</script>")
    assert "<script>x" not in build_report(calibrate(named, telemetry))


@pytest.mark.slow
def test_report_fits_narrow_screen_without_console_errors(calibration, tmp_path):
    (tmp_path / "report.html").write_text(build_report(calibration))
    with opened(tmp_path / "report.html", width=390) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert page.errors() == []
        # Keyboard users can scroll wide tables.
        assert page.evaluate("[...document.querySelectorAll('.wide')].every(e => e.tabIndex === 0)")
