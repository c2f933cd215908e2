"""Tables of telemetry, from CSV, Parquet or a DataFrame, checked where they come in."""

from __future__ import annotations

import csv
import io
import math
import re
import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import erfa
import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.fields import InvalidValue, known_names
from mgeo_attitude.scenario import Scenario
from mgeo_attitude.sensors import Sensor
from scipy.spatial.transform import Rotation

from mgeo_calibration.telemetry.checks import check_telemetry
from mgeo_calibration.telemetry.gyro_samples import means
from mgeo_calibration.telemetry.mapping import Channels, TelemetryMapping
from mgeo_calibration.telemetry.resolution import resolution
from mgeo_calibration.telemetry.telemetry import Telemetry, channels

#: A week of four sensors at 4 Hz is smaller.
MOST_BYTES = 2**30

_MISSING = {"", "nan", "na", "null", "none"}
_CHANNEL = re.compile(r"(.+)_(x|y|z|q[1-4])")
_UNIT_LENGTH = 0.01  # a quaternion may be off by this


def read_telemetry(
    source: Path | str | pd.DataFrame,
    scenario: Scenario,
    mapping: TelemetryMapping | None = None,
) -> Telemetry:
    """Read a table whose columns are those of `Telemetry.frame`, or what `mapping` says.

    Rows may stand in any order and repeat each other; those of one time are put together, so that
    sensors may have rows of their own. An entry is empty where there was no sample; a vector of
    three zeros is none, either. Columns that are not asked for are left out.

    Parameters
    ----------
    source : path or DataFrame
        A file that ends in ``.parquet`` needs pyarrow; any other is CSV with a header.
    scenario : Scenario
        Its epoch, and the names and kinds of its sensors.

    Raises
    ------
    OSError
        If it cannot be read.
    ImportError
        For Parquet without pyarrow.
    ValueError
        Naming file, row and column of what is missing, no number, unknown, given twice with
        different values, stuck, saturated or outside the field model.
    """
    if isinstance(source, pd.DataFrame):
        return _telemetry(source, scenario, mapping or TelemetryMapping())
    path = Path(source)
    if not stat.S_ISREG(path.stat().st_mode):
        raise ValueError(f"{path} is a folder, a pipe or a device: expected a file")
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path} has {path.stat().st_size} bytes: expected at most {MOST_BYTES}")
    try:
        frame = _parquet(path) if path.suffix == ".parquet" else _csv(path)
        return _telemetry(frame, scenario, mapping or TelemetryMapping())
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _csv(path: Path) -> pd.DataFrame:
    """The cells as texts: pandas would make numbers of some and an index of a row too long."""
    text = path.read_text(encoding="utf-8-sig")
    try:
        header, *rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    except (csv.Error, ValueError) as error:
        raise ValueError(f"no CSV with a header: {error}") from None
    for i, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise ValueError(f"row {i} has {len(row)} values: expected {len(header)}")
    return pd.DataFrame(rows, columns=header, dtype=object)


def _parquet(path: Path) -> pd.DataFrame:
    try:
        from pyarrow import ArrowException
    except ImportError:
        raise ImportError(f"{path}: Parquet needs pyarrow: pip install pyarrow") from None
    try:
        return pd.read_parquet(path, engine="pyarrow")
    except ArrowException as error:
        raise ValueError(f"no Parquet: {error}") from None


