"""Tables of telemetry, from CSV, Parquet or a DataFrame, checked where they come in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.frames import rotate, rotation_to_gcrs
from mgeo_attitude.environment.times import instants
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry.checks import refuse
from mgeo_calibration.telemetry.conversion import body_steps, convert_readings, to_body_axes
from mgeo_calibration.telemetry.files import read_table
from mgeo_calibration.telemetry.finding import Samples
from mgeo_calibration.telemetry.gyro_samples import means, reported
from mgeo_calibration.telemetry.held import Hold, held_rates
from mgeo_calibration.telemetry.mapping import GyroChannels, TelemetryMapping
from mgeo_calibration.telemetry.table import Values, named, read_values
from mgeo_calibration.telemetry.telemetry import Telemetry


def read_telemetry(
    source: Path | str | pd.DataFrame,
    scenario: Scenario,
    mapping: TelemetryMapping | None = None,
) -> Telemetry:
    """Read a table with the columns of `Telemetry.frame`, or those that `mapping` declares.

    Rows may be in any order and repeat each other; rows of one time are merged, so that sensors may
    have separate rows. A cell without a sample is empty; a vector or quaternion of zeros counts as
    empty. Other columns of numbers are `others`. Names are compared without case and without a unit
    in brackets, which is the unit of the column unless the mapping declares one.

    Parameters
    ----------
    source : path or DataFrame
        See `read_table` for what files may be.
    scenario : Scenario
        Its epoch, and the names and kinds of its sensors.

    Raises
    ------
    OSError
        If it cannot be read.
    ImportError
        For Parquet without pyarrow.
    ValueError
        Naming file, column, row, time, value, expectation and key: a cell that is no number or
        contradicts another, or a finding of a check that refuses, see `checks.CHECKS`.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import fly, read_telemetry
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> fly(scenario, design, seed=1).frame().to_csv("telemetry.csv", index=False)
    >>> read_telemetry("telemetry.csv", scenario).sensors["mag"].shape
    (901, 3)
    """
    if isinstance(source, pd.DataFrame):
        return _telemetry(source, scenario, mapping or TelemetryMapping())
    path = Path(source)
    try:
        return _telemetry(read_table(path), scenario, mapping or TelemetryMapping())
    except ValueError as error:
        raise ValueError(f"{path}: {str(error).strip()}") from error


def _telemetry(frame: pd.DataFrame, scenario: Scenario, mapping: TelemetryMapping) -> Telemetry:
    table = read_values(frame, scenario, mapping)
    times, found = table.times, table.found
    with named("gyro"):
        rates, step = _rates(times, found["gyro"], mapping.gyro, scenario)
    steps, position = {"gyro": step}, None
    if "position" in found:
        with named("position"):
            position = found["position"].rows * mapping.position.factor("m")
            frames = rotation_to_gcrs(
                mapping.position.frame or "GCRF", instants(scenario.epoch, times)
            )
            position = rotate(frames, position)
    sensors = {}
    for sensor in scenario.sensors:
        with named(sensor.name):
            sensors[sensor.name], steps[sensor.name] = convert_readings(
                sensor, found[sensor.name], table, scenario, position
            )
    telemetry = Telemetry(
        times=times,
        gyro_deg_s=rates,
        sensors=sensors,
        position=position,
        steps=steps,
        others=table.others,
        rows=table.numbers,
        has_gyro=not mapping.gyro.holds,
        hold=Hold.declared(mapping.gyro),
    )
    reported(telemetry)
    if not any(np.isfinite(rows).any() for rows in sensors.values()):
        raise ValueError(f"{', '.join(sensors)}: expected a sample of one of them")
    names = [*(["gyro"] if telemetry.has_gyro else []), *sensors]
    columns = {name: (found[name].columns, found[name].rows) for name in names}
    refuse(Samples(scenario, telemetry, columns, mapping))
    return telemetry


def _rates(
    times: Floats, read: Values, gyro: GyroChannels, scenario: Scenario
) -> tuple[Floats, Floats]:
    """Return mean rates about body axes, and the step of each axis [deg/s]."""
    rows, entry, _ = read
    assert isinstance(entry, GyroChannels)
    if gyro.holds:
        rates, step = to_body_axes(held_rates(gyro.holds, scenario, times), entry), np.zeros(3)
    else:
        step = body_steps(rows, entry, "deg/s")
        rates = to_body_axes(rows * entry.factor("deg/s"), entry)
    if gyro.holds or gyro.rate == "instantaneous":
        there = np.isfinite(rates).all(axis=1)
        rates[there] = means(times[there], rates[there])
    return rates, step
