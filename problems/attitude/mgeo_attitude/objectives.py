"""What can be minimized, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.filter.suite import Suite
from mgeo_attitude.filter.timeline import Schedule
from mgeo_attitude.scenario.objective_names import blocks_of

if TYPE_CHECKING:
    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.scenario import Scenario


@dataclass(frozen=True)
class Objective:
    """Something to minimize.

    Attributes
    ----------
    label : str
        With its unit.
    value : function of model, designs and their evaluation
        Values, shape (n,).
    indicator : function of values and scenario
        Values as indicators should see them: of order one, logarithms of what spans decades.
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    """

    label: str
    value: Callable[[FilterModel, Floats, Evaluation], Floats]
    indicator: Callable[[Floats, Scenario], Floats]
    needs_covariance: bool = False


def objective(name: str, suite: Suite) -> Objective:
    """The objective that a scenario of this suite names."""
    blocks = blocks_of(name)
    return _trace_of(blocks, suite) if blocks else OBJECTIVES[name]


def indicators(names: Sequence[str], F: Floats, scenario: Scenario) -> Floats:
    """Values of objectives, shape (n, n_obj), as indicators should see them; same shape.

    Parameters
    ----------
    names : sequence of str
        One for each column.
    """
    suite = Suite(scenario.gyro, scenario.sensors)
    return np.column_stack(
        [
            objective(name, suite).indicator(column, scenario)
            for name, column in zip(names, F.T, strict=True)
        ]
    )


def scaled(result: Evaluation, model: FilterModel) -> Floats:
    """Covariances at the end in units of the initial 1-sigmas, shape (n, n_states, n_states)."""
    matrix: Floats = result.covariance / np.outer(model.initial_sigma, model.initial_sigma)
    return matrix


def rate_change_deg_s(plan: Schedule, t_end: Floats, step: float) -> Floats:
    """Sum of the magnitudes of all changes of the rate until `t_end` [deg/s], shape (n,).

    The first one is from rest. The impulse of thrusters that turn the satellite, and so their
    propellant, is proportional to it for a spherical inertia.

    Parameters
    ----------
    plan : Schedule
        Of n designs.
    t_end : array, shape (n,)
        Ends of their runs [s]; NaN for a design without result, which has none here either.
    step : float
        [s]
    """
    flown = plan.lasting(_steps(t_end, step)) > 0
    place = np.where(flown, np.arange(flown.shape[1]), -1)
    before = np.pad(np.maximum.accumulate(place, axis=1), ((0, 0), (1, 0)), constant_values=-1)
    before = before[:, :-1, None]  # the stretch flown before each, -1 for none
    rates_before = np.take_along_axis(plan.end_rates, np.maximum(before, 0), axis=1)
    changes = plan.end_rates - np.where(before >= 0, rates_before, 0.0)
    return np.degrees(_sum(np.where(flown, np.linalg.norm(changes, axis=2), 0.0), t_end))


def angle_deg(plan: Schedule, t_end: Floats, step: float) -> Floats:
    """Sum of the angles turned through until `t_end` [deg], shape (n,), the last rate held.

    Parameters as of `rate_change_deg_s`.
    """
    times = step * plan.lasting(_steps(t_end, step))
    return np.degrees(_sum(np.linalg.norm(plan.rates, axis=2) * times, t_end))


def _steps(t_end: Floats, step: float) -> Ints:
    return np.rint(np.nan_to_num(t_end) / step).astype(np.int64)


def _sum(values: Floats, t_end: Floats) -> Floats:
    """Of each row from left to right, so that zeros at its end do not change the last bit."""
    total: Floats = np.where(np.isnan(t_end), np.nan, np.cumsum(values, axis=1)[:, -1])
    return total


def _normalized_trace(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
    """This and the next two are those of equation (13)."""
    mean: Floats = np.trace(scaled(result, model), axis1=1, axis2=2) / model.suite.n_states
    return mean


def _log_determinant(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
    sign, value = np.linalg.slogdet(scaled(result, model))
    per_state: Floats = np.where(sign > 0.0, value / np.log(10.0), np.nan) / model.suite.n_states
    return per_state


def _largest_eigenvalue(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
    matrices = scaled(result, model)
    largest = np.full(len(matrices), np.nan)
    sound = np.isfinite(matrices).all(axis=(1, 2))
    largest[sound] = np.linalg.eigvalsh(matrices[sound])[:, -1]
    return largest


def _time_to_accuracy(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
    """The longest time of a run where the requirements are not met at its end."""
    longest = model.n_steps * model.step
    time = np.where(np.isfinite(result.t_required), result.t_required, longest)
    return np.where(np.isnan(result.trace), np.nan, time)


def _trace_of(names: list[str], suite: Suite) -> Objective:
    chosen = np.repeat([block in names for block in suite.blocks], 3)

    def value(model: FilterModel, designs: Floats, result: Evaluation) -> Floats:
        variances = np.diagonal(result.covariance, axis1=1, axis2=2)
        total: Floats = variances[:, chosen].sum(axis=1)
        return total

    return Objective(f"trace of {', '.join(names)} [-]", value, _decades, needs_covariance=True)


def _share_of_duration(values: Floats, scenario: Scenario) -> Floats:
    return values / scenario.duration


def _decades(values: Floats, scenario: Scenario) -> Floats:
    """Five decades above 1e-6 to the interval from 0 to 1."""
    share: Floats = (np.log10(values) + 6.0) / 5.0
    return share


def _share_of_fastest(values: Floats, scenario: Scenario) -> Floats:
    limits = scenario.maneuvers
    share: Floats = values / (2.0 * np.sqrt(3.0) * limits.max_rate_deg_s * limits.count)
    return share


def _share_of_longest(values: Floats, scenario: Scenario) -> Floats:
    longest = np.sqrt(3.0) * scenario.maneuvers.max_rate_deg_s * scenario.duration
    share: Floats = values / longest
    return share


OBJECTIVES = {
    "t_end": Objective("t_end [s]", lambda model, X, result: result.t_end, _share_of_duration),
    "trace": Objective("trace [-]", lambda model, X, result: result.trace, _decades),
    "normalized_trace": Objective(
        "mean variance relative to the initial [-]",
        _normalized_trace,
        _decades,
        needs_covariance=True,
    ),
    "log_det": Objective(
        "log10 of the determinant relative to the initial, per state [-]",
        _log_determinant,
        lambda values, scenario: (values + 6.0) / 5.0,
        needs_covariance=True,
    ),
    "max_eigenvalue": Objective(
        "largest eigenvalue relative to the initial variances [-]",
        _largest_eigenvalue,
        _decades,
        needs_covariance=True,
    ),
    "t_required": Objective("time to required 1-sigma [s]", _time_to_accuracy, _share_of_duration),
    "angle": Objective(
        "angle turned [deg]",
        lambda model, X, result: angle_deg(result.plan, result.t_end, model.step),
        _share_of_longest,
    ),
    "rate_change": Objective(
        "sum of rate changes [deg/s]",
        lambda model, X, result: rate_change_deg_s(result.plan, result.t_end, model.step),
        _share_of_fastest,
    ),
}
