"""Diagnose telemetry that cannot be calibrated by checks that need no attitude."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from mgeo_attitude.scenario.scenario import Scenario

from mgeo_calibration.estimation.axes import axes_causes
from mgeo_calibration.estimation.batch import Batch
from mgeo_calibration.telemetry.checks import find_all
from mgeo_calibration.telemetry.telemetry import Telemetry

#: Causes in words, the most certain first, by the name of the check.
Checks = Mapping[str, tuple[str, ...]]
#: Checks whose findings come before the tests of a fit that converges; what the others find is then
#: tested with its size.
BEFORE_TESTS = ("repeated samples", "repeated numbers")


def check(scenario: Scenario, telemetry: Telemetry, data: Batch | None) -> Checks:
    """Check telemetry and axes without any attitude, the most certain check first.

    Parameters
    ----------
    data : Batch, optional
        Samples for the estimator, if telemetry allows them.
    """
    found = find_all(scenario, telemetry)
    axes = () if data is None else tuple(axes_causes(data))
    return {name: found[name] for name in BEFORE_TESTS} | {"axes": axes} | found


def causes(checks: Checks) -> tuple[str, ...]:
    """Return the causes of all checks, the most certain first."""
    return tuple(words for found in checks.values() for words in found)


class CannotCalibrate(ValueError):
    """No attitude or no estimate follows from telemetry; a cause comes first if a check finds one.

    Attributes
    ----------
    checks : mapping of str to tuple of str
        See `check`.
    """

    def __init__(self, message: str, checks: Checks | None = None) -> None:
        found = causes(checks or {})
        super().__init__(f"{found[0]} ({message})" if found else message)
        self.checks = checks or {}

    def check_table(self) -> pd.DataFrame:
        """Return a row for each check with what it ``says``."""
        rows = {name: "; ".join(found) or "nothing" for name, found in self.checks.items()}
        return pd.DataFrame({"says": rows}).rename_axis("check")
