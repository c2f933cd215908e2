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
from mgeo_attitude.scenario.goals import FlightErrors
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory

#: Share of Monte Carlo runs in which a plan's ``kept`` values hold, as a number and in words.
MOST, MOST_SAMPLES = 0.9, "9 of 10 Monte Carlo runs"
#: Largest number of plans that remarks and figures evaluate; 200 runs of each take 1 to 2 s.
_LOOKED_AT = 50


class Nominal(NamedTuple):
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

    Views created by `take` share the caches of their source.
    """

    problem: AttitudeManeuverProblem
    #: Number of independent Monte Carlo runs from which `kept` is computed.
    flights: ClassVar[int] = 200

    def __init__(self, problem: AttitudeManeuverProblem, X: ArrayLike) -> None:
        super().__init__(problem, X)
        self._known: dict[object, EvaluationCache] = {}
        self._backs: dict[bytes, SlewBack | None] = {}

    def select(self, rows: ArrayLike) -> Plans:
        part = super().select(rows)
        assert isinstance(part, Plans)  # the class of the problem's view
        part._known, part._backs = self._known, self._backs
        if "exactly" in self.__dict__:
            part.exactly = Nominal(*(each[np.asarray(rows)] for each in self.exactly))
        return part

    @cached_property
    def _run(self) -> Evaluation:
        return self.problem.run(self.X, covariance=True)

    @cached_property
    def exactly(self) -> Nominal:
        """Results of the nominal runs, taken from the run folder if stored, else evaluated."""
        return Nominal(self._run.t_end, self._run.trace, self._run.covariance)

    def arrays(self) -> dict[str, Floats]:
        """Return the results of the nominal runs by the field names of `Nominal`."""
        return self.exactly._asdict()

    @cached_property
    def F(self) -> Floats:
        """Objectives, shape (n, n_obj), taken from the run folder if stored, else evaluated.

        With Monte Carlo runs, the objectives are statistics of these; otherwise they are nominal.
        """
        return self.values[:, : self.problem.n_obj]

    @property
    def excesses(self) -> Floats:
        """Relative violation of each constraint, shape (n, n_limits); positive if violated."""
        if not self.problem.n_ieq_constr:
            return np.empty((len(self.X), 0))
        return self.values[:, self.problem.n_obj + self.problem.n_ieq_constr :]

    @cached_property
    def values(self) -> Floats:
        """Objectives, constraints and `excesses`, side by side."""
        problem = self.problem
        if problem.flights is None:
            return problem.valued(problem.model, self._run)
        return self._cache("values").evaluate(self.X, problem.judged)

    def _cache(self, of: object) -> EvaluationCache:
        return self._known.setdefault(of, EvaluationCache(last_batch_only=False))

    @property
    def kept(self) -> Floats:
        """Objectives in the share `MOST` of 200 independent Monte Carlo runs, shape (n, n_obj)."""
        return self._evaluate_runs()[:, : self.problem.n_obj]

    @property
    def kept_sigma_deg(self) -> Floats:
        """Attitude 1-sigma, worst body axis, in the share `MOST` of the runs [deg], shape (n,)."""
        return self._evaluate_runs()[:, self.problem.n_obj]

    @cached_property
    def sigma(self) -> Floats:
        """1-sigma of each state at `t_end`, as displayed, shape (n, n_states).

        The values belong to the nominal run. Magnetorquers have no representative nominal run,
        since their motion depends on the initial attitude; their values are root mean squares over
        the Monte Carlo runs of `kept`.
        """
        if self.problem.scenario.turned_by_coils:
            return self._evaluate_runs()[:, self.problem.n_obj + 1 :]
        return np.sqrt(np.diagonal(self.exactly.covariance, axis1=1, axis2=2))

    def _evaluate_runs(self, flights: int | None = None, seed: int | None = None) -> Floats:
        """Return statistics of independent Monte Carlo runs, shape (n, n_obj + 1 + n_states).

        Columns: objectives and 1-sigma of the attitude [deg] in the share `MOST` of the runs, then
        the root mean square of the 1-sigma of each state.
        """
        problem = self.problem
        errors = problem.scenario.flight or FlightErrors()
        errors = dataclasses.replace(
            errors,
            count=flights or self.flights,
            seed=errors.seed + 1 if seed is None else seed,
        )

        def found(model: FilterModel, ran: Evaluation) -> Floats:
            objectives = problem.valued(model, ran)[:, : problem.n_obj]
            variances = np.diagonal(ran.covariance, axis1=1, axis2=2)
            return np.column_stack([objectives, attitude_sigma_deg(ran.covariance), variances])

        def run(X: Floats) -> Floats:
            samples = MonteCarloRuns(problem.scenario, problem.model, errors)
            values = evaluate_runs(samples, X, found, problem.threads, True)
            own, variances = np.split(values, [problem.n_obj + 1], axis=2)
            return np.hstack([compute_quantile(own, MOST), np.sqrt(variances.mean(axis=0))])

        return self._cache(errors).evaluate(self.X, run)

    def promises(self, flights: int | None = None, seed: int | None = None) -> pd.DataFrame:
        """Compare the objectives of plans with those in 9 of 10 independent Monte Carlo runs.

        The runs are drawn from the scenario's ``flight`` errors, or from the default errors.

        Parameters
        ----------
        flights : int, optional
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
        statistics = self._evaluate_runs(flights, seed)
        for i, label in enumerate(self.problem.obj_names):
            own, kept = self.F[:, i], statistics[:, i]
            columns |= {f"promised {label}": own, f"kept {label}": kept}
            columns[f"kept / promised {label}"] = kept / own
        return pd.DataFrame(columns)

    @property
    def kept_t_end(self) -> Floats:
        """t_end in the share `MOST` of 200 independent Monte Carlo runs [s], shape (n,).

        Infinite if too few runs converge; NaN if t_end is no objective or the covariance was lost.
        """
        return self._t_end(self.kept)

    @property
    def robust_t_end(self) -> Floats:
        """t_end over the Monte Carlo runs of the problem [s], shape (n,); NaN without such runs."""
        has_runs = self.problem.scenario.flight is not None
        return self._t_end(self.F) if has_runs else np.full(len(self.X), np.nan)

    def _t_end(self, F: Floats) -> Floats:
        label = OBJECTIVES["t_end"].label
        if label not in self.problem.obj_names:
            return np.full(len(F), np.nan)
        times = F[:, self.problem.obj_names.index(label)]
        return np.where(times >= self.problem.model.nonconvergence_time, np.inf, times)

    @cached_property
    def held_until(self) -> Floats:
        """End of the constant-rate hold of each plan [s], shape (n,); NaN for a lost covariance.

        Without Monte Carlo runs, the hold ends at the nominal t_end. With Monte Carlo runs, the
        hold ends at the robust time, which holds in the share `MOST` of the runs or more, or at the
        end of the scenario if too few runs converge.
        """
        problem, t_end = self.problem, self.exactly.t_end
        errors = problem.scenario.flight
        if not errors:
            return t_end
        late = self.robust_t_end
        if errors.mean or errors.quantile < MOST:
            late = np.fmax(late, self.kept_t_end)
        step = problem.model.step
        late = np.fmin(np.nan_to_num(late, posinf=np.inf), problem.model.duration)
        # A mean over runs is no multiple of the step.
        return np.maximum(t_end, np.ceil(late / step - 1e-9) * step)

    @cached_property
    def ends(self) -> Floats:
        """End of each plan [s], shape (n,); NaN if the covariance was lost.

        Without a slew back, this is `held_until`. With a slew back, this is its end, or infinity if
        no slew back fits in the scenario's duration. A slew back takes about 25 ms per plan to
        compute.
        """
        if not self.problem.scenario.maneuvers.slew_back:
            return self.held_until
        times = np.full(len(self.X), np.nan)
        for i in np.flatnonzero(np.isfinite(self.exactly.t_end)).tolist():
            try:
                times[i] = self.trajectory(i).end
            except InvalidValue:
                times[i] = math.inf
        return times

    def trajectory(self, row: int) -> Trajectory:
        """Return the trajectory of a plan whose covariance was not lost.

        The slew back, the most expensive part, is cached for all views of a front.
        """
        problem, times = self.problem, (float(self.exactly.t_end[row]), float(self.held_until[row]))
        trajectory = Trajectory(problem.scenario, problem.model, self.X[row], *times)
        key = self.X[row].tobytes()
        if key not in self._backs:
            with suppress(InvalidValue):  # the trajectory raises the error when it is accessed
                self._backs[key] = trajectory.slew_back
        if key in self._backs:
            trajectory.__dict__["back"] = self._backs[key]  # fills the cached_property
        return trajectory


def spread(n: int) -> Ints:
    """Return up to 50 evenly spaced row indices of n."""
    return np.unique(np.linspace(0, n - 1, min(n, _LOOKED_AT)).round().astype(np.int64))


def looked_at(rows: Ints, n: int) -> str:
    """Return a phrase with the number of evaluated plans of a front of n."""
    return f"{len(rows)} plans" if len(rows) == n else f"{len(rows)} evaluated plans"
