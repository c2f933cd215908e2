"""The planned attitude as an attitude file of STK, ``.a``."""

from __future__ import annotations

from mgeo_attitude.environment.time_frames import as_utc
from mgeo_attitude.plan.attitudes import joined, warnings
from mgeo_attitude.plan.plan import ManeuverPlan

_MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]


def stk_text(plan: ManeuverPlan, *, spacing: float = 1.0) -> str:
    """Quaternions from ICRF to the body, scalar last, from the plan's start to its end.

    Times are seconds after ScenarioEpoch, which is in UTC.

    Parameters
    ----------
    spacing : greatest time between attitudes [s].

    Raises
    ------
    ValueError
        For a spacing not above zero.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, stk_text
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> print(stk_text(plan).splitlines()[5])
    CoordinateAxes ICRF
    """
    times, q = joined(plan, spacing)
    epoch = as_utc(plan.scenario.epoch)
    clock = epoch.strftime("%H:%M:%S.%f")
    lines = [
        "stk.v.11.0",
        *(f"# {line}" for line in warnings(plan)),
        "BEGIN Attitude",
        f"NumberOfAttitudePoints {len(times)}",
        f"ScenarioEpoch {epoch.day} {_MONTHS[epoch.month - 1]} {epoch.year} {clock}",
        "CentralBody Earth",
        "CoordinateAxes ICRF",
        "InterpolationOrder 1",
        "AttitudeTimeQuaternions",
    ]
    for time, row in zip(times, q, strict=True):
        lines.append(f"{time:.6f} " + " ".join(f"{part:.15f}" for part in row))
    return "\n".join([*lines, "END Attitude", ""])
