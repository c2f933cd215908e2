"""A plan: one design flown in one scenario, and everything an engineer asks of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property, lru_cache

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.bound.samples import NoLimit
from mgeo_attitude.environment.times import utc_texts
from mgeo_attitude.filter.history import FilterHistory, filter_history
from mgeo_attitude.geometry.quaternion import quaternions
from mgeo_attitude.maneuvers.motion import Phase
from mgeo_attitude.maneuvers.schedule import holding
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import block_units
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.settings.types import DEG
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory
from mgeo_attitude.view import lower_bound
from mgeo_attitude.view.describe import span
from mgeo_attitude.view.maneuver_view import ManeuverView
from mgeo_attitude.view.observability import alternatives, budget, covariance

#: Share of an initial 1-sigma from which on an error counts as not calibrated.
UNLEARNED = 0.5


@dataclass(frozen=True)
class ManeuverPlan(Settings):
    """Maneuvers to be flown from the scenario's epoch until the filter has converged.

    A plan that promises a time over flights goes on until then, at its last rate. If the scenario
    asks for it, a slew back to the attitude law of the start follows.

    Equal plans have equal scenarios and designs; all else is computed from them when first asked
    for. A plan may violate the scenario's constraints: `violations` tells.

    Parameters
    ----------
    scenario : Scenario
    design : sequence of float
        ωx, ωy, ωz [deg/s] and duration [s] of each maneuver in turn; empty for a plan of nothing,
        whose maneuvers hold the rate at the start for no time and then on.

    Raises
    ------
    InvalidValue
        (ValueError, TypeError) For a design of another length than the scenario's maneuvers, or a
        value outside the bounds of their rates and durations.

    Examples
    --------
    >>> from mgeo_attitude import Scenario
    >>> from mgeo_attitude.plan import ManeuverPlan
    >>> design = [0.5, 0.3, -0.2, 400.0, -0.3, 0.6, 0.2, 500.0, 0.2, -0.4, 0.7, 600.0]
    >>> plan = ManeuverPlan(Scenario.paper(), design)
    >>> plan.t_end, plan.accuracy()["after"].head(3).round(3).to_list()  # deg
    (2337.0, [0.043, 0.046, 0.055])
    """

    scenario: Scenario
    """what the plan is for"""
    design: tuple[float, ...]
    """rates [deg/s] and duration [s] of each maneuver"""

    def __post_init__(self) -> None:
        problem = self.problem
        nothing = tuple(
            np.tile(holding(problem.model.initial_rate), self.scenario.maneuvers.count).tolist()
        )
        if not self.design:
            object.__setattr__(self, "design", nothing)
        if self.design == nothing:  # a tumble may be faster than maneuvers
            return
        if len(self.design) != problem.n_var:
            raise InvalidValue(
                "design",
                list(self.design),
                f"expected {problem.n_var} numbers, 4 for each of the scenario's "
                f"{self.scenario.maneuvers.count} maneuvers",
            )
        limits = zip(self.design, problem.xl, problem.xu, problem.var_names, strict=True)
        for i, (value, low, high, name) in enumerate(limits):
            if not low <= value <= high:
                raise InvalidValue(
                    f"design[{i}]", value, f"expected {low:g} to {high:g} for {name}"
                )

    @classmethod
    def from_design(
        cls, problem: AttitudeManeuverProblem, x: ArrayLike, F: Floats | None = None
    ) -> ManeuverPlan:
        """Return the plan of a design vector, shape (n_var,), sharing the problem's tables.

        Parameters
        ----------
        F : array, shape (n_obj,), optional
            Its objectives, if they are known, as those over many Monte Carlo runs that a run has
            stored: they are not evaluated again.

        Raises
        ------
        ValueError, TypeError
            See the class.
        """
        design = np.asarray(x, dtype=float)
        if design.ndim != 1:
            raise ValueError(f"x of shape {design.shape}: expected ({problem.n_var},)")
        plan = cls(problem.scenario, tuple(design.tolist()))
        plan.__dict__["problem"] = problem
        if F is not None:
            plan.view.F = np.array([F], dtype=float)
        return plan

    @cached_property
    def problem(self) -> AttitudeManeuverProblem:
        """The problem that this is a solution of; other plans of the scenario share it."""
        return _problem(self.scenario)

    @cached_property
    def view(self) -> ManeuverView:
        """What is told of it as a solution of the problem."""
        return self.problem.view([self.design])

    @cached_property
    def history(self) -> FilterHistory:
        """The filter's run."""
        return filter_history(self.problem.model, self.design)

    @property
    def t_end(self) -> float:
        """When the filter has converged, or the scenario's duration [s].

        Raises
        ------
        ValueError
            If the covariance loses positivity, so that nothing follows from it.
        """
        t_end = float(self.view.exactly.t_end[0])
        if math.isnan(t_end):
            raise ValueError(f"design {list(self.design)}: its covariance loses positivity")
        return t_end

    @property
    def converged(self) -> bool:
        """Whether the run ended before the scenario's duration."""
        return self.t_end < self.problem.model.longest

    @property
    def trace(self) -> float:
        """Weighted trace of the covariance at `t_end`."""
        return float(self.view.exactly.trace[0])

    @property
    def covariance(self) -> Floats:
        """Covariance at `t_end`, shape (n_states, n_states)."""
        covariance: Floats = self.view.exactly.covariance[0]
        return covariance

    @property
    def sigma(self) -> Floats:
        """1-sigma of each state at `t_end`, shape (n_states,); see `Plans.sigma`."""
        sigma: Floats = self.view.sigma[0]
        return sigma

    @property
    def attitude_sigma_deg(self) -> float:
        """1-sigma about the worst body axis at `t_end` [deg]; see `sigma`."""
        return float(DEG.factor * self.sigma[:3].max())

    @property
    def answer(self) -> str:
        """What the plan is worth, in one line; see `describe.answer`."""
        (answer,) = self.view.answers()
        return answer

    def promises(self) -> pd.DataFrame:
        """Compare the objectives with those in 9 of 10 Monte Carlo runs, one row per objective.

        Columns: ``promised``, ``kept``, ``kept / promised [-]``; see `Plans.promises`.
        """
        values = self.view.promises().to_numpy(float).reshape(-1, 3)
        names = pd.Index(self.problem.obj_names, name="objective")
        return pd.DataFrame(values, names, ["promised", "kept", "kept / promised [-]"])

    @cached_property
    def held_until(self) -> float:
        """When the last rate ends [s]: at `t_end`, or later if that is only promised over flights.

        See `Plans.held_until`.
        """
        (held,) = self.view.held_until
        return float(held)

    @cached_property
    def trajectory(self) -> Trajectory:
        """What is flown until the plan ends."""
        design = np.array(self.design)
        return Trajectory(self.scenario, self.problem.model, design, self.t_end, self.held_until)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Maneuvers flown, the time for which the last rate is held, and the slew back."""
        return self.trajectory.phases

    @property
    def _calibration(self) -> list[Phase]:
        """The phases until `t_end`."""
        return [phase for phase in self.phases if phase.end <= self.t_end]

    @property
    def slew_back(self) -> SlewBack | None:
        """How the plan goes on after `held_until`, if the scenario asks for it."""
        return self.trajectory.back

    @property
    def duration(self) -> float:
        """When the plan ends, slew back included [s]."""
        return self.trajectory.end

    @property
    def attitude(self) -> Floats:
        """GCRS to body at every step of the filter until the end, shape (n + 1, 3, 3)."""
        return self.trajectory.attitude

    def steps(self, times: ArrayLike) -> NDArray[np.int64]:
        """Filter steps of times [s] that are on one."""
        return np.rint(np.asarray(times) / self.scenario.step).astype(np.int64)

    def late(self) -> list[str]:
        """Until when the last rate is held for late flights, in a line; empty if it is not."""
        if self.held_until <= self.t_end:
            return []
        return [
            f"flown exactly the filter has converged after {span(self.t_end)} ({self.t_end:.6g} "
            f"s); the last rate is held until {span(self.held_until)} ({self.held_until:.6g} s) "
            "for late flights"
        ]

    def timeline(self) -> pd.DataFrame:
        """One row per phase: when, at what rates, from which attitude to which.

        Attitudes are quaternions from GCRF to body, scalar last (see `quaternions`); the
        angle swept is all that is turned through, not the shortest way.
        """
        edges = np.array([*(phase.start for phase in self.phases), self.duration])
        texts = utc_texts(self.scenario.epoch, edges)
        q = quaternions(self.attitude[self.steps(edges)])
        rates = np.array([phase.rates_deg_s for phase in self.phases])
        columns: dict[str, object] = {
            "phase": [phase.label for phase in self.phases],
            "start [s]": edges[:-1],
            "end [s]": edges[1:],
            "duration [s]": np.diff(edges),
            "start UTC": texts[:-1],
            "end UTC": texts[1:],
        }
        columns |= {f"rate {axis} [deg/s]": rates[:, i] for i, axis in enumerate("xyz")}
        columns["swept [deg]"] = [phase.swept_deg for phase in self.phases]
        for name, values in (("start", q[:-1]), ("end", q[1:])):
            columns |= {f"{name} q{part}": values[:, i] for i, part in enumerate("123c")}
        return pd.DataFrame(columns)

    def accuracy(self) -> pd.DataFrame:
        """Predicted 1-sigma of every state at the start and at `t_end`, one row per state."""
        states = covariance.States.of(self.problem.model.suite)
        before, after = self.problem.model.initial_sigma, self.sigma
        return pd.DataFrame(
            {
                "unit": states.units,
                "before": before * states.factors,
                "after": after * states.factors,
                "after / before [-]": after / before,
            },
            index=pd.Index(states.names, name="state"),
        )

    def at_best(self) -> pd.DataFrame:
        """Compare the worst axes at `t_end` with the lower bound.

        See `lower_bound.compare_with_bound`.

        Raises
        ------
        NoLimit
            Where no limit is proved.
        """
        return lower_bound.compare_with_bound(
            self.problem.model, self.problem.limit_curves, self.history
        )

    def limit(self) -> list[str]:
        """How near the trace comes to what no maneuver can beat, or why that is not known."""
        try:
            found = self.problem.limit_curves
        except NoLimit as reason:
            return [f"how good a plan can be at best is not known: {reason}"]
        return list(lower_bound.describe_bound(found, self.t_end, self.trace))

    def uncalibrated(self) -> list[str]:
        """Errors of which less than half was learned, in words with the share that is left.

        The fast end of a front may converge because its filter has stalled.
        """
        suite = self.problem.model.suite
        # not of what a calibration has left: one that teaches little more is no bad plan
        initial = suite.initial_sigma(np.radians(self.scenario.initial.attitude_deg))
        left = (np.sqrt(np.diag(self.covariance)) / initial).reshape(-1, 3).max(axis=1)
        blocks = block_units(suite)
        return [
            f"{block.label} ({100.0 * share:.0f} % of the initial 1-sigma is left)"
            for block, share in zip(blocks, left, strict=True)
            if share > UNLEARNED
        ]

    def constraints(self) -> pd.DataFrame:
        """The scenario's constraints with their margins, one row per limit.

        Columns ``unit``, ``value``, ``bound`` ("at most" or "at least"), ``limit``, ``margin``,
        below zero where it is violated, and whether it is ``kept``; see
        `ManeuverView.limits`.
        """
        (table,) = self.view.limits()
        return table.assign(kept=table["margin"].to_numpy(float) >= 0.0)

    def violations(self) -> list[str]:
        """Constraints that are not kept, each in words with its numbers; none is what one wants."""
        table = self.constraints()
        return [
            f"{label} {row['value']:.6g} {row['unit']}, {row['bound']} {row['limit']:.6g} "
            f"{row['unit']}, violated by {-row['margin']:.3g} {row['unit']}"
            for label, row in table[~table["kept"].astype(bool)].iterrows()
        ]

    def contributions(self) -> pd.DataFrame:
        """What each phase bought; see `budget.contributions`."""
        return budget.contributions(self.problem.model, self.design, self.history)

    @cached_property
    def _budget(self) -> pd.DataFrame:
        return budget.budget(self.problem.model, self.design, self.history)

    @cached_property
    def _remedies(self) -> pd.DataFrame:
        rate = self.scenario.maneuvers.max_rate_deg_s
        return alternatives.remedies(self.problem.model, self.design, self.t_end, rate)

    def budget(self) -> pd.DataFrame:
        """Part of each 1-sigma at `t_end` that each source causes; see `budget.budget`."""
        return self._budget.copy()

    def remedies(self) -> pd.DataFrame:
        """1-sigmas at `t_end` if one thing were better; see `alternatives.remedies`."""
        return self._remedies.copy()

    def reasons(self) -> list[str]:
        """Name the drivers of required 1-sigmas, or of the attitude's, a line for each."""
        return budget.reasons(self.problem.model, self._budget, self._remedies, self.history)

    def sensor_use(self) -> pd.DataFrame:
        """For how long each sensor measured in each phase until `t_end` [s]."""
        known = self._calibration, self.design, self.history
        return budget.sensor_use(self.problem.model, *known)

    def correlations(self) -> pd.DataFrame:
        """Correlations of the errors at `t_end`; see `covariance.correlations`."""
        return covariance.correlations(self.problem.model, self.covariance)

    def least_observable(self, count: int = 3) -> pd.DataFrame:
        """What the plan leaves least known; see `covariance.least_observable`."""
        return covariance.least_observable(self.problem.model, self.covariance, count)

    def compare(self, designs: Mapping[str, ArrayLike] | None = None) -> pd.DataFrame:
        """The plan, in the first row, beside others at its `t_end`; see `alternatives.compare`.

        Parameters
        ----------
        designs : mapping, optional
            Default: the `alternatives.baselines` with maneuvers as long as the plan's in all.
        """
        if designs is None:
            designs = alternatives.without_optimizer(self.scenario, self._calibration)
        return alternatives.compare(self.problem, {"plan": self.design, **designs}, self.t_end)


@lru_cache(maxsize=4)  # its tables take some MB
def _problem(scenario: Scenario) -> AttitudeManeuverProblem:
    """The problem of a scenario; equal ones have the same tables, flights and results."""
    return AttitudeManeuverProblem(scenario)
