"""Evaluation of plans at given times without regard to convergence, and changes of their
durations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.constraints import Constraint, list_constraints
from mgeo_attitude.criteria.objectives import find_objective
from mgeo_attitude.filter.evaluator import evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, get_durations
from mgeo_attitude.scenario.scenario import Scenario

#: Fraction of a step by which maneuvers end early, so that rounding does not add a step.
_STEP_TOLERANCE = 1e-6
#: Function that returns objectives, shape (n, k), and largest constraint violations, shape (n,).
DesignEvaluator = Callable[[Floats], tuple[Floats, Floats]]


class PlanProblem(Protocol):
    """Protocol of an optimization problem whose variables are the maneuvers of a scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]

    def evaluate(self, X: Any, *args: Any, **kwargs: Any) -> Any: ...
    @property
    def model(self) -> FilterModel: ...


@dataclass(frozen=True)
class FixedTimeEvaluator:
    """Evaluator of one objective and the constraints at a given filter step.

    The filter need not have converged at this step.

    Attributes
    ----------
    scenario : Scenario
    model : FilterModel
        Model of the scenario, possibly with thinned samples.
    objective_name : str
        Key of the objective. Its logarithm is minimized; "log_det" is a logarithm already.
    threads : int, optional
        Number of threads of one evaluation.
    """

    scenario: Scenario
    model: FilterModel
    objective_name: str = "trace"
    threads: int | None = None

    @cached_property
    def motion_constraints(self) -> list[Constraint]:
        """Constraints of the scenario that depend on the motion but not on the final covariance."""
        return [each for each in list_constraints(self.scenario) if not each.needs_covariance]

    @cached_property
    def covariance_constraints(self) -> list[Constraint]:
        """Constraints of the scenario that depend on the final covariance."""
        return [each for each in list_constraints(self.scenario) if each.needs_covariance]

    def evaluate_at_steps(
        self,
        designs: Floats,
        steps: Ints | int,
        include_covariance_constraints: bool = False,
        allow_partial_steps: bool = False,
    ) -> tuple[Floats, Floats]:
        """Evaluate the objective and the constraint violations of each design at its filter step.

        Parameters
        ----------
        designs : array, shape (n, 4 m)
        steps : array of int, shape (n,), or int
            Step at which each design is evaluated.
        include_covariance_constraints : bool
            Whether to evaluate the constraints on the final covariance too.
        allow_partial_steps : bool
            Whether maneuvers may end within a step, which makes the objective a smooth function of
            the durations. It has no effect on scenarios with ramps between rates.

        Returns
        -------
        value : array, shape (n,)
            Logarithm of the objective; infinite if undefined.
        excess : array, shape (n, k)
            Relative violation of each bound, positive if violated.
        """
        if allow_partial_steps and self.model.slew_limits is None:
            designs = merge_partial_steps(designs, self.model.step)
        objective = find_objective(self.objective_name, self.model.suite)
        active = self.motion_constraints + (
            self.covariance_constraints if include_covariance_constraints else []
        )
        covariance = objective.needs_covariance or any(each.needs_covariance for each in active)
        result = evaluate(
            self.model, designs, self.threads, covariance=covariance, end_steps=np.asarray(steps)
        )
        value = objective.value(self.model, result)
        with np.errstate(invalid="ignore"):
            value = value if self.objective_name == "log_det" else np.log(value)
        violations = [each.compute_violations(result) for each in active]
        excess = np.concatenate(violations).T if violations else np.empty((len(designs), 0))
        value, excess = (np.where(np.isfinite(each), each, np.inf) for each in (value, excess))
        return value, excess

    def select_best(
        self, designs: Floats, steps: int, n_max: int, allow_partial_steps: bool = False
    ) -> Floats:
        """Return the best designs at a filter step, at most `n_max` of them.

        The designs are ordered by constraint violation and then by objective, the best first. The
        violation of a design is its largest violation of a motion constraint.

        Parameters
        ----------
        designs : array, shape (n, 4 m)
        steps : int
            Filter step of the evaluation.
        n_max : int
            Largest number of designs to return.
        allow_partial_steps : bool
            See `evaluate_at_steps`.

        Returns
        -------
        array, shape (k, 4 m), k <= n_max
        """
        return designs[self.rank_designs(designs, steps, allow_partial_steps)[:n_max]]

    def rank_designs(
        self, designs: Floats, steps: Ints | int, allow_partial_steps: bool = False
    ) -> Ints:
        """Rank designs by constraint violation, and then by objective at a filter step.

        The result contains row indices, the best design first.
        """
        value, excess = self.evaluate_at_steps(
            designs, steps, allow_partial_steps=allow_partial_steps
        )
        worst = np.maximum(excess, 0.0).max(axis=1, initial=0.0)
        return np.lexsort((value, worst))

    def evaluate_convergence(self, designs: Floats) -> tuple[Floats, Floats]:
        """Compute the convergence time, the trace and the largest constraint violation of each
        design.

        Parameters
        ----------
        designs : array, shape (n, 4 m)

        Returns
        -------
        F : array, shape (n, 2)
            Convergence times [s] and traces.
        violation : array, shape (n,)
            Largest violation of a motion constraint; 0 if all are satisfied.
        """
        result = evaluate(self.model, designs, self.threads)
        violations = [each.compute_violations(result) for each in self.motion_constraints]
        worst = np.concatenate([*violations, np.zeros((1, len(designs)))]).max(axis=0)
        return np.column_stack([result.t_end, result.trace]), worst


def build_fixed_time_evaluator(
    problem: PlanProblem, objective_name: str = "trace"
) -> FixedTimeEvaluator:
    """Build a `FixedTimeEvaluator` for one objective in nominal runs of a problem.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    objective_name : str
        Key of the objective.
    """
    return FixedTimeEvaluator(problem.scenario, problem.model, objective_name, problem.threads)


