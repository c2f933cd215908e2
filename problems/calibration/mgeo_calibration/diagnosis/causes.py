"""What is the matter, in the order in which it is looked for."""

from __future__ import annotations

from mgeo_attitude.scenario import Scenario

from mgeo_calibration.diagnosis.axes import axes_causes
from mgeo_calibration.diagnosis.channels import channel_causes
from mgeo_calibration.diagnosis.clocks import clock_causes
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.telemetry import Telemetry


def checks(
    scenario: Scenario, telemetry: Telemetry, data: Batch | None
) -> dict[str, tuple[str, ...]]:
    """What is seen without any attitude, in words, by what is looked at; the most certain first.

    Parameters
    ----------
    data : Batch, optional
        What was made of telemetry, if it could be.
    """
    return {
        "numbers": tuple(channel_causes(telemetry)),
        "times": tuple(clock_causes(scenario, telemetry)),
        "axes": () if data is None else tuple(axes_causes(data)),
    }


def causes(scenario: Scenario, telemetry: Telemetry, data: Batch | None) -> tuple[str, ...]:
    """All that `checks` say."""
    found = checks(scenario, telemetry, data)
    return tuple(words for said in found.values() for words in said)
