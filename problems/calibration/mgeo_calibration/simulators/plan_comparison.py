"""Comparison of the true attitude in simulated runs with the plan: pointing errors, constraints and
wheel momentum.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.directions import SatelliteState
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.path_constraints import compute_monitored_angle_on_orbit
from mgeo_attitude.geometry.rotation import rotation_matrix
from mgeo_attitude.plan.plan import ManeuverPlan
from mgeo_attitude.scenario.actuators import pseudo_inverse_allocation
from mgeo_attitude.scenario.constraints import PathConstraint
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.error_models import apply_bias_sensitivities
from scipy.spatial.transform import Rotation

from mgeo_calibration.simulators.simulated_run import (
    RandomErrors,
    draw_errors,
    select_sensitivity_channels,
    simulate_gyro,
)
from mgeo_calibration.telemetry.telemetry import Telemetry

START_ERROR, END_ERROR = "initial pointing error", "final pointing error"
MAX_ERROR = "largest pointing error"
MAX_RATE, WHEEL_MOMENTUM = "largest rate magnitude", "largest wheel momentum"
_BOUND_COLUMNS = ["bound_type", "bound_value"]
#: Upper quantile of the Monte Carlo runs in a table, in addition to the median.
UPPER_QUANTILE = 0.9
MEDIAN_COLUMN, QUANTILE_COLUMN, VIOLATED_COLUMN = "median", "90 % of runs", "violated [%]"


def compare_with_plan(plan: ManeuverPlan, telemetry: Telemetry) -> pd.DataFrame:
    """Return a table that compares the true attitude of a simulated run with the plan: pointing
    errors, path constraints, body rate and wheel momentum.

    The comparison ends at the end of the plan or at the last sample of telemetry. Rows: pointing
    errors, path constraints, the largest body rate and the largest momentum of a wheel.

    Returns
    -------
    DataFrame
        Columns: ``unit``; ``plan`` and ``simulated``, values of the planned and of the true
        attitude without margin; ``bound_type`` ("at most", "at least" or empty),
        ``bound_value`` and ``satisfied``. ``attrs["time_s"]`` is the end time [s].

    Raises
    ------
    ValueError
        If telemetry has no truth.
    """
    truth = telemetry.truth
    if truth is None:
        raise ValueError("telemetry has no truth: expected telemetry of a simulated run")
    n = min(len(plan.attitude), len(truth.attitude))
    wheels = None if truth.wheel_momentum is None else truth.wheel_momentum[:n]
    rows = build_constraint_table(
        plan,
        compute_constraint_values(plan, plan.attitude[:n]),
        compute_constraint_values(plan, truth.attitude[:n], wheels),
    )
    rows.attrs["time_s"] = float(telemetry.times[n - 1])
    return rows


def compute_constraint_values(
    plan: ManeuverPlan, attitude: Floats, wheel_momentum: Floats | None = None
) -> dict[str, float]:
    """Return the pointing errors [deg], the angle of each path constraint [deg], the largest body
    rate [deg/s] and the largest wheel momentum of an attitude history, as a dict by name of the
    quantity.

    A pointing error is the angle of the rotation between an attitude and the plan's attitude at the
    same sample. The dict contains the errors at the first and at the last sample, and the largest
    error. The angle of a path constraint is the largest (keep-in) or smallest (keep-out) angle,
    without margin.

    Parameters
    ----------
    attitude : array, shape (n, 3, 3)
        Rotation matrices from GCRS to body at the first n samples.
    wheel_momentum : array, shape (n, k), optional
        Momentum of each wheel [N m s]. Default: computed from the conservation of total momentum.
    """
    scenario, n = plan.scenario, len(attitude)
    apart = np.linalg.norm(attitude - plan.attitude[:n], axis=(1, 2))
    off = np.degrees(2.0 * np.arcsin(np.minimum(apart / np.sqrt(8.0), 1.0)))
    result = {
        START_ERROR: float(off[0]),
        END_ERROR: float(off[-1]),
        MAX_ERROR: float(off.max()),
    }
    step_rotations = Rotation.from_matrix(
        attitude[:-1] @ attitude[1:].transpose(0, 2, 1)
    ).as_rotvec()
    around = plan.problem.environment
    at = SatelliteState(*(getattr(around, name)[:n] for name in SatelliteState._fields))
    at = at if scenario.eclipse else at.without_eclipses()
    for constraint in scenario.path_constraints:
        result[constraint.label] = _compute_constraint_angle(
            constraint, scenario, at, attitude, np.vstack([np.zeros(3), step_rotations])
        )
    rates = np.linalg.norm(step_rotations, axis=1) / scenario.step
    result[MAX_RATE] = float(np.degrees(rates.max(initial=0.0)))
    if scenario.wheels is not None:
        if wheel_momentum is None:
            start = plan.problem.model.initial_rate
            wheel_momentum = _compute_momentum(
                scenario, attitude, step_rotations / scenario.step, start
            )
        result[WHEEL_MOMENTUM] = float(np.abs(wheel_momentum).max())
    return result


def build_constraint_table(
    plan: ManeuverPlan, planned: dict[str, float], simulated: dict[str, float]
) -> pd.DataFrame:
    """Return a table with planned and simulated constraint values in one row per quantity, the
    limit of the quantity, and whether the simulated value satisfies the limit. A quantity without
    limit counts as satisfied.
    """
    limits: dict[str, tuple[str, str, float]] = {MAX_RATE: ("deg/s", "", np.nan)}
    for each in plan.scenario.path_constraints:
        limits[each.label] = (
            "deg",
            "at most" if each.keep_in else "at least",
            each.half_angle_deg,
        )
    wheels = plan.scenario.wheels
    if wheels is not None:
        bound = "at most" if wheels.max_momentum else ""
        limits[WHEEL_MOMENTUM] = "N m s", bound, wheels.max_momentum or np.nan
    rows = []
    for label, value in simulated.items():
        unit, bound, limit = limits.get(label, ("deg", "", np.nan))
        beyond = limit - value if bound == "at least" else value - limit
        rows.append((unit, planned[label], value, bound, limit, not beyond > 0.0))
    columns = ["unit", "plan", "simulated", *_BOUND_COLUMNS, "satisfied"]
    return pd.DataFrame(rows, columns=columns, index=pd.Index(simulated, name="quantity"))


def simulate_gyro_guidance(
    plan: ManeuverPlan, model: FilterModel, random_errors: RandomErrors, n_steps: int
) -> Floats:
    """Return the true attitude of a satellite whose controller follows a plan with an attitude
    estimate integrated from the gyro.

    The attitude estimate starts at the plan's initial attitude and integrates the corrected gyro
    rates. The controller is ideal and keeps the estimate on the plan; the Basilisk simulator
    includes the limits of the wheels.

    The true attitude starts at the plan's initial attitude, rotated by the random initial error. It
    then rotates at the planned rates minus the errors of the corrected gyro rates. These errors are
    computed at the planned rates, which is accurate to first order.

    Parameters
    ----------
    random_errors : RandomErrors
    n_steps : int

    Returns
    -------
    array, shape (n_steps + 1, 3, 3)
        Rotation matrices from GCRS to body.
    """
    motion, suite = plan.trajectory.motion, model.suite
    rates, attitude = motion.rates[:n_steps], motion.attitude[: n_steps + 1]
    _, reported = simulate_gyro(model, rates, random_errors)
    x = {
        name: model.initial_states[None, i : i + 3]
        for name, i in suite.get_first_indices(suite.gyro).items()
    }
    follows = select_sensitivity_channels(
        model.sensitivity_factors[1 : n_steps + 1], suite, suite.gyro
    )
    apply_bias_sensitivities(suite.gyro.bias_sensitivities, x, follows)
    wrong = suite.gyro.correct_measurement(SimpleNamespace(**x), reported) - rates
    step = Rotation.from_rotvec(-model.step * (rates - wrong)).as_matrix()
    result = np.concatenate(
        [attitude[:1] @ rotation_matrix(-random_errors.initial_errors[:3] @ attitude[0]), step]
    )
    reach = 1
    while reach <= n_steps:  # products of 2, 4, 8... steps
        result[reach:] = result[reach:] @ result[:-reach]
        reach *= 2
    return result


def _compute_constraint_angle(
    constraint: PathConstraint,
    scenario: Scenario,
    at: SatelliteState,
    attitude: Floats,
    rotations: Floats,
) -> float:
    """Return the largest (keep-in) or smallest (keep-out) angle [deg] between body axis and
    direction of a path constraint over an attitude history, without margin.

    Samples at which the direction is not visible are ignored. If the direction is never visible,
    the result is -180 (keep-in) or 180 (keep-out).
    """
    known = np.zeros((len(attitude), 3, 3))
    excess = compute_monitored_angle_on_orbit(
        constraint.build_cone(), 0.0, at, scenario.epoch, attitude, rotations, known
    )
    # The excess is -inf for a constraint on a Sun that is always eclipsed.
    worst = float(np.degrees(max(float(excess.max()), -np.pi)))
    return worst if constraint.keep_in else -worst


def _compute_momentum(
    scenario: Scenario, attitude: Floats, rates: Floats, initial_rate: Floats
) -> Floats:
    """Return the momentum of each wheel at the start and at the end of each step, computed from the
    conservation of the total momentum. The total momentum follows from `Wheels.initial_momentum`
    and the initial rate; without initial momentum it is zero at any initial rate. With the
    pseudo-inverse allocation, the null-space part of the initial momentum stays in the wheels.

    The model equals the model of `filter.wheel_load` without disturbance torques and magnetic
    unloading. The result has the shape (2 n, k) and the unit N m s.
    """
    wheels = scenario.wheels
    assert wheels is not None
    axes, J = wheels.normalized_axes(), wheels.inertia_matrix()
    total, circulating = np.zeros(3), np.zeros(len(wheels.compute_load_matrix()))
    if wheels.initial_momentum:
        initial_momentum = np.array(wheels.initial_momentum)
        total = attitude[0].T @ (axes.T @ initial_momentum + J @ initial_rate)
        if wheels.allocation == "pseudo-inverse":
            circulating = initial_momentum - pseudo_inverse_allocation(axes) @ (
                axes.T @ initial_momentum
            )
    ends = np.concatenate([attitude[:-1], attitude[1:]])
    result: Floats = (
        ends @ total - np.tile(rates, (2, 1)) @ J.T
    ) @ wheels.compute_load_matrix().T + circulating
    return result


def summarize_gyro_guidance(plan: ManeuverPlan, n_runs: int, seed: int) -> pd.DataFrame:
    """Return a table with statistics of pointing errors and constraints over Monte Carlo runs in
    which the controller follows an attitude estimate integrated from the gyro.

    Returns
    -------
    DataFrame
        Rows as in `compare_with_plan`. Columns: ``unit``, ``plan``, median and 90 % quantile of the
        runs on the unfavorable side, ``bound_type``, ``bound_value`` and the percentage of runs
        that violate the constraint, NaN for a quantity without constraint. Empty for a satellite
        with magnetorquers, whose motion does not follow the gyro.
    """
    if plan.scenario.is_magnetorquer_driven:
        return pd.DataFrame()
    model = plan.problem.model
    n = min(round(min(plan.duration, plan.scenario.duration) / model.step), model.n_steps)
    true_values = [
        compute_constraint_values(
            plan, simulate_gyro_guidance(plan, model, draw_errors(model, n, generator), n)
        )
        for generator in np.random.default_rng(seed).spawn(n_runs)
    ]
    planned = compute_constraint_values(plan, plan.attitude[: n + 1])
    each = [build_constraint_table(plan, planned, one) for one in true_values]
    result = each[0][["unit", "plan", *_BOUND_COLUMNS]].copy()
    table = np.array([one["simulated"] for one in each])
    is_lower = (result["bound_type"] == "at least").to_numpy()
    for at, name in ((0.5, MEDIAN_COLUMN), (UPPER_QUANTILE, QUANTILE_COLUMN)):
        low, high = np.quantile(table, [1.0 - at, at], axis=0)
        result[name] = np.where(is_lower, low, high)
    result[VIOLATED_COLUMN] = 100.0 * np.mean(
        [~one["satisfied"].to_numpy(bool) for one in each], axis=0
    )
    result.loc[result["bound_type"] == "", VIOLATED_COLUMN] = np.nan
    return result[
        ["unit", "plan", MEDIAN_COLUMN, QUANTILE_COLUMN, *_BOUND_COLUMNS, VIOLATED_COLUMN]
    ]


def format_gyro_guidance(summary: pd.DataFrame) -> list[str]:
    """Return a list with one text that summarizes the table of `summarize_gyro_guidance`, or an
    empty list for an empty table.

    The text states the median and the 90 % quantile of the pointing error at the end, and for each
    constraint that some runs violate the percentage of these runs.
    """
    if not len(summary):
        return []
    half, most = summary.loc[END_ERROR, [MEDIAN_COLUMN, QUANTILE_COLUMN]]
    violations = summary[summary[VIOLATED_COLUMN] > 0.0]
    violated = "".join(
        f" {label} is violated in {share:.3g} % of the runs."
        for label, share in violations[VIOLATED_COLUMN].items()
    )
    return [
        "With gyro-based guidance from an uncertain initial attitude, half of the runs end within "
        f"{half:.3g} deg of the planned attitude and 90 % within {most:.3g} deg.{violated}"
    ]
