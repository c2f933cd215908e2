"""The presets against the paper's table 2 and the values that the project fixed, in their units."""

from __future__ import annotations

import dataclasses
import math
from datetime import UTC, datetime

import numpy as np
import pytest
from mgeo_attitude import Suite
from mgeo_attitude.scenario import Orbit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.settings import Convergence
from mgeo_attitude.scenario.toml import PRESETS
from mgeo_attitude.sensors import Magnetometer, SunSensor
from mgeo_attitude.settings.tables import to_table


def test_paper_orbit_and_limits_are_those_of_table_2() -> None:
    scenario = Scenario.paper()
    orbit = scenario.orbit
    assert isinstance(orbit, Orbit)
    assert orbit.propagator == "two-body"
    assert orbit.semi_major_axis == 7130982.0
    assert orbit.eccentricity == 0.001111
    assert orbit.inclination_deg == 98.405
    assert orbit.raan_deg == 230.297
    assert orbit.argument_of_perigee_deg == 90.0
    assert orbit.true_anomaly_deg == 305.0
    assert orbit.period == pytest.approx(5992.0, abs=1.0)
    assert scenario.duration == 2 * 5992.0
    assert scenario.step == 1.0
    assert scenario.n_steps == 11984
    limits = scenario.maneuvers
    assert (limits.count, limits.max_rate_deg_s, limits.max_duration) == (3, 1.0, 2000.0)


def test_paper_leaves_open_what_reproduces_its_fronts() -> None:
    scenario = Scenario.paper()
    assert scenario.epoch == datetime(2018, 6, 5, tzinfo=UTC)
    assert scenario.eclipse is False
    assert (scenario.convergence.window, scenario.convergence.relative_decrease) == (300.0, 0.05)
    assert scenario.initial.attitude_deg == 5.0
    assert dict(scenario.trace_weights) == {}
    gyro = scenario.gyro
    assert gyro.angle_random_walk_deg_per_sqrt_h == 0.01
    assert gyro.rate_random_walk == 3e-8
    assert gyro.bias_decay == 1e-5
    assert gyro.states() == {"bias": math.radians(0.01)}


def test_paper_sensors_in_the_units_of_the_filter() -> None:
    sun, mag = Scenario.paper().sensors
    assert isinstance(sun, SunSensor)
    assert isinstance(mag, Magnetometer)
    assert sun.noise() == pytest.approx([0.0349] * 3, abs=5e-5)  # 2 deg on the unit vector
    assert sun.states() == {"misalignment": math.radians(1.0), "bias": 0.02}
    assert mag.noise() == pytest.approx([500.0 / 50_000.0] * 3)
    assert mag.states() == pytest.approx(
        {"misalignment": math.radians(1.0), "bias": 2000.0 / 50_000.0}
    )


def test_the_paper_has_18_states() -> None:
    scenario = Scenario.paper()
    assert Suite(scenario.gyro, scenario.sensors).blocks == (
        "attitude",
        "gyro.bias",
        "sun.misalignment",
        "sun.bias",
        "mag.misalignment",
        "mag.bias",
    )


def test_cubesat_instruments() -> None:
    scenario = Scenario.cubesat_6u()
    gyro, (sun, mag) = scenario.gyro, scenario.sensors
    assert gyro.angle_random_walk_deg_per_sqrt_h == 0.15
    assert gyro.rate_random_walk == 8.1e-8
    assert gyro.initial_bias_deg_s * 3600.0 == pytest.approx(10.0, rel=1e-15)  # deg/h
    assert isinstance(sun, SunSensor)
    assert sun.noise_deg == 0.5
    assert sun.initial_misalignment_deg == 0.5
    assert math.degrees(sun.initial_bias) == pytest.approx(0.17, rel=1e-15)
    assert isinstance(mag, Magnetometer)
    assert (mag.noise_nt, mag.initial_misalignment_deg, mag.initial_bias_nt) == (100.0, 1.0, 500.0)
    assert scenario.initial.attitude_deg == 10.0
    assert scenario.eclipse is True


