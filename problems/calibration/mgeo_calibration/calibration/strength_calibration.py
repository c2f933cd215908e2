"""Calibrate magnetometers from the field strength, where attitude and rate are unknown."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.sensors.vector_sensors import Magnetometer

from mgeo_calibration.calibration.agreement import correlation_bound, nis_bounds
from mgeo_calibration.calibration.corrections import telemetry_units
from mgeo_calibration.estimation.batch import batch
from mgeo_calibration.estimation.belief import Belief
from mgeo_calibration.estimation.field_strength import BLOCKS, by_strength
from mgeo_calibration.telemetry.mapping import TelemetryMapping
from mgeo_calibration.telemetry.reading import read_telemetry
from mgeo_calibration.telemetry.telemetry import Telemetry

#: What is said of it wherever it is shown.
ALONE = (
    "by the strength of the field alone, without attitude: misalignments are not to be found, nor "
    "are errors that vary"
)


@dataclass(frozen=True, eq=False)
class StrengthCalibration:
    """Bias, scale factor and nonorthogonality of magnetometers.

    Attributes
    ----------
    table : DataFrame
        As `Calibration.table`, of those blocks.
    covariance : dict of str to array, shape (9, 9)
        By magnetometer, of those blocks in the filter's units.
    failures : list of str
        What residuals say against it; none is what one wants.
    notes : list of str
        Noise that is less than was said: the estimate is better than its 1-sigmas say.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate_alone, fly
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> found = calibrate_alone(scenario, fly(scenario, design, seed=1))
    >>> found.table["block"].unique().tolist()
    ['mag.bias']
    """

    table: pd.DataFrame
    covariance: dict[str, np.ndarray]
    failures: list[str]
    notes: list[str] = field(default_factory=list)

    @property
    def conclusion(self) -> str:
        """In one line."""
        if not self.failures:
            return f"the residuals support it; {ALONE}"
        return f"the residuals do not support it: {'; '.join(self.failures)}; {ALONE}"


def calibrate_alone(
    scenario: Scenario,
    telemetry: Telemetry | pd.DataFrame | Path | str,
    mapping: TelemetryMapping | None = None,
) -> StrengthCalibration:
    """Calibrate the magnetometers of a scenario, each alone.

    Parameters
    ----------
    telemetry, mapping
        As of `calibrate`; a mapping with ``holds = "unknown"`` under ``gyro`` asks for no gyro.

    Raises
    ------
    ValueError, OSError, ImportError
        From `read_telemetry`; or without a magnetometer, or for one that its readings do not tell.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_calibration import calibrate_alone, fly
    >>> scenario = Scenario.from_dict({"preset": "paper", "duration": 900.0})
    >>> design = [0.5, 0.3, -0.2, 300.0, -0.3, 0.6, 0.2, 300.0, 0.2, -0.4, 0.7, 300.0]
    >>> found = calibrate_alone(scenario, fly(scenario, design, seed=1))
    >>> list(found.covariance), len(found.table)
    (['mag'], 3)
    """
    if not isinstance(telemetry, Telemetry):
        telemetry = read_telemetry(telemetry, scenario, mapping)
    suite = Suite(scenario.gyro, scenario.sensors)
    data, belief, units = batch(scenario, telemetry), Belief.of(scenario), telemetry_units(suite)
    rows, covariances = [], {}
    failures, notes = list[str](), list[str]()
    magnetometers = [k for k, s in enumerate(suite.sensors) if isinstance(s, Magnetometer)]
    if not magnetometers:
        raise ValueError(
            "sensors: expected a magnetometer, whose field has a strength that is known"
        )
    for index in magnetometers:
        name = suite.sensors[index].name
        try:
            found = by_strength(data, index, belief)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        covariances[name] = found.covariance
        sigma = np.sqrt(np.diag(found.covariance))
        for number, block in enumerate(f"{name}.{part}" for part in BLOCKS):
            if block not in units:
                continue
            first = 3 * suite.blocks.index(block)
            for i, axis in enumerate("xyz"):
                k, unit = 3 * number + i, units[block]
                values = found.values[k], sigma[k], belief.sigma[first + i]
                rows.append((block, axis, unit.text, *(float(v) * unit.factor for v in values)))
        against, of_noise = _said(name, found.residuals, 2 * len(magnetometers))
        failures, notes = failures + against, notes + of_noise
    columns = ["block", "axis", "unit", "estimate", "sigma", "prior_sigma"]
    return StrengthCalibration(pd.DataFrame(rows, columns=columns), covariances, failures, notes)


def _said(name: str, residuals: np.ndarray, tests: int) -> tuple[list[str], list[str]]:
    """What residuals say against it and, as `SensorTest.notes`, of noise that is less."""
    failures, notes, square = [], [], float((residuals**2).mean())
    low, high = nis_bounds(len(residuals), tests)
    if not square <= high:
        failures.append(
            f"the strength that {name} measures scatters more than its noise (chi-square "
            f"{square:.3f} a reading, expected {low:.3f} to {high:.3f})"
        )
    if square < low:
        notes.append(
            f"{name}: sigmas are too large by {1.0 / np.sqrt(square):.3g}; its noise is less than "
            "the scenario says"
        )
    next_to = abs(float((residuals[1:] * residuals[:-1]).mean())) / square
    if next_to > (most := correlation_bound(len(residuals), tests)):
        less = np.sqrt((1.0 + next_to) / (1.0 - next_to))  # as of a first-order process
        failures.append(
            f"residuals of {name} are not white (correlation {next_to:.3f}, expected at most "
            f"{most:.3f}): sigmas are too small, about {less:.2g} times"
        )
    return failures, notes
