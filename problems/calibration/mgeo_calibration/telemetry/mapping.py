"""Declarations of a telemetry table, from TOML: columns, units, mountings, frames and time
scales.
"""

from __future__ import annotations

import math
import os
import tomllib
from datetime import UTC, date, datetime, timedelta
from typing import Annotated, Literal

import numpy as np
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import TAI_OFFSETS, tai_minus_utc
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, expect, format_known_names
from mgeo_attitude.settings.types import Degrees, DegreesPerSecond, Instant, Seconds, Triple
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass
from scipy.spatial.transform import Rotation

#: Conversion factors to each telemetry unit, by telemetry unit and given unit.
UNITS = {
    "deg/s": {"deg/s": 1.0, "rad/s": math.degrees(1.0), "deg/h": 1.0 / 3600.0},
    "nT": {"nT": 1.0, "uT": 1e3, "mG": 1e2, "G": 1e5, "T": 1e9},
    "m": {"m": 1.0, "km": 1e3},
    "-": {"-": 1.0},
    "deg": {"deg": 1.0, "rad": math.degrees(1.0)},
    "s": {
        "us": 1e-6,
        "ms": 1e-3,
        "s": 1.0,
        "min": 60.0,
        "h": 3600.0,
        "d": 86400.0,
        "week": 604800.0,
    },
}
#: Epoch of each time count, and its usual time scale.
EPOCHS = {
    "Unix": (datetime(1970, 1, 1, tzinfo=UTC), "UTC"),
    "GPS": (datetime(1980, 1, 6, tzinfo=UTC), "GPS"),
    "2000-01-01": (datetime(2000, 1, 1, tzinfo=UTC), "UTC"),
    "J2000": (datetime(2000, 1, 1, 12, tzinfo=UTC), "TT"),
}

#: Largest deviation of a matrix or a quaternion from a rotation. It allows rounding to five digits.
_MAX_ROUNDING_ERROR = 1e-4

Row = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
TimeUnit = Literal["us", "ms", "s", "min", "h", "d", "week"]
PositionFrame = Literal["GCRF", "EME2000", "TOD", "TEME", "ITRF"]
AttitudeFrame = Literal["GCRF", "EME2000", "TOD", "TEME", "ITRF", "LVLH"]


def _format_date(value: object) -> object:
    return value.isoformat() if type(value) is date else value


def compute_conversion_factor(unit: str, given_unit: str | None) -> float:
    """Return the factor that converts values from a given unit to a telemetry unit.

    Parameters
    ----------
    unit : str
        Unit of telemetry.
    given_unit : str, optional
        Given unit; None for the unit of telemetry.

    Raises
    ------
    InvalidValue
        If the units belong to different quantities.
    """
    given_unit = unit if given_unit is None else given_unit
    if given_unit not in UNITS[unit]:
        raise InvalidValue(
            "unit", given_unit, f"unknown unit{format_known_names(given_unit, UNITS[unit])}"
        )
    return UNITS[unit][given_unit]


def convert_to_scalar_last(q: Floats, scalar: str) -> Floats:
    """Convert quaternions to scalar-last order.

    Parameters
    ----------
    scalar : str
        Position of the scalar in `q`, ``first`` or ``last``.
    """
    return q if scalar == "last" else np.roll(q, -1, axis=-1)


@dataclass(frozen=True, kw_only=True)
class Channels(Settings):
    """Columns of one quantity in a telemetry table, with their scale, offset and unit.

    A value is ``scale`` times the raw number plus ``offset``, in ``unit``. A minus before a column
    name changes the sign afterwards, for example for mirrored axes.
    """

    columns: tuple[str, ...] | None = None
    """names of the columns; default: NAME_x, NAME_y and NAME_z, or NAME_q1 to NAME_q4 for a star
    tracker, or NAME for a photodiode; two columns of a direction sensor are the angles
    atan(x / z) and atan(y / z) in sensor axes"""
    unit: str | None = None
    """unit of the values after scale and offset; default: telemetry unit of the quantity"""
    scale: float | tuple[float, ...] = 1.0
    """factor of the raw numbers, such as the size of a count; one for all columns, or one per
    column"""
    offset: float | tuple[float, ...] = 0.0
    """constant added to the scaled numbers; one for all columns, or one per column"""

    def __post_init__(self) -> None:
        expect(np.all(self.scale), "scale", self.scale, "numbers other than zero")

    def expand_conversion(self, n: int) -> tuple[Floats, Floats]:
        """Return the scale and the offset of each of n columns, as two arrays.

        Raises
        ------
        InvalidValue
            If the number of scales or offsets is neither 1 nor n.
        """
        given = {"scale": self.scale, "offset": self.offset}
        for key, value in given.items():
            expect(
                np.size(value) in (1, n), key, value, f"one number, or {n} numbers, one per column"
            )
        return np.broadcast_to(self.scale, n), np.broadcast_to(self.offset, n)

    def compute_factor(self, unit: str) -> float:
        """Return the factor that converts the values of these columns to a telemetry unit.

        Raises
        ------
        InvalidValue
            If the units belong to different quantities.
        """
        return compute_conversion_factor(unit, self.unit)


