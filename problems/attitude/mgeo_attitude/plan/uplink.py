"""A plan as commands to uplink: when to turn at which rates, for how long."""

from __future__ import annotations

import numpy as np
import pandas as pd

from mgeo_attitude.environment.time_stamps import utc_texts
from mgeo_attitude.maneuvers.phases import RAMP
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER
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
    found = _asked(plan) if plan.scenario.turned_by_coils else _followed(plan)
    starts = np.array([start for _, start, _ in found])
    table = pd.DataFrame(
        {
            "command": range(1, len(found) + 1),
            "what": [label for label, _, _ in found],
            "start_utc": utc_texts(plan.scenario.epoch, starts),
            "start_s": starts.round(_TIME_DIGITS),
            "duration_s": np.diff([*starts, plan.duration]).round(_TIME_DIGITS),
        }
    )
    rates = np.array([rate for _, _, rate in found]).round(RATE_DIGITS) + 0.0  # no -0
    for i, axis in enumerate("xyz"):
        table[f"rate_{axis}_deg_s"] = rates[:, i]
    return table


#: What is commanded, when [s] after the epoch, and the body rates [deg/s].
_Command = tuple[str, float, tuple[float, float, float]]


def _asked(plan: ManeuverPlan) -> list[_Command]:
    """Of coils, whatever becomes of it."""
    flight, found = plan.trajectory.flown, []
    for number in dict.fromkeys(flight.numbers.tolist()):
        x, y, z, _ = plan.design[VARIABLES_PER_MANEUVER * number :][:VARIABLES_PER_MANEUVER]
        start = float(flight.times[:-1][flight.numbers == number][0])
        found.append((f"maneuver {number + 1}", start, (x, y, z)))
    return found


def _followed(plan: ManeuverPlan) -> list[_Command]:
    """Of rates that are flown as they are commanded, phase by phase."""
    found: list[_Command] = []
    ramp_since: float | None = None
    for phase in plan.phases:
        if phase.label.startswith(RAMP):
            ramp_since = phase.start if ramp_since is None else ramp_since
            continue
        start = phase.start if ramp_since is None else ramp_since
        found.append((phase.label, start, phase.rates_deg_s))
        ramp_since = None
    if ramp_since is not None:  # it ends in a ramp, to the last rate of all
        x, y, z = (float(rate) for rate in plan.trajectory.commanded[-4:-1])
        found.append((plan.phases[-1].label.removeprefix(RAMP), ramp_since, (x, y, z)))
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
    comments = "".join(f"# VIOLATED CONSTRAINT: {violation}\n" for violation in plan.violations())
    text: str = commands(plan).to_csv(index=False, lineterminator="\n")
    return comments + text
