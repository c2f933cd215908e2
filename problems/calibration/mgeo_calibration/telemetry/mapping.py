"""How telemetry of one's own is to be read: names of columns, units, mounting frames."""

from __future__ import annotations

import math
import os
import tomllib
from typing import Literal

import numpy as np
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue, known_names
from mgeo_attitude.settings.types import DegreesPerSecond, Triple
from pydantic import Field
from pydantic.dataclasses import dataclass
from scipy.spatial.transform import Rotation

#: Factors to the unit of telemetry, by that unit.
UNITS = {
    "deg/s": {"deg/s": 1.0, "rad/s": math.degrees(1.0), "deg/h": 1.0 / 3600.0},
    "nT": {"nT": 1.0, "uT": 1e3, "mG": 1e2, "G": 1e5, "T": 1e9},
    "m": {"m": 1.0, "km": 1e3},
    "-": {"-": 1.0},
    "deg": {"deg": 1.0, "rad": math.degrees(1.0)},
}

#: How far a matrix or a quaternion may be from a rotation: what is given to five digits is taken.
_ROUNDING = 1e-4

Row = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Channels(Settings):
    """Where the numbers of a sensor stand and what they mean.

    A minus before the name of a column turns its sign, which maps mirrored axes.
    """

    columns: tuple[str, ...] | None = None
    """its columns, if they are not called NAME_x, NAME_y, NAME_z or NAME_q1 to NAME_q4, or NAME of
    a photodiode; two of a direction are its angles in sensor axes, atan(x / z) and atan(y / z)"""
    unit: str | None = None
    """unit of its columns, if it is not that of telemetry"""
    quaternion: tuple[float, float, float, float] | None = None
    """how it is mounted: rotation from sensor to body axes, scalar last"""
    dcm: Triple[Row] | None = None
    """the same as a matrix: vector in body axes = dcm x vector in sensor axes"""

    def __post_init__(self) -> None:
        if self.quaternion is not None and self.dcm is not None:
            raise InvalidValue("dcm", self.dcm, "expected no quaternion beside it")
        q, matrix = self.quaternion, self.dcm
        if q is not None and abs(np.linalg.norm(q) - 1.0) > _ROUNDING:
            raise InvalidValue("quaternion", q, "expected a quaternion of unit length")
        if matrix is not None:
            product = np.array(matrix) @ np.transpose(matrix)
            if np.abs(product - np.eye(3)).max() > _ROUNDING or np.linalg.det(matrix) < 0.0:
                raise InvalidValue("dcm", matrix, "expected a rotation matrix")

    def to_body(self) -> Rotation:
        """Rotation from sensor to body axes."""
        if self.dcm is not None:
            return Rotation.from_matrix(self.dcm)
        return Rotation.from_quat(self.quaternion or (0.0, 0.0, 0.0, 1.0))

    def factor(self, unit: str) -> float:
        """From the unit of its columns to that of telemetry.

        Raises
        ------
        InvalidValue
            For a unit of another quantity.
        """
        given = unit if self.unit is None else self.unit
        if given not in UNITS[unit]:
            expected = f"unknown unit{known_names(given, UNITS[unit])}"
            raise InvalidValue("unit", given, expected)
        return UNITS[unit][given]


@dataclass(frozen=True, kw_only=True)
class GyroChannels(Channels):
    """Those of the gyro."""

    rate: Literal["mean", "instantaneous"] = "mean"
    """mean over the time since the sample before, or the rate at the sample"""
    range_deg_s: DegreesPerSecond | None = Field(default=None, gt=0.0)
    """rate at which it saturates"""
    holds: Literal["lvlh", "inertial", "unknown"] | None = None
    """there is no gyro, and the satellite holds these axes; dcm or quaternion turns LVLH (x
    forward, z down) to body axes; of unknown ones, magnetometers are calibrated alone"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.holds is not None:
            for key in ("columns", "unit", "range_deg_s"):
                if (value := getattr(self, key)) is not None:
                    raise InvalidValue(
                        key, value, "expected none: holds says that there is no gyro"
                    )


@dataclass(frozen=True, kw_only=True)
class SensorChannels(Channels):
    """Those of a sensor."""

    name: str
    """name of the sensor in the scenario"""


@dataclass(frozen=True, kw_only=True)
class TelemetryMapping(Settings):
    """How a table of one's own becomes `Telemetry`; what is not said is as `Telemetry.frame`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import TelemetryMapping, fly, read_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> table = fly(scenario, design, seed=1).frame().rename(columns={"time": "t"})
    >>> mapping = TelemetryMapping(time="t")
    >>> len(read_telemetry(table, scenario, mapping).times)
    901
    """

    time: str = "time"
    """column of seconds since the epoch or ISO 8601 times, UTC"""
    time_format: Literal["epoch", "unix", "unix-ms"] = "epoch"
    """what its numbers are: seconds since the epoch, Unix seconds or milliseconds"""
    gyro: GyroChannels = Field(default_factory=GyroChannels)
    """the gyro"""
    sensors: tuple[SensorChannels, ...] = ()
    """sensors, by the scenario's names"""
    position: Channels = Field(default_factory=Channels)
    """the satellite's position, GCRS"""

    @staticmethod
    def from_toml(path: str | os.PathLike[str]) -> TelemetryMapping:
        """Read a TOML file.

        Raises
        ------
        OSError
            If it cannot be read.
        ValueError
            Naming the file and the key.
        """
        from mgeo.store.reading import read_text

        text = read_text(path)
        try:
            return TelemetryMapping(**tomllib.loads(text))
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{path}: {error}") from None
