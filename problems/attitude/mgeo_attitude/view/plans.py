"""Plans of one scenario, evaluated once for all that is told of them; what a problem gives them."""

from __future__ import annotations

import dataclasses
import math
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mgeo.plugins.view import View
from mgeo_attitude._typing import Floats, Ints
from mgeo_attitude.bound.curves import LimitCurves
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.criteria.objectives import OBJECTIVES, attitude_sigma_deg
from mgeo_attitude.criteria.robustness import FlightSamples, kept_by, over_flights
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.scenario.windows import FlightErrors
from mgeo_attitude.settings.errors import InvalidValue

if TYPE_CHECKING:
    import pandas as pd

    from mgeo_attitude.filter.evaluator import Evaluation
    from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory


class ManeuverProblem(Protocol):
    """A problem whose designs are maneuvers of one scenario."""

    scenario: Scenario
    threads: int | None
    objectives: tuple[str, ...]
    n_var: int
    n_obj: int
    n_ieq_constr: int

    obj_names: tuple[str, ...]

    def run(self, X: Floats, vary: Any = None, **asked: Any) -> Evaluation: ...
    def flights_of(self, errors: FlightErrors) -> FlightSamples: ...
    def valued(self, model: FilterModel, result: Evaluation) -> Floats: ...
    def judged(self, X: Floats) -> Floats: ...
    def view(self, X: Any) -> Any: ...
    @property
    def environment(self) -> Environment: ...
    @property
    def model(self) -> FilterModel: ...
    @property
    def limit_curves(self) -> LimitCurves: ...
    @property
    def flights(self) -> FlightSamples | None: ...


#: What `Plans.promises` asks for, in words.
MOST_SAMPLES = "9 of 10 Monte Carlo samples"
#: Plans of a front that are looked at: with 200 flights of each a second or two.
MOST = 50


