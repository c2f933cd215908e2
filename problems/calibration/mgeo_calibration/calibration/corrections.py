"""Correction parameters for the satellite, and units of estimated states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.geometry.rotation import rotation_matrix, shear
from mgeo_attitude.sensors.base import Sensor
from mgeo_attitude.sensors.environment_errors import EnvironmentErrors
from mgeo_attitude.sensors.error_models import BiasSensitivity
from mgeo_attitude.sensors.gyro import Gyro
from mgeo_attitude.sensors.photodiode import Photodiode
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.types import DEG, DIMENSIONLESS, Unit
from scipy.spatial.transform import Rotation

#: Unit of gyro rates in telemetry.
DEG_S = Unit("deg/s", "deg_s", float(np.degrees(1.0)))
#: SI unit of each unit for display, and the factor that converts a value to it.
_SI_UNITS = {
    "deg": ("rad", float(np.radians(1.0))),
    "arcmin": ("rad", float(np.radians(1.0 / 60.0))),
    "deg/h": ("rad/s", float(np.radians(1.0 / 3600.0))),
    "nT": ("T", 1e-9),
    "ppm": ("-", 1e-6),
    "m": ("m", 1.0),
    "s": ("s", 1.0),
    "-": ("-", 1.0),
}


def compute_corrections(suite: Suite, states: Floats) -> dict[str, Any]:
    """Return the parameters that correct the raw readings of the gyro and of each sensor.

    See `Calibration.compute_corrections` for the contents of the dict.

    Parameters
    ----------
    states : array, shape (n_states,)
        States in the filter's units.
    """
    result: dict[str, Any] = {}
    for name, owner in suite.error_sources.items():
        if isinstance(
            owner, EnvironmentErrors
        ):  # No reading can be corrected for environment model errors.
            continue
        constants = {
            state: states[first : first + 3]
            for state, first in suite.get_first_indices(owner).items()
            if f"{name}.{state}" in suite.blocks
            and f"{name}.{state}" not in suite.uncalibrated_blocks
        }
        result[name] = _build_corrections(owner, constants)
    return result


def _build_corrections(owner: Gyro | Sensor, constants: Mapping[str, Floats]) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    R = stretch = np.eye(3)
    sensitivities = {each.state_name: each for each in owner.bias_sensitivities}
    for state, value in constants.items():
        if state in sensitivities:
            sensitivity = sensitivities[state]
            unit = sensitivity.coefficient_unit(find_error_unit(owner, sensitivity))
            kind = (
                "bias_sensitivities"
                if sensitivity.error == "bias"
                else f"{sensitivity.error}_sensitivities"
            )
            entry.setdefault(kind, {})[sensitivity.channel] = {
                f"{sensitivity.error}_per_unit": (unit.factor * value).tolist(),
                "unit": unit.text,
                "reference": sensitivity.reference,
            }
        elif state in owner.rotations:
            R = rotation_matrix(value)
            quaternion = quaternions_from_matrices(R[None])[0].tolist()
            entry |= {"dcm": R.tolist(), "quaternion": quaternion, "rotation": "body-to-sensor"}
        elif state == "bias":
            unit = find_bias_unit(owner)
            entry |= {"bias": (unit.factor * value).tolist(), "unit": unit.text}
        elif state == "latency":
            entry["latency_s"] = float(value.mean())
        else:
            entry[state] = value.tolist()
    if isinstance(owner, Photodiode) and "sensitivity" in constants:
        along = owner.axes[2] + constants["sensitivity"] @ owner.axes
        gain = float(np.linalg.norm(along))
        entry |= {"gain": gain, "normal": (along / gain).tolist()}
    if "scale_factor" in constants:
        stretch = stretch + np.diag(constants["scale_factor"])
    if "nonorthogonality" in constants:
        stretch = stretch + shear(constants["nonorthogonality"], np.eye(3))
    if {"scale_factor", "nonorthogonality"} & constants.keys():
        entry["correction"] = np.linalg.solve(stretch, R.T).tolist()
    return entry


def find_bias_unit(owner: Gyro | Sensor) -> Unit:
    """Return the unit in which telemetry reports the bias of the gyro or of a sensor."""
    return DEG_S if isinstance(owner, Gyro) else owner.telemetry_unit


def find_error_unit(owner: Gyro | Sensor, sensitivity: BiasSensitivity) -> Unit:
    """Return the telemetry unit of the bias or misalignment that depends on a housekeeping channel.

    The unit is that of the bias, or degrees for a misalignment.
    """
    return find_bias_unit(owner) if sensitivity.error == "bias" else DEG


def find_innovation_unit(sensor: Sensor) -> Unit:
    """Return the unit in which the innovations of a sensor are reported.

    Innovations of directions and attitudes are angles in degrees. Other innovations have the unit
    of the readings.
    """
    is_scalar, unit = len(sensor.telemetry_suffixes) == 1, sensor.telemetry_unit
    return DEG if unit == DIMENSIONLESS and not is_scalar else unit


def format_label(name: str) -> str:
    """Format a state name for display: ``gyro.bias`` becomes ``gyro bias``."""
    owner, _, state = name.rpartition(".")
    label = f"{owner} {state.replace('_', ' ')}" if owner else name
    return label.removeprefix("environment_errors ")


def convert_to_si(unit: str) -> tuple[str, float]:
    """Return the SI unit that replaces a display unit such as ``deg/h``, and the conversion factor.

    The denominator of a bias sensitivity, such as ``degC`` in ``nT per degC``, is not converted.
    """
    numerator, per, denominator = unit.partition(" per ")
    si_unit, factor = _SI_UNITS[numerator]
    return f"{si_unit}{per}{denominator}", factor


def convert_block(suite: Suite, states: Floats, block: str) -> Floats:
    """Convert a three-axis state, such as the gyro bias, to its display unit.

    Rotations are converted to rotation vectors.
    """
    first = 3 * suite.blocks.index(block)
    values = states[first : first + 3]
    if first in suite.rotation_indices:
        values = Rotation.from_matrix(rotation_matrix(values)).as_rotvec()
    return values * suite.units[block].factor
