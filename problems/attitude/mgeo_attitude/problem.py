"""The satellite problem for pymoo: which maneuvers calibrate best, soonest."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from pymoo.core.problem import Problem

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound import LimitCurves, limit
from mgeo_attitude.criteria.constraints import check_start, constraints
from mgeo_attitude.criteria.evaluation_cache import EvaluationCache
from mgeo_attitude.criteria.objectives import Objective, indicators, objective
from mgeo_attitude.criteria.robustness import Flight, Flights, judged, over_flights
from mgeo_attitude.environment import Environment
from mgeo_attitude.filter.model import FilterModel
from mgeo_attitude.maneuvers.schedule import VARIABLES_PER_MANEUVER, decode
from mgeo_attitude.scenario import FlightErrors, Scenario
from mgeo_attitude.scenario.settings import PAPER
from mgeo_attitude.sensors.suite import Suite
from mgeo_attitude.view import at_best, describe, promises, requirements
from mgeo_attitude.view.answers import answers
from mgeo_attitude.view.margins import tables

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go

    from mgeo_attitude.filter.evaluator import Evaluation

#: What a robust run is judged by, if its scenario does not say.
_ROBUST = FlightErrors(count=512, quantile=0.95)
_GROW = 0, 16, 64  # of them in the stages of a search before the last


class AttitudeManeuverProblem(Problem):
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
        What to minimize, if not the scenario's ``objectives``; docs/limits.md explains each:
        "t_end", "trace", "normalized_trace", "log_det", "max_eigenvalue", "t_required", "angle",
        "rate_change", and "trace:attitude,gyro.bias" for some blocks of the state.

    Raises
    ------
    TypeError, ValueError
        For a scenario of another type, a count below one, an objective that is not known, or a
        start that breaks a limit; see `constraints.check_start`.
    """

    var_names: list[str]
    obj_names: tuple[str, ...]
    constraint_names: tuple[str, ...]

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
        self.threads = threads
        self.objectives = scenario.objectives
        self._caches: dict[int, EvaluationCache] = {}  # by numbers of flights
        self._judged: dict[FlightErrors, EvaluationCache] = {}  # by those of `promises`
        self.obj_names = tuple(entry.label for entry in self._objectives())
        self.constraint_names = tuple(entry.label for entry in constraints(scenario))
        limits = scenario.maneuvers
        greatest = np.array([limits.max_rate_deg_s] * 3 + [limits.max_duration])
        super().__init__(
            n_var=VARIABLES_PER_MANEUVER * limits.count,
            n_obj=len(self.objectives),
            n_ieq_constr=len(self.constraint_names),
            xl=np.tile(greatest * [-1.0, -1.0, -1.0, 0.0], limits.count),
            xu=np.tile(greatest, limits.count),
            vtype=float,
            requires_kwargs=bool(scenario.flight and scenario.flight.grow),  # the algorithm
        )
        names = [*(f"omega_{axis}_{{}} [deg/s]" for axis in "xyz"), "duration_{} [s]"]
        self.var_names = [name.format(m + 1) for m in range(limits.count) for name in names]

    @cached_property
    def environment(self) -> Environment:
        """Orbit, Sun, field and shadow of the scenario; computed once, when first needed."""
        return Environment.from_scenario(self.scenario)

    @cached_property
    def model(self) -> FilterModel:
        """Tables of the filter; computed once, when first needed."""
        return FilterModel.from_scenario(self.scenario, self.environment)

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
    def flights(self) -> Flights | None:
        """Flights over which plans are judged; None if they are flown exactly."""
        errors = self.scenario.flight
        return None if errors is None else Flights(self.scenario, self.model, errors)

    def _evaluate(
        self, X: Floats, out: dict[str, Any], *args: Any, algorithm: Any = None, **kwargs: Any
    ) -> None:
        designs = describe.checked_designs(self, X)
        decode(designs)  # tells of a bad design by its place among all of them
        values = self._complete(designs, getattr(algorithm, "stage", None))
        ends = [self.n_obj, self.n_obj + self.n_ieq_constr]
        out["F"], out["G"], _ = np.split(values, ends, axis=1)

    def _complete(self, designs: Floats, stage: int | None = None) -> Floats:
        """Objectives, constraints, and excesses over their limits, side by side, shape (n, k).

        Over as many flights as a stage of a search has, all of them without one. No design of the
        batch before is run again.
        """
        count = 0 if self.flights is None else self.flights.errors.in_stage(stage)
        cache = self._caches.setdefault(count, EvaluationCache())
        return cache.complete(designs, partial(self._run, count))

    def _run(self, count: int, X: Floats) -> Floats:
        """The same of designs that nobody knows, over so many flights; 0: exactly."""
        if self.flights is None or not count:
            return self._values(None, X)
        flown = self._values(self.flights.first(count), X)
        return judged(flown, self.n_obj, self.flights.errors)

    def _values(self, flights: Iterable[Flight] | None, X: Floats) -> Floats:
        """All of designs as they are, shape (n, k), or in f flights, shape (f, n, k)."""
        # with the compiler, for which a list of problems need not wait
        from mgeo_attitude.filter.evaluator import evaluate

        objectives, asked = self._objectives(), constraints(self.scenario)
        covariance = any(each.needs_covariance for each in objectives)
        covariance |= any(each.needs_covariance for each in asked)

        def values(model: FilterModel, result: Evaluation) -> Floats:
            excesses = [constraint.excesses(result) for constraint in asked]
            found = [entry.value(model, result) for entry in objectives]
            found += [of_limits.max(axis=0) for of_limits in excesses]
            return np.column_stack([*found, *chain.from_iterable(excesses)])

        if flights is not None:
            return over_flights(flights, X, values, self.threads, covariance)
        return values(self.model, evaluate(self.model, X, self.threads, covariance=covariance))

    def _objectives(self) -> list[Objective]:
        suite = Suite(self.scenario.gyro, self.scenario.sensors)
        return [objective(name, suite) for name in self.objectives]

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> AttitudeManeuverProblem:
        """Build it from a scenario as nested dicts, see `Scenario.from_dict`; {} is the paper's."""
        return cls(Scenario.from_dict(options) if options else None)

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
        errors = self.scenario.flight or _ROBUST
        fewer = tuple(count for count in _GROW if count < errors.count)
        flight = dataclasses.replace(errors, grow=errors.grow or fewer)
        return AttitudeManeuverProblem(
            dataclasses.replace(self.scenario, flight=flight), threads=self.threads
        )

    def starts(self, n: int, random_state: np.random.Generator) -> Floats:
        """Designs to begin a search with, shape (n, n_var); see `refine.starts`."""
        from mgeo_attitude.refine import starts  # compiles

        return starts(self, n, random_state)

    def refine(self, X: ArrayLike) -> Iterator[Floats]:
        """Better ones in the place of designs, shape (n, n_var), bit by bit; see `refine.polish`.

        Raises
        ------
        ValueError
            For other objectives than the time and one that tells how much is known.
        """
        from mgeo_attitude.refine import polish_steps  # compiles

        return polish_steps(self, X)

    def describe(self, X: ArrayLike) -> pd.DataFrame:
        """Each solution, one row, in an engineer's terms."""
        return describe.describe(self, np.atleast_2d(np.asarray(X, dtype=float)))

    def promises(
        self, X: ArrayLike, flights: int = 200, share: float = 0.9, seed: int | None = None
    ) -> pd.DataFrame:
        """What solutions promise, and what a share of other flights keeps.

        A promise is the value of an objective of this problem: flown exactly, or over its own
        flights. The others are drawn anew from the scenario's ``flight`` errors, or from their
        defaults.

        Parameters
        ----------
        X : array_like, shape (n, n_var)
        seed : int, optional
            Of the others; default: the next after that of the problem's own.

        Returns
        -------
        DataFrame
            A row a solution; for each objective the columns ``promised LABEL``, ``kept LABEL``
            and, of both, ``kept / promised LABEL``.
        """
        import pandas as pd

        designs = describe.checked_designs(self, X)
        errors = self.scenario.flight or FlightErrors()
        errors = dataclasses.replace(
            errors,
            count=flights,
            seed=errors.seed + 1 if seed is None else seed,
            quantile=share,
            mean=False,
        )

        def judge(designs: Floats) -> Floats:
            """What is promised and kept, side by side."""
            promised = self._complete(designs)[:, : self.n_obj]
            flown = self._values(Flights(self.scenario, self.model, errors), designs)
            return np.hstack([promised, judged(flown, self.n_obj, errors)[:, : self.n_obj]])

        cache = self._judged.setdefault(errors, EvaluationCache(forget=False))
        promised, kept = np.split(cache.complete(designs, judge), 2, axis=1)
        columns: dict[str, Floats] = {}
        for label, told, found in zip(self.obj_names, promised.T, kept.T, strict=True):
            columns |= {f"promised {label}": told, f"kept {label}": found}
            columns[f"kept / promised {label}"] = found / told
        return pd.DataFrame(columns)

    def remarks(self, X: ArrayLike) -> list[str]:
        """How many of a front's solutions keep what they promise, and their limits to the end.

        And how near they come to what no maneuver can beat. See `promises.remarks`,
        `clearance.remarks`, `promises.end_remarks`, `requirements.remarks` and
        `at_best.remarks`; the `notes` follow.
        """
        from mgeo_attitude.view import clearance  # compiles

        designs = np.atleast_2d(np.asarray(X, dtype=float))
        parts = (
            promises.remarks,
            clearance.remarks,
            promises.end_remarks,
            requirements.remarks,
            at_best.remarks,
        )
        found = [line for remarks in parts for line in remarks(self, designs)]
        return found + self.notes()

    def notes(self) -> list[str]:
        """Where the scenario is outside of what the linear covariance was found true for."""
        from mgeo_attitude.scenario.validity import validity  # imports scipy

        return [f"{line} (docs/consistency.md): verify a plan" for line in validity(self.scenario)]

    def ways_out(self, X: ArrayLike) -> list[str]:
        """Errors of which plans that miss requirements learn nothing; `requirements.ways_out`."""
        return requirements.ways_out(self, np.atleast_2d(np.asarray(X, dtype=float)))

    def impossible(self) -> list[str]:
        """Why no plan at all keeps the scenario's limits, in lines; empty where one may.

        See `at_best.impossible`.
        """
        return at_best.impossible(self)

    def answers(self, X: ArrayLike) -> list[str]:
        """What each solution is worth, in one line; see `mgeo_attitude.view.answers`."""
        return answers(self, np.atleast_2d(np.asarray(X, dtype=float)))

    def limits(self, X: ArrayLike) -> list[pd.DataFrame]:
        """The scenario's limits and each solution's margins; see `margins.tables`.

        Where plans are judged over flights, a value is what the demanded share of them keeps.
        Path limits, and the budget of wheels, have a row each for the time after the filter has
        converged, too, in which the last rate is held for late flights or the body slews back. No
        search sees these.
        """
        from mgeo_attitude.view import clearance  # compiles

        designs = describe.checked_designs(self, np.atleast_2d(np.asarray(X, dtype=float)))
        excesses = self._complete(designs)[:, self.n_obj + self.n_ieq_constr :]
        limits = [limit for c in constraints(self.scenario) for limit in c.limits]
        return tables(limits, excesses, clearance.all_after(self, designs))

    def front_summary(self, F: ArrayLike) -> dict[str, float]:
        """How many points of a front converge in the first orbit, and how many later.

        Nothing is said of a front of other objectives than the paper's.
        """
        if self.objectives != PAPER:
            return {}
        return describe.front_summary(self.scenario, np.atleast_2d(np.asarray(F, dtype=float)))

    def figures(self, X: ArrayLike) -> dict[str, go.Figure]:
        """Interactive figures of a set of solutions; ``front`` for the paper's objectives."""
        from mgeo_attitude.view.figures import figures

        return figures(self, np.atleast_2d(np.asarray(X, dtype=float)))

    def solution_figures(self, X: ArrayLike) -> list[dict[str, go.Figure]]:
        """For each solution its own small figures: rates, directions of Sun and field, errors."""
        from mgeo_attitude.view.figures import solution_figures

        return list(solution_figures(self, np.atleast_2d(np.asarray(X, dtype=float))))
