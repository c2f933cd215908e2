"""Conversion of the telemetry of a scenario to a batch, the input of the estimator.

A batch contains the gyro rates of the steps between samples, and the readings of the sensors with
the vectors that the sensors observe.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.model import compute_references
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.measurements import stack_noise_sigmas
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite

from mgeo_calibration.estimation.prior import UNKNOWN_ATTITUDE_SIGMA
from mgeo_calibration.telemetry.attitude_hold import AssumedAttitude
from mgeo_calibration.telemetry.columns import find_sensitivity_channels
from mgeo_calibration.telemetry.findings import Samples
from mgeo_calibration.telemetry.gyro_samples import (
    UNKNOWN_RATE_RATIO,
    compute_averaging_durations,
    compute_median_step,
    compute_rate_sigma,
    compute_step_rates,
    find_gyro_spikes,
    select_gyro_samples,
)
from mgeo_calibration.telemetry.orbit_checks import find_invalid_norms
from mgeo_calibration.telemetry.quantization import compute_angle_variance_rate
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Names of the channels with the absolute gyro rate about each axis [deg/s]. A bias proportional to
#: such a channel is a scale factor that differs between the two senses of rotation.
RATE_MAGNITUDES = ("abs_gyro_x", "abs_gyro_y", "abs_gyro_z")


@dataclass(frozen=True, eq=False, kw_only=True)
class Batch:
    """Telemetry prepared for the estimator: gyro rates, sensor readings and observed vectors at
    n + 1 samples.

    Attributes
    ----------
    suite : Suite
        Gyro and sensors. The sample noise of the gyro is converted to angle random walk.
    times : array, shape (n + 1,)
        Time of each sample after the epoch [s].
    gyro_rates : array, shape (n, 3)
        Mean measured rate in each step [rad/s].
    rate_changes : array, shape (n, 3)
        Change of the measured rate from the start to the end of each step [rad/s].
    excess_angle_variance : array, shape (n, 3)
        Variance of the rotation angle about each body axis in each step, in addition to the gyro
        noise [rad²]. Sources are interpolated rates, gyro spikes and quantization.
    breaks : array of bool, shape (n,)
        Steps in which the gyro does not determine the rotation.
    readings : tuple of arrays, shape (n + 1, k, 3)
        Readings of each sensor, as in `Measurements.sensors`; NaN without a reading.
    noise : array, shape (s, 3)
        1-sigma of each component of the sensors' readings, including quantization; see
        `stack_noise_sigmas`.
    vectors : array, shape (n + 1, n_vectors, 3)
        Reference and auxiliary vectors of the sensors in GCRS; see `FilterModel.references`.
    channel_values : array, shape (n + 1, n_sensitivities)
        Channels of the bias sensitivities; see `Suite.compute_channel_deviations`.
    pointing : AssumedAttitude, optional
        Attitude that a satellite without a gyro is assumed to hold. The attitude then varies by the
        pointing error instead of the measured rates.
    """

    suite: Suite
    times: Floats
    gyro_rates: Floats
    rate_changes: Floats
    excess_angle_variance: Floats
    breaks: Bools
    readings: tuple[Floats, ...]
    noise: Floats
    vectors: Floats
    channel_values: Floats
    pointing: AssumedAttitude | None = None

    def select_channel_values(self, owner: Gyro | Sensor, samples: slice | Ints) -> list[Floats]:
        """Return the channel values, such as temperatures, on which the bias of a gyro or sensor
        depends.

        Parameters
        ----------
        owner : Gyro or Sensor
        samples : slice or array of int
            Selection of m samples.

        Returns
        -------
        list of arrays, shape (m, 1)
            Deviation of each channel from its reference value, one array for each bias sensitivity.
        """
        columns = self.suite.find_sensitivity_columns(owner)
        return [self.channel_values[samples][:, [k]] for k in range(columns.start, columns.stop)]

    @property
    def durations(self) -> Floats:
        """Duration of each step [s], shape (n,)."""
        return np.diff(self.times)

    @property
    def has_reading(self) -> Bools:
        """Boolean mask of shape (s, n + 1) that marks the samples at which each sensor has a
        reading.
        """
        return np.stack([np.isfinite(rows[:, 0, 0]) for rows in self.readings])

    def select_samples(self, low: int, high: int) -> Batch:
        """Return a batch that contains only the samples `low` to `high` - 1."""
        samples, steps = slice(low, high), slice(low, high - 1)
        return replace(
            self,
            times=self.times[samples],
            gyro_rates=self.gyro_rates[steps],
            rate_changes=self.rate_changes[steps],
            excess_angle_variance=self.excess_angle_variance[steps],
            breaks=self.breaks[steps],
            readings=tuple(rows[samples] for rows in self.readings),
            vectors=self.vectors[samples],
            channel_values=self.channel_values[samples],
            pointing=self.pointing
            and self.pointing._replace(attitude=self.pointing.attitude[samples]),
        )


def build_batch(scenario: Scenario, telemetry: Telemetry) -> Batch:
    """Build the input of the estimator from the telemetry of a scenario.

    The observed vectors follow from the orbit and the environment of the scenario. Some telemetry
    is omitted, replaced or used with a larger variance:

    - Readings of a sensor are omitted at samples at which a scenario with eclipses predicts no
      measurement, and readings of a photodiode where the Sun is outside its field of view.
    - Missing gyro rates are interpolated. Their 1-sigma is half of the difference between the
      neighboring rates.
    - A gyro spike is replaced by the rate that its neighbors predict. Its 1-sigma is the size of
      the spike.
    - Samples in gyro gaps longer than `UNKNOWN_RATE_RATIO` median steps are omitted.
    - If the scenario has the result of an earlier calibration as its prior, samples up to the epoch
      are omitted, because the earlier calibration has used them. The first sample is then the
      epoch.

    Parameters
    ----------
    scenario : Scenario
    telemetry : Telemetry
        Telemetry with times after the epoch of the scenario.

    Returns
    -------
    Batch

    Raises
    ------
    ValueError
        If the sensors of the telemetry are not the sensors of the scenario, the gyro has fewer than
        two samples, the channel of a bias sensitivity is missing, the vectors have another unit, or
        no telemetry follows the epoch of a scenario with a prior.
    """
    for finding in find_invalid_norms(Samples.from_telemetry(scenario, telemetry)):
        raise ValueError(str(finding))
    if scenario.prior is not None:
        telemetry = _select_after_epoch(scenario, telemetry)
    gyro_times, rates = select_gyro_samples(telemetry)
    median_step = compute_median_step(gyro_times)
    suite = replace(scenario.suite, gyro=scenario.gyro.convert_sample_noise(median_step))
    readings = telemetry.build_readings(suite)
    is_selected = np.isfinite(telemetry.gyro_deg_s[:, 0])
    is_selected |= np.any([np.isfinite(rows[:, 0, 0]) for rows in readings], axis=0)
    gaps = (np.diff(gyro_times) > UNKNOWN_RATE_RATIO * median_step).nonzero()[0]
    for gap_start, gap_end in zip(gyro_times[gaps], gyro_times[gaps + 1], strict=True):
        is_selected &= (telemetry.times <= gap_start) | (telemetry.times >= gap_end)
    is_selected &= (telemetry.times >= gyro_times[0] - median_step) & (
        telemetry.times <= gyro_times[-1] + median_step
    )
    is_selected[0] |= scenario.prior is not None

    times = telemetry.times[is_selected]
    position, hold = telemetry.interpolate_positions(times), telemetry.attitude_hold
    environment = Environment.from_times(scenario, times, position)
    if not scenario.eclipse:
        environment = environment.without_eclipses()
    vectors, available = compute_references(suite, environment)
    sensors = tuple(
        np.where(
            available[:, i, None, None],
            mask_dark_readings(suite.sensors[i], rows[is_selected]),
            np.nan,
        )
        for i, rows in enumerate(readings)
    )
    spikes = find_gyro_spikes(suite, telemetry)
    rates -= spikes
    gyro_rates, rate_changes, gap_variance, breaks = compute_step_rates(
        times, gyro_times, rates, median_step
    )
    declared = suite.gyro.quantization_deg_per_s or 0.0
    quantization_step = np.radians(np.maximum(telemetry.find_quantization_steps("gyro"), declared))
    sigma = compute_rate_sigma(suite, median_step)
    quantization_variance = compute_angle_variance_rate(
        rates, median_step, quantization_step, sigma
    )
    # With this variance, the vector sensors determine whether the body has rotated by a spike. All
    # steps within one gyro sample share the error of the sample.
    averaging_durations = compute_averaging_durations(gyro_times)[:, None]
    spike_variance = (
        np.minimum(
            np.abs(spikes).max(axis=1, keepdims=True) * averaging_durations, UNKNOWN_ATTITUDE_SIGMA
        )
        ** 2
        / averaging_durations
    )
    gyro_samples = np.minimum(np.searchsorted(gyro_times, times[1:]), len(gyro_times) - 1)
    return Batch(
        suite=suite,
        times=times,
        gyro_rates=gyro_rates,
        rate_changes=rate_changes,
        excess_angle_variance=gap_variance[:, None]
        + (quantization_variance + spike_variance)[gyro_samples] * np.diff(times)[:, None],
        breaks=breaks & (hold is None),
        readings=sensors,
        noise=stack_noise_sigmas(_compute_noise(sensor, telemetry) for sensor in suite.sensors),
        vectors=vectors,
        channel_values=suite.compute_channel_deviations(
            {
                name: np.interp(times, telemetry.times, values)
                for name, values in find_sensitivity_channels(
                    suite, collect_channels(telemetry)
                ).items()
            },
            len(times),
        ),
        pointing=hold.compute_attitude(scenario, times, position) if hold else None,
    )


def collect_channels(telemetry: Telemetry) -> dict[str, Floats]:
    """Return the telemetry channels on which a bias may depend, as arrays of shape (n,) keyed by
    channel name.

    These are all housekeeping columns, and the absolute gyro rate about each axis; see
    `RATE_MAGNITUDES`.

    Parameters
    ----------
    telemetry : Telemetry
        Telemetry of n samples.
    """
    has_gyro = np.isfinite(telemetry.gyro_deg_s[:, 0])
    gyro_times, rates = telemetry.times[has_gyro], np.abs(telemetry.gyro_deg_s[has_gyro])
    magnitudes = {
        name: np.interp(telemetry.times, gyro_times, rates[:, axis])
        for axis, name in enumerate(RATE_MAGNITUDES)
    }
    return {**magnitudes, **telemetry.housekeeping}


def mask_dark_readings(sensor: Sensor, readings: Floats) -> Floats:
    """Return the readings of a photodiode, with NaN where the Sun is outside its field of view.

    The mean of the readings before and after a sample decides. If the reading itself decided, only
    readings with noise of one sign would remain near the edge of the field of view. A reading
    without neighbors decides for itself. Readings of other sensors are returned unchanged.

    Parameters
    ----------
    sensor : Sensor
    readings : array, shape (n, k, 3)
        Readings of the sensor.

    Returns
    -------
    array, shape (n, k, 3)
    """
    if not isinstance(sensor, Photodiode):
        return readings
    values = readings[:, 0, 0]
    neighbors = np.full((2, len(values)), np.nan)
    neighbors[0, 1:], neighbors[1, :-1] = values[:-1], values[1:]
    count = np.isfinite(neighbors).sum(axis=0)
    mean = np.where(count > 0, np.nansum(neighbors, axis=0) / np.maximum(count, 1), values)
    lit = mean >= np.cos(np.radians(sensor.half_angle_deg))
    result: Floats = np.where(lit[:, None, None], readings, np.nan)
    return result


def _compute_noise(sensor: Sensor, telemetry: Telemetry) -> Floats:
    """Return the 1-sigma noise of each component of a sensor's readings, including quantization, as
    an array of shape (k,).
    """
    step, sigma = telemetry.find_quantization_steps(sensor.name), np.array(sensor.noise_sigmas())
    if sensor.has_unit_length:
        rows = telemetry.sensors[sensor.name]
        lengths = np.linalg.norm(rows[np.isfinite(rows[:, 0])], axis=1)
        step = np.full(len(sigma), step.max() / np.median(lengths) if len(lengths) else 0.0)
    elif len(sensor.telemetry_suffixes) < 4:
        step = step / sensor.telemetry_unit.factor
    else:  # A rotation by a small angle changes a quaternion by half of the angle.
        step = 2.0 * np.full(3, step.max())
    noise: Floats = np.sqrt(sigma**2 + step**2 / 12.0)
    return noise


def _select_after_epoch(scenario: Scenario, telemetry: Telemetry) -> Telemetry:
    """Return the telemetry after the epoch of the scenario, preceded by a sample at the epoch
    without readings.
    """
    later = telemetry.times > 0.0
    if later.sum() < 2:
        raise ValueError(
            f"telemetry ends at {telemetry.times[-1]:.6f} s after {scenario.epoch.isoformat()}: "
            "expected samples after this epoch, because the calibration in the scenario's prior "
            "has already used all earlier samples. Add later telemetry, or remove the prior"
        )

    def prepend_nan(rows: Floats) -> Floats:
        return np.vstack([np.full(rows.shape[1], np.nan), rows[later]])

    position = telemetry.position
    if position is not None:
        start, _ = scenario.orbit.propagate(scenario.epoch, np.zeros(1))
        position = np.vstack([start, position[later]])
    return Telemetry(
        times=np.append(0.0, telemetry.times[later]),
        gyro_deg_s=prepend_nan(telemetry.gyro_deg_s),
        sensors={name: prepend_nan(rows) for name, rows in telemetry.sensors.items()},
        position=position,
        housekeeping={
            name: np.append(np.interp(0.0, telemetry.times, values), values[later])
            for name, values in telemetry.housekeeping.items()
        },
        quantization_steps={
            name: telemetry.find_quantization_steps(name) for name in ("gyro", *telemetry.sensors)
        },
        attitude_hold=telemetry.attitude_hold,
    )