class Exactly(NamedTuple):
    """What n plans come to that are flown exactly.

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


class Times(NamedTuple):
    """t_end [s] of a plan over flights, infinite if too few converge; None if nobody knows.

    Attributes
    ----------
    kept
        By most of 200 flights; None where it is no objective, or the covariance was lost.
    promised
        By the plan's problem over its own flights; None, too, if these are none.
    """

    kept: float | None = None
    promised: float | None = None


#: Of a plan that nobody has flown.
UNKNOWN = Times()


class Plans(View):
    """Maneuver plans, shape (n, n_var), and what their evaluation gives, each when first asked for.

    Those that are taken of others share what is known of them.
    """

    problem: ManeuverProblem
    #: Other flights in which is looked at what plans keep.
    flights: ClassVar[int] = 200

    def __init__(self, problem: ManeuverProblem, X: ArrayLike) -> None:
        super().__init__(problem, X)
        self._known: dict[object, EvaluationCache] = {}
        self._backs: dict[bytes, SlewBack | None] = {}

    def take(self, rows: ArrayLike) -> Plans:
        part = super().take(rows)
        assert isinstance(part, Plans)  # as the problem's view is
        part._known, part._backs = self._known, self._backs
        return part

    @cached_property
    def exactly(self) -> Exactly:
        """What they come to when they are flown exactly."""
        n = self.problem.model.suite.n_states
        found = np.split(self._exact_run, [1, 2, 2 + n * n], axis=1)
        return Exactly(found[0][:, 0], found[1][:, 0], found[2].reshape(len(self.X), n, n))

    @cached_property
    def values(self) -> Floats:
        """Objectives, constraints, and excesses over their limits, side by side.

        Flown exactly, or over the flights of the problem.
        """
        problem = self.problem
        if problem.flights is None:
            return self._exact_run[:, 2 + problem.model.suite.n_states**2 :]
        return self._cache("values").complete(self.X, problem.judged)

    @cached_property
    def _exact_run(self) -> Floats:
        """`exactly` and, if the problem has no flights, the `values`, side by side."""
        problem = self.problem

        def run(X: Floats) -> Floats:
            ran = problem.run(X, covariance=True)
            known = [
                ran.t_end,
                ran.trace,
                ran.covariance.reshape(len(X), problem.model.suite.n_states**2),
            ]
            if problem.flights is None:
                known.append(problem.valued(problem.model, ran))
            return np.column_stack(known)

        return self._cache("exactly").complete(self.X, run)

    def _cache(self, of: object) -> EvaluationCache:
        return self._known.setdefault(of, EvaluationCache(forget=False))

    @property
    def promised(self) -> Floats:
        """Objectives, flown exactly or over the flights of the problem, shape (n, n_obj)."""
        return self.values[:, : self.problem.n_obj]

    @cached_property
    def kept(self) -> Floats:
        """Objectives that most of 200 other flights keep, shape (n, n_obj)."""
        return self._kept()[:, : self.problem.n_obj]

    @property
    def kept_sigma_deg(self) -> Floats:
        """1-sigma of the attitude about the worst body axis that they keep [deg], shape (n,)."""
        return self._kept()[:, self.problem.n_obj]

    @cached_property
    def sigma(self) -> Floats:
        """1-sigma of each state at `t_end`, as it is told, shape (n, n_states).

        Flown exactly. Coils turn a satellite otherwise from every attitude, so that no flight is
        the exact one: there it is the root mean square over the flights of `kept`.
        """
        if self.problem.scenario.turned_by_coils:
            return self._kept()[:, self.problem.n_obj + 1 :]
        return np.sqrt(np.diagonal(self.exactly.covariance, axis1=1, axis2=2))

    def _kept(
        self, flights: int | None = None, share: float = 0.9, seed: int | None = None
    ) -> Floats:
        """Objectives and the 1-sigma of the attitude [deg] that a share of flights keeps.

        Beside them the root mean square over the flights of the 1-sigma of each state.
        """
        problem = self.problem
        errors = problem.scenario.flight or FlightErrors()
        errors = dataclasses.replace(
            errors,
            count=flights or self.flights,
            seed=errors.seed + 1 if seed is None else seed,
            quantile=share,
            mean=False,
        )

        def known(model: FilterModel, ran: Evaluation) -> Floats:
            objectives = problem.valued(model, ran)[:, : problem.n_obj]
            variances = np.diagonal(ran.covariance, axis1=1, axis2=2)
            return np.column_stack([objectives, attitude_sigma_deg(ran.covariance), variances])

        def run(X: Floats) -> Floats:
            samples = problem.flights_of(errors)
            found = over_flights(samples, X, known, problem.threads, True)
            told, variances = np.split(found, [problem.n_obj + 1], axis=2)
            return np.hstack([kept_by(told, share), np.sqrt(variances.mean(axis=0))])

        return self._cache(errors).complete(self.X, run)

    def promises(
        self, flights: int | None = None, share: float = 0.9, seed: int | None = None
    ) -> pd.DataFrame:
        """What plans promise, and what a share of other flights keeps.

        A promise is the value of an objective of the problem: flown exactly, or over its own
        flights. The others are drawn anew from the scenario's ``flight`` errors, or from their
        defaults.

        Parameters
        ----------
        flights : int, optional
            How many others; default: 200.
        seed : int, optional
            Of the others; default: the next after that of the problem's own.

        Returns
        -------
        DataFrame
            A row a plan; for each objective the columns ``promised LABEL``, ``kept LABEL`` and, of
            both, ``kept / promised LABEL``.
        """
        import pandas as pd

        columns: dict[str, Floats] = {}
        both = zip(
            self.problem.obj_names,
            self.promised.T,
            self._kept(flights, share, seed).T[: self.problem.n_obj],
            strict=True,
        )
        for label, told, found in both:
            columns |= {f"promised {label}": told, f"kept {label}": found}
            columns[f"kept / promised {label}"] = found / told
        return pd.DataFrame(columns)

    @cached_property
    def times(self) -> list[Times]:
        """The `Times` of each plan."""
        problem = self.problem
        if "t_end" not in problem.objectives:
            return [UNKNOWN] * len(self.X)
        place = problem.obj_names.index(OBJECTIVES["t_end"].label)
        too_late = problem.model.too_late

        def told(found: Floats) -> list[float | None]:
            times = found[:, place].tolist()
            return [None if t != t else math.inf if t >= too_late else t for t in times]

        own = told(self.promised) if problem.scenario.flight else [None] * len(self.X)
        return [Times(*both) for both in zip(told(self.kept), own, strict=True)]

    @cached_property
    def held_until(self) -> Floats:
        """Until when plans are flown before they end or slew back [s], shape (n,).

        One that promises a time over flights is flown until the later of what it promises and what
        most flights keep; until the end of the scenario, if too few converge. Any other is flown
        exactly, until t_end. NaN where the covariance was lost.
        """
        problem, t_end = self.problem, self.exactly.t_end
        if not problem.scenario.flight:
            return t_end
        longest = problem.model.longest
        late = np.array(
            [[min(time or 0.0, longest) for time in found] for found in self.times], dtype=float
        ).reshape(-1, 2)
        steps = np.ceil(late.max(axis=1) / problem.model.step - 1e-9)  # a mean may be on none
        held: Floats = np.maximum(t_end, steps * problem.model.step)
        return held

    @cached_property
    def ends(self) -> Floats:
        """When plans end [s], shape (n,).

        That is `held_until` or, with a slew back, when that ends, some 25 ms a plan: infinite where
        there is no way back within the scenario's duration. NaN where the covariance was lost.
        """
        problem, t_end = self.problem, self.exactly.t_end
        if not problem.scenario.maneuvers.slew_back:
            return self.held_until
        found = np.full(len(self.X), np.nan)
        for i in np.flatnonzero(np.isfinite(t_end)).tolist():
            try:
                found[i] = self.trajectory(i).end
            except InvalidValue:
                found[i] = math.inf
        return found

    def trajectory(self, row: int) -> Trajectory:
        """All that is flown of a plan whose covariance was not lost.

        Its slew back, which takes longest to find, is found once for all views that share a front.
        """
        from mgeo_attitude.trajectory.trajectory import Trajectory  # imports scipy

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
    """Rows of n that are looked at, up to `MOST` at even distances."""
    return np.unique(np.linspace(0, n - 1, min(n, MOST)).round().astype(np.int64))


def looked_at(rows: Ints, n: int) -> str:
    """How many of a front of n these are, in words."""
    return f"{len(rows)} plans" if len(rows) == n else f"{len(rows)} plans looked at"
