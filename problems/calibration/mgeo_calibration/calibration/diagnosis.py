"""Checks of telemetry that need no attitude, which name the cause if a calibration fails."""

from __future__ import annotations

from collections.abc import Mapping

from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.estimation.axis_mistakes import find_axis_mistakes
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.telemetry.checks import describe_findings
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Findings of each check as one-line texts, by name of the check, most reliable check first.
CheckResults = Mapping[str, tuple[str, ...]]
#: Checks that also explain an inconsistent calibration. The other checks apply only if there is no
#: fit, because the model tests of a fit estimate the sizes of these errors.
EXPLANATORY_CHECKS = ("repeated samples", "repeated numbers")


def run_checks(scenario: Scenario, telemetry: Telemetry, data: Batch | None) -> CheckResults:
    """Run all telemetry checks that do not need an attitude estimate.

    Return a dict that maps the name of each check to its findings, one line of text each.

    Parameters
    ----------
    data : Batch, optional
        Batch of the estimator, for the checks of axes and quaternions.
    """
    result = describe_findings(scenario, telemetry)
    axes = () if data is None else tuple(find_axis_mistakes(data))
    return {name: result[name] for name in EXPLANATORY_CHECKS} | {"axes": axes} | result


def list_data_faults(checks: CheckResults) -> tuple[str, ...]:
    """List the faults found by the telemetry checks, starting with the most reliable check.

    Each finding is one line of text.
    """
    return tuple(finding for findings in checks.values() for finding in findings)


class CalibrationError(ValueError):
    """Raised if the telemetry does not determine the attitude, or if the fit does not converge.

    The message starts with the most reliable finding of the checks.

    Attributes
    ----------
    checks : mapping of str to tuple of str
        Result of `run_checks`.
    """

    def __init__(self, message: str, checks: CheckResults | None = None) -> None:
        result = list_data_faults(checks or {})
        super().__init__(f"{result[0]}. Message of the fit: {message}" if result else message)
        self.checks = checks or {}
