"""A satellite without a gyro that holds LVLH with a pointing error of some correlation time."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from mgeo_attitude import Environment, Scenario
from mgeo_attitude.environment.frames import lvlh_to_gcrs
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_calibration import TelemetryMapping, calibrate
from mgeo_calibration.telemetry.mapping import GyroChannels
from scipy.spatial.transform import Rotation

SCENARIO = dataclasses.replace(Scenario.cubesat_6u(), eclipse=False)
STEP, DURATION = 10.0, 6000.0


def flight(error_deg, correlation_time, seed):
    """Table and true magnetometer bias [nT] of a satellite that points by a Markov process."""
    rng = np.random.default_rng(seed)
    times = np.arange(STEP, DURATION, STEP)
    environment = Environment.at(SCENARIO, times)
    decay = np.exp(-STEP / correlation_time)
    error = np.zeros((len(times), 3))
    error[0] = error_deg * rng.standard_normal(3)
    for k in range(1, len(times)):
        chance = error_deg * np.sqrt(1.0 - decay**2) * rng.standard_normal(3)
        error[k] = decay * error[k - 1] + chance
    axes = lvlh_to_gcrs(np.array(environment.position), np.array(environment.velocity))
    to_gcrs = Rotation.from_matrix(axes) * Rotation.from_rotvec(error, degrees=True)
    bias = 500.0 * rng.standard_normal(3)
    mag = to_gcrs.inv().apply(np.array(environment.field)) + bias
    sun = to_gcrs.inv().apply(np.array(environment.sun))
    sensor = {each.name: each for each in SCENARIO.sensors}
    mag += sensor["mag"].noise_nt * rng.standard_normal(mag.shape)
    sun += np.radians(sensor["sun"].noise_deg) * rng.standard_normal(sun.shape)
    table = {"time": times}
    for name, rows in (("mag", mag), ("sun", sun)):
        table |= {f"{name}_{axis}": row for axis, row in zip("xyz", rows.T, strict=True)}
    return pd.DataFrame(table), bias


@pytest.mark.parametrize(("error_deg", "correlation_time"), [(2.0, 300.0), (5.0, 1000.0)])
def test_a_declared_pointing_error_gives_the_bias_and_is_consistent(error_deg, correlation_time):
    table, bias = flight(error_deg, correlation_time, 1)
    gyro = GyroChannels(
        holds="lvlh",
        pointing_error_deg=error_deg,
        pointing_correlation_time=correlation_time,
    )
    found = calibrate(SCENARIO, table, TelemetryMapping(gyro=gyro))
    assert found.supported, found.conclusion
    rows = found.table().query("block == 'mag.bias'")
    off = (rows["estimate"] - bias) / rows["sigma"]
    assert off.abs().max() < 4.0
    assert (rows["sigma"] < 0.3 * rows["prior_sigma"]).all()


def test_a_pointing_error_needs_axes_and_a_time():
    with pytest.raises(InvalidValue, match=r"pointing_error_deg = 2\.0: expected holds"):
        GyroChannels(pointing_error_deg=2.0, pointing_correlation_time=300.0)
    with pytest.raises(InvalidValue, match="pointing_correlation_time = None: expected a pointing"):
        GyroChannels(holds="lvlh", pointing_error_deg=2.0)
