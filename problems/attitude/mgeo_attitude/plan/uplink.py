"""Export of a plan as a sequence of body-rate commands."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd

from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.maneuvers.motion import HOLD_LABEL, RAMP_PREFIX, Phase
from mgeo_attitude.plan.files import format_csv
from mgeo_attitude.plan.plan import ManeuverPlan

#: Decimals of a rate [deg/s]. The rounding error of the rate vector is at most 0.9e-8 deg/s.
RATE_DIGITS = 8
#: Decimals of a time [s], as in time stamps.
_TIME_DIGITS = 6


def list_commands(plan: ManeuverPlan) -> pd.DataFrame:
    """Return a table of the body-rate commands that execute a plan, with one row per command.

    A command applies until the next command starts. A ramp belongs to the command that it leads to:
    the rates are commanded at the start of the ramp. The maneuvers are followed by the
    constant-rate hold until the filter has converged, by its extension for Monte Carlo runs that
    converge late, and by the slew back, if the plan has them. With magnetorquers, each maneuver is
    a command that is executed until its rate is reached, and no command follows the last maneuver.

    Times are rounded to microseconds and rates to `RATE_DIGITS` decimals. The attitude error from
    rounding grows by less than 1e-8 deg per second.

    Parameters
    ----------
    plan : ManeuverPlan

    Returns
    -------
    DataFrame
        Columns: ``command``, the number from 1; ``label``; ``start_utc``; ``start_s``, after the
        epoch of the scenario; ``duration_s``; and the body rates ``rate_x_deg_s``,
        ``rate_y_deg_s`` and ``rate_z_deg_s``.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, list_commands
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> list_commands(plan)[["label", "start_s", "duration_s"]]
                    label  start_s  duration_s
    0          maneuver 1      0.0       400.0
    1          maneuver 2    400.0       500.0
    2          maneuver 3    900.0       600.0
    3  constant-rate hold   1500.0       837.0
    """
    phases = _merge_ramps(plan)
    starts = np.array([phase.start for phase in phases])
    table = pd.DataFrame(
        {
            "command": range(1, len(phases) + 1),
            "label": [phase.label for phase in phases],
            "start_utc": format_time_stamps(plan.scenario.epoch, starts),
            "start_s": starts.round(_TIME_DIGITS),
            "duration_s": np.diff([*starts, plan.duration]).round(_TIME_DIGITS),
        }
    )
    rates = (
        np.array([phase.commanded_deg_s for phase in phases]).round(RATE_DIGITS) + 0.0
    )  # Adding zero converts -0.
    for i, axis in enumerate("xyz"):
        table[f"rate_{axis}_deg_s"] = rates[:, i]
    return table


def _merge_ramps(plan: ManeuverPlan) -> list[Phase]:
    phases: list[Phase] = []
    for phase in plan.phases:
        label = phase.label.removeprefix(RAMP_PREFIX)
        if plan.scenario.is_magnetorquer_driven and label.startswith(HOLD_LABEL):
            continue
        if not phases or phases[-1].label != label:
            phases.append(dataclasses.replace(phase, label=label))
    return phases


def to_uplink_csv(plan: ManeuverPlan) -> str:
    """Return the body-rate commands of a plan as CSV text; see `list_commands` for the columns.

    Lines before the header that begin with # list violated constraints.

    Parameters
    ----------
    plan : ManeuverPlan

    Returns
    -------
    str

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, to_uplink_csv
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> to_uplink_csv(plan).splitlines()[1]
    '1,maneuver 1,2018-06-05T00:00:00.000000,0.0,400.0,0.5,0.3,-0.2'
    """
    return format_csv(plan, list_commands(plan), index=False)
