"""Gyro parameters, and sensors without misalignment."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Gyro, Magnetometer, Scenario, StarTracker, Suite, SunSensor
from mgeo_attitude.settings.errors import InvalidValue


@pytest.mark.parametrize(("floor", "decay"), [(0.5, 1e-3), (10.0, 2e-2)])
def test_bias_instability_is_maximum_allan_deviation_of_gauss_markov_process(floor, decay):
    """The Allan variance of a Gauss-Markov process is IEEE Std 952-1997, equation C.11."""
    gyro = Gyro(bias_instability_deg_per_h=floor, bias_decay=decay)
    T, (q, _, _) = 1.0 / decay, np.sqrt(gyro.compute_noise_density()["bias"])
    tau = np.geomspace(0.1, 10.0, 2000) * T
    decay_terms = 3.0 - 4.0 * np.exp(-tau / T) + np.exp(-2.0 * tau / T)
    variance = (q * T) ** 2 / tau * (1.0 - T / (2.0 * tau) * decay_terms)
    assert np.degrees(np.sqrt(variance.max())) * 3600.0 == pytest.approx(floor, rel=2e-3)
    assert Gyro(rate_random_walk=2e-7).effective_rate_random_walk == (2e-7,) * 3


def test_inconsistent_bias_parameters_are_rejected():
    expected = r"bias_instability_deg_per_h = 1.0: expected bias_decay > 0"
    with pytest.raises(InvalidValue, match=expected):
        Gyro(bias_instability_deg_per_h=1.0)
    with pytest.raises(InvalidValue, match=r"rate_random_walk = .*expected all > 0 rad/s\^1.5, or"):
        Gyro(rate_random_walk=(0.0, 1e-8, 1e-8))


def test_maximum_rate_above_gyro_range_is_rejected():
    paper = Scenario.paper()
    assert paper.maneuvers.max_rate_deg_s == 1.0
    dataclasses.replace(paper, gyro=Gyro(range_deg_per_s=1.0))
    expected = r"maneuvers.max_rate_deg_s = 1.0: expected at most gyro.range_deg_per_s = 0.5"
    with pytest.raises(InvalidValue, match=expected):
        dataclasses.replace(paper, gyro=Gyro(range_deg_per_s=0.5))


def test_star_tracker_without_misalignment_measures_attitude_error_only():
    sensors = (
        StarTracker(initial_misalignment_deg=0.0),
        SunSensor(initial_misalignment_deg=0.0),
        Magnetometer(),
    )
    suite = Suite(Gyro(), sensors)
    sensor_blocks = ("sun.bias", "mag.misalignment", "mag.bias")
    assert suite.blocks == ("attitude", "gyro.bias", *sensor_blocks)
    H = suite.measurement_matrix(sensors[0], np.zeros(3))
    np.testing.assert_allclose(H[:, :3] @ H[:, :3].T, np.eye(3), atol=1e-15)
    assert not H[:, 3:].any()


def test_gyro_bias_decays_only_in_paper_preset():
    presets = ("cubesat_6u", "cubesat_6u_full", "cubesat_1u", "microsatellite")
    assert {Scenario.from_dict({"preset": name}).gyro.bias_decay for name in presets} == {0.0}
    assert Gyro().bias_decay == 0.0
    assert Scenario.paper().gyro.bias_decay == 1e-5
