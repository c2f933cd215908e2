"""Rare or coarsely quantized gyro samples are not attributed to other sensors."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from mgeo_attitude import Scenario
from mgeo_calibration import TelemetryMapping, calibrate

FILES = Path(__file__).parent / "coarse"


@pytest.fixture
def beacons():
    scenario = Scenario.from_toml(FILES / "beacons.toml")
    steady = dataclasses.replace(scenario.gyro, bias_decay=0.0)  # The simulated bias is constant.
    scenario = dataclasses.replace(scenario, gyro=steady)
    mapping = TelemetryMapping.from_toml(FILES / "beacons-columns.toml")
    return scenario, lambda scenario: calibrate(scenario, FILES / "beacons.csv.gz", mapping)


@pytest.mark.slow
def test_noisy_gyro_is_identified_with_consistent_noise(beacons):
    scenario, calibrated = beacons
    key = r"Set gyro\.angle_random_walk_deg_per_sqrt_h"
    with pytest.raises(ValueError, match=rf"^gyro is noisier than declared, .* {key}") as refused:
        calibrated(scenario)
    said = re.search(
        r"about ([0-9.]+) deg/sqrt\(h\).*sample_noise_deg_s = ([0-9.]+)", str(refused.value)
    )
    walk, sample = map(float, said.groups())
    assert 12.0 < walk < 24.0  # 15 from the samples, the rest from rate changes.
    for changes in ({"angle_random_walk_deg_per_sqrt_h": walk}, {"sample_noise_deg_s": sample}):
        gyro = dataclasses.replace(scenario.gyro, **changes)
        found = calibrated(dataclasses.replace(scenario, gyro=gyro))
        assert found.is_consistent, found.conclusion
        bias = found.build_table().query("block == 'mag.bias'")
        off = (bias["estimate"] - [18300.0, -42700.0, 90000.0]) / bias["sigma"]
        assert np.abs(off).max() < 3.0


def test_coarsely_quantized_gyro_is_consistent_with_note():
    found = calibrate(Scenario.from_toml(FILES / "counts.toml"), FILES / "counts.csv.gz")
    assert found.is_consistent, found.conclusion
    assert not any(re.match("(sun|mag): sigmas", note) for note in found.notes)
    assert any("noise or steps of the gyro" in note for note in found.notes)
    bias = found.build_table().query("block == 'gyro.bias'")
    off = (bias["estimate"] / 3600.0 - [-2.1, -3.6, 1.4]) / (bias["sigma"] / 3600.0)
    assert np.abs(off).max() < 3.0
