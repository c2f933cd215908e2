"""Telemetry: what a satellite sent down, in the units of its files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.sensors.readings import from_channels
from mgeo_attitude.sensors.suite import Suite
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from mgeo.store.atomic import write_file
from mgeo_calibration.telemetry.quantization import resolution

#: Positions are known between samples that are so far apart [s].
LONGEST_STEP = 300.0
_FEWEST_POSITIONS = 4


@dataclass(frozen=True, eq=False, kw_only=True)
class Truth:
    """What was true at each of n samples; only a simulation knows.

    Attributes
    ----------
    attitude : array, shape (n, 3, 3)
        GCRS to body.
    states : array, shape (n, n_states)
        States of gyro and sensors, in the filter's units, rotations as vectors of
        `rotation.rotate`; zero for the attitude.
    wheel_momentum : array, shape (n, k), optional
        Of each wheel, where a simulation has wheels [N m s].
    """

    attitude: Floats
    states: Floats
    wheel_momentum: Floats | None = None

    def first(self, n: int) -> Truth:
        """At the first n samples."""
        wheels = self.wheel_momentum
        return Truth(
            attitude=self.attitude[:n],
            states=self.states[:n],
            wheel_momentum=None if wheels is None else wheels[:n],
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Telemetry:
    """Samples of gyro and sensors at n times; a row of NaN is where there was none.

    Attributes
    ----------
    times : array, shape (n,)
        Seconds since the scenario's epoch, increasing.
    gyro_deg_s : array, shape (n, 3)
        Mean of the rate that the gyro reports since its sample before, body axes.
    sensors : mapping of str to array, shape (n, 3), (n, 4) or (n, 1)
        By the sensor's name: vector (nT, or of unit length), quaternion or number, see
        `Sensor.channels`.
    position : array, shape (n, 3), optional
        Satellite [m], GCRS, if it is not to follow from the scenario's orbit; see `positions`.
    truth : Truth, optional
        Beside what a simulation reports; it is no part of tables and files.
    others : mapping of str to array, shape (n,)
        What else was measured at these times, such as temperatures and currents, in any unit;
        between samples of its own by lines.
    steps : mapping of str to array, shape (3,), (4,) or (1,)
        In which ``gyro`` and sensors count, where that cannot be seen, as they were mounted
        otherwise; see `step_of`.
    has_gyro : bool
        Whether the rates were measured, not assumed.

    Raises
    ------
    ValueError
        For an array of another shape, an infinity, a vector that is NaN in part, no sample, or
        times that are not finite or do not increase.

    Examples
    --------
    >>> import numpy as np
    >>> from mgeo_calibration import Telemetry
    >>> times = np.arange(1.0, 4.0)
    >>> sensors = {"mag": np.full((3, 3), 2e4)}
    >>> telemetry = Telemetry(times=times, gyro_deg_s=np.zeros((3, 3)), sensors=sensors)
    >>> telemetry.frame().columns.to_list()
    ['time', 'gyro_x', 'gyro_y', 'gyro_z', 'mag_x', 'mag_y', 'mag_z']
    """

    times: Floats
    gyro_deg_s: Floats
    sensors: Mapping[str, Floats] = field(default_factory=dict)
    position: Floats | None = None
    truth: Truth | None = None
    others: Mapping[str, Floats] = field(default_factory=dict)
    steps: Mapping[str, Floats] = field(default_factory=dict)
    has_gyro: bool = True

    def __post_init__(self) -> None:
        times = np.array(self.times, dtype=float)
        one = times.ndim == 1 and len(times) > 0 and bool(np.isfinite(times).all())
        if not one or (np.diff(times) <= 0.0).any():
            raise ValueError("times: expected one or more finite numbers in increasing order [s]")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "gyro_deg_s", self._samples("gyro", self.gyro_deg_s, (3,)))
        sensors = {
            name: self._samples(name, rows, (3, 4, 1)) for name, rows in self.sensors.items()
        }
        object.__setattr__(self, "sensors", sensors)
        if self.position is not None:
            object.__setattr__(self, "position", self._samples("position", self.position, (3,)))
        others = {name: np.array(values, dtype=float) for name, values in self.others.items()}
        for name, values in others.items():
            if values.shape != times.shape or not np.isfinite(values).all():
                raise ValueError(f"{name}: expected {len(times)} finite numbers")
        object.__setattr__(self, "others", others)

    def frame(self) -> pd.DataFrame:
        """The table: ``time``, ``gyro_x``..., the channels of every sensor, and `others`."""
        columns = {"time": self.times} | _columns("gyro", self.gyro_deg_s)
        for name, rows in self.sensors.items():
            columns |= _columns(name, rows)
        if self.position is not None:
            columns |= _columns("position", self.position)
        columns |= {name: values for name, values in self.others.items() if name not in columns}
        return pd.DataFrame(columns)

    def step_of(self, name: str) -> Floats:
        """In which the channels of ``gyro`` or a sensor count, zero of any number."""
        return self._steps[name]

    @cached_property
    def _steps(self) -> dict[str, Floats]:
        rows = {"gyro": self.gyro_deg_s, **self.sensors}
        return {**self.steps} | {
            name: resolution(each) for name, each in rows.items() if name not in self.steps
        }

    def until(self, time: float) -> Telemetry:
        """The samples until a time [s].

        Raises
        ------
        ValueError
            If there is none.
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
            others={name: values[:n] for name, values in self.others.items()},
            steps=self.steps,
            has_gyro=self.has_gyro,
            truth=truth and truth.first(n),
        )

    def to_csv(self, path: Path | str) -> None:
        """Write the table; floats by repr, so that it reads back exactly.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        write_file(path, self.frame().to_csv(index=False, lineterminator="\n").encode())

    def positions(self, times: Floats) -> Floats | None:
        """Where the satellite was at m of its times, shape (m, 3) [m]; None if that is not known.

        Between samples of the position, which may be rarer, by a spline: 4 nT off after five
        minutes.

        Raises
        ------
        ValueError
            For a time without a sample near it.
        """
        if self.position is None:
            return None
        there = np.isfinite(self.position[:, 0])
        if there.all():
            return self.position[np.searchsorted(self.times, times)]
        at = self.times[there]
        if len(at) < _FEWEST_POSITIONS:
            raise ValueError(f"position: {len(at)} samples: expected {_FEWEST_POSITIONS} or more")
        k = np.clip(np.searchsorted(at, times), 1, len(at) - 1)
        usual = min(float(np.median(np.diff(at))), LONGEST_STEP)
        far = np.where((times < at[0]) | (times > at[-1]), 0.0, at[k] - at[k - 1]) > LONGEST_STEP
        far &= ~np.isin(times, at)
        far |= (times < at[0] - usual) | (times > at[-1] + usual)
        if far.any():
            raise ValueError(
                f"position: none near time {times[np.argmax(far)]:.6f} s: expected samples at most "
                f"{LONGEST_STEP:g} s apart, from the begin to the end"
            )
        found: Floats = CubicSpline(at, self.position[there])(times)
        return found

    def readings(self, suite: Suite) -> tuple[Floats, ...]:
        """Of every sensor of a suite, shape (n, k, 3), in the filter's units, NaN where none.

        Raises
        ------
        ValueError
            For a sensor of the suite that is missing, or one that it does not know.
        """
        names = [sensor.name for sensor in suite.sensors]
        if set(names) != set(self.sensors):
            raise ValueError(f"telemetry of {list(self.sensors)}: expected that of {names}")
        return tuple(from_channels(sensor, self.sensors[sensor.name]) for sensor in suite.sensors)

    def _samples(self, name: str, values: ArrayLike, widths: tuple[int, ...]) -> Floats:
        rows: Floats = np.array(values, dtype=float)
        if rows.shape not in [(len(self.times), width) for width in widths]:
            raise ValueError(
                f"{name}: expected an array of shape ({len(self.times)}, {widths[0]}), not "
                f"{rows.shape}"
            )
        missing = np.isnan(rows)
        for wrong, what in (
            (np.isinf(rows).any(axis=1), "expected finite numbers"),
            (missing.any(axis=1) & ~missing.all(axis=1), "expected all of its numbers or none"),
        ):
            if wrong.any():
                k = int(np.argmax(wrong))
                raise ValueError(
                    f"{name} at time {self.times[k]:.6f} s = {rows[k].tolist()}: {what}"
                )
        return rows


def channels(name: str, width: int = 3) -> list[str]:
    """Columns of a vector, or of a quaternion: ``mag_x``..., ``tracker_q1``...; of a number one."""
    if width == 1:
        return [name]
    return [f"{name}_{part}" for part in ("xyz" if width == 3 else ("q1", "q2", "q3", "q4"))]


def _columns(name: str, rows: Floats) -> dict[str, Any]:
    return dict(zip(channels(name, rows.shape[1]), rows.T, strict=True))
