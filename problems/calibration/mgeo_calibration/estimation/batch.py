"""What telemetry says, in the estimator's terms: steps between samples, and what was seen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mgeo_attitude._typing import Bools, Floats, Ints
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.model import compute_references
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.measurements import pad_to_three
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

#: Channels of the magnitudes of the gyro's rates [deg/s]: a bias that follows them is a scale
#: factor that differs between the senses of rotation.
RATE_MAGNITUDES = ("abs_gyro_x", "abs_gyro_y", "abs_gyro_z")


@dataclass(frozen=True, eq=False, kw_only=True)
class Batch:
    """n + 1 samples and the n steps between them.

    Attributes
    ----------
    times : array, shape (n + 1,)
        [s]
    gyro_rates : array, shape (n, 3)
        Mean of the reported rate over each step [rad/s].
    rate_changes : array, shape (n, 3)
        By what it changes from the begin of a step to its end [rad/s].
    excess_angle_variance : array, shape (n, 3)
        Variance of the angle about each body axis in each step beside that of the gyro's noise
        [rad²]: of a guessed rate, of one that stands apart, and of rates that are counted in steps.
    breaks : array of bool, shape (n,)
        Steps over which the attitude is not known from the gyro.
    readings : tuple of arrays, shape (n + 1, k, 3)
        As `Readings.sensors`.
    noise : array, shape (s, 3)
        1-sigma of each sensor, in the unit of its noise, with that of its steps; see `pad_to_three`.
    vectors : array, shape (n + 1, n_vectors, 3)
        What the sensors look at and their gradients, GCRS; see `FilterModel.references`.
    channel_values : array, shape (n + 1, n_influences)
        See `Suite.compute_channel_deviations`.
    pointing : Held, optional
        Attitude that a satellite without gyro holds: it moves by its pointing error, not by rates.
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
        """What influences of an owner are times at m samples, each of shape (m, 1)."""
        own = self.suite.find_sensitivity_columns(owner)
        return [self.channel_values[samples][:, [k]] for k in range(own.start, own.stop)]

    @property
    def durations(self) -> Floats:
        """Of the steps [s]."""
        return np.diff(self.times)

    @property
    def has_reading(self) -> Bools:
        """Where sensors have reported, shape (s, n + 1)."""
        return np.stack([np.isfinite(rows[:, 0, 0]) for rows in self.readings])

    def select_samples(self, low: int, high: int) -> Batch:
        """Samples low to high - 1."""
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
    """Telemetry with what a scenario says of orbit, sensors and eclipse.

    A sensor that a scenario with eclipses calls blind at a sample has reported nothing there, nor
    has a photodiode whose face the Sun is not before. Rates
    of the gyro that are missing are interpolated, with half the difference of their neighbors as
    1-sigma; so is one that stands apart from both, with how far it does as 1-sigma. What was sent
    while the gyro was silent for longer (`UNKNOWN_RATE_RATIO`) is left out.

    If the scenario goes on from a calibration, the first sample is the epoch, and what was sent
    until then is left out: the calibration has read it.

    Raises
    ------
    ValueError
        For telemetry of other sensors, of fewer than two samples of the gyro, or without a channel
        that a bias follows; nothing after the epoch of a scenario that goes on; or
        vectors of another unit.
    """
    for finding in find_invalid_norms(Samples.from_telemetry(scenario, telemetry)):
        raise ValueError(str(finding))
    if scenario.prior is not None:
        telemetry = _select_after_epoch(scenario, telemetry)
    at, rates = select_gyro_samples(telemetry)
    usual = compute_median_step(at)
    suite = replace(scenario.suite, gyro=scenario.gyro.convert_sample_noise(usual))
    readings = telemetry.build_readings(suite)
    there = np.isfinite(telemetry.gyro_deg_s[:, 0])
    there |= np.any([np.isfinite(rows[:, 0, 0]) for rows in readings], axis=0)
    silent = (np.diff(at) > UNKNOWN_RATE_RATIO * usual).nonzero()[0]
    for last, first in zip(at[silent], at[silent + 1], strict=True):
        there &= (telemetry.times <= last) | (telemetry.times >= first)
    there &= (telemetry.times >= at[0] - usual) & (telemetry.times <= at[-1] + usual)
    there[0] |= scenario.prior is not None

    times = telemetry.times[there]
    position, hold = telemetry.interpolate_positions(times), telemetry.attitude_hold
    environment = Environment.from_times(scenario, times, position)
    if not scenario.eclipse:
        environment = environment.without_eclipses()
    vectors, available = compute_references(suite, environment)
    sensors = tuple(
        np.where(
            available[:, i, None, None], mask_dark_readings(suite.sensors[i], rows[there]), np.nan
        )
        for i, rows in enumerate(readings)
    )
    off = find_gyro_spikes(suite, telemetry)
    rates -= off
    gyro, change, missing, breaks = compute_step_rates(times, at, rates, usual)
    declared = suite.gyro.quantization_deg_per_s or 0.0
    step = np.radians(np.maximum(telemetry.find_quantization_steps("gyro"), declared))
    sigma = compute_rate_sigma(suite, usual)
    counted = compute_angle_variance_rate(rates, usual, step, sigma)
    # vectors say whether the body has turned so: all parts of a sample are off together
    stands = compute_averaging_durations(at)[:, None]
    wrong = (
        np.minimum(np.abs(off).max(axis=1, keepdims=True) * stands, UNKNOWN_ATTITUDE_SIGMA) ** 2
        / stands
    )
    j = np.minimum(np.searchsorted(at, times[1:]), len(at) - 1)
    return Batch(
        suite=suite,
        times=times,
        gyro_rates=gyro,
        rate_changes=change,
        excess_angle_variance=missing[:, None] + (counted + wrong)[j] * np.diff(times)[:, None],
        breaks=breaks & (hold is None),
        readings=sensors,
        noise=pad_to_three(_compute_noise(sensor, telemetry) for sensor in suite.sensors),
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
    """Return the other columns of telemetry and `RATE_MAGNITUDES`, shape (n,)."""
    there = np.isfinite(telemetry.gyro_deg_s[:, 0])
    at, rates = telemetry.times[there], np.abs(telemetry.gyro_deg_s[there])
    magnitudes = {
        name: np.interp(telemetry.times, at, rates[:, axis])
        for axis, name in enumerate(RATE_MAGNITUDES)
    }
    return {**magnitudes, **telemetry.housekeeping}


def mask_dark_readings(sensor: Sensor, readings: Floats) -> Floats:
    """Readings, shape (n, k, 3), of a photodiode without those of a Sun outside its cone.

    Whether it is inside say the samples before and after, since noise of its own that decided
    would be noise of a sign; where both are missing it says so itself.
    """
    if not isinstance(sensor, Photodiode):
        return readings
    values = readings[:, 0, 0]
    around = np.full((2, len(values)), np.nan)
    around[0, 1:], around[1, :-1] = values[:-1], values[1:]
    count = np.isfinite(around).sum(axis=0)
    mean = np.where(count > 0, np.nansum(around, axis=0) / np.maximum(count, 1), values)
    lit = mean >= np.cos(np.radians(sensor.half_angle_deg))
    found: Floats = np.where(lit[:, None, None], readings, np.nan)
    return found


def _compute_noise(sensor: Sensor, telemetry: Telemetry) -> Floats:
    """1-sigma of each number, with the variance of a number that is rounded."""
    step, sigma = telemetry.find_quantization_steps(sensor.name), np.array(sensor.noise_sigmas())
    if sensor.has_unit_length:
        rows = telemetry.sensors[sensor.name]
        lengths = np.linalg.norm(rows[np.isfinite(rows[:, 0])], axis=1)
        step = np.full(len(sigma), step.max() / np.median(lengths) if len(lengths) else 0.0)
    elif len(sensor.telemetry_suffixes) < 4:
        step = step / sensor.telemetry_unit.factor
    else:  # a turn by a small angle changes a quaternion by half of it
        step = 2.0 * np.full(3, step.max())
    noise: Floats = np.sqrt(sigma**2 + step**2 / 12.0)
    return noise


def _select_after_epoch(scenario: Scenario, telemetry: Telemetry) -> Telemetry:
    """Samples after the epoch, and an empty one then."""
    later = telemetry.times > 0.0
    if later.sum() < 2:
        raise ValueError(
            f"telemetry ends at {telemetry.times[-1]:.6f} s after {scenario.epoch.isoformat()}, "
            "until when the calibration that the scenario goes on from has read it: expected later "
            "samples"
        )

    def empty_before(rows: Floats) -> Floats:
        return np.vstack([np.full(rows.shape[1], np.nan), rows[later]])

    position = telemetry.position
    if position is not None:
        start, _ = scenario.orbit.propagate(scenario.epoch, np.zeros(1))
        position = np.vstack([start, position[later]])
    return Telemetry(
        times=np.append(0.0, telemetry.times[later]),
        gyro_deg_s=empty_before(telemetry.gyro_deg_s),
        sensors={name: empty_before(rows) for name, rows in telemetry.sensors.items()},
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
