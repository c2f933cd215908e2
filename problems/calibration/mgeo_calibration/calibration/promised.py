"""What a plan has promised beside what came out."""

from __future__ import annotations

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter.history import filter_history
from mgeo_attitude.plan import ManeuverPlan
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.view.describe import exactly
from mgeo_attitude.view.observability import States

from mgeo_calibration.calibration.corrections import telemetry_units


def promised(suite: Suite, time: float, covariance: Floats, plan: ManeuverPlan) -> pd.DataFrame:
    """Per state ``unit``, ``predicted`` and ``achieved`` 1-sigma, and their ratio.

    The plan's linear covariance is that at the calibration's last sample, or at the end of the
    plan's scenario if that is earlier: ``attrs["time_s"]``. ``attrs["flown"]`` says of what motion,
    if that may be asked. Units are those of telemetry.

    Parameters
    ----------
    suite, time, covariance
        Of the calibration.

    Raises
    ------
    ValueError
        For a plan of a satellite with other states.
    """
    model = plan.problem.model
    if model.suite.blocks != suite.blocks:
        raise ValueError(
            f"the plan is for a satellite with the states {list(model.suite.blocks)}: expected "
            f"the calibration's {list(suite.blocks)}"
        )
    history = filter_history(model.endless, plan.trajectory.commanded)
    k = int(np.argmin(np.abs(history.times - time)))
    units = {"attitude": suite.units["attitude"], **telemetry_units(suite)}
    each = [units[block] for block in suite.blocks for _ in "xyz"]
    factors = np.array([unit.factor for unit in each])
    predicted = history.sigma[k] * factors
    achieved = np.sqrt(np.diag(covariance)) * factors
    found = pd.DataFrame(
        {
            "unit": [unit.text for unit in each],
            "predicted": predicted,
            "achieved": achieved,
            "achieved / predicted [-]": achieved / predicted,
        },
        index=pd.Index(States.of(model.suite).names, name="state"),
    )
    found.attrs |= {"time_s": float(history.times[k]), "flown": exactly(plan.scenario)}
    return found
