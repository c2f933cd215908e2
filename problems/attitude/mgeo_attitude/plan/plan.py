"""Maneuver plan: one design in one scenario, with its analyses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property, lru_cache

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from pydantic.dataclasses import dataclass

from mgeo_attitude._typing import Floats
from mgeo_attitude.environment.times import format_time_stamps
from mgeo_attitude.filter.history import FilterHistory, run_filter
from mgeo_attitude.geometry.quaternion import quaternions_from_matrices
from mgeo_attitude.lower_bound.samples import NoLowerBoundError
from mgeo_attitude.maneuvers.motion import Phase
from mgeo_attitude.maneuvers.schedule import build_hold_design
from mgeo_attitude.problem import AttitudeManeuverProblem
from mgeo_attitude.scenario.scenario import Scenario
from mgeo_attitude.sensors.suite import list_block_units
from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.errors import InvalidValue
from mgeo_attitude.settings.types import DEG
from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory
from mgeo_attitude.view import lower_bound
from mgeo_attitude.view.maneuver_view import ManeuverView
from mgeo_attitude.view.observability import covariance, error_budget, improvements
from mgeo_attitude.view.summaries import format_duration

#: Remaining share of an initial 1-sigma above which an error counts as not calibrated.
UNCALIBRATED_SHARE = 0.5


@dataclass(frozen=True)
class ManeuverPlan(Settings):
    """Calibration maneuvers from the scenario's epoch until the filter has converged.

    With Monte Carlo runs, the last rate is held until the robust time. A slew back to the initial
    attitude law follows if the scenario requests it.

    Plans are equal if their scenarios and designs are equal; results are computed on first access.
    A plan may violate constraints of the scenario, see `list_violations`.

    Parameters
    ----------
    scenario : Scenario
    design : sequence of float
        ωx, ωy, ωz [deg/s] and duration [s] of each maneuver in turn. An empty design holds the
        initial rate.

    Raises
    ------
    InvalidValue
        (ValueError, TypeError) If the length of the design does not match the number of maneuvers,
        or if a value is outside the bounds of rates and durations.

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
    """scenario of the plan"""
    design: tuple[float, ...]
    """rates [deg/s] and duration [s] of each maneuver"""

    def __post_init__(self) -> None:
        problem = self.problem
        nothing = tuple(
            np.tile(
                build_hold_design(problem.model.initial_rate), self.scenario.maneuvers.count
            ).tolist()
        )
        if not self.design:
            object.__setattr__(self, "design", nothing)
        if self.design == nothing:  # a tumbling satellite may exceed the bounds of maneuver rates
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
        """Return the plan of a design vector, sharing the tables of a problem.

        Parameters
        ----------
        problem : AttitudeManeuverProblem
        x : array_like, shape (n_var,)
            Design vector.
        F : array, shape (n_obj,), optional
            Known objectives, such as those stored in a run folder. They are not evaluated again.

        Raises
        ------
        ValueError, TypeError
            If the design is invalid, as in the constructor.
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
        """Problem of the scenario; equal scenarios share it."""
        return _build_problem(self.scenario)

    @cached_property
    def view(self) -> ManeuverView:
        """View of the plan as a solution of its problem."""
        return self.problem.view([self.design])

    @cached_property
    def history(self) -> FilterHistory:
        """Filter run of the plan."""
        return run_filter(self.problem.model, self.design)

    @property
    def t_end(self) -> float:
        """Time of convergence, or the scenario's duration [s].

        Raises
        ------
        ValueError
            If the covariance loses positivity.
        """
        t_end = float(self.view.nominal.t_end[0])
        if math.isnan(t_end):
            raise ValueError(
                f"design {list(self.design)}: the covariance of the filter loses positivity"
            )
        return t_end

    @property
    def converged(self) -> bool:
        """Whether the filter converged before the scenario's duration."""
        return self.t_end < self.problem.model.duration

    @property
    def trace(self) -> float:
        """Weighted trace of the covariance at `t_end`."""
        return float(self.view.nominal.trace[0])

    @property
    def covariance(self) -> Floats:
        """Covariance at `t_end`, shape (n_states, n_states), in the filter's units."""
        covariance: Floats = self.view.nominal.covariance[0]
        return covariance

    @property
    def sigma(self) -> Floats:
        """1-sigma of each state at `t_end`, shape (n_states,); see `Plans.sigma`."""
        sigma: Floats = self.view.sigma[0]
        return sigma

    @property
    def attitude_sigma_deg(self) -> float:
        """Attitude 1-sigma about the worst body axis at `t_end` [deg]; see `sigma`."""
        return float(DEG.factor * self.sigma[:3].max())

    @property
    def summary(self) -> str:
        """One-line summary of the plan; see `describe.answers`."""
        (answer,) = self.view.summaries()
        return answer

    def compare_with_monte_carlo(self) -> pd.DataFrame:
        """Compare the objectives with those in 9 of 10 Monte Carlo runs, one row per objective.

        Columns: ``predicted``, ``kept``, ``kept / promised [-]``; see `Plans.promises`.
        """
        values = self.view.compare_with_monte_carlo().to_numpy(float).reshape(-1, 3)
        names = pd.Index(self.problem.obj_names, name="objective")
        return pd.DataFrame(
            values, names, ["predicted", "Monte Carlo", "Monte Carlo / predicted [-]"]
        )

    @cached_property
    def hold_end(self) -> float:
        """End of the constant-rate hold [s], at `t_end` or later; see `Plans.held_until`."""
        (held,) = self.view.hold_end
        return float(held)

    @cached_property
    def trajectory(self) -> Trajectory:
        """Motion of the satellite until the end of the plan."""
        design = np.array(self.design)
        return Trajectory(self.scenario, self.problem.model, design, self.t_end, self.hold_end)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Maneuvers, constant-rate hold and slew back, in this order."""
        return self.trajectory.phases

    @property
    def _calibration_phases(self) -> list[Phase]:
        return [phase for phase in self.phases if phase.end <= self.t_end]

    @property
    def slew_back(self) -> SlewBack | None:
        """Slew back after `held_until`, or None if the scenario does not request one."""
        return self.trajectory.slew_back

    @property
    def duration(self) -> float:
        """End of the plan, slew back included [s]."""
        return self.trajectory.end

    @property
    def attitude(self) -> Floats:
        """Attitude from GCRS to body at every filter step of the plan, shape (n + 1, 3, 3)."""
        return self.trajectory.attitude

    def to_steps(self, times: ArrayLike) -> NDArray[np.int64]:
        """Return the filter steps at times [s], which must be multiples of the step."""
        return np.rint(np.asarray(times) / self.scenario.step).astype(np.int64)

    def describe_hold(self) -> list[str]:
        """Return a line on the constant-rate hold beyond `t_end`, if there is one."""
        if self.hold_end <= self.t_end:
            return []
        return [
            f"the filter has converged after {format_duration(self.t_end)} ({self.t_end:.6g} s) in the "
            f"nominal run; the last rate is held until {format_duration(self.hold_end)} "
            f"({self.hold_end:.6g} s) for runs that converge later"
        ]

    def build_timeline(self) -> pd.DataFrame:
        """Return times, rates and attitudes of the plan, one row per phase.

        Attitudes are quaternions from GCRF to body, scalar last (see `quaternions_from_matrices`). The swept
        angle is the integral of the rate, not the angle between the attitudes.
        """
        edges = np.array([*(phase.start for phase in self.phases), self.duration])
        texts = format_time_stamps(self.scenario.epoch, edges)
        q = quaternions_from_matrices(self.attitude[self.to_steps(edges)])
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
        columns["rotation [deg]"] = [phase.rotation_deg for phase in self.phases]
        for name, values in (("start", q[:-1]), ("end", q[1:])):
            columns |= {f"{name} q{part}": values[:, i] for i, part in enumerate("123c")}
        return pd.DataFrame(columns)

    def build_accuracy_table(self) -> pd.DataFrame:
        """Return the predicted 1-sigma of every state before the plan and at `t_end`."""
        states = covariance.StateLabels.from_suite(self.problem.model.suite)
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

    def compare_with_lower_bound(self) -> pd.DataFrame:
        """Compare the worst axes at `t_end` with the lower bound.

        The table is that of `lower_bound.compare_with_lower_bound`.

        Raises
        ------
        NoLowerBoundError
            If no lower bound is proved.
        """
        return lower_bound.compare_with_lower_bound(
            self.problem.model, self.problem.lower_bound, self.history
        )

    def describe_lower_bound(self) -> list[str]:
        """Return lines that compare the trace with the lower bound."""
        try:
            curves = self.problem.lower_bound
        except NoLowerBoundError as reason:
            return [f"no lower bound of the trace: {reason}"]
        return list(lower_bound.describe_lower_bound(curves, self.t_end, self.trace))

    def list_uncalibrated_errors(self) -> list[str]:
        """Return the errors whose 1-sigma fell by less than half, with the remaining share.

        The fast end of a front may converge because the filter has stalled.
        """
        suite = self.problem.model.suite
        # Compare with the uncertainty before any calibration: a plan that follows a calibration
        # need not reduce the uncertainty much further.
        initial = suite.initial_sigma(np.radians(self.scenario.initial.attitude_deg))
        left = (np.sqrt(np.diag(self.covariance)) / initial).reshape(-1, 3).max(axis=1)
        blocks = list_block_units(suite)
        return [
            f"{block.label} ({100.0 * share:.0f} % of the initial 1-sigma is left)"
            for block, share in zip(blocks, left, strict=True)
            if share > UNCALIBRATED_SHARE
        ]

    def build_constraint_table(self) -> pd.DataFrame:
        """Return the scenario's constraints with their margins, one row per constraint.

        Columns: ``unit``; ``value``; ``bound`` ("at most" or "at least"); ``limit``; ``margin``,
        which is negative if the constraint is violated; ``kept``, whether it is satisfied. See
        `ManeuverView.limits`.
        """
        (table,) = self.view.constraints()
        return table.assign(satisfied=table["margin"].to_numpy(float) >= 0.0)

    def list_violations(self) -> list[str]:
        """Return the violated constraints with values and bounds, one line each."""
        table = self.build_constraint_table()
        return [
            f"{label} {row['value']:.6g} {row['unit']}, {row['bound_type']} {row['bound_value']:.6g} "
            f"{row['unit']}, violated by {-row['margin']:.3g} {row['unit']}"
            for label, row in table[~table["satisfied"].astype(bool)].iterrows()
        ]

    def compute_uncertainty_by_phase(self) -> pd.DataFrame:
        """Return the uncertainty reduction by phase; see `budget.compute_uncertainty_by_phase`."""
        return error_budget.compute_uncertainty_by_phase(
            self.problem.model, self.design, self.history
        )

    @cached_property
    def _error_budget(self) -> pd.DataFrame:
        return error_budget.compute_error_budget(self.problem.model, self.design, self.history)

    @cached_property
    def _improvements(self) -> pd.DataFrame:
        rate = self.scenario.maneuvers.max_rate_deg_s
        return improvements.evaluate_improvements(self.problem.model, self.design, self.t_end, rate)

    def compute_error_budget(self) -> pd.DataFrame:
        """Return the error budget of the 1-sigmas at `t_end`; see `budget.budget`."""
        return self._error_budget.copy()

    def evaluate_improvements(self) -> pd.DataFrame:
        """Return the 1-sigmas at `t_end` with single improvements; see `alternatives.remedies`."""
        return self._improvements.copy()

    def describe_error_drivers(self) -> list[str]:
        """Return a line on the error drivers of each required 1-sigma; see `budget.describe_error_drivers`."""
        return error_budget.describe_error_drivers(
            self.problem.model, self._error_budget, self._improvements, self.history
        )

    def compute_measurement_times(self) -> pd.DataFrame:
        """Return the time during which each sensor measured in each phase until `t_end` [s]."""
        arguments = self._calibration_phases, self.design, self.history
        return error_budget.compute_measurement_times(self.problem.model, *arguments)

    def compute_correlations(self) -> pd.DataFrame:
        """Return the correlations of the errors at `t_end`; see `covariance.compute_correlations`."""
        return covariance.compute_correlations(self.problem.model, self.covariance)

    def find_least_observable(self, n_directions: int = 3) -> pd.DataFrame:
        """Return the least observable directions; see `covariance.find_least_observable`."""
        return covariance.find_least_observable(self.problem.model, self.covariance, n_directions)

    def compare_with_designs(self, designs: Mapping[str, ArrayLike] | None = None) -> pd.DataFrame:
        """Compare the plan, in the first row, with other designs at its `t_end`.

        Parameters
        ----------
        designs : mapping, optional
            Designs by name; default: `alternatives.baselines` with the total maneuver time of the
            plan.

        Returns
        -------
        DataFrame
            See `alternatives.compare`.
        """
        if designs is None:
            designs = improvements.build_matching_baselines(self.scenario, self._calibration_phases)
        return improvements.compare_designs(
            self.problem, {"plan": self.design, **designs}, self.t_end
        )


@lru_cache(maxsize=4)  # the tables of a problem take some MB
def _build_problem(scenario: Scenario) -> AttitudeManeuverProblem:
    return AttitudeManeuverProblem(scenario)