@dataclass(frozen=True, kw_only=True)
class MountedChannels(Channels):
    """Columns of the gyro or a sensor in a telemetry table, with the mounting rotation between
    sensor axes and body axes.

    A quaternion "from A to B" follows CCSDS 504.0-B: (e sin(φ/2), cos(φ/2)) for the rotation by φ
    about e that rotates the axes of A to the axes of B. Coordinates of a vector transform by the
    inverse.
    """

    rotation: Literal["sensor-to-body", "body-to-sensor"] | None = None
    """direction of the mounting rotation; dcm times the coordinates in the first axes gives the
    coordinates in the second axes; required with quaternion or dcm"""
    quaternion: Quaternion | None = None
    """mounting as a quaternion from the first to the second axes of rotation"""
    dcm: Triple[Row] | None = None
    """mounting as a rotation matrix from the first to the second axes of rotation, row by row"""
    scalar: Literal["first", "last"] = "last"
    """position of the scalar in quaternions, including the columns of a star tracker"""

    def __post_init__(self) -> None:
        super().__post_init__()
        q, matrix = self.quaternion, self.dcm
        expect(q is None or matrix is None, "dcm", matrix, "either dcm or quaternion, not both")
        if q is not None and abs(np.linalg.norm(q) - 1.0) > _MAX_ROUNDING_ERROR:
            raise InvalidValue("quaternion", q, "expected a quaternion of unit length")
        if matrix is not None:
            product = np.array(matrix) @ np.transpose(matrix)
            if (
                np.abs(product - np.eye(3)).max() > _MAX_ROUNDING_ERROR
                or np.linalg.det(matrix) < 0.0
            ):
                raise InvalidValue("dcm", matrix, "expected a rotation matrix")
        if self.is_mounted and self.rotation is None:
            expected = "expected 'sensor-to-body' or 'body-to-sensor' with quaternion or dcm"
            raise InvalidValue("rotation", self.rotation, expected)

    @property
    def is_mounted(self) -> bool:
        """True if the mapping declares a rotation between sensor axes and body axes."""
        return self.quaternion is not None or self.dcm is not None

    def build_body_rotation(self) -> Rotation:
        """Return the rotation that converts vectors from sensor axes to body axes."""
        if self.dcm is not None:
            result = Rotation.from_matrix(self.dcm)
        else:
            q = np.array(self.quaternion or (0.0, 0.0, 0.0, 1.0))
            result = Rotation.from_quat(
                convert_to_scalar_last(q, self.scalar if self.quaternion else "last")
            )
            result = result.inv()  # Coordinates transform by the inverse of the axes.
        return result.inv() if self.rotation == "body-to-sensor" else result


@dataclass(frozen=True, kw_only=True)
class GyroChannels(MountedChannels):
    """Gyro columns of a telemetry table, or the reference axes of a satellite without a gyro."""

    rate: Literal["mean", "instantaneous"] = "mean"
    """whether the columns contain the mean rate since the previous sample, or the rate at the
    sample"""
    range_deg_s: DegreesPerSecond | None = Field(default=None, gt=0.0)
    """rate at which the gyro saturates, in the positive and the negative direction"""
    reference_axes: Literal["lvlh", "inertial", "unknown"] | None = None
    """attitude that a satellite without a gyro holds. 'lvlh': fixed in axes with x forward and z
    down; 'inertial': fixed in inertial axes; 'unknown': not known, so that only magnetometers are
    calibrated. dcm or quaternion declare the rotation between these axes and the body; in the key
    rotation, these axes take the place of the sensor axes"""
    pointing_error_deg: Degrees | None = Field(default=None, gt=0.0)
    """pointing error of a satellite without a gyro: 1-sigma of the angle between its declared and
    its true attitude, about each body axis. With reference_axes = 'inertial', the declared attitude
    is relative to GCRF, and dcm or quaternion is required"""
    pointing_correlation_time: Seconds | None = Field(default=None, gt=0.0)
    """time in which the autocorrelation of the pointing error falls to 1/e"""

    def __post_init__(self) -> None:
        super().__post_init__()
        error, time = self.pointing_error_deg, self.pointing_correlation_time
        if self.reference_axes is not None:
            for key in ("columns", "unit", "range_deg_s"):
                expect(
                    getattr(self, key) is None,
                    key,
                    getattr(self, key),
                    "none, because reference_axes declares that there is no gyro",
                )
        has_known_axes = self.reference_axes in ("lvlh", "inertial") or error is None
        expect(
            has_known_axes,
            "pointing_error_deg",
            error,
            "reference_axes = 'lvlh' or 'inertial' together with it",
        )
        has_known_mounting = error is None or self.reference_axes != "inertial" or self.is_mounted
        expect(
            has_known_mounting,
            "pointing_error_deg",
            error,
            "dcm or quaternion from GCRF to the body together with it",
        )
        expect(
            (error is None) == (time is None),
            "pointing_correlation_time",
            time,
            "a pointing error together with its correlation time, or neither",
        )


