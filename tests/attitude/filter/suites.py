"""Sensor suites that the filter's tests run over."""

from mgeo_attitude import Gyro, Magnetometer, StarTracker, Suite, SunSensor

SUITES = {
    "paper": Suite(Gyro(), (SunSensor(), Magnetometer())),
    "no magnetometer": Suite(Gyro(), (SunSensor(),)),
    "no Sun sensor": Suite(Gyro(), (Magnetometer(),)),
    "two Sun sensors": Suite(
        Gyro(),
        (
            SunSensor(name="sun_x", boresight=(1.0, 0.0, 0.0), field_of_view_deg=60.0),
            SunSensor(name="sun_z", boresight=(0.0, 1.0, -2.0), field_of_view_deg=100.0),
            Magnetometer(),
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
}
