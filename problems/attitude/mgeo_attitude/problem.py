"""The satellite problem for pymoo: which maneuvers calibrate best, soonest."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem

from mgeo.plugins.protocol import ProblemMixin
from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.assembly import limit
from mgeo_attitude.bound.curves import LimitCurves
from mgeo_attitude.criteria.constraints import check_start, constraints
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.criteria.objectives import Objective, can_be_polished, indicators, objective
from mgeo_attitude.criteria.robustness import FlightSample, FlightSamples, judged, over_flights
from mgeo_attitude.environment.environment import Environment
from mgeo_attitude.filter.evaluator import Evaluation, evaluate
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import decode
from mgeo_attitude.refine.polish import polish_steps
from mgeo_attitude.refine.starts import starts
from mgeo_attitude.scenario.channels import check_followed
from mgeo_attitude.scenario.goals import FlightErrors
from mgeo_attitude.scenario.scenario import Scenario

if TYPE_CHECKING:
    from mgeo_attitude.view.maneuver_view import ManeuverView

#: Flights that a robust run is judged by, and the share that must keep it, if not told.
_FLIGHTS, _QUANTILE = 512, 0.95
#: Designs that a run begins with, and its evaluations before a polish, if not told otherwise.
_STARTS, _BEFORE_POLISH = 12, 6_000
#: Maneuvers from which on these and a polish are recommended, by the rule of convergence or else;
#: see docs/how-good.md.
_POLISHED, _POLISHED_BY = 6, {"end": 3}
_GROW = 0, 16, 64  # of them in the stages of a search before the last
#: What a plan's file calls itself.
PLAN_FORMAT = "mgeo-attitude-plan"


class AttitudeManeuverProblem(ProblemMixin, Problem):
    """Minimize time to converge and final trace over constant-rate maneuvers, equation (5).

    Variables are ωx, ωy, ωz [deg/s] and duration [s] of each maneuver in turn; objectives are
    t_end [s] and the trace of the filter's covariance then (rad², rad²/s² and dimensionless
    squares, weighted by the scenario's trace weights), unless others are asked for. Limits of the
    scenario are inequality constraints: see `constraint_names`.

    Parameters
    ----------
    scenario : Scenario, optional
        Default: `Scenario.paper()`.
    n_maneuvers : int, optional
        Default: the scenario's ``maneuvers.count``.
    threads : int, optional
        Threads of one evaluation; default: the processors this process may use. The result does
        not depend on it.
    flights : int, optional
        Flights over which plans are judged, 0 for none, if not the scenario's ``flight.count``.
    quantile : float, optional
        Share of the flights that must keep the value of an objective, if not its
        ``flight.quantile``.
    objectives : sequence of str, optional
        What to minimize, if not the scenario's ``objectives``: keys of `criteria.objectives`, or
        "trace:attitude,gyro.bias" for some blocks of the state.

    Raises
    ------
    TypeError, ValueError
        For a scenario of another type, a count below one, an objective that is not known, or a
        start that breaks a limit; see `constraints.check_start`.

    Examples
    --------
    >>> from mgeo_attitude import AttitudeManeuverProblem, Scenario
    >>> problem = AttitudeManeuverProblem(Scenario.cubesat_6u(), objectives=("t_end", "trace"))
    >>> problem.n_var, problem.obj_names, problem.constraint_names
    (24, ('t_end [s]', 'trace [-]'), ())
    """

    var_names: list[str]
    obj_names: tuple[str, ...]
    constraint_names: tuple[str, ...]
    without_effect = ("threads",)

    def __init__(
        self,
        scenario: Scenario | None = None,
        n_maneuvers: int | None = None,
        threads: int | None = None,
        objectives: Sequence[str] | None = None,
        flights: int | None = None,
        quantile: float | None = None,
    ) -> None:
        scenario = Scenario.paper() if scenario is None else scenario
        if not isinstance(scenario, Scenario):
            raise TypeError(
                f"scenario = {scenario!r}: expected a Scenario, such as Scenario.paper() or "
                "Scenario.from_toml('file.toml')"
            )
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise ValueError(f"threads = {threads!r}: expected an integer >= 1, or None")
        changes: dict[str, Any] = {} if objectives is None else {"objectives": objectives}
        if n_maneuvers is not None:
            changes["maneuvers"] = dataclasses.replace(scenario.maneuvers, count=n_maneuvers)
        asked: dict[str, Any] = {"count": flights, "quantile": quantile}
        asked = {key: value for key, value in asked.items() if value is not None}
        if flights == 0:
            changes["flight"] = None
        elif asked:
            changes["flight"] = dataclasses.replace(scenario.flight or FlightErrors(), **asked)
        self.scenario = scenario = dataclasses.replace(scenario, **changes)
        check_start(scenario)
        check_followed(scenario.channels, scenario.suite)
        self.threads = threads
        self.objectives = scenario.objectives
        self._count = scenario.flight.count if scenario.flight else 0  # of flights
        self._cache = EvaluationCache()
        self.obj_names = tuple(entry.label for entry in self._objectives())
        self.constraint_names = tuple(entry.label for entry in constraints(scenario))
        limits = scenario.maneuvers
        greatest = np.array([limits.max_rate_deg_s] * 3 + [limits.max_duration])
        xl = np.tile(greatest * [-1.0, -1.0, -1.0, 0.0], limits.count)
        xu = np.tile(greatest, limits.count)
        names = [*(f"omega_{axis}_{{}} [deg/s]" for axis in "xyz"), "duration_{} [s]"]
        self.var_names = [name.format(m + 1) for m in range(limits.count) for name in names]
        super().__init__(
            n_var=len(self.var_names),
            n_obj=len(self.objectives),
            n_ieq_constr=len(self.constraint_names),
            xl=xl,
            xu=xu,
            vtype=float,
        )

    @cached_property
    def environment(self) -> Environment:
        """Orbit, Sun, field and shadow of the scenario; computed once, when first needed."""
        return Environment.from_scenario(self.scenario)

    @cached_property
    def model(self) -> FilterModel:
        """Tables of the filter; computed once, when first needed."""
        return FilterModel.from_scenario(self.scenario, self.environment)

    def run(
        self,
        X: Floats,
        vary: Callable[[FilterModel], FilterModel] | None = None,
        **asked: Any,
    ) -> Evaluation:
        """What the filter makes of designs flown exactly, see `evaluator.evaluate`.

        Parameters
        ----------
        vary : function, optional
            What to fly in place of the model, made of it.
        """
        model = self.model if vary is None else vary(self.model)
        return evaluate(model, X, self.threads, **asked)

    @cached_property
    def limit_curves(self) -> LimitCurves:
        """What no plan that is flown exactly can beat; computed once, when first needed.

        Raises
        ------
        NoLimit
            Where none can be proved.
        """
        return limit(self.scenario, self.model)

    @cached_property
    def flights(self) -> FlightSamples | None:
        """Flights over which plans are judged; None if they are flown exactly."""
        errors = self.scenario.flight
        return None if errors is None else FlightSamples(self.scenario, self.model, errors)

    def at_stage(self, stage: int) -> AttitudeManeuverProblem:
        """The problem as a stage of a search judges it, from 0; see `mgeo.MGEOStaged`.

        That is over fewer of its flights; itself in a stage that has all of them.
        """
        errors = self.scenario.flight
        if self.flights is None or errors is None or errors.in_stage(stage) == errors.count:
            return self
        rough = copy.copy(self)  # with the same tables and flights
        rough._count, rough._cache = errors.in_stage(stage), EvaluationCache()
        return rough

    def _evaluate(self, X: Floats, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        designs = np.asarray(X, dtype=float)
        if designs.ndim != 2 or designs.shape[1] != self.n_var:
            raise ValueError(f"X of shape {designs.shape}: expected (n, {self.n_var})")
        decode(designs)  # tells of a bad design by its place among all of them
        ends = [self.n_obj, self.n_obj + self.n_ieq_constr]
        out["F"], out["G"], _ = np.split(self.judged(designs), ends, axis=1)

    def judged(self, X: Floats) -> Floats:
        """Objectives, constraints, and excesses over their limits, side by side, shape (n, k).

        Of designs flown exactly or, if there are flights, over these. None of the batch before is
        run again.
        """
        return self._cache.complete(X, self._run)

    def _run(self, X: Floats) -> Floats:
        if self.flights is None or not self._count:
            return self.valued(self.model, self.run(X, covariance=self._needs_covariance))
        flown = self.flown(self.flights.first(self._count), X)
        return judged(flown, self.n_obj, self.flights.errors)

    def flown(self, flights: Iterable[FlightSample], X: Floats) -> Floats:
        """The same of designs in each of f flights, shape (f, n, k)."""
        return over_flights(flights, X, self.valued, self.threads, self._needs_covariance)

    def valued(self, model: FilterModel, result: Evaluation) -> Floats:
        """The same of what has been flown; with covariances, if objectives or limits need them."""
        excesses = [constraint.excesses(result) for constraint in constraints(self.scenario)]
        found = [entry.value(model, result) for entry in self._objectives()]
        found += [of_limits.max(axis=0) for of_limits in excesses]
        return np.column_stack([*found, *chain.from_iterable(excesses)])

    @property
    def _needs_covariance(self) -> bool:
        known = any(each.needs_covariance for each in self._objectives())
        return known or any(each.needs_covariance for each in constraints(self.scenario))

    def _objectives(self) -> list[Objective]:
        return [objective(name, self.scenario.suite) for name in self.objectives]

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> AttitudeManeuverProblem:
        """Build it from a scenario as nested dicts, see `Scenario.from_dict`; {} is the paper's."""
        return cls(Scenario.from_dict(options) if options else None)

    @classmethod
    def solution_of(cls, document: Mapping[str, Any]) -> tuple[Mapping[str, Any], Any] | None:
        """Options and design of a plan's file, as JSON values; None of any other document."""
        if document.get("format") != PLAN_FORMAT:
            return None
        return document.get("scenario", {}), document.get("design")

    def document_of(self, x: ArrayLike) -> dict[str, Any]:
        """A plan's file of a design, shape (n_var,), as JSON values; see `plan.to_json`."""
        from mgeo_attitude.plan.files import document
        from mgeo_attitude.plan.plan import ManeuverPlan

        return document(ManeuverPlan.from_design(self, x))

    @classmethod
    def read_files(cls, options: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Options of a scenario file in `folder`, with the orbit's file that they name, if any."""
        orbit = options.get("orbit")
        if not isinstance(orbit, Mapping) or "file" not in orbit:
            return dict(options)
        return Scenario.from_dict(options, folder).to_dict()

    def options(self) -> dict[str, Any]:
        """The scenario as nested dicts of JSON's types."""
        return self.scenario.to_dict()

    def indicator_space(self, F: ArrayLike) -> Floats:
        """Objectives as indicators see them, such as t_end / duration and (log10 trace + 6) / 5.

        For these two it is equation (11). With the paper's preset the reference point (1, 1) holds
        every solution worth having.

        Parameters
        ----------
        F : array_like, shape (n, n_obj)

        Returns
        -------
        array, shape (n, n_obj)
        """
        values = np.atleast_2d(np.asarray(F, dtype=float))
        return indicators(self.objectives, values, self.scenario)

    def robust(self) -> AttitudeManeuverProblem:
        """The same scenario, whose plans are judged over its flights, or else over 512.

        Of the 512, 19 of 20 must keep an objective, so that 9 of 10 of others do: of plans whose
        share is near what is asked, a search finds those that are lucky with its own flights. That
        a plan which 89 of 100 keep passes so is a matter of 4 sigma, with 256 flights of 3. A
        search by stages, see `mgeo.MGEOStaged`, flies plans exactly at first, then in 16 and in
        64 of the flights.
        """
        errors = self.scenario.flight or FlightErrors(count=_FLIGHTS, quantile=_QUANTILE)
        fewer = tuple(count for count in _GROW if count < errors.count)
        flight = dataclasses.replace(errors, grow=errors.grow or fewer)
        scenario = dataclasses.replace(self.scenario, flight=flight)
        return AttitudeManeuverProblem(scenario, threads=self.threads)

    def recommended(self) -> dict[str, Any]:
        """How a run is best begun and ended; nothing of the paper's scenario, which is a study.

        Nothing with few maneuvers, where a search alone comes as near the limit, nor where a polish
        takes far longer than a search: over flights and with coils. With budgets of wheels, starts.
        """
        scenario, wheels = self.scenario, self.scenario.wheels
        least = _POLISHED_BY.get(scenario.convergence.rule, _POLISHED)
        few = scenario.maneuvers.count < least
        if few or scenario.name == "paper" or scenario.flight or scenario.turned_by_coils:
            return {}
        if not can_be_polished(self.objectives) or (wheels and wheels.budgeted):
            return {"starts": _STARTS}
        return {"starts": _STARTS, "polish": True, "evaluations": _BEFORE_POLISH}

    def starts(self, n: int, random_state: np.random.Generator) -> Floats:
        """Designs to begin a search with, shape (n, n_var); see `refine.starts`."""
        return starts(self, n, random_state)

    def refine(self, X: ArrayLike) -> Iterator[Floats]:
        """Better designs in their place, bit by bit, then others between; see `refine.polish`.

        Raises
        ------
        ValueError
            For other objectives than the time and one that tells how much is known.
        """
        return polish_steps(self, X, more=True)

    def view(self, X: ArrayLike) -> ManeuverView:
        """What people are shown of plans, shape (n, n_var), each evaluated once."""
        from mgeo_attitude.view.maneuver_view import ManeuverView

        return ManeuverView(self, X)
