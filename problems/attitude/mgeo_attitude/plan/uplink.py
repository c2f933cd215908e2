"""A plan as commands to uplink: when to turn at which rates, for how long."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd

from mgeo_attitude.environment.times import utc_texts
from mgeo_attitude.maneuvers.motion import HELD, RAMP, Phase
from mgeo_attitude.plan.files import csv_text
from mgeo_attitude.plan.plan import ManeuverPlan

#: Of a rate [deg/s] after the point: half a unit about each axis is 0.9e-8 deg/s.
RATE_DIGITS = 8
_TIME_DIGITS = 6  # as in UTC


def commands(plan: ManeuverPlan) -> pd.DataFrame:
    """One row per command, from its start until the next one's.

    A ramp belongs to the command for which it is flown: its rates are commanded when the ramp
    begins. The last rows are the rate that is held until the filter has converged, the same rate
    for late flights, if the plan promises a time over flights, and the slew back, if there is one.

    With coils each maneuver is a command, carried out until its rate is reached; nothing is
    commanded after the last.

    Times are whole microseconds. Rates have `RATE_DIGITS` after the point, so that a plan flown by
    them is off by less than 1e-8 deg for each second.

    Columns: ``command``, from 1; ``what``; ``start_utc``; ``start_s`` after the scenario's epoch;
    ``duration_s``; and the body rates ``rate_x_deg_s``, ``rate_y_deg_s``, ``rate_z_deg_s``.

    Parameters
    ----------
    plan : ManeuverPlan

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, commands
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> commands(plan)[["what", "start_s", "duration_s"]]
             what  start_s  duration_s
    0  maneuver 1      0.0       400.0
    1  maneuver 2    400.0       500.0
    2  maneuver 3    900.0       600.0
    3   rate held   1500.0       837.0
    """
    found = _followed(plan)
    starts = np.array([phase.start for phase in found])
    table = pd.DataFrame(
        {
            "command": range(1, len(found) + 1),
            "what": [phase.label for phase in found],
            "start_utc": utc_texts(plan.scenario.epoch, starts),
            "start_s": starts.round(_TIME_DIGITS),
            "duration_s": np.diff([*starts, plan.duration]).round(_TIME_DIGITS),
        }
    )
    rates = np.array([phase.commanded_deg_s for phase in found]).round(RATE_DIGITS) + 0.0  # no -0
    for i, axis in enumerate("xyz"):
        table[f"rate_{axis}_deg_s"] = rates[:, i]
    return table


def _followed(plan: ManeuverPlan) -> list[Phase]:
    """Phases of a plan, ramps and what they lead to as one that begins with the ramp."""
    found: list[Phase] = []
    for phase in plan.phases:
        label = phase.label.removeprefix(RAMP)
        if plan.scenario.turned_by_coils and label.startswith(HELD):
            continue
        if not found or found[-1].label != label:
            found.append(dataclasses.replace(phase, label=label))
    return found


def to_uplink_csv(plan: ManeuverPlan) -> str:
    """The `commands` as CSV.

    Lines that begin with # stand before the header where the plan violates constraints.

    Parameters
    ----------
    plan : ManeuverPlan

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, to_uplink_csv
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> to_uplink_csv(plan).splitlines()[1]
    '1,maneuver 1,2018-06-05T00:00:00.000000,0.0,400.0,0.5,0.3,-0.2'
    """
    return csv_text(plan, commands(plan), index=False)
