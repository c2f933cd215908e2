"""Noise of each sample of a gyro that is read at points in time, declared in the scenario."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Gyro, Scenario
from mgeo_calibration import CalibrationError, calibrate, simulate_telemetry

from .flights import PLAN, normalized, short

CUBESAT = short(Scenario.cubesat_6u(), 2000.0)
NOISE = 0.05  # of each sample [deg/s]


def with_noise(interval, sigma):
    gyro = dataclasses.replace(CUBESAT.gyro, sample_noise_deg_s=sigma)
    return dataclasses.replace(CUBESAT, step=interval, gyro=gyro)


def is_supported(scenario, telemetry):
    try:
        return calibrate(scenario, telemetry).is_consistent
    except CalibrationError:
        return False


@pytest.mark.parametrize("interval", [2.0, 10.0])
def test_declared_sample_noise_is_that_of_the_estimate(interval):
    """Noise is added by hand, and telemetry says how far its samples are apart."""
    telemetry = simulate_telemetry(with_noise(interval, None), PLAN, 1)
    chance = np.random.default_rng(2).standard_normal(telemetry.gyro_deg_s.shape)
    noisy = dataclasses.replace(telemetry, gyro_deg_s=telemetry.gyro_deg_s + NOISE * chance)
    declared = calibrate(with_noise(1.0, NOISE), noisy)
    assert declared.is_consistent
    nees, z = normalized(declared, telemetry)
    assert nees < 2.0
    assert np.abs(z).max() < 4.0
    assert not is_supported(with_noise(1.0, None), noisy)


def test_flights_and_plans_have_the_declared_noise():
    quiet, noisy = (simulate_telemetry(with_noise(2.0, sigma), PLAN, 1) for sigma in (None, NOISE))
    scatter = np.diff(noisy.gyro_deg_s - quiet.gyro_deg_s, axis=0)[1:] / np.sqrt(2.0)
    chance = 4.0 * np.sqrt(0.75 / len(scatter))  # of the deviation of neighbors that share a sample
    np.testing.assert_allclose(scatter.std(axis=0), NOISE, rtol=chance)


def test_samples_of_independent_errors_are_an_angle_random_walk():
    """σ √T: 0.1 deg/s every 4 s is 0.2 deg/√s, 12 deg/√h."""
    gyro = Gyro(angle_random_walk_deg_per_sqrt_h=5.0, sample_noise_deg_s=0.1)
    assert gyro.convert_sample_noise(4.0).angle_random_walk_deg_per_sqrt_h == pytest.approx(
        (13.0,) * 3
    )
    assert Gyro().convert_sample_noise(4.0) == Gyro()
