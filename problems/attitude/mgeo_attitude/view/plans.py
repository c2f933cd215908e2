"""Evaluation results of plans of one scenario, each computed on first access."""

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
from mgeo_attitude.criteria.objectives import OBJECTIVES, attitude_sigma_deg
from mgeo_attitude.criteria.robustness import MonteCarloRuns, compute_quantile, evaluate_runs
from mgeo_attitude.filter.evaluator import Evaluation
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.criteria import MonteCarloSettings
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory

#: Share of Monte Carlo runs in which a plan's ``kept`` values hold, as a number and in words.
MONTE_CARLO_SHARE, MONTE_CARLO_SHARE_TEXT = 0.9, "9 of 10 Monte Carlo runs"
#: Largest number of plans that remarks and figures evaluate; 200 runs of each take 1 to 2 s.
_MAX_EVALUATED = 50


class NominalResults(NamedTuple):
    """Results of the nominal runs of n plans.

    Attributes
    ----------
    t_end, trace : arrays, shape (n,)
        Time of convergence [s] and weighted trace of the covariance at that time; NaN if the
        covariance lost positivity.
    covariance : array, shape (n, n_states, n_states)
        Covariance at `t_end`.
    """

    t_end: Floats
    trace: Floats
    covariance: Floats


class Plans(View):
    """Maneuver plans, shape (n, n_var), with cached results.

    Views created by `select` share the caches of their source.
    """

    problem: AttitudeManeuverProblem
    #: Number of independent Monte Carlo runs from which `kept` is computed.
    n_monte_carlo_runs: ClassVar[int] = 200

    def __init__(self, problem: AttitudeManeuverProblem, X: ArrayLike) -> None:
        super().__init__(problem, X)
        self._caches: dict[object, EvaluationCache] = {}
        self._slew_backs: dict[bytes, SlewBack | None] = {}

    def select(self, rows: ArrayLike) -> Plans:
        part = super().select(rows)
        assert isinstance(part, Plans)  # the class of the problem's view
        part._caches, part._slew_backs = self._caches, self._slew_backs
        if "nominal" in self.__dict__:
            part.nominal = NominalResults(*(each[np.asarray(rows)] for each in self.nominal))
        return part

    @cached_property
    def _nominal_run(self) -> Evaluation:
        return self.problem.evaluate_nominal(self.X, covariance=True)

    @cached_property
    def nominal(self) -> NominalResults:
        """Results of the nominal runs, taken from the run folder if stored, else evaluated."""
        return NominalResults(
            self._nominal_run.t_end, self._nominal_run.trace, self._nominal_run.covariance
        )

    def arrays(self) -> dict[str, Floats]:
        """Return the results of the nominal runs by the field names of `NominalResults`."""
        return self.nominal._asdict()

    @cached_property
    def F(self) -> Floats:
        """Objectives, shape (n, n_obj), taken from the run folder if stored, else evaluated.

        With Monte Carlo runs, the objectives are statistics of these; otherwise they are nominal.
        """
        return self.objectives_and_constraints[:, : self.problem.n_obj]

    @property
    def violations(self) -> Floats:
        """Relative violation of each constraint, shape (n, n_limits); positive if violated."""
        if not self.problem.n_ieq_constr:
            return np.empty((len(self.X), 0))
        return self.objectives_and_constraints[:, self.problem.n_obj + self.problem.n_ieq_constr :]

    @cached_property
    def objectives_and_constraints(self) -> Floats:
        """Objectives, constraints and `excesses`, side by side."""
        problem = self.problem
        if problem.monte_carlo_runs is None:
            return problem.compute_values(problem.model, self._nominal_run)
        return self._get_cache("values").evaluate(self.X, problem.evaluate_designs)

    def _get_cache(self, key: object) -> EvaluationCache:
        return self._caches.setdefault(key, EvaluationCache(last_batch_only=False))

    @property
    def monte_carlo_objectives(self) -> Floats:
        """Objectives in the share `MOST` of 200 independent Monte Carlo runs, shape (n, n_obj)."""
        return self._evaluate_runs()[:, : self.problem.n_obj]

    @property
    def monte_carlo_sigma_deg(self) -> Floats:
        """Attitude 1-sigma, worst body axis, in the share `MOST` of the runs [deg], shape (n,)."""
        return self._evaluate_runs()[:, self.problem.n_obj]

    @cached_property
    def sigma(self) -> Floats:
        """1-sigma of each state at `t_end`, as displayed, shape (n, n_states).

        The values belong to the nominal run. Magnetorquers have no representative nominal run,
        since their motion depends on the initial attitude; their values are root mean squares over
        the Monte Carlo runs of `kept`.
        """
        if self.problem.scenario.is_magnetorquer_driven:
            return self._evaluate_runs()[:, self.problem.n_obj + 1 :]
        return np.sqrt(np.diagonal(self.nominal.covariance, axis1=1, axis2=2))

    def _evaluate_runs(self, n_runs: int | None = None, seed: int | None = None) -> Floats:
        """Return statistics of independent Monte Carlo runs, shape (n, n_obj + 1 + n_states).

        Columns: objectives and 1-sigma of the attitude [deg] in the share `MOST` of the runs, then
        the root mean square of the 1-sigma of each state.
        """
        problem = self.problem
        errors = problem.scenario.monte_carlo or MonteCarloSettings()
        errors = dataclasses.replace(
            errors,
            n_runs=n_runs or self.n_monte_carlo_runs,
            seed=errors.seed + 1 if seed is None else seed,
        )

        def found(model: FilterModel, ran: Evaluation) -> Floats:
            objectives = problem.compute_values(model, ran)[:, : problem.n_obj]
            variances = np.diagonal(ran.covariance, axis1=1, axis2=2)
            return np.column_stack([objectives, attitude_sigma_deg(ran.covariance), variances])

        def run(X: Floats) -> Floats:
            samples = MonteCarloRuns(problem.scenario, problem.model, errors)
            values = evaluate_runs(samples, X, found, problem.threads, True)
            own, variances = np.split(values, [problem.n_obj + 1], axis=2)
            return np.hstack(
                [compute_quantile(own, MONTE_CARLO_SHARE), np.sqrt(variances.mean(axis=0))]
            )

        return self._get_cache(errors).evaluate(self.X, run)

    def compare_with_monte_carlo(
        self, n_runs: int | None = None, seed: int | None = None
    ) -> pd.DataFrame:
        """Compare the objectives of plans with those in 9 of 10 independent Monte Carlo runs.

        The runs are drawn from the scenario's ``flight`` errors, or from the default errors.

        Parameters
        ----------
        n_runs : int, optional
            Number of runs; default: 200.
        seed : int, optional
            Seed of the runs; default: the seed of the problem's own runs plus one.

        Returns
        -------
        DataFrame
            One row per plan. For each objective: ``promised LABEL``, the plan's value; ``kept
            LABEL``, the value in 9 of 10 runs; and their ratio ``kept / promised LABEL``.
        """
        columns: dict[str, Floats] = {}
        statistics = self._evaluate_runs(n_runs, seed)
        for i, label in enumerate(self.problem.obj_names):
            own, robust = self.F[:, i], statistics[:, i]
            columns |= {f"predicted {label}": own, f"Monte Carlo {label}": robust}
            columns[f"Monte Carlo / predicted {label}"] = robust / own
        return pd.DataFrame(columns)

    @property
    def monte_carlo_t_end(self) -> Floats:
        """t_end in the share `MOST` of 200 independent Monte Carlo runs [s], shape (n,).

        Infinite if too few runs converge; NaN if t_end is no objective or the covariance was lost.
        """
        return self._extract_t_end(self.monte_carlo_objectives)

    @property
    def robust_t_end(self) -> Floats:
        """t_end over the Monte Carlo runs of the problem [s], shape (n,); NaN without such runs."""
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
        """End of the constant-rate hold of each plan [s], shape (n,); NaN for a lost covariance.

        Without Monte Carlo runs, the hold ends at the nominal t_end. With Monte Carlo runs, the
        hold ends at the robust time, which holds in the share `MOST` of the runs or more, or at the
        end of the scenario if too few runs converge.
        """
        problem, t_end = self.problem, self.nominal.t_end
        errors = problem.scenario.monte_carlo
        if not errors:
            return t_end
        late = self.robust_t_end
        if errors.mean or errors.quantile < MONTE_CARLO_SHARE:
            late = np.fmax(late, self.monte_carlo_t_end)
        step = problem.model.step
        late = np.fmin(np.nan_to_num(late, posinf=np.inf), problem.model.duration)
        # A mean over runs is no multiple of the step.
        return np.maximum(t_end, np.ceil(late / step - 1e-9) * step)

    @cached_property
    def end_times(self) -> Floats:
        """End of each plan [s], shape (n,); NaN if the covariance was lost.

        Without a slew back, this is `held_until`. With a slew back, this is its end, or infinity if
        no slew back fits in the scenario's duration. A slew back takes about 25 ms per plan to
        compute.
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
        """Return the trajectory of a plan whose covariance was not lost.

        The slew back, the most expensive part, is cached for all views of a front.
        """
        problem, times = self.problem, (float(self.nominal.t_end[row]), float(self.hold_end[row]))
        trajectory = Trajectory(problem.scenario, problem.model, self.X[row], *times)
        key = self.X[row].tobytes()
        if key not in self._slew_backs:
            with suppress(InvalidValue):  # the trajectory raises the error when it is accessed
                self._slew_backs[key] = trajectory.slew_back
        if key in self._slew_backs:
            trajectory.__dict__["slew_back"] = self._slew_backs[key]  # fills the cached_property
        return trajectory


def select_sample_rows(n: int) -> Ints:
    """Return up to 50 evenly spaced row indices of n."""
    return np.unique(np.linspace(0, n - 1, min(n, _MAX_EVALUATED)).round().astype(np.int64))


def format_plan_count(rows: Ints, n: int) -> str:
    """Return a phrase with the number of evaluated plans of a front of n."""
    return f"{len(rows)} plans" if len(rows) == n else f"{len(rows)} evaluated plans"
