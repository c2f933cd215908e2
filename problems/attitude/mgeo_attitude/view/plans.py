"""Plans of one scenario, and what their evaluation gives, each computed when first asked for."""

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
from mgeo_attitude.criteria.robustness import FlightSamples, kept_by, over_flights
from mgeo_attitude.filter.evaluator import Evaluation
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.goals import FlightErrors
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory

#: Share of Monte Carlo runs that a plan's ``kept`` values hold in, and the same in words.
MOST, MOST_SAMPLES = 0.9, "9 of 10 Monte Carlo samples"
#: Plans of a front that remarks and figures look at: over 200 runs each a second or two.
_LOOKED_AT = 50


class Nominal(NamedTuple):
    """Results of the nominal runs of n plans.

    Attributes
    ----------
    t_end, trace : arrays, shape (n,)
        [s] and the weighted trace of the covariance then; NaN where that was lost.
    covariance : array, shape (n, n_states, n_states)
        Then.
    """

    t_end: Floats
    trace: Floats
    covariance: Floats


class Plans(View):
    """Maneuver plans, shape (n, n_var); those taken of others share what is known of them."""

    problem: AttitudeManeuverProblem
    #: Monte Carlo runs, other than those of the problem, of which `kept` is.
    flights: ClassVar[int] = 200

    def __init__(self, problem: AttitudeManeuverProblem, X: ArrayLike) -> None:
        super().__init__(problem, X)
        self._known: dict[object, EvaluationCache] = {}
        self._backs: dict[bytes, SlewBack | None] = {}

    def take(self, rows: ArrayLike) -> Plans:
        part = super().take(rows)
        assert isinstance(part, Plans)  # as the problem's view is
        part._known, part._backs = self._known, self._backs
        if "exactly" in self.__dict__:
            part.exactly = Nominal(*(each[np.asarray(rows)] for each in self.exactly))
        return part

    @cached_property
    def _run(self) -> Evaluation:
        return self.problem.run(self.X, covariance=True)

    @cached_property
    def exactly(self) -> Nominal:
        """Results of the nominal runs, as a run has stored them, or else evaluated."""
        return Nominal(self._run.t_end, self._run.trace, self._run.covariance)

    def arrays(self) -> dict[str, Floats]:
        """Return the results of the nominal runs, by the names of `Nominal`."""
        return self.exactly._asdict()

    @cached_property
    def F(self) -> Floats:
        """Objectives, shape (n, n_obj), as a run has stored them, or else evaluated.

        Those of the nominal run or, if the problem has Monte Carlo runs, over these.
        """
        return self.values[:, : self.problem.n_obj]

    @property
    def excesses(self) -> Floats:
        """How far each limit of the constraints is exceeded, shape (n, n_limits)."""
        if not self.problem.n_ieq_constr:
            return np.empty((len(self.X), 0))
        return self.values[:, self.problem.n_obj + self.problem.n_ieq_constr :]

    @cached_property
    def values(self) -> Floats:
        """Objectives, constraints and `excesses`, side by side."""
        problem = self.problem
        if problem.flights is None:
            return problem.valued(problem.model, self._run)
        return self._cache("values").complete(self.X, problem.judged)

    def _cache(self, of: object) -> EvaluationCache:
        return self._known.setdefault(of, EvaluationCache(forget=False))

    @property
    def kept(self) -> Floats:
        """Objectives in `MOST` of 200 other Monte Carlo runs, shape (n, n_obj)."""
        return self._over_others()[:, : self.problem.n_obj]

    @property
    def kept_sigma_deg(self) -> Floats:
        """1-sigma of the attitude about the worst body axis in them [deg], shape (n,)."""
        return self._over_others()[:, self.problem.n_obj]

    @cached_property
    def sigma(self) -> Floats:
        """1-sigma of each state at `t_end`, as answers and tables show it, shape (n, n_states).

        Of the nominal run. Magnetorquers turn a satellite otherwise from every attitude, so that no
        run is nominal: there it is the root mean square over the runs of `kept`.
        """
        if self.problem.scenario.turned_by_coils:
            return self._over_others()[:, self.problem.n_obj + 1 :]
        return np.sqrt(np.diagonal(self.exactly.covariance, axis1=1, axis2=2))

    def _over_others(self, flights: int | None = None, seed: int | None = None) -> Floats:
        """Objectives and the 1-sigma of the attitude [deg] in `MOST` of other Monte Carlo runs.

        Beside them the root mean square over the runs of the 1-sigma of each state.
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
            samples = FlightSamples(problem.scenario, problem.model, errors)
            values = over_flights(samples, X, found, problem.threads, True)
            own, variances = np.split(values, [problem.n_obj + 1], axis=2)
            return np.hstack([kept_by(own, MOST), np.sqrt(variances.mean(axis=0))])

        return self._cache(errors).complete(self.X, run)

    def promises(self, flights: int | None = None, seed: int | None = None) -> pd.DataFrame:
        """Compare the objectives of plans with those in 9 of 10 other Monte Carlo runs.

        The others are drawn anew from the scenario's ``flight`` errors, or from their defaults.

        Parameters
        ----------
        flights : int, optional
            Number of other runs; default: 200.
        seed : int, optional
            Of the others; default: the next after that of the problem's own.

        Returns
        -------
        DataFrame
            A row a plan; for each objective the columns ``promised LABEL``, ``kept LABEL`` and, of
            both, ``kept / promised LABEL``.
        """
        columns: dict[str, Floats] = {}
        found = self._over_others(flights, seed)
        for i, label in enumerate(self.problem.obj_names):
            own, kept = self.F[:, i], found[:, i]
            columns |= {f"promised {label}": own, f"kept {label}": kept}
            columns[f"kept / promised {label}"] = kept / own
        return pd.DataFrame(columns)

    @property
    def kept_t_end(self) -> Floats:
        """t_end in `MOST` of 200 other Monte Carlo runs [s], shape (n,).

        Infinite if too few converge; NaN where t_end is no objective, or the covariance was lost.
        """
        return self._t_end(self.kept)

    @property
    def robust_t_end(self) -> Floats:
        """t_end over the Monte Carlo runs of the problem [s], shape (n,); NaN if it has none."""
        known = self.problem.scenario.flight is not None
        return self._t_end(self.F) if known else np.full(len(self.X), np.nan)

    def _t_end(self, F: Floats) -> Floats:
        label = OBJECTIVES["t_end"].label
        if label not in self.problem.obj_names:
            return np.full(len(F), np.nan)
        times = F[:, self.problem.obj_names.index(label)]
        return np.where(times >= self.problem.model.too_late, np.inf, times)

    @cached_property
    def held_until(self) -> Floats:
        """Until when plans hold their last rate before they end or slew back [s], shape (n,).

        For a plan with a robust time until then, in `MOST` runs or more; until the end of the
        scenario, if too few converge. For any other until t_end of the nominal run. NaN where the
        covariance was lost.
        """
        problem, t_end = self.problem, self.exactly.t_end
        errors = problem.scenario.flight
        if not errors:
            return t_end
        late = self.robust_t_end
        if errors.mean or errors.quantile < MOST:
            late = np.fmax(late, self.kept_t_end)
        step = problem.model.step
        late = np.fmin(np.nan_to_num(late, posinf=np.inf), problem.model.longest)
        return np.maximum(t_end, np.ceil(late / step - 1e-9) * step)  # a mean is on no step

    @cached_property
    def ends(self) -> Floats:
        """When plans end [s], shape (n,).

        That is `held_until` or, with a slew back, when that ends, some 25 ms a plan: infinite where
        there is no way back within the scenario's duration. NaN where the covariance was lost.
        """
        if not self.problem.scenario.maneuvers.slew_back:
            return self.held_until
        found = np.full(len(self.X), np.nan)
        for i in np.flatnonzero(np.isfinite(self.exactly.t_end)).tolist():
            try:
                found[i] = self.trajectory(i).end
            except InvalidValue:
                found[i] = math.inf
        return found

    def trajectory(self, row: int) -> Trajectory:
        """Return the trajectory of a plan whose covariance was not lost.

        Its slew back, which takes longest to find, is found once for all views that share a front.
        """
        problem, times = self.problem, (float(self.exactly.t_end[row]), float(self.held_until[row]))
        found = Trajectory(problem.scenario, problem.model, self.X[row], *times)
        key = self.X[row].tobytes()
        if key not in self._backs:
            with suppress(InvalidValue):  # there is none, as whoever asks for it is told
                self._backs[key] = found.back
        if key in self._backs:
            found.__dict__["back"] = self._backs[key]  # as cached_property keeps it
        return found


def spread(n: int) -> Ints:
    """Return up to 50 rows of n at even distances."""
    return np.unique(np.linspace(0, n - 1, min(n, _LOOKED_AT)).round().astype(np.int64))


def looked_at(rows: Ints, n: int) -> str:
    """Return in words how many of a front of n these are."""
    return f"{len(rows)} plans" if len(rows) == n else f"{len(rows)} plans looked at"
