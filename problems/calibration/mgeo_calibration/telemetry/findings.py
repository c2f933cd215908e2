"""Input and result type of the telemetry checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from mgeo_attitude._typing import Floats
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry.mapping import TelemetryMapping
from mgeo_calibration.telemetry.telemetry import Telemetry, format_place, list_column_names


class Finding(NamedTuple):
    """Problem reported by a telemetry check, with its place, the expected value and advice.

    Attributes
    ----------
    column : str
        Column, gyro or sensor.
    place : str
        Row and time; see `telemetry.format_place`.
    value : str
        Value with its unit.
    expected : str
        Expected value or property.
    advice : str
        Key to declare or treatment of the samples, as an imperative.
    """

    column: str
    place: str
    value: str
    expected: str
    advice: str

    def __str__(self) -> str:
        at = f"{self.column} at {self.place}"
        advice = f"{self.advice[0].upper()}{self.advice[1:]}"
        return f"{at}: {self.value}, expected {self.expected}. {advice}"


@dataclass(frozen=True, eq=False)
class Samples:
    """Input of the telemetry checks: converted telemetry, raw columns and the mapping of the table.

    Attributes
    ----------
    scenario : Scenario
    telemetry : Telemetry
    columns : mapping of str to (names, array of shape (n, k))
        Columns of gyro and sensors in their own axes and units.
    mapping : TelemetryMapping
        Declarations of the table.
    """

    scenario: Scenario
    telemetry: Telemetry
    columns: Mapping[str, tuple[Sequence[str], Floats]]
    mapping: TelemetryMapping

    @classmethod
    def from_telemetry(cls, scenario: Scenario, telemetry: Telemetry) -> Samples:
        """Build the input of the telemetry checks without the raw columns. Samples in body axes
        replace the raw values.
        """
        gyro = {"gyro": telemetry.gyro_deg_s} if telemetry.has_gyro else {}
        rows = gyro | dict(telemetry.sensors)
        columns = {
            name: (list_column_names(name, each.shape[1]), each) for name, each in rows.items()
        }
        return cls(scenario, telemetry, columns, TelemetryMapping())

    def format_place(self, k: int) -> str:
        return format_place(k, self.telemetry.times, self.telemetry.row_numbers)
