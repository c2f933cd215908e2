"""Evaluation results of maneuver plans of one scenario, each computed on first access."""

from __future__ import annotations

import dataclasses
import math
from contextlib import suppress
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mgeo.plugins.view import View
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.criteria.objectives import OBJECTIVES
from mgeo_attitude.criteria.robustness import MonteCarloRuns, compute_quantile, evaluate_runs
from mgeo_attitude.filter.evaluator import Evaluation
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.criteria import MonteCarloSettings
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory

#: Share of Monte Carlo runs that do not exceed the displayed value, as a number and in words.
MONTE_CARLO_SHARE, MONTE_CARLO_SHARE_TEXT = 0.9, "90 % of Monte Carlo runs"
#: Largest number of plans that warnings and figures evaluate. For each, 200 runs take 1 to 2 s.
_MAX_EVALUATED = 50


class NominalResults(NamedTuple):
    """Results of n plans in nominal runs, that is, without random errors.

    Attributes
    ----------
    t_end, trace : arrays, shape (n,)
        Convergence time [s], and weighted trace of the covariance at that time; NaN if the
        covariance lost positivity.
    covariance : array, shape (n, n_states, n_states)
        Covariance at `t_end` in the filter's units.
    """

    t_end: Floats
    trace: Floats
    covariance: Floats


