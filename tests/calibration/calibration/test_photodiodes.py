"""Photodiodes: simulation, reading and calibration."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import EnvironmentErrors, FilterModel, Magnetometer, Photodiode, Scenario
from mgeo_calibration import calibrate, simulate_telemetry
from mgeo_calibration.estimation.batch import build_batch
from mgeo_calibration.estimation.initial_attitude import compute_sun_directions
from mgeo_calibration.telemetry.checks import describe_findings

from .runs import PLAN, check_errors, normalize_error, short

NORMALS = {"px": (1.0, 0.0, 0.0), "mx": (-1.0, 0.0, 0.0), "py": (0.0, 1.0, 0.0),
           "my": (0.0, -1.0, 0.0), "pz": (0.0, 0.0, 1.0), "mz": (0.0, 0.0, -1.0)}  # fmt: skip
DIODES = tuple(Photodiode(name=name, normal=normal) for name, normal in NORMALS.items())
MAG = next(each for each in Scenario.cubesat_6u().sensors if isinstance(each, Magnetometer))
SCENARIO = short(
    Scenario.cubesat_6u(),
    3000.0,
    sensors=(*DIODES, MAG),
    environment_errors=EnvironmentErrors(earth_albedo=0.3, albedo=0.03),
)


@pytest.fixture(scope="module")
def telemetry():
    return simulate_telemetry(SCENARIO, PLAN, 1)


@pytest.mark.slow
def test_gains_and_normals_are_calibrated_within_sigma(telemetry):
    calibration = calibrate(SCENARIO, telemetry)
    check_errors([normalize_error(calibration, telemetry)])
    assert calibration.is_consistent
    table = calibration.build_table().set_index(["block", "axis"])
    assert table.loc[("px.sensitivity", "z"), "sigma"] < 0.02  # from 0.05
    sent = calibration.compute_corrections()["px"]
    along = np.array([1.0, 0.0, 0.0]) + sent["sensitivity"] @ DIODES[0].axes
    np.testing.assert_allclose(sent["gain"] * np.array(sent["normal"]), along, rtol=1e-12)


def test_readings_of_unlit_photodiodes_are_ignored(telemetry):
    """Zeros, noise or albedo give the calibration of empty cells."""
    rng, sensors = np.random.default_rng(4), dict(telemetry.sensors)
    for name in NORMALS:
        dark = np.isnan(sensors[name])
        dark[0] = False
        noise = 0.02 * rng.standard_normal(dark.shape)
        sensors[name] = np.where(dark, np.maximum(noise, 0.0), sensors[name])
    read = dataclasses.replace(telemetry, sensors=sensors)
    one, other = (calibrate(SCENARIO, each.truncate(700.0)) for each in (telemetry, read))
    apart = np.abs(one.states - other.states) / np.sqrt(np.diag(one.covariance))
    assert apart.max() < 0.3
    assert describe_findings(SCENARIO, read)["repeated numbers"] == ()


def test_three_lit_photodiodes_determine_sun_direction(telemetry):
    data = build_batch(SCENARIO, telemetry)
    k = np.searchsorted(telemetry.times, data.times)
    true = telemetry.truth.states[k]
    found = compute_sun_directions(data.suite, data.readings, true)
    there = np.isfinite(found[:, 0])
    lit = sum(np.isfinite(rows[:, 0, 0]).astype(int) for rows in data.readings[:6])
    np.testing.assert_array_equal(there, lit == 3)
    assert there.sum() > 100
    model = FilterModel.from_scenario(SCENARIO)
    sun = np.einsum("kij,kj->ki", telemetry.truth.attitude[k], model.references[k, 0])
    off = found[there] - sun[there]  # One direction includes albedo.
    assert np.abs(np.median(off, axis=0)).max() < 0.15
    dark = dataclasses.replace(SCENARIO, environment_errors=EnvironmentErrors())
    clean = simulate_telemetry(dark, PLAN, 2)
    data = build_batch(dark, clean)
    true = clean.truth.states[np.searchsorted(clean.times, data.times)]
    found = compute_sun_directions(data.suite, data.readings, true)
    sun = np.einsum("kij,kj->ki", clean.truth.attitude[-len(found) :], data.vectors[:, 0])
    assert np.nanstd(found - sun) < 0.03
