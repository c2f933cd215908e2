"""All checks of telemetry against declared conventions and physical limits, and their execution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry import channel_checks, orbit_checks
from mgeo_calibration.telemetry.findings import Finding, Samples
from mgeo_calibration.telemetry.telemetry import Telemetry


class Check(NamedTuple):
    """Telemetry check that yields findings. A finding of a fatal check prevents the telemetry from
    being read.
    """

    name: str
    find: Callable[[Samples], Iterator[Finding]]
    is_fatal: bool


CHECKS = (
    Check("time range", orbit_checks.find_invalid_times, True),
    Check("constant channels", channel_checks.find_constant_channels, True),
    Check("saturated rates", channel_checks.find_saturated_rates, True),
    Check("norms", orbit_checks.find_invalid_norms, True),
    Check("positions against the orbit", orbit_checks.find_inconsistent_positions, True),
    Check("repeated samples", channel_checks.find_repeated_samples, False),
    Check("repeated numbers", channel_checks.find_repeated_numbers, False),
    Check("rates against vectors", orbit_checks.find_inconsistent_rates, False),
    Check("field strength against time", orbit_checks.find_inconsistent_field_strengths, False),
)


def reject_findings(samples: Samples) -> None:
    """Run the fatal telemetry checks, and raise ValueError with the first finding."""
    for check in CHECKS:
        for finding in check.find(samples) if check.is_fatal else ():
            raise ValueError(str(finding))


def describe_findings(scenario: Scenario, telemetry: Telemetry) -> dict[str, tuple[str, ...]]:
    """Run all telemetry checks. Return the findings of each check as lines of text, keyed by check
    name.
    """
    samples = Samples.from_telemetry(scenario, telemetry)
    return {check.name: tuple(map(str, check.find(samples))) for check in CHECKS}
