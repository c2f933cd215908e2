"""Objectives of the optimization, and scalar measures of the attitude accuracy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.sensors.suite import Suite

if TYPE_CHECKING:
    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.filter.model import FilterModel
    from mgeo_attitude.scenario.scenario import Scenario

#: Keys of the objectives of the paper, equation (5) of docs/explanation/models-and-filter.md.
PAPER_OBJECTIVES = ("t_end", "trace")

#: Prefix of the key of a trace over some blocks of the state, as in ``trace:attitude,gyro.bias``.
TRACE_PREFIX = "trace:"


def attitude_sigma_deg(covariance: Floats) -> Floats:
    """Return the largest attitude 1-sigma [deg] about the three body axes.

    This accuracy is compared with ``required_sigma.attitude_deg`` and shown in summaries, tables,
    figures and files.

    Parameters
    ----------
    covariance : array, shape (..., n_states, n_states)
        Covariance of the error state, which begins with the attitude error [rad]. NaN gives NaN.
    """
    variances = np.diagonal(covariance, axis1=-2, axis2=-1)[..., :3]
    sigma: Floats = np.degrees(np.sqrt(variances.max(axis=-1)))
    return sigma


def attitude_accuracy_deg(covariance: Floats) -> Floats:
    """Return the largest attitude 1-sigma [deg] about any axis, not only about the body axes.

    The value is the square root of the largest eigenvalue of the attitude covariance. Unlike
    `attitude_sigma_deg`, the value does not depend on the choice of body axes, so that comparisons
    of sensor suites use it. The value is between `attitude_sigma_deg` and the square root of the
    trace.

    Parameters
    ----------
    covariance : array, shape (..., n_states, n_states)
        Covariance of the error state, which begins with the attitude error [rad]. NaN gives NaN.
    """
    attitude = covariance[..., :3, :3]
    is_finite = np.asarray(np.isfinite(attitude).all(axis=(-1, -2)))
    largest = np.linalg.eigvalsh(np.where(is_finite[..., None, None], attitude, 0.0))[..., -1]
    return np.where(is_finite, np.degrees(np.sqrt(np.maximum(largest, 0.0))), np.nan)


@dataclass(frozen=True)
class Objective:
    """Objective of the optimization: a quantity of a plan that is minimized.

    Attributes
    ----------
    name : str
        Name in column headers.
    unit : str
        Unit in column headers; ``-`` for a dimensionless quantity.
    description : str
        Description for the documentation, one line.
    value : function of FilterModel and Evaluation
        Function that returns the value of each design, shape (n,).
    indicator : function of array and Scenario
        Function that scales values to order one for performance indicators, logarithmically if the
        values span decades.
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    is_smooth : bool
        Whether the objective is a smooth function of the rates through the covariance at the end,
        so that a local refinement can use its gradient.
    """

    name: str
    unit: str
    description: str
    value: Callable[[FilterModel, Evaluation], Floats]
    indicator: Callable[[Floats, Scenario], Floats]
    needs_covariance: bool = False
    is_smooth: bool = False

    @property
    def label(self) -> str:
        """Name and unit for column headers, such as ``t_end [s]``."""
        return f"{self.name} [{self.unit}]"


def parse_trace_blocks(key: str) -> list[str]:
    """Return the state blocks in an objective key of the form ``trace:BLOCK,BLOCK...``.

    The list is empty for any other key.
    """
    return key.removeprefix(TRACE_PREFIX).split(",") if key.startswith(TRACE_PREFIX) else []


def find_objective(key: str, suite: Suite) -> Objective:
    """Return the objective for a key such as ``t_end`` or ``trace:attitude``.

    The suite defines the state blocks.
    """
    blocks = parse_trace_blocks(key)
    return _build_trace_objective(blocks, suite) if blocks else OBJECTIVES[key]


def is_refinable(keys: Sequence[str]) -> bool:
    """Return True if the local refinement supports the given objectives.

    The objectives must be ``t_end`` and one smooth objective.
    """
    remaining = [key for key in keys if key != "t_end"]
    if len(keys) != 2 or len(remaining) != 1:
        return False
    return bool(parse_trace_blocks(remaining[0])) or OBJECTIVES[remaining[0]].is_smooth


def find_smooth_objective(keys: Sequence[str]) -> str:
    """Return the key of the smooth objective, which the local refinement minimizes.

    Raises
    ------
    ValueError
        If the objectives cannot be refined; see `is_refinable`.
    """
    if not is_refinable(keys):
        smooth = ", ".join(key for key, each in OBJECTIVES.items() if each.is_smooth)
        raise ValueError(
            f"objectives = {list(keys)}: local refinement needs 't_end' and one of {smooth}, "
            f"{TRACE_PREFIX}BLOCK,BLOCK..."
        )
    return next(key for key in keys if key != "t_end")


def scale_for_indicators(keys: Sequence[str], F: Floats, scenario: Scenario) -> Floats:
    """Scale objective values to order one for performance indicators such as the hypervolume.

    The values have the shape (n, n_obj).
    """
    pairs = zip(keys, F.T, strict=True)
    return np.column_stack(
        [find_objective(key, scenario.suite).indicator(f, scenario) for key, f in pairs]
    )


def _scale_covariances(model: FilterModel, result: Evaluation) -> Floats:
    """Return the final covariance of each plan in units of the initial 1-sigmas.

    The matrices, shape (n, k, k), contain the k calibrated states.
    """
    indices = model.suite.calibrated_indices
    sigma = model.initial_sigma[indices]
    # The method `take` returns C order. An index array would change the memory order and so the
    # rounding.
    block = result.covariance.take(indices, axis=1).take(indices, axis=2)
    return block / np.outer(sigma, sigma)


def _compute_normalized_trace(model: FilterModel, result: Evaluation) -> Floats:
    """Compute the mean ratio of final to initial variance of the calibrated states."""
    matrices = _scale_covariances(model, result)
    mean: Floats = np.trace(matrices, axis1=1, axis2=2) / matrices.shape[1]
    return mean


def _compute_log_determinant(model: FilterModel, result: Evaluation) -> Floats:
    matrices, indices = _scale_covariances(model, result), model.suite.calibrated_indices
    sign, value = np.linalg.slogdet(matrices)
    value = value - np.linalg.slogdet(model.initial_correlation[np.ix_(indices, indices)]).logabsdet
    per_state: Floats = np.where(sign > 0.0, value / np.log(10.0), np.nan) / matrices.shape[1]
    return per_state


def _compute_largest_eigenvalue(model: FilterModel, result: Evaluation) -> Floats:
    matrices = _scale_covariances(model, result)
    largest = np.full(len(matrices), np.nan)
    is_finite = np.isfinite(matrices).all(axis=(1, 2))
    largest[is_finite] = np.linalg.eigvalsh(matrices[is_finite])[:, -1]
    return largest


def _compute_time_to_accuracy(model: FilterModel, result: Evaluation) -> Floats:
    """Compute the time [s] from which each design satisfies all required 1-sigmas.

    If a required 1-sigma is violated at the end, the time is the scenario's duration.
    """
    time = np.where(np.isfinite(result.t_required), result.t_required, model.duration)
    return np.where(np.isnan(result.trace), np.nan, time)


def _compute_angle(model: FilterModel, result: Evaluation) -> Floats:
    """Compute the total rotation angle [deg] of each design until t_end.

    The angle includes the rotation at the last rate after the last maneuver.
    """
    times = model.step * _count_interval_steps(model, result)
    return np.degrees(_sum_rows(np.linalg.norm(result.plan.rates, axis=2) * times, result))


def _compute_rate_change(model: FilterModel, result: Evaluation) -> Floats:
    """Compute the sum of the magnitudes of all rate changes until t_end [deg/s].

    The first change starts from the initial rate. For a spherical inertia, the impulse of attitude
    thrusters is proportional to the sum, and so is the propellant mass.
    """
    is_executed, rates = _count_interval_steps(model, result) > 0, result.plan.end_rates
    indices = np.where(is_executed, np.arange(is_executed.shape[1]), -1)
    previous = np.pad(np.maximum.accumulate(indices, axis=1), ((0, 0), (1, 0)), constant_values=-1)
    previous = previous[:, :-1, None]  # Index of the previous interval; -1 for the first interval.
    rates_before = np.take_along_axis(rates, np.maximum(previous, 0), axis=1)
    changes = rates - np.where(previous >= 0, rates_before, model.initial_rate)
    return np.degrees(
        _sum_rows(np.where(is_executed, np.linalg.norm(changes, axis=2), 0.0), result)
    )


def _count_interval_steps(model: FilterModel, result: Evaluation) -> Ints:
    return result.plan.count_steps(
        np.rint(np.nan_to_num(result.t_end) / model.step).astype(np.int64)
    )


def _sum_rows(values: Floats, result: Evaluation) -> Floats:
    """Sum each row of `values`, and return NaN for a design without a result.

    The terms are added from left to right, so that trailing zeros do not change the rounding.
    """
    return np.where(np.isnan(result.t_end), np.nan, np.cumsum(values, axis=1)[:, -1])


def _build_trace_objective(blocks: list[str], suite: Suite) -> Objective:
    is_selected = np.repeat([block in blocks for block in suite.blocks], 3)

    def value(model: FilterModel, result: Evaluation) -> Floats:
        variances = np.diagonal(result.covariance, axis1=1, axis2=2)
        total: Floats = variances[:, is_selected].sum(axis=1)
        return total

    name = f"trace of {', '.join(blocks)}"
    return Objective(name, "-", TRACE_DESCRIPTION, value, _scale_decades, needs_covariance=True)


def _scale_decades(values: Floats, scenario: Scenario) -> Floats:
    """Scale values logarithmically, so that 1e-6 becomes 0 and 0.1 becomes 1."""
    return (np.log10(values) + 6.0) / 5.0


def _build_scaling(reference: Callable[[Scenario], float]) -> Callable[[Floats, Scenario], Floats]:
    return lambda values, scenario: values / reference(scenario)


#: Description of the objectives with the prefix `TRACE_PREFIX`.
TRACE_DESCRIPTION = "trace over some blocks of the state, such as `trace:attitude,gyro.bias`"

#: Objectives by the key in a scenario file.
OBJECTIVES = {
    "t_end": Objective(
        "t_end",
        "s",
        "time at which the plan ends by the convergence rule, first objective of the paper, "
        "equation (5)",
        lambda model, result: result.t_end,
        _build_scaling(lambda scenario: scenario.duration),
    ),
    "trace": Objective(
        "trace",
        "-",
        "weighted trace of the covariance at t_end, second objective of the paper",
        lambda model, result: result.trace,
        _scale_decades,
        is_smooth=True,
    ),
    "normalized_trace": Objective(
        "mean variance relative to the initial",
        "-",
        "mean of the variances, each relative to its initial value",
        _compute_normalized_trace,
        _scale_decades,
        needs_covariance=True,
        is_smooth=True,
    ),
    "log_det": Objective(
        "log10 of the determinant relative to the initial, per state",
        "-",
        "log10 of the determinant of the covariance in units of the initial 1-sigmas, per state "
        "(D-optimal)",
        _compute_log_determinant,
        lambda values, scenario: (values + 6.0) / 5.0,
        needs_covariance=True,
        is_smooth=True,
    ),
    "max_eigenvalue": Objective(
        "largest eigenvalue relative to the initial variances",
        "-",
        "largest eigenvalue of the covariance in units of the initial 1-sigmas (E-optimal)",
        _compute_largest_eigenvalue,
        _scale_decades,
        needs_covariance=True,
        is_smooth=True,
    ),
    "t_required": Objective(
        "time to required 1-sigma",
        "s",
        "time from which on all of `[required_sigma]` are satisfied until t_end",
        _compute_time_to_accuracy,
        _build_scaling(lambda scenario: scenario.duration),
    ),
    "angle": Objective(
        "rotation angle",
        "deg",
        "accumulated rotation angle until t_end",
        _compute_angle,
        _build_scaling(lambda s: np.sqrt(3.0) * s.maneuvers.max_rate_deg_s * s.duration),
    ),
    "rate_change": Objective(
        "sum of rate changes",
        "deg/s",
        "summed magnitudes of all rate changes until t_end, proportional to thruster impulse",
        _compute_rate_change,
        _build_scaling(
            lambda s: 2.0 * np.sqrt(3.0) * s.maneuvers.max_rate_deg_s * s.maneuvers.count
        ),
    ),
}
