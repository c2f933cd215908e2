"""Sensor suites for parametrized tests."""

import dataclasses

import pytest
from mgeo_attitude import (
    BiasSensitivity,
    EnvironmentErrors,
    Gyro,
    HorizonSensor,
    Magnetometer,
    Photodiode,
    Scenario,
    StarTracker,
    Suite,
    SunSensor,
    TwoAxisSunSensor,
)
from mgeo_attitude.scenario import HousekeepingChannel

#: Housekeeping channels of the suite "bias_sensitivities".
CHANNELS = (
    HousekeepingChannel(name="temp", in_sunlight=40.0, in_shadow=-20.0, time_constant=400.0),
    HousekeepingChannel(name="current", times=(0.0, 300.0, 900.0), values=(0.0, 0.5, -0.2)),
)

FULL = Scenario.cubesat_6u_full()
#: Sensors that measure in every step, for any filter step.
FULL_SENSORS = tuple(dataclasses.replace(each, sample_interval=None) for each in FULL.sensors)

SUITES = {
    "paper": Suite(Gyro(bias_decay=1e-5), (SunSensor(), Magnetometer())),
    "noise by axis": Suite(
        Gyro(
            angle_random_walk_deg_per_sqrt_h=(0.01, 0.2, 0.05),
            bias_instability_deg_per_h=(1.0, 5.0, 200.0),
            bias_decay=1e-3,
        ),
        (SunSensor(noise_deg=(0.5, 1.0, 4.0)), Magnetometer(noise_nt=(100.0, 500.0, 2000.0))),
    ),
    "two Sun sensors": Suite(
        Gyro(),
        (
            SunSensor(name="sun_x", boresight=(1.0, 0.0, 0.0), half_angle_deg=60.0),
            SunSensor(name="sun_z", boresight=(0.0, 1.0, -2.0), half_angle_deg=100.0),
            Magnetometer(),
        ),
    ),
    "soft iron": Suite(
        Gyro(initial_nonorthogonality_deg=0.1),
        (
            SunSensor(),
            Magnetometer(initial_scale_factor=0.02, initial_nonorthogonality_deg=0.5),
        ),
    ),
    "star tracker": Suite(Gyro(), (StarTracker(), Magnetometer())),
    "oblique star tracker": Suite(
        Gyro(),
        (
            StarTracker(
                boresight=(1.0, -2.0, 0.5),
                max_rate_deg_s=1.0,
                sun_exclusion_deg=60.0,
                earth_exclusion_deg=10.0,
                moon_exclusion_deg=40.0,
            ),
            Magnetometer(),
        ),
    ),
    "random-walk bias": Suite(Gyro(bias_decay=0.0), (SunSensor(), Magnetometer())),
    "full gyro": Suite(
        Gyro(initial_scale_factor=1e-3, initial_misalignment_deg=0.1), (SunSensor(), Magnetometer())
    ),
    "varying errors": Suite(
        Gyro(),
        (
            SunSensor(),
            Magnetometer(),
        ),
        EnvironmentErrors(
            albedo=0.05,
            albedo_correlation_time=40.0,
            field_error_nt=100.0,
            field_error_correlation_time=20.0,
        ),
    ),
    "orbit error": Suite(
        Gyro(initial_scale_factor=1e-3),
        (
            Magnetometer(name="inner"),
            SunSensor(boresight=(1.0, 0.0, 0.0), half_angle_deg=60.0),
            Magnetometer(),
        ),
        EnvironmentErrors(
            earth_albedo=0.3,
            albedo=0.03,
            field_error_nt=100.0,
            orbit_error_m=(2000.0, 200.0, 500.0),
            orbit_error_correlation_time=300.0,
        ),
    ),
    "considered": Suite(
        Gyro(initial_misalignment_deg=0.1, considered=("misalignment",)),
        (
            SunSensor(sample_interval=4.0),
            Magnetometer(initial_scale_factor=0.02, considered=("scale_factor",)),
        ),
        EnvironmentErrors(
            albedo=0.05,
            field_error_nt=100.0,
            orbit_error_m=(1000.0, 1000.0, 1000.0),
            orbit_error_axes="inertial",
            considered=("albedo", "orbit_error"),
        ),
    ),
    "two angles": Suite(
        Gyro(),
        (
            TwoAxisSunSensor(boresight=(1.0, 0.0, 0.0), half_angle_deg=60.0),
            HorizonSensor(sun_exclusion_deg=40.0, considered=("bias",), sample_interval=2.0),
            Magnetometer(),
        ),
        EnvironmentErrors(
            earth_albedo=0.3,
            albedo=0.03,
            orbit_error_m=(1000.0, 1000.0, 1000.0),
            orbit_error_correlation_time=300.0,
        ),
    ),
    "photodiodes": Suite(
        Gyro(),
        (
            Photodiode(name="px", normal=(1.0, 0.0, 0.0), relative_noise=0.01),
            Photodiode(name="mx", normal=(-1.0, 0.0, 0.0), initial_latency_s=0.5),
            Photodiode(name="py", normal=(0.0, 2.0, 0.1), considered=("sensitivity",)),
            Photodiode(
                name="mz", normal=(0.3, -1.0, -1.0), half_angle_deg=80.0, includes_albedo=False
            ),
            Magnetometer(),
        ),
        EnvironmentErrors(earth_albedo=0.3, albedo=0.03, orbit_error_m=(1000.0, 1000.0, 1000.0)),
    ),
    "bias_sensitivities": Suite(
        Gyro(
            initial_scale_factor=1e-3,
            bias_decay=1e-3,
            bias_sensitivities=(
                BiasSensitivity("temp", 1e-3, "degC", 20.0),
                BiasSensitivity("current", 0.02, "A"),
            ),
        ),
        (
            TwoAxisSunSensor(bias_sensitivities=(BiasSensitivity("temp", 1e-3, "degC"),)),
            Magnetometer(
                bias_sensitivities=(
                    BiasSensitivity("current", 2000.0, "A"),
                    BiasSensitivity("temp", 20.0, "degC", 20.0),
                )
            ),
        ),
    ),
    "a tracker says what body axes are": Suite(
        Gyro(initial_misalignment_deg=0.1, bias_instability_deg_per_h=2.0, bias_decay=1e-3),
        (
            # A star tracker with less noise reduces the first variance by seven digits in one
            # update.
            StarTracker(initial_misalignment_deg=0.0, noise_arcsec=30.0),
            SunSensor(),
            Magnetometer(initial_misalignment_deg=0.0),
        ),
    ),
    "late": Suite(
        Gyro(),
        (
            TwoAxisSunSensor(initial_latency_s=0.5),
            StarTracker(initial_latency_s=0.2, boresight=(1.0, -2.0, 0.5)),
            Magnetometer(initial_latency_s=1.0),
        ),
        EnvironmentErrors(orbit_error_m=(1000.0, 1000.0, 1000.0)),
    ),
    "cubesat_6u_full": Suite(FULL.gyro, FULL_SENSORS, FULL.environment_errors),
    "every constant": Suite(
        Gyro(
            initial_scale_factor=1e-3,
            initial_misalignment_deg=0.1,
            initial_nonorthogonality_deg=0.1,
        ),
        (
            SunSensor(),
            Magnetometer(initial_scale_factor=0.02, initial_nonorthogonality_deg=0.5),
        ),
    ),
}

#: Suites that together have most features: constant errors, considered states, processes, fields of
#: view, three-axis attitude and scalar measurements. Tests of the other suites are slow.
FAST = ("paper", "oblique star tracker", "considered", "every constant", "photodiodes")


def of_suites(names):
    """Return test parameters, of which suites outside of `FAST` are marked as slow."""
    return [n if n in FAST else pytest.param(n, marks=pytest.mark.slow) for n in names]


every_suite = pytest.mark.parametrize("name", of_suites(SUITES))
