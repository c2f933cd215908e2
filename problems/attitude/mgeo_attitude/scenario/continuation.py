"""Scenarios that continue after a calibration, from its time, attitude and covariance."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

import numpy as np

from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.environment.times import as_utc, instant_after, seconds_between
from mgeo_attitude.scenario.prior import Prior, read_prior
from mgeo_attitude.scenario.toml import Table, merge_table
from mgeo_attitude.sensors.error_models import expand_per_axis
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.base import to_table
from mgeo_attitude.settings.errors import InvalidKey, InvalidValue, expect

#: Entries of a calibration from which a scenario continues, with their types.
ENTRIES: Mapping[str, Any] = {
    "scenario": Mapping,
    "time_s": int | float,
    "quaternion": list,
    "rate_deg_s": list,
    "states": Mapping,
    "covariance": list,
}

#: Keys that the calibration or its scenario determines.
DETERMINED_KEYS = ("preset", "prior")
#: Tolerance for an epoch that equals the time of the calibration [s].
_SAME_INSTANT = 1e-3

#: Text of the entry ``conclusion`` in a statistically consistent calibration.
CONSISTENT = "The telemetry is statistically consistent with the model."

#: Key of a scenario that accepts a statistically inconsistent calibration.
ACCEPT_INCONSISTENT = "accept_inconsistent"

#: Latest time of a calibration [s].
_MAX_TIME = 1e9
#: Number of 1-sigmas by which a measured rate may exceed its bound because of noise.
_N_SIGMAS = 6.0


def continue_scenario(table: Mapping[str, Any], build_scenario: Callable[[Any], Any]) -> Table:
    """Return the nested dict of a scenario that starts from the result of a calibration.

    The calibration, a dict as saved in JSON, is the entry ``after`` of the table. Without an
    ``epoch``, the scenario starts at the time, attitude and covariance of the calibration. With a
    later ``epoch``, time-varying errors are propagated to the epoch (see `propagate_prior`), and
    attitude and rate follow from ``initial``, since the calibration does not determine them at that
    time.

    Parameters
    ----------
    table : mapping
        Table of a scenario with the entry ``after``.
    build_scenario : function
        Function that returns the scenario of a table.

    Returns
    -------
    dict
        Table without ``after``, with the entry ``prior``.

    Raises
    ------
    InvalidValue
        If the entry ``after`` is no calibration, if the calibration is statistically inconsistent
        and `ACCEPT_INCONSISTENT` is not true, or if the table has a key that the calibration
        determines.
    """
    overrides = dict(table)
    calibration = _check_calibration(overrides.pop("after"))
    _check_consistency(calibration, overrides.pop(ACCEPT_INCONSISTENT, False))
    for key in DETERMINED_KEYS:
        if key in overrides:
            expected = f"expected no {key} with 'after': the calibration determines it"
            raise InvalidValue(key, overrides[key], expected)
    try:
        before = build_scenario(calibration["scenario"])
        prior = read_prior(calibration, before.suite)
    except InvalidValue as error:
        raise error.prefix_key("after") from None
    time = float(calibration["time_s"])
    base = before.to_dict()
    if "epoch" not in overrides:
        base["epoch"] = instant_after(before.epoch, time).isoformat()
        base["orbit"] |= to_table(before.orbit.shift_epoch(time))
        base |= _shift_channels(base, time)
        base["prior"] = to_table(_clip_rate(prior, before))
        return merge_table(base, overrides)
    later = seconds_between(before.epoch, _parse_epoch(overrides["epoch"]))
    expected = f"an instant after that of the calibration, {calibration.get('utc', f'{time} s')}"
    expect(later > time - _SAME_INSTANT, "epoch", overrides["epoch"], expected)
    base["orbit"] |= to_table(before.orbit.shift_epoch(later))
    base |= _shift_channels(base, later)
    base["prior"] = None
    table = merge_table(base, overrides)
    table["prior"] = to_table(
        propagate_prior(prior, before.suite, max(0.0, later - time), build_scenario(table))
    )
    return table


def _shift_channels(base: Mapping[str, Any], time: float) -> dict[str, Any]:
    """Shift the predictions of housekeeping channels, such as temperatures, to a later start.

    The result is the table entry ``housekeeping_channels``. Times are shifted, and initial values
    are removed.
    """
    later = []
    for channel in base.get("housekeeping_channels", []):
        shifted = {key: value for key, value in channel.items() if key != "initial"}
        if "times" in channel:
            shifted["times"] = [instant - time for instant in channel["times"]]
        later.append(shifted)
    return {"housekeeping_channels": later} if later else {}


def propagate_prior(prior: Prior, suite: Suite, duration: float, scenario: Any) -> Prior:
    """Propagate the result of a calibration to the start of a later scenario.

    No measurements are available during this time. The gyro's bias and the Gauss-Markov errors
    decay and accumulate noise; constants keep their uncertainty. Attitude and rate are the initial
    values of the new scenario, uncorrelated with all other states.

    Parameters
    ----------
    prior : Prior
        Result of the calibration.
    suite : Suite
        Gyro, sensors and environment model errors of the calibration.
    duration : float
        Time from the calibration to the start of the new scenario [s].
    scenario : Scenario
        Scenario that starts at the end of the duration.

    Returns
    -------
    Prior
    """
    from mgeo_attitude.geometry.quaternion import quaternions_from_matrices  # This imports scipy.

    decay, variance = np.ones(suite.n_states), np.zeros(suite.n_states)
    rate, density = suite.gyro.bias_decay, suite.compute_noise_density()[3:6]
    decay[3:6] = math.exp(-rate * duration)
    variance[3:6] = density * (
        -math.expm1(-2.0 * rate * duration) / (2.0 * rate) if rate else duration
    )
    for process, first in zip(
        suite.processes.values(), range(suite.n_kinematic, suite.n_dynamic, 3), strict=True
    ):
        block = slice(first, first + 3)
        decay[block], variance[block] = process.discretize(duration)
    covariance = decay[:, None] * np.array(prior.covariance) * decay + np.diag(variance)
    covariance[:3], covariance[:, :3] = 0.0, 0.0
    covariance[:3, :3] = scenario.initial_attitude_covariance
    at = Environment.from_times(scenario, np.zeros(1))
    quaternion = quaternions_from_matrices(scenario.compute_initial_attitude(at)[None])[0]
    table = {
        "quaternion": quaternion.tolist(),
        "rate_deg_s": np.degrees(scenario.compute_initial_rate(at)).tolist(),
        "states": (decay * prior.estimates)[3:].reshape(-1, 3).tolist(),
        "covariance": covariance.tolist(),
    }
    return Prior(**table)


def _parse_epoch(value: Any) -> datetime:
    try:
        epoch = datetime.fromisoformat(value) if isinstance(value, str) else value
        return as_utc(epoch)
    except (ValueError, AttributeError):
        expected = "expected a date and time with a UTC offset, later than the calibration"
        raise InvalidValue("epoch", value, expected) from None


def _check_calibration(calibration: Any) -> Mapping[str, Any]:
    """Check that a calibration has all required entries with valid values, and return it unchanged.

    `ENTRIES` lists the required entries. Raise InvalidKey for a missing entry, and InvalidValue for
    an invalid one.
    """
    if not isinstance(calibration, Mapping):
        raise InvalidValue("after", calibration, "expected a calibration as saved in JSON")
    for key, kind in ENTRIES.items():
        if key not in calibration:
            raise InvalidKey(
                f"after.{key}", None, "missing; expected a calibration as saved in JSON"
            )
        entry = calibration[key]
        if not isinstance(entry, kind) or isinstance(entry, bool):
            names = " or ".join(each.__name__ for each in getattr(kind, "__args__", (kind,)))
            raise InvalidValue(f"after.{key}", entry, f"expected {names}")
    time = calibration["time_s"]
    expect(0.0 <= time <= _MAX_TIME, "after.time_s", time, f"a number in [0, {_MAX_TIME:g}] s")
    return calibration


def _check_consistency(calibration: Mapping[str, Any], accept: Any) -> None:
    """Raise InvalidValue if the calibration is statistically inconsistent and `accept` is False."""
    if not isinstance(accept, bool):
        raise InvalidValue(ACCEPT_INCONSISTENT, accept, "expected true or false")
    conclusion = calibration.get("conclusion", CONSISTENT)
    if conclusion != CONSISTENT and not accept:
        expected = (
            f"expected {CONSISTENT!r}; to continue nevertheless, set {ACCEPT_INCONSISTENT} = true"
        )
        raise InvalidValue("after.conclusion", conclusion, expected)


def _clip_rate(prior: Prior, scenario: Any) -> Prior:
    """Clip the body rate of a prior to the maximum rate or wheel momentum.

    The rate is clipped only if gyro noise can explain the excess. Otherwise, the prior is returned
    unchanged.
    """
    rate, wheels = np.array(prior.rate_deg_s), scenario.wheels
    ratios = [np.abs(rate).max() / scenario.maneuvers.max_rate_deg_s]
    if wheels is not None and wheels.max_momentum is not None and not wheels.initial_momentum:
        momentum = wheels.compute_largest_load(np.radians(rate) @ wheels.inertia_matrix())
        ratios.append(momentum / wheels.max_momentum)
    ratio = max(ratios)
    walk = max(expand_per_axis(scenario.suite.gyro.angle_random_walk_deg_per_sqrt_h))
    noise = walk / 60.0 / math.sqrt(scenario.step)
    if not 1.0 < ratio <= 1.0 + _N_SIGMAS * noise / np.abs(rate).max():
        return prior
    return dataclasses.replace(prior, rate_deg_s=tuple((rate / ratio).tolist()))