@dataclass(frozen=True, kw_only=True)
class SensorChannels(MountedChannels):
    """Columns of a sensor in a telemetry table, with the reference frame and direction of star
    tracker quaternions.
    """

    name: str
    """name of the sensor in the scenario"""
    attitude: Literal["frame-to-sensor", "sensor-to-frame"] | None = None
    """direction of star tracker quaternions; default: frame-to-sensor"""
    frame: AttitudeFrame | None = None
    """reference frame of star tracker quaternions; default: GCRF; LVLH has x forward and z down"""


@dataclass(frozen=True, kw_only=True)
class PositionChannels(Channels):
    """Columns of the satellite position in a telemetry table, with their reference frame."""

    frame: PositionFrame | None = None
    """reference frame of the positions; default: GCRF, checked against the orbit of the scenario"""


@dataclass(frozen=True, kw_only=True)
class TelemetryMapping(Settings):
    """Conventions of a telemetry table: columns, units, mountings, frames and time scale. The
    defaults match the tables from `Telemetry.to_frame`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import TelemetryMapping, read_telemetry, simulate_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> table = simulate_telemetry(scenario, design, seed=1).to_frame()
    >>> table = table.rename(columns={"time": "t"})
    >>> mapping = TelemetryMapping(time="t")
    >>> len(read_telemetry(table, scenario, mapping).times)
    901
    """

    time: str = "time"
    """column with ISO 8601 times, or with numbers that count from an epoch"""
    time_unit: TimeUnit | None = None
    """unit of a time column with numbers; default: unit in brackets after the column name, or s"""
    time_fraction: str | None = None
    """second time column, which is added to the first, such as milliseconds or the GPS time of
    week"""
    time_fraction_unit: TimeUnit = "ms"
    """unit of the second time column"""
    time_epoch: Annotated[
        Literal["Unix", "GPS", "J2000", "2000-01-01"] | Instant | None,
        BeforeValidator(_format_date),
    ] = None
    """instant from which a time column with numbers counts; default: epoch of the scenario, in SI
    seconds; 2000-01-01 is midnight and J2000 is noon of that day in the time scale"""
    time_system: Literal["UTC", "TAI", "GPS", "TT"] | None = None
    """time scale of ISO 8601 times and of counted numbers; UTC excludes leap seconds, like Unix
    time; default: GPS for the epoch GPS, TT for J2000, otherwise UTC"""
    gyro: GyroChannels = Field(default_factory=GyroChannels)
    """columns of the gyro"""
    sensors: tuple[SensorChannels, ...] = ()
    """columns of sensors, by name in the scenario"""
    position: PositionChannels = Field(default_factory=PositionChannels)
    """columns of the satellite position"""

    @property
    def time_scale(self) -> str:
        """Time scale of the time column. Unless declared, it is the usual time scale of the
        declared epoch.
        """
        named = EPOCHS.get(str(self.time_epoch), (None, "UTC"))[1]
        return self.time_system or named

    @property
    def count_start(self) -> datetime | None:
        """Epoch of a numeric time column, in the time scale of the column. None stands for the
        epoch of the scenario.
        """
        if not isinstance(self.time_epoch, datetime):
            return EPOCHS[self.time_epoch][0] if self.time_epoch else None
        ahead = 0.0
        if self.time_scale in TAI_OFFSETS:
            ahead = tai_minus_utc(self.time_epoch) - TAI_OFFSETS[self.time_scale]
        return self.time_epoch + timedelta(seconds=ahead)

    @staticmethod
    def from_toml(path: str | os.PathLike[str]) -> TelemetryMapping:
        """Read a telemetry mapping from a TOML file.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            With the file and the invalid key.
        """
        from mgeo.store.readers import read_text

        text = read_text(path)
        try:
            return TelemetryMapping(**tomllib.loads(text))
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{path}: {error}") from None
