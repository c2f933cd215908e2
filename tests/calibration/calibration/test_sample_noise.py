"""Noise of each gyro sample, declared in the scenario."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Gyro, Scenario
from mgeo_calibration import CalibrationError, calibrate, simulate_telemetry

from .runs import PLAN, normalize_error, short

CUBESAT = short(Scenario.cubesat_6u(), 2000.0)
NOISE = 0.05  # Noise per sample [deg/s].


def with_noise(interval, sigma):
    gyro = dataclasses.replace(CUBESAT.gyro, sample_noise_deg_s=sigma)
    return dataclasses.replace(CUBESAT, step=interval, gyro=gyro)


def is_consistent(scenario, telemetry):
    try:
        return calibrate(scenario, telemetry).is_consistent
    except CalibrationError:
        return False


@pytest.mark.parametrize("interval", [2.0, 10.0])
def test_declared_sample_noise_is_consistent(interval):
    """Noise is added to the samples; the sample interval comes from telemetry."""
    telemetry = simulate_telemetry(with_noise(interval, None), PLAN, 1)
    chance = np.random.default_rng(2).standard_normal(telemetry.gyro_deg_s.shape)
    noisy = dataclasses.replace(telemetry, gyro_deg_s=telemetry.gyro_deg_s + NOISE * chance)
    declared = calibrate(with_noise(1.0, NOISE), noisy)
    assert declared.is_consistent
    nees, z = normalize_error(declared, telemetry)
    assert nees < 2.0
    assert np.abs(z).max() < 4.0
    assert not is_consistent(with_noise(1.0, None), noisy)


def test_simulation_and_plan_use_declared_sample_noise():
    quiet, noisy = (simulate_telemetry(with_noise(2.0, sigma), PLAN, 1) for sigma in (None, NOISE))
    scatter = np.diff(noisy.gyro_deg_s - quiet.gyro_deg_s, axis=0)[1:] / np.sqrt(2.0)
    chance = 4.0 * np.sqrt(0.75 / len(scatter))  # Neighboring differences share a sample.
    np.testing.assert_allclose(scatter.std(axis=0), NOISE, rtol=chance)


def test_sample_noise_equals_angle_random_walk():
    """σ √T: 0.1 deg/s every 4 s is 0.2 deg/√s, 12 deg/√h."""
    gyro = Gyro(angle_random_walk_deg_per_sqrt_h=5.0, sample_noise_deg_s=0.1)
    assert gyro.convert_sample_noise(4.0).angle_random_walk_deg_per_sqrt_h == pytest.approx(
        (13.0,) * 3
    )
    assert Gyro().convert_sample_noise(4.0) == Gyro()