def _telemetry(frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping) -> Telemetry:
    names = [sensor.name for sensor in scenario.sensors]
    given: dict[str, Channels] = {entry.name: entry for entry in mapping.sensors}
    for i, entry in enumerate(mapping.sensors):
        if entry.name not in names:
            expected = f"unknown sensor{known_names(entry.name, names)}"
            raise InvalidValue(f"sensors[{i}].name", entry.name, expected)
    asked: dict[str, tuple[Channels, list[str]]] = {
        "gyro": (mapping.gyro, _asked("gyro", mapping.gyro))
    }
    for sensor in scenario.sensors:
        channel = given.get(sensor.name, Channels())
        widths = (3, 2) if sensor.unit_length else (len(sensor.channels),)
        asked[sensor.name] = channel, _asked(sensor.name, channel, *widths)
    position = _asked("position", mapping.position)
    if "position" not in names and (
        mapping.position.columns or set(position) & set(map(str, frame.columns))
    ):
        asked["position"] = mapping.position, position
    wanted = [mapping.time, *(column for _, columns in asked.values() for column in columns)]
    _check_columns(frame, wanted, names)

    times = _seconds(frame[mapping.time], scenario)
    table = np.column_stack([_numbers(frame[column], column) for column in wanted[1:]])
    times, table = _merged(times, table, wanted[1:])
    found, first = {}, 0
    for name, (_, columns) in asked.items():
        found[name] = table[:, first : first + len(columns)]
        first += len(columns)
    counted = found.pop("gyro")
    gyro = _turned(counted, mapping.gyro, "deg/s")
    steps = {"gyro": _steps(counted, mapping.gyro, "deg/s")}
    _check_range(times, gyro, mapping.gyro.range_deg_s)
    if mapping.gyro.rate == "instantaneous":
        there = np.isfinite(gyro).all(axis=1)
        gyro[there] = means(times[there], gyro[there])
    where = found.pop("position", None)
    sensors = {}
    for sensor in scenario.sensors:
        rows, own = found[sensor.name], asked[sensor.name][0]
        sensors[sensor.name] = _reported(sensor, rows, own)
        if rows.shape[1] == 2:
            step = np.radians(own.factor("deg") * resolution(rows).max())
            steps[sensor.name] = np.full(3, step)
        else:
            steps[sensor.name] = _steps(rows, own, sensor.channel_unit.text)
    telemetry = Telemetry(
        times=times,
        gyro_deg_s=gyro,
        sensors=sensors,
        position=None if where is None else _turned(where, mapping.position, "m"),
        steps=steps,
    )
    check_telemetry(telemetry, scenario)
    return telemetry


def _asked(name: str, entry: Channels, width: int = 3, *others: int) -> list[str]:
    columns = channels(name, width) if entry.columns is None else list(entry.columns)
    if len(columns) not in (width, *others):
        expected = " or ".join(map(str, (width, *others)))
        raise ValueError(f"columns of {name} = {columns}: expected {expected} names")
    return columns


def _check_columns(frame: pd.DataFrame, wanted: Sequence[str], sensors: Sequence[str]) -> None:
    names = [str(name) for name in frame.columns]
    for name in wanted:
        if names.count(name) > 1 or list(wanted).count(name) > 1:
            raise ValueError(f"column {name!r} is there, or asked for, twice")
    if missing := [name for name in wanted if name not in names]:
        raise ValueError(f"missing columns {', '.join(missing)}: there are {', '.join(names)}")
    for name in names:
        part = _CHANNEL.fullmatch(name)
        if part and name not in wanted and part[1] not in ("gyro", "position", *sensors):
            raise ValueError(
                f"column {name!r}: the scenario has no sensor of this name"
                f"{known_names(part[1], sensors)}"
            )
    if frame.empty:
        raise ValueError("there are no rows")


def _numbers(column: pd.Series, name: str) -> Floats:
    """A column as floats, NaN where it is empty."""
    if column.dtype.kind in "iuf":
        values: Floats = column.to_numpy(dtype=float)
    else:
        values = np.asarray(_plain(column.tolist()) or [*map(_number, column)], dtype=np.float64)
    if np.isinf(values).any():
        row = int(np.argmax(np.isinf(values)))
        raise ValueError(f"row {row + 1}, {name} = {_shown(column.iloc[row])}: expected a number")
    return values


def _plain(cells: list[Any]) -> list[float]:
    """Numbers of texts, nearly always; nothing if one of the cells wants a closer look."""
    try:
        text = "".join(cells)
        return (
            [float(cell or "nan") for cell in cells] if text.isascii() and "_" not in text else []
        )
    except (TypeError, ValueError):
        return []


def _number(cell: object) -> float:
    """A cell's number, NaN if it is empty, an infinity for anything else."""
    if isinstance(cell, str):
        text = cell.strip()
        if text.lower() in _MISSING:
            return math.nan
        if not text.isascii() or "_" in text:  # Python would take 1_0 and digits of other scripts
            return math.inf
        try:
            return float(text)
        except ValueError:
            return math.inf
    if cell is None or cell is pd.NA or cell is pd.NaT:
        return math.nan
    is_number = isinstance(cell, int | float | np.number) and not isinstance(cell, bool)
    return float(cell) if is_number else math.inf  # type: ignore[arg-type]


def _shown(cell: Any) -> str:
    plain = cell.item() if isinstance(cell, np.generic) else cell
    return f"{plain!r:.40}"


