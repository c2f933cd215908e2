"""Magnetometer calibration from the field strength, compared with SciPy and an independent
simulation.
"""

import dataclasses
import re

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_attitude.sensors.base import scale_noise
from mgeo_calibration import Telemetry, calibrate, calibrate_magnetometers, simulate_telemetry
from mgeo_calibration.estimation.field_strength import compute_response_matrix, fit_field_strength
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ..calibration.runs import PLAN, short

TRUE = np.array([-51000.0, 17000.0, -37000.0, 0.1, -0.07, 0.03, 0.02, -0.05, 0.04])
PRIOR = np.array([1e5] * 3 + [0.3] * 3 + [0.1] * 3)
SIGMA = np.array([100.0, 150.0, 200.0])


def simulate_readings(seed, n=2000, true=TRUE):
    """Return the readings of a magnetometer in random attitudes, and the field strengths."""
    generator = np.random.default_rng(seed)
    strength = generator.uniform(25000.0, 55000.0, n)
    field = Rotation.random(n, rng=generator).apply([0.0, 0.0, 1.0]) * strength[:, None]
    scale, (yz, zx, xy) = true[3:6], true[6:]
    shear = np.array([[0.0, xy, zx], [xy, 0.0, yz], [zx, yz, 0.0]])
    measured = field + field * scale + field @ shear + true[:3]
    return measured + SIGMA * generator.standard_normal((n, 3)), strength


def test_estimate_equals_least_squares_of_scipy():
    measured, strength = simulate_readings(1)
    fit = fit_field_strength(measured, strength, SIGMA, np.zeros(9), PRIOR)
    W = np.linalg.inv(compute_response_matrix(fit.parameters))
    u = (measured - fit.parameters[:3]) @ W
    noise = W @ np.diag(SIGMA**2) @ W
    spread = np.sqrt(4.0 * np.einsum("ni,ij,nj->n", u, noise, u) + 2.0 * (noise**2).sum())

    def residual(x):
        values = x * PRIOR
        u = np.linalg.solve(compute_response_matrix(values), (measured - values[:3]).T).T
        bias = np.trace(np.linalg.inv(compute_response_matrix(values)) @ np.diag(SIGMA**2)
                        @ np.linalg.inv(compute_response_matrix(values)))  # fmt: skip
        return np.concatenate([((u**2).sum(axis=1) - strength**2 - bias) / spread, x])

    reference = least_squares(
        residual, fit.parameters / PRIOR * 0.9, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    sigma = np.sqrt(np.diag(fit.covariance))
    assert (np.abs(reference.x * PRIOR - fit.parameters) / sigma).max() < 1e-2
    covariance = np.linalg.inv(reference.jac.T @ reference.jac) * np.outer(PRIOR, PRIOR)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), sigma, rtol=0.01)


def test_errors_are_consistent_with_covariance():
    """The mean normalized square of 60 estimation errors lies within its statistical bounds."""
    squares = []
    for seed in range(60):
        measured, strength = simulate_readings(100 + seed, 400)
        fit = fit_field_strength(measured, strength, SIGMA, np.zeros(9), PRIOR)
        error = fit.parameters - TRUE
        squares.append(error @ np.linalg.solve(fit.covariance, error))
    # The bound is 4.5 standard deviations of the mean of 60 chi-square values with 9 degrees of
    # freedom.
    assert abs(np.mean(squares) - 9.0) < 4.5 * np.sqrt(18.0 / 60.0)


CUBESAT = short(Scenario.from_dict({"preset": "cubesat_6u"}), 3000.0)
LARGE_BIASES = ((-51000.0, 17000.0, -37000.0), (27000.0, 42000.0, -62000.0))


def simulate_large_bias(seed, bias):
    """Return scenario, telemetry with a magnetometer bias as large as on two known CubeSats, and
    its source.
    """
    (mag,) = (sensor for sensor in CUBESAT.sensors if sensor.name == "mag")
    true_scenario = dataclasses.replace(CUBESAT, sensors=(mag,))
    source = simulate_telemetry(true_scenario, PLAN, seed)
    scenario = dataclasses.replace(
        CUBESAT, sensors=(dataclasses.replace(mag, initial_bias_nt=40000.0),)
    )
    readings = {"mag": source.sensors["mag"] + np.array(bias)}
    telemetry = Telemetry(times=source.times, gyro_deg_s=source.gyro_deg_s, sensors=readings)
    return scenario, telemetry, source


@pytest.mark.cases(1)
@pytest.mark.parametrize("bias", LARGE_BIASES)
def test_bias_as_large_as_field_is_estimated(bias):
    """The fit starts from the field strength, because such a bias makes the field directions
    useless.
    """
    scenario, telemetry, source = simulate_large_bias(4, bias)
    calibration, magnetometer_calibration = (
        calibrate(scenario, telemetry),
        calibrate_magnetometers(scenario, telemetry),
    )
    first = 3 * calibration.suite.blocks.index("mag.bias")
    true = source.truth.states[-1, first : first + 3] * scenario.sensors[0].telemetry_unit.factor
    for table in (calibration.build_table(), magnetometer_calibration.build_table()):
        rows = table[table["block"] == "mag.bias"]
        normalized_error = (rows["estimate"].to_numpy() - true - bias) / rows["sigma"].to_numpy()
        assert np.abs(normalized_error).max() < 5.0
    assert magnetometer_calibration.is_consistent
    assert len(magnetometer_calibration.notes) == 1
    sensors = tuple(scale_noise(sensor, 2.0) for sensor in scenario.sensors)
    noisy = calibrate_magnetometers(dataclasses.replace(scenario, sensors=sensors), telemetry)
    assert noisy.is_consistent
    declared, measured = map(float, re.findall(r"noise of ([0-9.]+) nT", noisy.notes[1]))
    assert declared / measured == pytest.approx(2.0, abs=0.5)
