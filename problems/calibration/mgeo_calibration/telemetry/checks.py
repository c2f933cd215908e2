"""List of all telemetry checks against declared conventions and physical limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.telemetry import channel_checks, orbit_checks
from mgeo_calibration.telemetry.finding import Finding, Samples
from mgeo_calibration.telemetry.telemetry import Telemetry


class Check(NamedTuple):
    """Telemetry check; reading fails on a finding if ``refuses`` is true."""

    name: str
    find: Callable[[Samples], Iterator[Finding]]
    refuses: bool


CHECKS = (
    Check("time range", orbit_checks.time_range, True),
    Check("constant channels", channel_checks.constant_channels, True),
    Check("saturated rates", channel_checks.saturated_rates, True),
    Check("norms", orbit_checks.norms, True),
    Check("positions against the orbit", orbit_checks.positions, True),
    Check("repeated samples", channel_checks.repeated_samples, False),
    Check("repeated numbers", channel_checks.repeated_numbers, False),
    Check("rates against vectors", orbit_checks.rates, False),
    Check("field strength against time", orbit_checks.field_strength, False),
)


def refuse(samples: Samples) -> None:
    """Raise ValueError with the first finding of the checks that refuse telemetry."""
    for check in CHECKS:
        for finding in check.find(samples) if check.refuses else ():
            raise ValueError(str(finding))


def find_all(scenario: Scenario, telemetry: Telemetry) -> dict[str, tuple[str, ...]]:
    """Return the descriptions of all findings, by check name."""
    samples = Samples.of(scenario, telemetry)
    return {check.name: tuple(map(str, check.find(samples))) for check in CHECKS}