def _seconds(column: pd.Series, scenario: Scenario) -> Floats:
    """Seconds of SI since the epoch, from such seconds or from ISO 8601 texts, UTC."""
    name = str(column.name)
    is_text = column.dtype.kind not in "iufM"
    if is_text and not math.isinf(_number(column.iloc[0])):
        is_text, column = False, pd.Series(_numbers(column, name), name=column.name)
    times: Floats
    if column.dtype.kind != "M" and not is_text:
        times = _numbers(column, name)
    else:
        at = pd.to_datetime(column, utc=True, format="ISO8601", errors="coerce")
        calendar = (at - pd.Timestamp(scenario.epoch)).dt.total_seconds().to_numpy(dtype=float)
        times = calendar + (_leap_seconds(at) - _leap_seconds(pd.Series([scenario.epoch])))
    if np.isnan(times).any():
        row = int(np.argmax(np.isnan(times)))
        raise ValueError(
            f"row {row + 1}, {name} = {_shown(column.iloc[row])}: expected seconds since the epoch "
            "or a time of ISO 8601"
        )
    return times


def _leap_seconds(at: pd.Series) -> Floats:
    """TAI less UTC at these instants [s], NaN where there is none."""
    known = at.notna().to_numpy()
    found = np.full(len(at), np.nan)
    days = pd.DatetimeIndex(at[known])
    # erfa.dat would warn of years before 1960 and of those to come
    leap, _ = erfa.ufunc.dat(days.year, days.month, days.day, 0.0)
    found[known] = leap
    return found


def _merged(times: Floats, table: Floats, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Rows in the order of their times, those of one time put together."""
    order = np.argsort(times, kind="stable")
    times, table = times[order], table[order]
    first = np.flatnonzero(np.append(True, np.diff(times) > 0.0))
    with np.errstate(invalid="ignore"):
        low, high = np.fmin.reduceat(table, first), np.fmax.reduceat(table, first)
    if (differs := low < high).any():
        row, column = np.argwhere(differs)[0]
        raise ValueError(
            f"time {times[first[row]]:.6f} s occurs with {names[column]} = {low[row, column]!r} "
            f"and {high[row, column]!r}: expected one of the two"
        )
    return times[first], low


def _turned(rows: Floats, entry: Channels, unit: str) -> Floats:
    """In body axes and in the unit of telemetry."""
    scaled = rows * entry.factor(unit)
    if entry.quaternion is None and entry.dcm is None:
        return scaled
    there = np.isfinite(rows).all(axis=1)
    scaled[there] = entry.to_body().apply(scaled[there])
    return scaled


def _steps(rows: Floats, entry: Channels, unit: str) -> Floats:
    """In which channels count, in body axes, as 1-sigmas of rounded numbers add up."""
    step = resolution(rows)
    if rows.shape[1] == 3:
        step = np.sqrt(entry.to_body().as_matrix() ** 2 @ (step * entry.factor(unit)) ** 2)
    return step


def _reported(sensor: Sensor, rows: Floats, entry: Channels) -> Floats:
    """Channels of a sensor, as if it were mounted along the body axes."""
    try:
        if rows.shape[1] == 2:
            x, y = np.tan(np.radians(entry.factor("deg") * rows.T))
            along = np.column_stack([x, y, np.ones_like(x)])
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            found: Floats = entry.to_body().apply(along)
            return found
        if len(sensor.channels) == 3:
            found = _turned(rows, entry, sensor.channel_unit.text)
            found[(rows == 0.0).all(axis=1)] = np.nan  # many report so that they see nothing
            return found
        entry.factor("-")
    except InvalidValue as error:
        raise error.under(sensor.name) from None
    there = np.isfinite(rows).all(axis=1)
    lengths = np.linalg.norm(rows[there], axis=1)
    if (np.abs(lengths - 1.0) > _UNIT_LENGTH).any():
        length = lengths[np.argmax(np.abs(lengths - 1.0))]
        raise ValueError(f"{sensor.name}: a quaternion of length {length:.6g}: expected 1")
    if entry.quaternion is None and entry.dcm is None:
        return rows
    turned = rows.copy()
    turned[there] = (Rotation.from_quat(rows[there]) * entry.to_body().inv()).as_quat(True)
    return turned


def _check_range(times: Floats, gyro: Floats, most: float | None) -> None:
    saturated = np.abs(gyro) >= (np.inf if most is None else most)
    if saturated.any():
        row, axis = np.argwhere(saturated)[0]
        raise ValueError(
            f"gyro_{'xyz'[axis]} at time {times[row]:.6f} s = {gyro[row, axis]:.6g} deg/s: the "
            f"gyro saturates at range_deg_s = {most:g}"
        )
