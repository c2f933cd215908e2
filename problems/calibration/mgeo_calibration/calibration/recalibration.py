"""Repetition of a calibration with additional states, or with sensor noise estimated from the
innovations.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeVar

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.base import Sensor, scale_noise
from mgeo_attitude.sensors.error_models import BiasSensitivity, get_initial_sigma
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.settings.errors import InvalidValue, format_known_names
from mgeo_attitude.settings.types import DEG

from mgeo_calibration.calibration.calibrate import calibrate
from mgeo_calibration.calibration.calibration import Calibration
from mgeo_calibration.calibration.corrections import find_bias_unit
from mgeo_calibration.calibration.hypotheses import has_sensitivity
from mgeo_calibration.estimation.batch import RATE_MAGNITUDES
from mgeo_calibration.telemetry.columns import split_name_and_unit
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Key that requests noise estimation.
NOISE_KEY = "noise"
_SENSITIVITIES_FIELD = "bias_sensitivities"
#: Ratio of the 1-sigma of an added bias variation to the initial 1-sigma of the bias. The initial
#: 1-sigma of a measured bias is small, but its variation may be larger.
_BIAS_VARIATION_FACTOR = 10.0
#: Initial 1-sigma of each added state, in the unit of its key.
INITIAL_SIGMAS = {
    "scale_factor": 0.02,
    "misalignment_deg": 1.0,
    "nonorthogonality_deg": 1.0,
    "latency_s": 1.0,
}
T = TypeVar("T", Gyro, Sensor)
_N_ROUNDS = 3  # The set of outliers depends on the noise.


def recalibrate(
    calibration: Calibration,
    telemetry: Telemetry,
    keys: Sequence[str],
) -> Calibration:
    """Repeat a calibration with additional states, with estimated sensor noise, or with both.

    The telemetry is the same, and the noise is estimated from the innovations.

    Parameters
    ----------
    calibration : Calibration
    telemetry : Telemetry
    keys : sequence of str
        States such as ``mag.scale_factor`` or ``gyro.misalignment``, bias sensitivities such as
        ``mag.temp`` for the column ``temp``, and `NOISE_KEY`.

    Raises
    ------
    InvalidValue
        If a key adds nothing, or the scenario continues an earlier calibration.
    CalibrationError
        See `calibrate`.
    """
    states = [key for key in keys if key != NOISE_KEY]
    scenario = add_states(calibration.scenario, states, telemetry.housekeeping)
    result = calibrate(scenario, telemetry) if scenario != calibration.scenario else calibration
    for _ in range(_N_ROUNDS if NOISE_KEY in keys else 0):
        result = calibrate(update_noise(result), telemetry)
    return result


def add_states(
    scenario: Scenario, keys: Sequence[str], housekeeping: Mapping[str, Floats]
) -> Scenario:
    """Return a copy of a scenario that estimates additional errors of the gyro or the sensors.

    Each added state has a typical initial 1-sigma.

    Parameters
    ----------
    keys : sequence of str
        ``mag.scale_factor``; ``mag.temp`` or ``mag.misalignment.temp`` for a bias or misalignment
        that is proportional to the column ``temp``; ``gyro.scale_asymmetry``.
    housekeeping : mapping of str to array
        Other columns of telemetry.
    """
    channels = list_addable_sensitivities(scenario, housekeeping)
    options: dict[str, Any] = list_addable_states(scenario) | dict.fromkeys(
        channels, _SENSITIVITIES_FIELD
    )
    for key in keys:
        if key not in options:
            suggestion = format_known_names(key, [*options, NOISE_KEY])
            expected = f"expected a state that can be added{suggestion}"
            raise InvalidValue("fit", key, expected)
    if keys and scenario.prior is not None:
        expected = "expected a scenario without an earlier calibration, whose prior lacks the state"
        raise InvalidValue("fit", keys[0], expected)

    def extend(owner: T) -> T:
        name = getattr(owner, "name", "gyro")
        own_keys = [key for key in keys if key.partition(".")[0] == name]
        changes: dict[str, Any] = {
            options[key]: INITIAL_SIGMAS[options[key].removeprefix("initial_")]
            for key in own_keys
            if key not in channels
        }
        new: list[BiasSensitivity] = [each for key in own_keys for each in channels.get(key, ())]
        if new:
            changes[_SENSITIVITIES_FIELD] = (*getattr(owner, _SENSITIVITIES_FIELD), *new)
        return dataclasses.replace(owner, **changes)

    return dataclasses.replace(
        scenario,
        gyro=extend(scenario.gyro),
        sensors=tuple(extend(sensor) for sensor in scenario.sensors),
    )


def list_addable_states(scenario: Scenario) -> dict[str, str]:
    """List the calibration parameters that a scenario does not estimate but could estimate.

    The dict maps names such as ``mag.scale_factor`` to the scenario keys that add the states.
    """
    result = {}
    owners: tuple[Any, ...] = (scenario.gyro, *scenario.sensors)
    for owner in owners:
        for field in dataclasses.fields(owner):
            size = field.name.removeprefix("initial_")
            if size in INITIAL_SIGMAS and field.name != size and not getattr(owner, field.name):
                state = size.removesuffix("_deg").removesuffix("_s")
                result[f"{getattr(owner, 'name', 'gyro')}.{state}"] = field.name
    return result


def list_addable_sensitivities(
    scenario: Scenario, housekeeping: Mapping[str, Floats]
) -> dict[str, tuple[BiasSensitivity, ...]]:
    """List the bias sensitivities that a scenario can add, such as a temperature dependence.

    The dict maps names such as ``mag.temp`` to bias sensitivities.
    """
    result: dict[str, tuple[BiasSensitivity, ...]] = {}
    owners: tuple[Gyro | Sensor, ...] = (scenario.gyro, *scenario.sensors)
    for owner in owners:
        states, name = owner.states(), getattr(owner, "name", "gyro")
        errors: dict[Literal["bias", "misalignment"], str]
        errors = {"bias": "", "misalignment": "misalignment."}
        if isinstance(owner, Gyro):
            del errors["misalignment"]
            if not any(has_sensitivity(owner, magnitude) for magnitude in RATE_MAGNITUDES):
                result["gyro.scale_asymmetry"] = tuple(
                    BiasSensitivity(
                        magnitude, initial_sigma=INITIAL_SIGMAS["scale_factor"], unit="deg/s"
                    )
                    for magnitude in RATE_MAGNITUDES
                )
        for error, prefix in errors.items():
            for column, values in housekeeping.items():
                if (
                    error not in states
                    or has_sensitivity(owner, column, error)
                    or not np.ptp(values)
                ):
                    continue
                channel, unit = split_name_and_unit(column)
                sigma = _BIAS_VARIATION_FACTOR * np.max(get_initial_sigma(states[error]))
                error_unit = find_bias_unit(owner) if error == "bias" else DEG
                sensitivity = BiasSensitivity(
                    channel,
                    initial_sigma=float(error_unit.factor * sigma / np.ptp(values)),
                    unit=unit or "unit",
                    reference=float(np.mean(values)),
                    error=error,
                )
                result[f"{name}.{prefix}{channel}"] = (sensitivity,)
    return result


def update_noise(calibration: Calibration) -> Scenario:
    """Scale the noise of each sensor so that its mean normalized innovation squared becomes 1.

    Return a copy of the scenario of the calibration with the scaled noise.
    """
    factors = {test.sensor: float(np.sqrt(test.nis)) for test in calibration.tests}
    sensors = tuple(
        scale_noise(sensor, factors.get(sensor.name, 1.0))
        for sensor in calibration.scenario.sensors
    )
    return dataclasses.replace(calibration.scenario, sensors=sensors)


def compare_calibrations(first: Calibration, second: Calibration) -> pd.DataFrame:
    """Return a table with the estimates and 1-sigmas of two calibrations side by side.

    The table has one row per calibration parameter and axis of the second calibration.

    The column ``change / sigma [-]`` is the difference in units of the second 1-sigma. A state that
    the first calibration lacks is compared with zero.
    """
    columns = ["estimate", "sigma"]
    keys = ["block", "axis", "unit"]
    old, new = (each.build_table().set_index(keys)[columns] for each in (first, second))
    table = new.join(old.add_suffix(" before"))
    table["change / sigma [-]"] = (
        table["estimate"] - table["estimate before"].fillna(0.0)
    ) / table["sigma"]
    return table.reset_index(["axis", "unit"])[
        [
            "axis",
            "unit",
            "estimate before",
            "sigma before",
            "estimate",
            "sigma",
            "change / sigma [-]",
        ]
    ]


def describe_noise(calibration: Calibration) -> str:
    """Format the declared noise of all sensors as one line, such as ``mag.noise_nt = 300``."""
    return ", ".join(
        f"{sensor.name}.{name} = {_format_sigma(getattr(sensor, name))}"
        for sensor in calibration.scenario.sensors
        for name in sensor.noise_parameters
    )


def _format_sigma(sigma: float | tuple[float, ...]) -> str:
    if isinstance(sigma, tuple):
        return f"[{', '.join(map(_format_sigma, sigma))}]"
    return f"{sigma:.4g}"
