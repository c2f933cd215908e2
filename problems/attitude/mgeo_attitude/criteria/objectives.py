"""Objectives, one record each, and the accuracy of the attitude as one number."""

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

#: Objectives of the paper, equation (5).
PAPER = ("t_end", "trace")

#: Prefix of the trace over some blocks of the state: ``trace:attitude,gyro.bias``.
TRACE_OF = "trace:"


def attitude_sigma_deg(covariance: Floats) -> Floats:
    """1-sigma of the attitude about the worst of the three body axes [deg], shape (...).

    It is what ``required_sigma.attitude_deg`` is compared with, and what answers, tables, figures
    and files tell.

    Parameters
    ----------
    covariance : array, shape (..., n_states, n_states)
        Of the error state, the attitude error [rad] first; NaN gives NaN.
    """
    variances = np.diagonal(covariance, axis1=-2, axis2=-1)[..., :3]
    sigma: Floats = np.degrees(np.sqrt(variances.max(axis=-1)))
    return sigma


def attitude_accuracy_deg(covariance: Floats) -> Floats:
    """1-sigma of the angle by which the attitude is off, about the worst axis [deg], shape (...).

    The attitude error is a small rotation vector; of its covariance it is the root of the largest
    eigenvalue, which, unlike `attitude_sigma_deg`, does not depend on how the body's axes are
    drawn. It is never less than that, nor more than the root of the trace. Sensor suites are
    compared by it.

    Parameters
    ----------
    covariance : array, shape (..., n_states, n_states)
        Of the error state, the attitude error [rad] first; NaN gives NaN.
    """
    attitude = covariance[..., :3, :3]
    sound = np.asarray(np.isfinite(attitude).all(axis=(-1, -2)))
    largest = np.linalg.eigvalsh(np.where(sound[..., None, None], attitude, 0.0))[..., -1]
    return np.where(sound, np.degrees(np.sqrt(np.maximum(largest, 0.0))), np.nan)


