"""Magnetometers by the strength of the field, beside scipy and by an independent simulation."""

import dataclasses

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


def readings(seed, n=2000, true=TRUE):
    """Of a magnetometer that is turned anyhow, as is defined: scale, shear, bias, noise."""
    generator = np.random.default_rng(seed)
    strength = generator.uniform(25000.0, 55000.0, n)
    field = Rotation.random(n, rng=generator).apply([0.0, 0.0, 1.0]) * strength[:, None]
    k, (yz, zx, xy) = true[3:6], true[6:]
    shear = np.array([[0.0, xy, zx], [xy, 0.0, yz], [zx, yz, 0.0]])
    measured = field + field * k + field @ shear + true[:3]
    return measured + SIGMA * generator.standard_normal((n, 3)), strength


def test_it_is_the_least_squares_of_scipy():
    """The same sum of squares, minimized by another program with numerical derivatives."""
    measured, strength = readings(1)
    found = fit_field_strength(measured, strength, SIGMA, np.zeros(9), PRIOR)
    W = np.linalg.inv(compute_response_matrix(found.parameters))
    u = (measured - found.parameters[:3]) @ W
    noise = W @ np.diag(SIGMA**2) @ W
    spread = np.sqrt(4.0 * np.einsum("ni,ij,nj->n", u, noise, u) + 2.0 * (noise**2).sum())

    def residual(x):
        values = x * PRIOR
        u = np.linalg.solve(compute_response_matrix(values), (measured - values[:3]).T).T
        bias = np.trace(np.linalg.inv(compute_response_matrix(values)) @ np.diag(SIGMA**2)
                        @ np.linalg.inv(compute_response_matrix(values)))  # fmt: skip
        return np.concatenate([((u**2).sum(axis=1) - strength**2 - bias) / spread, x])

    other = least_squares(
        residual, found.parameters / PRIOR * 0.9, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    sigma = np.sqrt(np.diag(found.covariance))
    assert (np.abs(other.x * PRIOR - found.parameters) / sigma).max() < 1e-2
    covariance = np.linalg.inv(other.jac.T @ other.jac) * np.outer(PRIOR, PRIOR)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), sigma, rtol=0.01)


def test_errors_are_as_large_as_the_covariance_says():
    """Mean square of 60 draws, in the metric of the covariance, within chance."""
    squares = []
    for seed in range(60):
        measured, strength = readings(100 + seed, 400)
        found = fit_field_strength(measured, strength, SIGMA, np.zeros(9), PRIOR)
        off = found.parameters - TRUE
        squares.append(off @ np.linalg.solve(found.covariance, off))
    # 4.5 standard deviations of the mean of 60 chi-squares of 9
    assert abs(np.mean(squares) - 9.0) < 4.5 * np.sqrt(18.0 / 60.0)


CUBESAT = short(Scenario.from_dict({"preset": "cubesat_6u"}), 3000.0)
LARGE = ((-51000.0, 17000.0, -37000.0), (27000.0, 42000.0, -62000.0))


def with_bias(seed, bias):
    """Gyro and magnetometer alone, whose bias is as large as that of two known cubesats."""
    (mag,) = (sensor for sensor in CUBESAT.sensors if sensor.name == "mag")
    flown = dataclasses.replace(CUBESAT, sensors=(mag,))
    sent = simulate_telemetry(flown, PLAN, seed)
    of = dataclasses.replace(CUBESAT, sensors=(dataclasses.replace(mag, initial_bias_nt=40000.0),))
    readings = {"mag": sent.sensors["mag"] + np.array(bias)}
    telemetry = Telemetry(times=sent.times, gyro_deg_s=sent.gyro_deg_s, sensors=readings)
    return of, telemetry, sent


@pytest.mark.cases(1)
@pytest.mark.parametrize("bias", LARGE)
def test_a_bias_as_large_as_the_field_is_found(bias):
    """The start is by strength: directions with such a bias in them say that the gyro is wrong."""
    of, telemetry, sent = with_bias(4, bias)
    found, alone = calibrate(of, telemetry), calibrate_magnetometers(of, telemetry)
    first = 3 * found.suite.blocks.index("mag.bias")
    true = sent.truth.states[-1, first : first + 3] * of.sensors[0].telemetry_unit.factor
    for table in (found.build_table(), alone.build_table()):
        rows = table[table["block"] == "mag.bias"]
        off = (rows["estimate"].to_numpy() - true - bias) / rows["sigma"].to_numpy()
        assert np.abs(off).max() < 5.0
    assert alone.is_consistent
    assert len(alone.notes) == 1
    sensors = tuple(scale_noise(sensor, 2.0) for sensor in of.sensors)
    noisy = calibrate_magnetometers(dataclasses.replace(of, sensors=sensors), telemetry)
    assert noisy.is_consistent
    assert "sigmas are too large by 2" in noisy.notes[1]
