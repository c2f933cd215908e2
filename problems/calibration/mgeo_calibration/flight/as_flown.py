"""Where satellites end and what they keep: of one true attitude, and of many flights."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import Place
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.path_limits import excess_along
from mgeo_attitude.geometry.rotation import matrix
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.actuators import pseudo_inverse
from mgeo_attitude.scenario.limits import PathLimit
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.errors import influenced
from scipy.spatial.transform import Rotation

from mgeo_calibration.flight.flight import Draws, columns, draw, gyro_of
from mgeo_calibration.telemetry.telemetry import Telemetry

END, GREATEST = "off the plan, end", "off the plan, most"
MOMENTUM = "wheel momentum"
#: Share of the flights that a table's column is of, beside half of them.
MOST = 0.9
HALF, MOST_OF, BROKEN = "half of flights", "9 of 10", "broken [%]"


def as_flown(plan: ManeuverPlan, telemetry: Telemetry) -> pd.DataFrame:
    """What a flight of a plan came to until the plan's end, or its last sample, a row for each.

    Rows are the pointing error, each path limit and the greatest momentum of a wheel. Columns:
    ``unit``; ``plan``, of the attitude that was planned, and ``flown``, of the true one, both
    without a margin; ``bound`` ("at most", "at least" or none), ``limit``, and whether it was
    ``kept``. ``attrs["time_s"]`` is the end.

    Raises
    ------
    ValueError
        For telemetry whose truth nobody knows.
    """
    truth = telemetry.truth
    if truth is None:
        raise ValueError("telemetry has no truth: expected that of a simulated flight")
    n = min(len(plan.attitude), len(truth.attitude))
    wheels = None if truth.wheel_momentum is None else truth.wheel_momentum[:n]
    rows = beside(plan, values(plan, plan.attitude[:n]), values(plan, truth.attitude[:n], wheels))
    rows.attrs["time_s"] = float(telemetry.times[n - 1])
    return rows


def values(plan: ManeuverPlan, attitude: Floats, wheels: Floats | None = None) -> dict[str, float]:
    """What is to be kept, of a true attitude at the first n samples, shape (n, 3, 3), by label.

    Parameters
    ----------
    wheels : array, shape (n, k), optional
        Momentum of each wheel [N m s]; default: what keeps the satellite's, on which no torque
        acts.
    """
    scenario, n = plan.scenario, len(attitude)
    apart = np.linalg.norm(attitude - plan.attitude[:n], axis=(1, 2))
    off = 2.0 * np.arcsin(np.minimum(apart / np.sqrt(8.0), 1.0))
    found = {END: float(np.degrees(off[-1])), GREATEST: float(np.degrees(off.max()))}
    turn = Rotation.from_matrix(attitude[:-1] @ attitude[1:].transpose(0, 2, 1)).as_rotvec()
    around = plan.problem.environment
    at = Place(*(getattr(around, name)[:n] for name in Place._fields))
    at = at if scenario.eclipse else at.without_shadow()
    for limit in scenario.path_limits:
        found[limit.label] = _angle(limit, scenario, at, attitude, np.vstack([np.zeros(3), turn]))
    if scenario.wheels is not None:
        if wheels is None:
            start = plan.problem.model.initial_rate
            wheels = _momentum(scenario, attitude, turn / scenario.step, start)
        found[MOMENTUM] = float(np.abs(wheels).max())
    return found


def beside(plan: ManeuverPlan, planned: dict[str, float], flown: dict[str, float]) -> pd.DataFrame:
    """The table of `as_flown`."""
    limits: dict[str, tuple[str, str, float]] = {}
    for each in plan.scenario.path_limits:
        limits[each.label] = "deg", "at most" if each.keep_in else "at least", each.half_angle_deg
    wheels = plan.scenario.wheels
    if wheels is not None:
        bound = "at most" if wheels.max_momentum else ""
        limits[MOMENTUM] = "N m s", bound, wheels.max_momentum or np.nan
    rows = []
    for label, value in flown.items():
        unit, bound, limit = limits.get(label, ("deg", "", np.nan))
        beyond = limit - value if bound == "at least" else value - limit
        rows.append((unit, planned[label], value, bound, limit, not beyond > 0.0))
    columns = ["unit", "plan", "flown", "bound", "limit", "kept"]
    return pd.DataFrame(rows, columns=columns, index=pd.Index(flown, name="as flown"))


def by_gyro(plan: ManeuverPlan, model: FilterModel, draws: Draws, n_steps: int) -> Floats:
    """True attitude of a satellite that is turned by what its gyro says, shape (n + 1, 3, 3).

    It believes the plan's first attitude, adds up what its gyro reports, without what is believed
    of its errors, and makes that the plan's, exactly: Basilisk's does so as well as wheels can.
    """
    motion, suite = plan.trajectory.motion, model.suite
    rates, attitude = motion.rates[:n_steps], motion.attitude[: n_steps + 1]
    _, reported = gyro_of(model, rates, draws)
    x = {
        name: model.initial_states[None, i : i + 3] for name, i in suite.places(suite.gyro).items()
    }
    follows = columns(model.influences[1 : n_steps + 1], suite, suite.gyro)
    influenced(suite.gyro.influences, x, follows)
    wrong = suite.gyro.corrected(SimpleNamespace(**x), reported) - rates
    step = Rotation.from_rotvec(-model.step * (rates - wrong)).as_matrix()
    found = np.concatenate([attitude[:1] @ matrix(-draws.errors[:3] @ attitude[0]), step])
    reach = 1
    while reach <= n_steps:  # products of 2, 4, 8... steps
        found[reach:] = found[reach:] @ found[:-reach]
        reach *= 2
    return found


def _angle(
    limit: PathLimit, scenario: Scenario, at: Place, attitude: Floats, turn: Floats
) -> float:
    """Least or greatest angle [deg]."""
    known = np.zeros((len(attitude), 3, 3))
    excess = excess_along(limit.cone(), 0.0, at, scenario.epoch, attitude, turn, known)
    worst = float(np.degrees(max(float(excess.max()), -np.pi)))  # of a Sun that never shines
    return worst if limit.keep_in else -worst


def _momentum(scenario: Scenario, attitude: Floats, rates: Floats, start: Floats) -> Floats:
    """Of each wheel at both ends of steps, shape (2 n, k) [N m s], from a body rate at the start.

    As `filter.wheel_load`, without disturbances and what coils unload.
    """
    wheels = scenario.wheels
    assert wheels is not None
    axes, J = wheels.spin_axes(), wheels.matrix()
    total, circulating = np.zeros(3), np.zeros(len(wheels.shares()))
    if wheels.initial_momentum:
        held = np.array(wheels.initial_momentum)
        total = attitude[0].T @ (axes.T @ held + J @ start)
        if wheels.allocation == "pseudo-inverse":
            circulating = held - pseudo_inverse(axes) @ (axes.T @ held)
    ends = np.concatenate([attitude[:-1], attitude[1:]])
    found: Floats = (ends @ total - np.tile(rates, (2, 1)) @ J.T) @ wheels.shares().T + circulating
    return found


def ends(plan: ManeuverPlan, n_runs: int, seed: int) -> pd.DataFrame:
    """Of flights with the errors of `verify`, until the plan's end; a row as in `as_flown`.

    Columns: ``unit``; ``plan``; what half and nine of ten flights come to or stay on the better
    side of; ``bound``, ``limit``; and in how many it is ``broken [%]``. None of a satellite that
    coils turn, whatever its gyro says.
    """
    if plan.scenario.turned_by_coils:
        return pd.DataFrame()
    model = plan.problem.model
    n = min(round(min(plan.duration, plan.scenario.duration) / model.step), model.n_steps)
    flown = [
        values(plan, by_gyro(plan, model, draw(model, n, generator), n))
        for generator in np.random.default_rng(seed).spawn(n_runs)
    ]
    planned = values(plan, plan.attitude[: n + 1])
    each = [beside(plan, planned, one) for one in flown]
    found = each[0][["unit", "plan", "bound", "limit"]].copy()
    table = np.array([one["flown"] for one in each])
    least = (found["bound"] == "at least").to_numpy()
    for at, name in ((0.5, HALF), (MOST, MOST_OF)):
        low, high = np.quantile(table, [1.0 - at, at], axis=0)
        found[name] = np.where(least, low, high)
    found[BROKEN] = 100.0 * np.mean([~one["kept"].to_numpy(bool) for one in each], axis=0)
    found.loc[found["bound"] == "", BROKEN] = np.nan
    return found[["unit", "plan", HALF, MOST_OF, "bound", "limit", BROKEN]]


def told(found: pd.DataFrame) -> list[str]:
    """In a line where flights end, and which limits they break; none without flights."""
    if not len(found):
        return []
    half, most = found.loc[END, [HALF, MOST_OF]]
    broken = found[found[BROKEN] > 0.0]
    limits = "".join(
        f"; {label} broken in {share:.3g} %" for label, share in broken[BROKEN].items()
    )
    return [
        "turned by what the gyro says, from an attitude that is not quite the plan's, half of the "
        f"flights end less than {half:.3g} deg off it, 9 of 10 less than {most:.3g} deg{limits}"
    ]
