"""The planned attitude as waypoints that Basilisk's module ``waypointReference`` reads."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.plan.attitudes import Attitudes, attitudes, matrices_of, warnings
from mgeo_attitude.plan.plan import ManeuverPlan


def waypoints_text(plan: ManeuverPlan, *, spacing: float = 1.0) -> str:
    """A line for each instant: time [s], quaternion, angular velocity and acceleration.

    The quaternion is from GCRF to the body with its scalar last, ``attitudeType = 2`` of the
    module; velocity [rad/s] and acceleration [rad/s²] are in inertial axes, as by default. Where
    phases meet and rates jump there are two lines of one instant. Of a plan that violates
    constraints lines that begin with # say so first: as many are the module's ``headerLines``.

    Parameters
    ----------
    spacing : greatest time between instants [s]; between them the module interpolates linearly.

    Raises
    ------
    ValueError
        For a spacing not above zero.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan, waypoints_text
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> len(waypoints_text(plan).splitlines()[0].split(","))
    11
    """
    lines = [f"# {line}" for line in warnings(plan)]
    for part in attitudes(plan, spacing):
        rows = np.column_stack([part.q, _inertial(part)])
        for time, row in zip(part.times, rows, strict=True):
            lines.append(f"{time:.6f}," + ",".join(f"{value:.15e}" for value in row))
    return "\n".join([*lines, ""])


def _inertial(part: Attitudes) -> Floats:
    """Angular velocity and acceleration in inertial axes, shape (k, 6).

    The body's own turn adds nothing to an acceleration that is taken to these axes.
    """
    accelerations = np.gradient(part.rates, part.times, axis=0)
    back = np.swapaxes(matrices_of(part.q), -1, -2)
    found: Floats = np.hstack(
        [np.einsum("kij,kj->ki", back, each) for each in (part.rates, accelerations)]
    )
    return found
