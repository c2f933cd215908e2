"""Telemetry: samples of gyro, sensors and housekeeping channels, and the truth of a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.sensors.measurements import from_telemetry
from mgeo_attitude.sensors.suite import Suite
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from mgeo.store.atomic import write_file
from mgeo_calibration.telemetry.attitude_hold import AttitudeHold
from mgeo_calibration.telemetry.quantization import estimate_quantization_steps

#: Longest time between positions for interpolation [s].
MAX_POSITION_STEP = 300.0
_MIN_POSITIONS = 4


@dataclass(frozen=True, eq=False, kw_only=True)
class Truth:
    """True attitude, gyro states and sensor states at the n samples of a simulation.

    Attributes
    ----------
    attitude : array, shape (n, 3, 3)
        Rotation matrices from GCRS to body.
    states : array, shape (n, n_states)
        True gyro and sensor states in the filter's units. Rotations are vectors of
        `rotation.rotate`; the attitude block is zero.
    wheel_momentum : array, shape (n, k), optional
        Momentum of each wheel [N m s], if the simulation has wheels.
    """

    attitude: Floats
    states: Floats
    wheel_momentum: Floats | None = None

    def truncate(self, n: int) -> Truth:
        """Return a copy that contains only the first n samples."""
        wheels = self.wheel_momentum
        return Truth(
            attitude=self.attitude[:n],
            states=self.states[:n],
            wheel_momentum=None if wheels is None else wheels[:n],
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Telemetry:
    """Samples of gyro, sensors and housekeeping channels at n times. Missing samples are rows of
    NaN.

    Attributes
    ----------
    times : array, shape (n,)
        Seconds since the scenario's epoch, increasing.
    gyro_deg_s : array, shape (n, 3)
        Mean body rate since the previous gyro sample [deg/s].
    sensors : mapping of str to array, shape (n, 3), (n, 4) or (n, 1)
        Samples by sensor name: vectors [nT or unit length], quaternions from GCRF to body with the
        scalar last, or scalars; see `Sensor.channels`.
    position : array, shape (n, 3), optional
        Satellite position in GCRS [m], which replaces the scenario's orbit; see
        `interpolate_positions`.
    row_numbers : array of int, shape (n,), optional
        Rows of the samples in the source table; the first row below the header is 1.
    truth : Truth, optional
        Truth of a simulation; not part of tables and files.
    housekeeping : mapping of str to array, shape (n,)
        Housekeeping channels, such as temperatures and currents, in any unit, interpolated
        linearly.
    quantization_steps : mapping of str to array, shape (3,), (4,) or (1,)
        Quantization steps of ``gyro`` and sensors that cannot be estimated from the samples, for
        example after a rotation; see `find_quantization_steps`.
    has_gyro : bool
        True if the rates are measured, false if assumed.
    attitude_hold : AttitudeHold, optional
        Reference axes and pointing error of a satellite without a gyro.

    Raises
    ------
    ValueError
        If an array has a wrong shape, a value is infinite, a vector is partly NaN, or times are
        missing, not finite or not increasing.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_calibration import Telemetry
    >>> times = np.arange(1.0, 4.0)
    >>> sensors = {"mag": np.full((3, 3), 2e4)}
    >>> telemetry = Telemetry(times=times, gyro_deg_s=np.zeros((3, 3)), sensors=sensors)
    >>> telemetry.to_frame().columns.to_list()
    ['time', 'gyro_x', 'gyro_y', 'gyro_z', 'mag_x', 'mag_y', 'mag_z']
    """

    times: Floats
    gyro_deg_s: Floats
    sensors: Mapping[str, Floats] = field(default_factory=dict)
    position: Floats | None = None
    row_numbers: Ints | None = None
    truth: Truth | None = None
    housekeeping: Mapping[str, Floats] = field(default_factory=dict)
    quantization_steps: Mapping[str, Floats] = field(default_factory=dict)
    has_gyro: bool = True
    attitude_hold: AttitudeHold | None = None

    def __post_init__(self) -> None:
        times = np.array(self.times, dtype=float)
        one = times.ndim == 1 and len(times) > 0 and bool(np.isfinite(times).all())
        if not one or (np.diff(times) <= 0.0).any():
            raise ValueError("times: expected one or more finite numbers in increasing order [s]")
        object.__setattr__(self, "times", times)
        object.__setattr__(
            self, "gyro_deg_s", self._validate_samples("gyro", self.gyro_deg_s, (3,))
        )
        sensors = {
            name: self._validate_samples(name, rows, (3, 4, 1))
            for name, rows in self.sensors.items()
        }
        object.__setattr__(self, "sensors", sensors)
        if self.position is not None:
            object.__setattr__(
                self, "position", self._validate_samples("position", self.position, (3,))
            )
        housekeeping = {
            name: np.array(values, dtype=float) for name, values in self.housekeeping.items()
        }
        for name, values in housekeeping.items():
            if values.shape != times.shape or not np.isfinite(values).all():
                raise ValueError(f"{name}: expected {len(times)} finite numbers")
        object.__setattr__(self, "housekeeping", housekeeping)

    def to_frame(self) -> pd.DataFrame:
        """Return the telemetry as a table with the column ``time`` and one column per component of
        the gyro, the sensors, the position and the housekeeping channels.
        """
        columns = {"time": self.times} | _build_columns("gyro", self.gyro_deg_s)
        for name, rows in self.sensors.items():
            columns |= _build_columns(name, rows)
        if self.position is not None:
            columns |= _build_columns("position", self.position)
        columns |= {
            name: values for name, values in self.housekeeping.items() if name not in columns
        }
        return pd.DataFrame(columns)

    def find_quantization_steps(self, name: str) -> Floats:
        """Return the quantization step of each channel of the gyro or of a sensor. Steps that are
        not declared are estimated from the samples; zero means no quantization.
        """
        return self._effective_steps[name]

    @cached_property
    def _effective_steps(self) -> dict[str, Floats]:
        rows = {"gyro": self.gyro_deg_s, **self.sensors}
        return {**self.quantization_steps} | {
            name: estimate_quantization_steps(each)
            for name, each in rows.items()
            if name not in self.quantization_steps
        }

    def truncate(self, time: float) -> Telemetry:
        """Return a copy without the samples after a given time in seconds.

        Raises
        ------
        ValueError
            If there is no sample.
        """
        n = int(np.searchsorted(self.times, time, side="right"))
        if not time >= self.times[0]:
            raise ValueError(f"no sample until {time!r} s: the first is at {self.times[0]:.6f} s")
        truth = self.truth
        return Telemetry(
            times=self.times[:n],
            gyro_deg_s=self.gyro_deg_s[:n],
            sensors={name: rows[:n] for name, rows in self.sensors.items()},
            position=None if self.position is None else self.position[:n],
            row_numbers=None if self.row_numbers is None else self.row_numbers[:n],
            housekeeping={name: values[:n] for name, values in self.housekeeping.items()},
            quantization_steps=self.quantization_steps,
            has_gyro=self.has_gyro,
            attitude_hold=self.attitude_hold,
            truth=truth and truth.truncate(n),
        )

    def to_csv(self, path: Path | str) -> None:
        """Write the telemetry to a CSV file in which floats keep full precision.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        write_file(path, self.to_frame().to_csv(index=False, lineterminator="\n").encode())

    def interpolate_positions(self, times: Floats) -> Floats | None:
        """Return the satellite position at given sample times, or None if the telemetry has no
        positions.

        Missing positions are interpolated by a cubic spline. With positions 300 s apart, the
        resulting error of the field is 4 nT.

        Returns
        -------
        array, shape (m, 3), or None
            Position in GCRS [m].

        Raises
        ------
        ValueError
            If a time is too far from the known positions.
        """
        if self.position is None:
            return None
        is_known = np.isfinite(self.position[:, 0])
        if is_known.all():
            return self.position[np.searchsorted(self.times, times)]
        at = self.times[is_known]
        if len(at) < _MIN_POSITIONS:
            raise ValueError(f"position: {len(at)} samples: expected {_MIN_POSITIONS} or more")
        k = np.clip(np.searchsorted(at, times), 1, len(at) - 1)
        usual = min(float(np.median(np.diff(at))), MAX_POSITION_STEP)
        far = (
            np.where((times < at[0]) | (times > at[-1]), 0.0, at[k] - at[k - 1]) > MAX_POSITION_STEP
        )
        far &= ~np.isin(times, at)
        far |= (times < at[0] - usual) | (times > at[-1] + usual)
        if far.any():
            raise ValueError(
                f"position: no sample near time {times[np.argmax(far)]:.6f} s: expected samples "
                f"at most {MAX_POSITION_STEP:g} s apart, from the start to the end"
            )
        result: Floats = CubicSpline(at, self.position[is_known])(times)
        return result

    def build_readings(self, suite: Suite) -> tuple[Floats, ...]:
        """Return the readings of the sensors of a suite, converted to the units of the filter, as
        one array per sensor.

        Returns
        -------
        tuple of arrays, shape (n, k, 3)
            One array per sensor, with k vectors per reading.

        Raises
        ------
        ValueError
            If sensors are missing or unknown.
        """
        names = [sensor.name for sensor in suite.sensors]
        if set(names) != set(self.sensors):
            raise ValueError(
                f"telemetry has the sensors {list(self.sensors)}: expected the sensors of the "
                f"scenario, {names}"
            )
        return tuple(from_telemetry(sensor, self.sensors[sensor.name]) for sensor in suite.sensors)

    def _validate_samples(self, name: str, values: ArrayLike, widths: tuple[int, ...]) -> Floats:
        rows: Floats = np.array(values, dtype=float)
        if rows.shape not in [(len(self.times), width) for width in widths]:
            raise ValueError(
                f"{name}: expected an array of shape ({len(self.times)}, {widths[0]}), not "
                f"{rows.shape}"
            )
        missing = np.isnan(rows)
        for wrong, what in (
            (np.isinf(rows).any(axis=1), "expected finite numbers"),
            (missing.any(axis=1) & ~missing.all(axis=1), "expected all components or none"),
        ):
            if wrong.any():
                k = int(np.argmax(wrong))
                raise ValueError(
                    f"{name} at {format_place(k, self.times, self.row_numbers)} = "
                    f"{rows[k].tolist()}: {what}"
                )
        return rows


def format_place(k: int, times: Floats, row_numbers: Ints | None = None) -> str:
    """Return the time of sample `k` and, if known, its row in the source table, as text for
    messages.
    """
    time = f"time {f'{times[k]:.6f}'.rstrip('0').rstrip('.')} s"
    return time if row_numbers is None else f"row {row_numbers[k]}, {time}"


def list_column_names(name: str, width: int = 3) -> list[str]:
    """Return the column names of a quantity with 1, 3 or 4 components: ``mag``; ``mag_x`` to
    ``mag_z``; or ``mag_q1`` to ``mag_q4``.
    """
    if width == 1:
        return [name]
    return [f"{name}_{part}" for part in ("xyz" if width == 3 else ("q1", "q2", "q3", "q4"))]


def _build_columns(name: str, rows: Floats) -> dict[str, Any]:
    return dict(zip(list_column_names(name, rows.shape[1]), rows.T, strict=True))
