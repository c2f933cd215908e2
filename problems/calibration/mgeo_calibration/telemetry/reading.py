"""Reading of telemetry from CSV and Parquet files or a DataFrame, with conversion and checks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.frames import rotate, rotation_to_gcrs
from mgeo_attitude.environment.times import compute_julian_dates
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry.attitude_hold import AttitudeHold, compute_assumed_rates
from mgeo_calibration.telemetry.checks import reject_findings
from mgeo_calibration.telemetry.conversion import (
    compute_body_steps,
    convert_readings,
    rotate_to_body,
)
from mgeo_calibration.telemetry.files import read_table
from mgeo_calibration.telemetry.findings import Samples
from mgeo_calibration.telemetry.gyro_samples import compute_mean_rates, select_gyro_samples
from mgeo_calibration.telemetry.mapping import GyroChannels, TelemetryMapping
from mgeo_calibration.telemetry.table import ColumnValues, prefix_errors, read_values
from mgeo_calibration.telemetry.telemetry import Telemetry


def read_telemetry(
    source: Path | str | pd.DataFrame,
    scenario: Scenario,
    mapping: TelemetryMapping | None = None,
) -> Telemetry:
    """Read telemetry from a table or file, convert it to the body frame and reject implausible
    data.

    Rows may be unordered. Rows with equal times are merged, so that sensors may have separate rows.
    Missing samples are empty cells; a zero vector or quaternion counts as missing. Other numeric
    columns become `Telemetry.housekeeping`. Column names are compared without case and without a
    unit in brackets, which is the unit of the column unless the mapping declares one.

    Parameters
    ----------
    source : path or DataFrame
        Table, or a file as in `read_table`.
    scenario : Scenario
        Scenario with the epoch and the sensors.
    mapping : TelemetryMapping, optional
        Declarations of the table.

    Returns
    -------
    Telemetry

    Raises
    ------
    OSError
        If the file cannot be read.
    ImportError
        If pyarrow is missing for Parquet.
    ValueError
        With file, column, row, time, value, expectation and key, if a cell is not a number, cells
        contradict each other, or a fatal check has a finding; see `checks.CHECKS`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import read_telemetry, simulate_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> simulate_telemetry(scenario, design, seed=1).to_csv("telemetry.csv")
    >>> read_telemetry("telemetry.csv", scenario).sensors["mag"].shape
    (901, 3)
    """
    if isinstance(source, pd.DataFrame):
        return _build_telemetry(source, scenario, mapping or TelemetryMapping())
    path = Path(source)
    try:
        return _build_telemetry(read_table(path), scenario, mapping or TelemetryMapping())
    except ValueError as error:
        raise ValueError(f"{path}: {str(error).strip()}") from error


def _build_telemetry(
    frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping
) -> Telemetry:
    table = read_values(frame, scenario, mapping)
    times, result = table.times, table.values
    with prefix_errors("gyro"):
        rates, step = _convert_rates(times, result["gyro"], mapping.gyro, scenario)
    steps, position = {"gyro": step}, None
    if "position" in result:
        with prefix_errors("position"):
            position = result["position"].rows * mapping.position.compute_factor("m")
            frames = rotation_to_gcrs(
                mapping.position.frame or "GCRF", compute_julian_dates(scenario.epoch, times)
            )
            position = rotate(frames, position)
    sensors = {}
    for sensor in scenario.sensors:
        with prefix_errors(sensor.name):
            sensors[sensor.name], steps[sensor.name] = convert_readings(
                sensor, result[sensor.name], table, scenario, position
            )
    telemetry = Telemetry(
        times=times,
        gyro_deg_s=rates,
        sensors=sensors,
        position=position,
        quantization_steps=steps,
        housekeeping=table.housekeeping,
        row_numbers=table.row_numbers,
        has_gyro=not mapping.gyro.reference_axes,
        attitude_hold=AttitudeHold.from_channels(mapping.gyro),
    )
    select_gyro_samples(telemetry)
    if not any(np.isfinite(rows).any() for rows in sensors.values()):
        raise ValueError(
            f"{', '.join(sensors)}: no samples. Expected samples of at least one sensor"
        )
    names = [*(["gyro"] if telemetry.has_gyro else []), *sensors]
    columns = {name: (result[name].columns, result[name].rows) for name in names}
    reject_findings(Samples(scenario, telemetry, columns, mapping))
    return telemetry


def _convert_rates(
    times: Floats, values: ColumnValues, gyro: GyroChannels, scenario: Scenario
) -> tuple[Floats, Floats]:
    """Return the mean body rates [deg/s] and the quantization step of each axis."""
    rows, entry, _ = values
    assert isinstance(entry, GyroChannels)
    if gyro.reference_axes:
        rates, step = (
            rotate_to_body(compute_assumed_rates(gyro.reference_axes, scenario, times), entry),
            np.zeros(3),
        )
    else:
        step = compute_body_steps(rows, entry, "deg/s")
        rates = rotate_to_body(rows * entry.compute_factor("deg/s"), entry)
    if gyro.reference_axes or gyro.rate == "instantaneous":
        is_reported = np.isfinite(rates).all(axis=1)
        rates[is_reported] = compute_mean_rates(times[is_reported], rates[is_reported])
    return rates, step
