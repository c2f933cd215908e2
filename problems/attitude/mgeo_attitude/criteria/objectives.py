"""What can be minimized, by name, and how well the attitude is known as one number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario.settings import blocks_of
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.settings.types import DEG

if TYPE_CHECKING:
    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.scenario.scenario import Scenario


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
    sigma: Floats = DEG.factor * np.sqrt(variances.max(axis=-1))
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
    return np.where(sound, DEG.factor * np.sqrt(np.maximum(largest, 0.0)), np.nan)


@dataclass(frozen=True)
class Objective:
    """Something to minimize.

    Attributes
    ----------
    label : str
        With its unit.
    value : function of model and evaluation
        Values, shape (n,).
    indicator : function of values and scenario
        Values as indicators should see them: of order one, logarithms of what spans decades.
    needs_covariance : bool
        Whether the evaluation must contain the covariances at the end.
    """

    label: str
    value: Callable[[FilterModel, Evaluation], Floats]
    indicator: Callable[[Floats, Scenario], Floats]
    needs_covariance: bool = False


def objective(name: str, suite: Suite) -> Objective:
    """The objective that a scenario of this suite names."""
    blocks = blocks_of(name)
    return _trace_of(blocks, suite) if blocks else OBJECTIVES[name]


#: Objectives that tell how much is known at the end, and change smoothly with the rates.
SMOOTH = ("trace", "normalized_trace", "log_det", "max_eigenvalue")


def can_be_polished(names: Sequence[str]) -> bool:
    """Whether objectives are the time and one that changes smoothly with the rates."""
    others = [name for name in names if name != "t_end"]
    smooth = bool(others) and (others[0] in SMOOTH or bool(blocks_of(others[0])))
    return len(names) == 2 and len(others) == 1 and smooth


def smooth_objective(names: Sequence[str]) -> str:
    """Which of two objectives to improve, the other being the time.

    Raises
    ------
    ValueError
        For any other objectives.
    """
    if not can_be_polished(names):
        raise ValueError(
            f"objectives = {list(names)}: plans are polished where they are 't_end' and one of "
            f"{', '.join(SMOOTH)}, trace:BLOCK,BLOCK..."
        )
    return next(name for name in names if name != "t_end")


def indicators(names: Sequence[str], F: Floats, scenario: Scenario) -> Floats:
    """Values of the named objectives, shape (n, n_obj), as indicators should see them."""
    suite = scenario.suite
    pairs = zip(names, F.T, strict=True)
    return np.column_stack([objective(name, suite).indicator(f, scenario) for name, f in pairs])


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


def _trace_of(names: list[str], suite: Suite) -> Objective:
    chosen = np.repeat([block in names for block in suite.blocks], 3)

    def value(model: FilterModel, result: Evaluation) -> Floats:
        variances = np.diagonal(result.covariance, axis1=1, axis2=2)
        total: Floats = variances[:, chosen].sum(axis=1)
        return total

    return Objective(f"trace of {', '.join(names)} [-]", value, _decades, needs_covariance=True)


def _decades(values: Floats, scenario: Scenario) -> Floats:
    """Five decades above 1e-6 to the interval from 0 to 1."""
    return (np.log10(values) + 6.0) / 5.0


def _share(whole: Callable[[Scenario], float]) -> Callable[[Floats, Scenario], Floats]:
    """Values as a fraction of what they could be in a scenario."""
    return lambda values, scenario: values / whole(scenario)


OBJECTIVES = {
    "t_end": Objective(
        "t_end [s]", lambda model, result: result.t_end, _share(lambda scenario: scenario.duration)
    ),
    "trace": Objective("trace [-]", lambda model, result: result.trace, _decades),
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
    "t_required": Objective(
        "time to required 1-sigma [s]",
        _time_to_accuracy,
        _share(lambda scenario: scenario.duration),
    ),
    "angle": Objective(
        "angle turned [deg]",
        _angle,
        _share(lambda s: np.sqrt(3.0) * s.maneuvers.max_rate_deg_s * s.duration),
    ),
    "rate_change": Objective(
        "sum of rate changes [deg/s]",
        _rate_change,
        _share(lambda s: 2.0 * np.sqrt(3.0) * s.maneuvers.max_rate_deg_s * s.maneuvers.count),
    ),
}
