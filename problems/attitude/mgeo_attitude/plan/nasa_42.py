"""The planned attitude as a command script of NASA's simulator 42 (Inp_Cmd.txt)."""

from __future__ import annotations

from mgeo_attitude.environment.time_stamps import utc_texts
from mgeo_attitude.plan.attitudes import joined, warnings
from mgeo_attitude.plan.plan import ManeuverPlan


def script_text(plan: ManeuverPlan, *, spacing: float = 1.0) -> str:
    """Commanded quaternions ``qrn`` of spacecraft 0, scalar last, from 42's inertial frame N.

    Times are seconds of a simulation that begins at the plan's epoch, which the first line names;
    42 does not read that line.

    Parameters
    ----------
    spacing : greatest time between commands [s].

    Raises
    ------
    ValueError
        For a spacing not above zero.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, script_text
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> print(script_text(plan).splitlines()[-1])
    EOF
    """
    times, q = joined(plan, spacing)
    (epoch,) = utc_texts(plan.scenario.epoch, [0.0])
    lines = [f"<<<<<<<<<<<<<<<<<  42:  Command Script File, from {epoch} UTC >>>>>>>>>>>>>>>>>"]
    lines += [f"# {line}" for line in warnings(plan)]
    for time, row in zip(times, q, strict=True):
        parts = " ".join(f"{part:.15f}" for part in row)
        lines.append(f"{time:.6f} SC[0] qrn = [{parts}]")
    return "\n".join([*lines, "EOF", ""])
