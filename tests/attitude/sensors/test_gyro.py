"""Figures of a gyro's data sheet, and sensors that say what body axes are."""

import dataclasses

import numpy as np
import pytest
from mgeo_attitude import Gyro, Magnetometer, Scenario, StarTracker, Suite, SunSensor
from mgeo_attitude.settings.errors import InvalidValue


@pytest.mark.parametrize(("floor", "decay"), [(0.5, 1e-3), (10.0, 2e-2)])
def test_bias_instability_is_the_top_of_the_markov_process_s_allan_deviation(floor, decay):
    """Allan variance of such a process: IEEE Std 952-1997, equation C.11."""
    gyro = Gyro(bias_instability_deg_per_h=floor, bias_decay=decay)
    T, (q, _, _) = 1.0 / decay, np.sqrt(gyro.compute_noise_density()["bias"])
    tau = np.geomspace(0.1, 10.0, 2000) * T
    rest = 3.0 - 4.0 * np.exp(-tau / T) + np.exp(-2.0 * tau / T)
    variance = (q * T) ** 2 / tau * (1.0 - T / (2.0 * tau) * rest)
    assert np.degrees(np.sqrt(variance.max())) * 3600.0 == pytest.approx(floor, rel=2e-3)
    assert Gyro(rate_random_walk=2e-7).effective_rate_random_walk == (2e-7,) * 3


def test_a_floor_that_no_process_has_is_refused():
    expected = r"bias_instability_deg_per_h = 1.0: expected none without bias_decay"
    with pytest.raises(InvalidValue, match=expected):
        Gyro(bias_instability_deg_per_h=1.0)
    with pytest.raises(InvalidValue, match=r"rate_random_walk = .*expected all > 0 rad/s\^1.5, or"):
        Gyro(rate_random_walk=(0.0, 1e-8, 1e-8))


def test_no_plan_is_faster_than_the_gyro_measures():
    paper = Scenario.paper()
    assert paper.maneuvers.max_rate_deg_s == 1.0
    dataclasses.replace(paper, gyro=Gyro(range_deg_per_s=1.0))
    expected = r"maneuvers.max_rate_deg_s = 1.0: expected at most gyro.range_deg_per_s = 0.5"
    with pytest.raises(InvalidValue, match=expected):
        dataclasses.replace(paper, gyro=Gyro(range_deg_per_s=0.5))


def test_a_sensor_without_misalignment_sees_the_attitude_alone():
    sensors = (
        StarTracker(initial_misalignment_deg=0.0),
        SunSensor(initial_misalignment_deg=0.0),
        Magnetometer(),
    )
    suite = Suite(Gyro(), sensors)
    own = ("sun.bias", "mag.misalignment", "mag.bias")
    assert suite.blocks == ("attitude", "gyro.bias", *own)
    H = suite.measurement_matrix(sensors[0], np.zeros(3))
    np.testing.assert_allclose(H[:, :3] @ H[:, :3].T, np.eye(3), atol=1e-15)
    assert not H[:, 3:].any()


def test_the_bias_decays_in_the_paper_s_scenario_alone():
    presets = ("cubesat_6u", "cubesat_6u_full", "cubesat_1u", "microsatellite")
    assert {Scenario.from_dict({"preset": name}).gyro.bias_decay for name in presets} == {0.0}
    assert Gyro().bias_decay == 0.0
    assert Scenario.paper().gyro.bias_decay == 1e-5