class Plans(View):
    """Maneuver plans of one problem, whose evaluation results are computed on first access.

    A view that `select` returns shares the caches of its source.

    Parameters
    ----------
    problem : AttitudeManeuverProblem
    X : array_like, shape (n, n_var)
        Designs.
    """

    noun = "plan"
    problem: AttitudeManeuverProblem
    #: Number of independent Monte Carlo runs per plan.
    n_monte_carlo_runs: ClassVar[int] = 200

    def __init__(self, problem: AttitudeManeuverProblem, X: ArrayLike) -> None:
        super().__init__(problem, X)
        self._caches: dict[object, EvaluationCache] = {}
        self._slew_backs: dict[bytes, SlewBack | None] = {}

    def select(self, rows: ArrayLike) -> Plans:
        part = super().select(rows)
        assert isinstance(part, Plans)  # `View.select` returns an instance of this class.
        part._caches, part._slew_backs = self._caches, self._slew_backs
        if "nominal" in self.__dict__:
            part.nominal = NominalResults(*(each[np.asarray(rows)] for each in self.nominal))
        return part

    @cached_property
    def _nominal_run(self) -> Evaluation:
        return self.problem.evaluate_nominal(self.X, covariance=True)

    @cached_property
    def nominal(self) -> NominalResults:
        """Results of the nominal runs, stored or computed on first access."""
        return NominalResults(
            self._nominal_run.t_end, self._nominal_run.trace, self._nominal_run.covariance
        )

    def arrays(self) -> dict[str, Floats]:
        return self.nominal._asdict()

    @cached_property
    def F(self) -> Floats:
        """Objectives of the plans, shape (n, n_obj), stored or computed on first access.

        With Monte Carlo runs, the objectives are quantiles or means over the runs; otherwise they
        are those of the nominal runs.
        """
        return self.objectives_and_constraints[:, : self.problem.n_obj]

    @property
    def violations(self) -> Floats:
        """Relative violation of each bound, shape (n, n_bounds), positive if it is violated."""
        if not self.problem.n_ieq_constr:
            return np.empty((len(self.X), 0))
        return self.objectives_and_constraints[:, self.problem.n_obj + self.problem.n_ieq_constr :]

    @cached_property
    def objectives_and_constraints(self) -> Floats:
        """Objectives, constraint values and relative violations, as columns of one array."""
        problem = self.problem
        if problem.monte_carlo_runs is None:
            return problem.compute_values(problem.model, self._nominal_run)
        return self._get_cache("values").evaluate(self.X, problem.evaluate_designs)

    def _get_cache(self, key: object) -> EvaluationCache:
        return self._caches.setdefault(key, EvaluationCache(last_batch_only=False))

    @property
    def monte_carlo_objectives(self) -> Floats:
        """Objectives that 90 % of Monte Carlo runs do not exceed, shape (n, n_obj)."""
        return self._evaluate_runs()[:, : self.problem.n_obj]

    @property
    def monte_carlo_sigma_deg(self) -> Floats:
        """Worst-axis attitude 1-sigma [deg] that 90 % of Monte Carlo runs do not exceed, shape
        (n,).
        """
        sigma_deg: Floats = np.degrees(self.monte_carlo_sigma[:, 0])
        return sigma_deg

    @property
    def monte_carlo_sigma(self) -> Floats:
        """Worst-axis 1-sigmas not exceeded in 90 % of Monte Carlo runs, shape (n, n_blocks).

        The values are in the internal units of the filter.
        """
        first = self.problem.n_obj
        return self._evaluate_runs()[:, first : first + len(self.problem.model.suite.blocks)]

    @cached_property
    def sigma(self) -> Floats:
        """Predicted 1-sigma of each state at `t_end`, in filter units, shape (n, n_states).

        The values are those of the nominal run. With magnetorquers no run is nominal, because the
        motion depends on the initial attitude error; the values are then root mean squares over
        independent Monte Carlo runs.
        """
        if self.problem.scenario.is_magnetorquer_driven:
            return self._evaluate_runs()[:, -len(self.problem.model.initial_sigma) :]
        return np.sqrt(np.diagonal(self.nominal.covariance, axis1=1, axis2=2))

    def _evaluate_runs(self, n_runs: int | None = None, seed: int | None = None) -> Floats:
        """Evaluate the plans in independent Monte Carlo runs, and return statistics over the runs.

        The columns are the 0.9-quantiles of the objectives and of the worst-axis 1-sigma of each
        3-vector of the state, then the root mean square of the 1-sigma of each state.
        """
        problem = self.problem
        errors = problem.scenario.monte_carlo or MonteCarloSettings()
        errors = dataclasses.replace(
            errors,
            n_runs=n_runs or self.n_monte_carlo_runs,
            seed=errors.seed + 1 if seed is None else seed,
        )

        def compute_values(model: FilterModel, result: Evaluation) -> Floats:
            objectives = problem.compute_values(model, result)[:, : problem.n_obj]
            variances = np.diagonal(result.covariance, axis1=1, axis2=2)
            worst = np.sqrt(variances.reshape(len(variances), -1, 3).max(axis=2))
            return np.column_stack([objectives, worst, variances])

        def compute_statistics(X: Floats) -> Floats:
            runs = MonteCarloRuns(problem.scenario, problem.model, errors)
            values = evaluate_runs(runs, X, compute_values, problem.threads, True)
            criteria, variances = np.split(values, [-len(problem.model.initial_sigma)], axis=2)
            return np.hstack(
                [compute_quantile(criteria, MONTE_CARLO_SHARE), np.sqrt(variances.mean(axis=0))]
            )

        return self._get_cache(errors).evaluate(self.X, compute_statistics)

    def compare_with_monte_carlo(
        self, n_runs: int | None = None, seed: int | None = None
    ) -> pd.DataFrame:
        """Compare the predicted objectives of each plan with those of Monte Carlo runs.

        The runs are independent of those that the search used. Their errors are drawn from the
        table ``monte_carlo`` of the scenario, or from its defaults.

        Parameters
        ----------
        n_runs : int, optional
            Number of runs; default: 200.
        seed : int, optional
            Seed of the runs; default: the seed of the problem's own runs plus one.

        Returns
        -------
        DataFrame
            One row per plan. For each objective: ``predicted LABEL``; ``Monte Carlo LABEL``, the
            0.9-quantile over the runs; and their ratio ``Monte Carlo / predicted LABEL``.
        """
        columns: dict[str, Floats] = {}
        statistics = self._evaluate_runs(n_runs, seed)
        for i, label in enumerate(self.problem.obj_names):
            predicted, robust = self.F[:, i], statistics[:, i]
            columns |= {f"predicted {label}": predicted, f"Monte Carlo {label}": robust}
            columns[f"Monte Carlo / predicted {label}"] = robust / predicted
        return pd.DataFrame(columns)

    @property
    def monte_carlo_t_end(self) -> Floats:
        """Time by which 90 % of independent Monte Carlo runs converge [s], shape (n,).

        The value is infinite if too few runs converge. It is NaN if t_end is not an objective or if
        the covariance lost positivity.
        """
        return self._extract_t_end(self.monte_carlo_objectives)

    @property
    def robust_t_end(self) -> Floats:
        """Convergence time over the Monte Carlo runs of the optimization [s], shape (n,).

        The values are NaN if the optimization uses nominal runs only.
        """
        has_runs = self.problem.scenario.monte_carlo is not None
        return self._extract_t_end(self.F) if has_runs else np.full(len(self.X), np.nan)

    def _extract_t_end(self, F: Floats) -> Floats:
        label = OBJECTIVES["t_end"].label
        if label not in self.problem.obj_names:
            return np.full(len(F), np.nan)
        times = F[:, self.problem.obj_names.index(label)]
        return np.where(times >= self.problem.model.nonconvergence_time, np.inf, times)

    @cached_property
    def hold_end(self) -> Floats:
        """Time at which each plan stops holding its last rate [s], shape (n,).

        Without Monte Carlo runs this is the nominal convergence time. With Monte Carlo runs, it is
        the time at which the requested quantile of the runs, and at least 90 %, have converged, or
        the end of the scenario if too few runs converge. It is NaN if the covariance lost
        positivity.
        """
        problem, t_end = self.problem, self.nominal.t_end
        errors = problem.scenario.monte_carlo
        if not errors:
            return t_end
        end = self.robust_t_end
        if errors.mean or errors.quantile < MONTE_CARLO_SHARE:
            end = np.fmax(end, self.monte_carlo_t_end)
        step = problem.model.step
        end = np.fmin(np.nan_to_num(end, posinf=np.inf), problem.model.duration)
        # A mean over runs is not a multiple of the step.
        return np.maximum(t_end, np.ceil(end / step - 1e-9) * step)

    @cached_property
    def end_times(self) -> Floats:
        """End time of each plan after the epoch [s], shape (n,).

        Without a slew back this is `hold_end`, else the end of the slew back. The value is infinite
        if no slew back fits into the scenario's duration, and NaN if the covariance of the plan
        lost positivity. A slew back takes about 25 ms per plan to compute.
        """
        if not self.problem.scenario.maneuvers.slew_back:
            return self.hold_end
        times = np.full(len(self.X), np.nan)
        for i in np.flatnonzero(np.isfinite(self.nominal.t_end)).tolist():
            try:
                times[i] = self.compute_trajectory(i).end
            except InvalidValue:
                times[i] = math.inf
        return times

    def compute_trajectory(self, row: int) -> Trajectory:
        """Compute the attitude trajectory of one plan, from the epoch to the end of the plan.

        The covariance of the plan must not have lost positivity. The slew back, which takes most of
        the time, is cached for all views that share their caches.

        Parameters
        ----------
        row : int
            Row of the plan.

        Returns
        -------
        Trajectory
        """
        problem, times = self.problem, (float(self.nominal.t_end[row]), float(self.hold_end[row]))
        trajectory = Trajectory(problem.scenario, problem.model, self.X[row], *times)
        key = self.X[row].tobytes()
        if key not in self._slew_backs:
            with suppress(InvalidValue):  # The trajectory raises the error again on access.
                self._slew_backs[key] = trajectory.slew_back
        if key in self._slew_backs:
            trajectory.__dict__["slew_back"] = self._slew_backs[key]  # Set the cached_property.
        return trajectory


def select_sample_rows(n: int) -> Ints:
    """Return up to 50 evenly spaced row indices out of n rows."""
    return np.unique(np.linspace(0, n - 1, min(n, _MAX_EVALUATED)).round().astype(np.int64))


def format_plan_count(rows: Ints, n: int) -> str:
    """Return "50 plans" or, if only a sample of the plans was evaluated, "50 sampled plans"."""
    return f"{len(rows)} plans" if len(rows) == n else f"{len(rows)} sampled plans"