def build_design_evaluator(problem: PlanProblem) -> DesignEvaluator:
    """Return a function that computes the objectives and the largest violation of each design.

    Returns
    -------
    function
        Returns objectives, shape (n, n_obj), and largest violations, shape (n,), of n designs.
    """

    def evaluate_designs(designs: Floats) -> tuple[Floats, Floats]:
        F, G = problem.evaluate(designs, return_values_of=["F", "G"])
        return F, np.maximum(G, 0.0).max(axis=1, initial=0.0)

    return evaluate_designs


def set_end_times(designs: Floats, times: Floats | float, max_duration: float) -> Floats:
    """Return copies of designs that are shortened or extended to given end times.

    Maneuvers at the end are shortened, down to zero, or the last maneuver is extended. No maneuver
    becomes longer than `max_duration`, so that a plan may also end earlier than its time.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    times : array, shape (n,), or float
        End of each design [s].
    max_duration : float
        Longest duration of a maneuver [s].

    Returns
    -------
    array, shape (n, 4 m)
    """
    result = designs.copy()
    durations = get_durations(result)
    end_times = np.broadcast_to(times, len(designs))[:, None]
    ends = np.minimum(np.cumsum(durations, axis=1), end_times)
    ends[:, -1:] = end_times
    durations[:] = np.minimum(np.diff(ends, axis=1, prepend=0.0), max_duration)
    return result


def stretch_durations(designs: Floats, factors: Floats | float, max_duration: float) -> Floats:
    """Return copies of designs in which all durations are multiplied by a factor.

    Durations are limited to `max_duration`.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    factors : array, shape (n,), or float
        Factor of each design.
    max_duration : float
        Longest duration of a maneuver [s].

    Returns
    -------
    array, shape (n, 4 m)
    """
    result = designs.copy()
    durations = get_durations(result)
    column = np.broadcast_to(factors, len(designs))[:, None]
    durations[:] = np.minimum(column * durations, max_duration)
    return result


def scale_time(
    designs: Floats, factors: Floats | float, max_duration: float, max_rate_deg_s: float
) -> Floats:
    """Return copies of designs with durations multiplied and rates divided by the same factor.

    Unless a bound is reached, the designs pass through the same attitudes.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    factors : array, shape (n,), or float
        Factor of each design.
    max_duration : float
        Longest duration of a maneuver [s].
    max_rate_deg_s : float
        Maximum rate about each axis [deg/s].

    Returns
    -------
    array, shape (n, 4 m)
    """
    result = stretch_durations(designs, factors, max_duration)
    maneuvers = result.reshape(len(result), -1, VARIABLES_PER_MANEUVER)
    column = np.broadcast_to(factors, len(designs))[:, None, None]
    maneuvers[:, :, :3] = np.clip(maneuvers[:, :, :3] / column, -max_rate_deg_s, max_rate_deg_s)
    return result


def round_to_steps(evaluator: FixedTimeEvaluator, designs: Floats) -> Floats:
    """Return copies of designs in which each maneuver ends at the nearest filter step.

    A maneuver that ends within a step otherwise continues to the end of the step, half a step too
    long on average. Designs of scenarios with ramps are returned unchanged, because ramps start on
    steps.
    """
    if evaluator.model.slew_limits is not None:
        return designs
    result, step = designs.copy(), evaluator.model.step
    durations = get_durations(result)
    ends = np.maximum(np.rint(np.cumsum(durations, axis=1) / step) - _STEP_TOLERANCE, 0.0)
    longest = evaluator.scenario.maneuvers.max_duration
    durations[:] = np.minimum(step * np.diff(ends, axis=1, prepend=0.0), longest)
    return result


def merge_partial_steps(designs: Floats, step: float) -> Floats:
    """Replace each step in which rates change with a maneuver at the mean rate of the step.

    The mean is weighted by time. All maneuvers of the returned designs end on steps, and their
    evaluated results are smooth functions of the original durations.

    Parameters
    ----------
    designs : array, shape (n, 4 m)
    step : float
        Filter step [s].

    Returns
    -------
    array, shape (n, 4 (2 m - 1))
    """
    maneuvers = designs.reshape(len(designs), -1, VARIABLES_PER_MANEUVER)
    rates, ends = maneuvers[:, :, :3], np.cumsum(maneuvers[:, :, 3], axis=1) / step
    if ends.shape[1] == 1:
        return designs
    starts = np.hstack([np.zeros((len(ends), 1)), ends[:, :-1]])
    shared = np.floor(ends[:, :-1])  # Steps in which maneuvers end, shape (n, m - 1).
    weights = np.minimum(shared[:, :, None] + 1.0, ends[:, None]) - np.maximum(
        shared[:, :, None], starts[:, None]
    )
    weights = np.maximum(weights, 0.0)
    weights[:, :, -1] += 1.0 - weights.sum(axis=2)  # The last rate is held in the rest of a step.
    n, m = ends.shape
    result = np.empty((n, 2 * m - 1, VARIABLES_PER_MANEUVER))
    result[:, ::2, :3], result[:, 1::2, :3] = rates, weights @ rates
    end_steps = np.empty((n, 2 * m - 1))
    end_steps[:, :-1:2], end_steps[:, 1::2] = shared, shared + 1.0
    end_steps[:, -1] = np.ceil(ends[:, -1] - _STEP_TOLERANCE)
    end_steps = np.maximum.accumulate(end_steps, axis=1)
    result[:, :, 3] = step * np.diff(
        np.maximum(end_steps - _STEP_TOLERANCE, 0.0), axis=1, prepend=0.0
    )
    return result.reshape(n, -1)
