"""What is left of the limits of the way after a plan has converged."""

from __future__ import annotations

import numpy as np

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment import Environment
from mgeo_attitude.environment.pointing import Place
from mgeo_attitude.filter.momentum import MomentumBudget
from mgeo_attitude.filter.path_limits import excess_at
from mgeo_attitude.flight.whole import Whole

#: Unit, value, "at most" or "at least", limit and margin: a row of `margins.tables`.
Row = tuple[str, float, str, float, float]


def limits_after(
    whole: Whole, start: float, end: float, covariance: Floats, while_: str
) -> dict[str, Row]:
    """Margins of path limits, and of the wheels' budget, by label.

    Parameters
    ----------
    start, end : float
        [s] after the epoch, both on a step of the filter.
    covariance : array, shape (3, 3)
        Of the attitude error at the start, body axes [rad²]; it is as well known to the end.
    while_ : str
        Which time it is, in words, for the labels.
    """
    model, scenario = whole.model, whole.scenario
    first, last = (round(time / model.step) for time in (start, end))
    attitude = whole.attitude[first : last + 1]
    rows: dict[str, Row] = {}
    wheels = scenario.wheels
    if wheels is not None and wheels.budgeted:
        bounds = (wheels.max_momentum, wheels.max_torque)
        names = (("wheel momentum", "N m s"), ("wheel torque", "N m"))
        loads = _wheel_load(whole, first, last).tolist()
        for (name, unit), load, bound in zip(names, loads, bounds, strict=True):
            if bound is not None:
                rows[name] = (unit, load, "at most", bound, bound - load)
    at = Place.at(scenario, start + model.step * np.arange(len(attitude), dtype=float))
    at = at if scenario.eclipse else at.without_shadow()
    known = np.repeat(covariance[None], len(attitude), axis=0)
    for limit in scenario.path_limits:
        cone, bound = limit.cone(), limit.half_angle_deg
        excess = excess_at(cone, limit.attitude_sigmas, at, scenario.epoch, attitude, known)
        worst = np.degrees(max(float(excess.max()), -np.pi))  # of a Sun that never shines
        if cone.inside:
            rows[limit.label] = ("deg", worst, "at most", bound, bound - worst)
        else:
            rows[limit.label] = ("deg", -worst, "at least", bound, -worst - bound)
    return {f"{label} {while_}": row for label, row in rows.items()}


def _wheel_load(whole: Whole, first: int, last: int) -> Floats:
    """Greatest momentum [N m s] and torque [N m] of a wheel with a budget, shape (2,)."""
    from mgeo_attitude.filter.wheel_load import wheel_loads  # compiles

    model, scenario = whole.model, whole.scenario
    times = model.step * np.arange(last + 1, dtype=float)  # the run may end earlier
    around = Environment.at(scenario, times)
    budget = MomentumBudget.of(scenario, around, model.initial_attitude, model.initial_rate)
    assert budget is not None  # of wheels with one
    flown = model.schedule(whole.commanded, last + 1)
    found: Floats = wheel_loads(budget, flown, np.array([last]), model.step, 1, first)[0]
    return found