def test_cubesat_shares_the_papers_orbit_and_limits() -> None:
    paper, cubesat = Scenario.paper(), Scenario.cubesat_6u()
    for key in ("epoch", "duration", "step", "orbit"):
        assert getattr(cubesat, key) == getattr(paper, key)
    assert cubesat.maneuvers == dataclasses.replace(paper.maneuvers, count=6)


def test_all_but_the_paper_s_ask_what_is_known_at_the_end_of_six_maneuvers() -> None:
    found = {name: Scenario.from_dict({"preset": name}) for name in PRESETS}
    asked = {name: (each.maneuvers.count, each.convergence.rule) for name, each in found.items()}
    assert asked.pop("paper") == (3, "trace")
    assert set(asked.values()) == {(6, "end")}


def test_only_the_papers_runs_may_end_on_a_rise() -> None:
    paper, cubesat = Scenario.paper().convergence, Scenario.cubesat_6u().convergence
    assert paper.allow_rise is True
    assert cubesat == dataclasses.replace(
        paper, rule="end", relative_decrease=0.01, allow_rise=False
    )
    assert Convergence().allow_rise is False


def test_a_preset_is_named_after_itself() -> None:
    assert {name: Scenario.from_dict({"preset": name}).name for name in PRESETS} == {
        "paper": "paper",
        "cubesat_1u": "cubesat_1u",
        "cubesat_6u": "cubesat_6u",
        "microsatellite": "microsatellite",
        "cubesat_6u_full": "cubesat_6u_full",
    }


def test_the_full_cubesat_has_every_error_and_is_the_cubesat_otherwise() -> None:
    plain, full = Scenario.cubesat_6u(), Scenario.cubesat_6u_full()
    suite = full.suite
    assert suite.blocks == (
        "attitude",
        "gyro.bias",
        "gyro.scale_factor",
        "gyro.misalignment",
        "gyro.nonorthogonality",
        "world.albedo",
        "world.field_error",
        "world.orbit_error",
        "sun.misalignment",
        "sun.bias",
        "mag.misalignment",
        "mag.bias",
        "mag.scale_factor",
        "mag.nonorthogonality",
    )
    assert suite.considered.tolist() == [21, 22, 23]
    off = dict.fromkeys(
        [
            "initial_scale_factor",
            "initial_misalignment_deg",
            "initial_nonorthogonality_deg",
        ],
        0.0,
    )
    table, expected = full.to_dict(), plain.to_dict() | {"world": to_table(full.world)}
    for key, values in off.items():
        if key in table["gyro"]:
            table["gyro"][key] = values
        for one in (table, expected):
            for sensor in one["sensors"]:
                if key in sensor and key != "initial_misalignment_deg":
                    sensor[key] = values
                for name in ("sample_interval", "considered"):
                    sensor.pop(name, None)
    assert table | {"name": "cubesat_6u"} == expected


def test_the_small_cubesat_is_turned_by_coils_and_the_large_satellite_by_wheels() -> None:
    small, large = Scenario.cubesat_1u(), Scenario.microsatellite()
    assert small.turned_by_coils
    assert small.coils is not None
    turns, area, ampere = 450, 0.0049, 3.3 / 107.0
    assert small.coils.max_dipole == pytest.approx([turns * area * ampere] * 3, rel=1e-3)
    assert small.duration == pytest.approx(2.0 * small.orbit.period, abs=small.step)
    assert not large.turned_by_coils
    assert large.wheels is not None
    x, y, z = 0.6, 0.7, 0.87
    sides = np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    np.testing.assert_allclose(large.wheels.inertia, 110.0 / 12.0 * sides, rtol=1e-3)
    assert [sensor.kind for sensor in large.sensors].count("star-tracker") == 2
    assert small.assumed == large.assumed == ()