@dataclass(frozen=True)
class Objective:
    """A quantity to minimize.

    Attributes
    ----------
    name : str
        Of the quantity, as columns of tables show it.
    unit : str
        ``-`` for none.
    description : str
        One line for the documentation.
    value : function of model and evaluation
        Values, shape (n,).
    indicator : function of values and scenario
        Values as indicators should see them: of order one, logarithms of what spans decades.
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    is_smooth : bool
        Whether it measures what is known at the end and changes smoothly with the rates, so that a
        local refinement can follow its derivatives.
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
        """Name and unit, such as ``t_end [s]``."""
        return f"{self.name} [{self.unit}]"


def blocks_of(key: str) -> list[str]:
    """Return the blocks in ``trace:BLOCK,BLOCK...``, or none for another key."""
    return key.removeprefix(TRACE_OF).split(",") if key.startswith(TRACE_OF) else []


def objective(key: str, suite: Suite) -> Objective:
    """Return the objective that a scenario with this suite calls by its key."""
    blocks = blocks_of(key)
    return _trace_of(blocks, suite) if blocks else OBJECTIVES[key]


def can_be_polished(keys: Sequence[str]) -> bool:
    """Return whether the objectives are the time and one smooth measure of what is known."""
    others = [key for key in keys if key != "t_end"]
    if len(keys) != 2 or len(others) != 1:
        return False
    return bool(blocks_of(others[0])) or OBJECTIVES[others[0]].is_smooth


def smooth_objective(keys: Sequence[str]) -> str:
    """Return which of two objectives a local refinement improves, the other being the time.

    Raises
    ------
    ValueError
        For other objectives.
    """
    if not can_be_polished(keys):
        smooth = ", ".join(key for key, each in OBJECTIVES.items() if each.is_smooth)
        raise ValueError(
            f"objectives = {list(keys)}: plans are polished where they are 't_end' and one of "
            f"{smooth}, {TRACE_OF}BLOCK,BLOCK..."
        )
    return next(key for key in keys if key != "t_end")


def indicators(keys: Sequence[str], F: Floats, scenario: Scenario) -> Floats:
    """Return values of the objectives, shape (n, n_obj), as indicators should see them."""
    pairs = zip(keys, F.T, strict=True)
    return np.column_stack(
        [objective(key, scenario.suite).indicator(f, scenario) for key, f in pairs]
    )


def _scaled(model: FilterModel, result: Evaluation) -> Floats:
    """Covariances of calibrated states at the end in units of the initial 1-sigmas, (n, k, k)."""
    of = model.suite.calibrated
    sigma = model.initial_sigma[of]
    # an index array would leave an order in memory that sums follow
    block = result.covariance.take(of, axis=1).take(of, axis=2)
    return block / np.outer(sigma, sigma)


def _normalized_trace(model: FilterModel, result: Evaluation) -> Floats:
    """This and the next two are those of equation (13)."""
    matrices = _scaled(model, result)
    mean: Floats = np.trace(matrices, axis1=1, axis2=2) / matrices.shape[1]
    return mean


def _log_determinant(model: FilterModel, result: Evaluation) -> Floats:
    matrices, of = _scaled(model, result), model.suite.calibrated
    sign, value = np.linalg.slogdet(matrices)
    value = value - np.linalg.slogdet(model.initial_correlation[np.ix_(of, of)]).logabsdet
    per_state: Floats = np.where(sign > 0.0, value / np.log(10.0), np.nan) / matrices.shape[1]
    return per_state


def _largest_eigenvalue(model: FilterModel, result: Evaluation) -> Floats:
    matrices = _scaled(model, result)
    largest = np.full(len(matrices), np.nan)
    sound = np.isfinite(matrices).all(axis=(1, 2))
    largest[sound] = np.linalg.eigvalsh(matrices[sound])[:, -1]
    return largest


def _time_to_accuracy(model: FilterModel, result: Evaluation) -> Floats:
    """The longest time of a run where the requirements are not met at its end."""
    time = np.where(np.isfinite(result.t_required), result.t_required, model.longest)
    return np.where(np.isnan(result.trace), np.nan, time)


def _angle(model: FilterModel, result: Evaluation) -> Floats:
    """Sum of the angles turned through until t_end [deg], the last rate held."""
    times = model.step * _lasting(model, result)
    return np.degrees(_sum(np.linalg.norm(result.plan.rates, axis=2) * times, result))


def _rate_change(model: FilterModel, result: Evaluation) -> Floats:
    """Sum of the magnitudes of all changes of the rate until t_end [deg/s], from the initial one.

    The impulse of thrusters that turn the satellite, and so their propellant, is proportional to
    it for a spherical inertia.
    """
    flown, rates = _lasting(model, result) > 0, result.plan.end_rates
    place = np.where(flown, np.arange(flown.shape[1]), -1)
    before = np.pad(np.maximum.accumulate(place, axis=1), ((0, 0), (1, 0)), constant_values=-1)
    before = before[:, :-1, None]  # the stretch flown before each, -1 for none
    rates_before = np.take_along_axis(rates, np.maximum(before, 0), axis=1)
    changes = rates - np.where(before >= 0, rates_before, model.initial_rate)
    return np.degrees(_sum(np.where(flown, np.linalg.norm(changes, axis=2), 0.0), result))


def _lasting(model: FilterModel, result: Evaluation) -> Ints:
    """Steps of each stretch of the plans until t_end."""
    return result.plan.lasting(np.rint(np.nan_to_num(result.t_end) / model.step).astype(np.int64))


def _sum(values: Floats, result: Evaluation) -> Floats:
    """Of each row from left to right, so that zeros at its end do not change the last bit."""
    return np.where(np.isnan(result.t_end), np.nan, np.cumsum(values, axis=1)[:, -1])


def _trace_of(blocks: list[str], suite: Suite) -> Objective:
    chosen = np.repeat([block in blocks for block in suite.blocks], 3)

    def value(model: FilterModel, result: Evaluation) -> Floats:
        variances = np.diagonal(result.covariance, axis1=1, axis2=2)
        total: Floats = variances[:, chosen].sum(axis=1)
        return total

    name = f"trace of {', '.join(blocks)}"
    return Objective(name, "-", TRACE_DESCRIPTION, value, _decades, needs_covariance=True)


def _decades(values: Floats, scenario: Scenario) -> Floats:
    """Map five decades above 1e-6 to the interval from 0 to 1."""
    return (np.log10(values) + 6.0) / 5.0


def _share(whole: Callable[[Scenario], float]) -> Callable[[Floats, Scenario], Floats]:
    """Return values as a fraction of their greatest possible value in a scenario."""
    return lambda values, scenario: values / whole(scenario)


#: Description of the trace over some blocks.
TRACE_DESCRIPTION = "trace over some blocks of the state, such as `trace:attitude,gyro.bias`"

#: The objectives by the keys that scenarios give them.
OBJECTIVES = {
    "t_end": Objective(
        "t_end",
        "s",
        "time until the filter has converged, the first of the paper's, equation (5)",
        lambda model, result: result.t_end,
        _share(lambda scenario: scenario.duration),
    ),
    "trace": Objective(
        "trace",
        "-",
        "weighted trace of the covariance then, the second of the paper's",
        lambda model, result: result.trace,
        _decades,
        is_smooth=True,
    ),
    "normalized_trace": Objective(
        "mean variance relative to the initial",
        "-",
        "mean of the variances, each relative to its initial one",
        _normalized_trace,
        _decades,
        needs_covariance=True,
        is_smooth=True,
    ),
    "log_det": Objective(
        "log10 of the determinant relative to the initial, per state",
        "-",
        "log10 of the covariance's determinant in units of the initial 1-sigmas, per state "
        "(D-optimal)",
        _log_determinant,
        lambda values, scenario: (values + 6.0) / 5.0,
        needs_covariance=True,
        is_smooth=True,
    ),
    "max_eigenvalue": Objective(
        "largest eigenvalue relative to the initial variances",
        "-",
        "largest eigenvalue of the covariance in units of the initial 1-sigmas (E-optimal)",
        _largest_eigenvalue,
        _decades,
        needs_covariance=True,
        is_smooth=True,
    ),
    "t_required": Objective(
        "time to required 1-sigma",
        "s",
        "time from which on all of `[required_sigma]` are met until t_end",
        _time_to_accuracy,
        _share(lambda scenario: scenario.duration),
    ),
    "angle": Objective(
        "angle turned",
        "deg",
        "angle turned through until t_end",
        _angle,
        _share(lambda s: np.sqrt(3.0) * s.maneuvers.max_rate_deg_s * s.duration),
    ),
    "rate_change": Objective(
        "sum of rate changes",
        "deg/s",
        "sum of all changes of the rate until t_end: the impulse of thrusters",
        _rate_change,
        _share(lambda s: 2.0 * np.sqrt(3.0) * s.maneuvers.max_rate_deg_s * s.maneuvers.count),
    ),
}
