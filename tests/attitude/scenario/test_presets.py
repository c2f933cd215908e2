"""Presets, against Table 2 of the paper and against the sources of their values."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mgeo_attitude.scenario import Orbit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors import Magnetometer, SunSensor


def test_paper_orbit_and_maneuver_bounds_equal_table_2() -> None:
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
    bounds = scenario.maneuvers
    assert (bounds.count, bounds.max_rate_deg_s, bounds.max_duration) == (3, 1.0, 2000.0)


def test_paper_sensors_have_values_in_filter_units() -> None:
    sun, mag = Scenario.paper().sensors
    assert isinstance(sun, SunSensor)
    assert isinstance(mag, Magnetometer)
    assert sun.noise_sigmas() == pytest.approx([0.0349] * 3, abs=5e-5)  # 2 deg on the unit vector
    assert sun.states() == {"misalignment": math.radians(1.0), "bias": 0.02}
    assert mag.noise_sigmas() == pytest.approx([500.0 / 50_000.0] * 3)
    assert mag.states() == pytest.approx(
        {"misalignment": math.radians(1.0), "bias": 2000.0 / 50_000.0}
    )


def test_cubesat_1u_has_magnetorquers_and_microsatellite_has_wheels() -> None:
    small, large = Scenario.cubesat_1u(), Scenario.microsatellite()
    assert small.is_magnetorquer_driven
    assert small.magnetorquers is not None
    windings, area, current = 450, 0.0049, 3.3 / 107.0
    assert small.magnetorquers.max_dipole == pytest.approx(
        [windings * area * current] * 3, rel=1e-3
    )
    assert small.duration == pytest.approx(2.0 * small.orbit.period, abs=small.step)
    assert not large.is_magnetorquer_driven
    assert large.wheels is not None
    x, y, z = 0.6, 0.7, 0.87
    sides = np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    np.testing.assert_allclose(large.wheels.inertia, 110.0 / 12.0 * sides, rtol=1e-3)
    assert [sensor.kind for sensor in large.sensors].count("star-tracker") == 2
    assert small.assumptions == large.assumptions == ()
