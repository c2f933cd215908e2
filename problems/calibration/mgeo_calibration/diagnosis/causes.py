"""What is the matter, in the order in which it is looked for."""

from __future__ import annotations

from collections.abc import Iterator

from mgeo_attitude.scenario import Scenario

from mgeo_calibration.diagnosis.axes import axes_causes
from mgeo_calibration.diagnosis.channels import channel_causes
from mgeo_calibration.diagnosis.clocks import clock_causes
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.telemetry import Telemetry


def causes(scenario: Scenario, telemetry: Telemetry, data: Batch | None) -> tuple[str, ...]:
    """All that is seen without any attitude, the most certain first.

    Parameters
    ----------
    data : Batch, optional
        What was made of telemetry, if it could be.
    """

    def found() -> Iterator[str]:
        yield from channel_causes(telemetry)
        yield from clock_causes(scenario, telemetry)
        if data is not None:
            yield from axes_causes(data)

    return tuple(found())
